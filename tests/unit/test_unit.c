/* test_unit.c - quantities with units: sizes, products, powers, and the sentences that refuse the wrong ones. */

#include "check.h"
#include "math/unit.h"

#define PI 3.14159265358979323846

typedef struct Case { const char *text, *want; double value; } Case;

static void check_cases(const Case *cases, int count)
{
    for (int i = 0; i < count; i++) {
        char why[200] = "";
        double x = 0;
        if (dig_unit_parse(cases[i].text, cases[i].want, &x, why, sizeof why) != DIG_OK)
            fail_msg("'%s' as %s: %s", cases[i].text, cases[i].want, why);
        if (!(fabs(x - cases[i].value) <= 1e-12 * fabs(cases[i].value)))
            fail_msg("'%s' = %.17g, want %.17g", cases[i].text, x, cases[i].value);
    }
}

TEST(common_quantities_become_si)
{
    static const Case cases[] = {
        {"4 cm", "m", 0.04}, {"4cm", "m", 0.04}, {" 2.5 mm ", "m", 0.0025}, {"1e3 um", "m", 1e-3}, {"-3 km", "m", -3000},
        {"5 kg", "kg", 5}, {"250 g", "kg", 0.25}, {"2 t", "kg", 2000}, {"30 deg", "rad", PI / 6}, {"1 rev", "rad", 2 * PI},
        {"50 ms", "s", 0.05}, {"2 min", "s", 120}, {"1.5 h", "s", 5400}, {"36 km/h", "m/s", 10}, {"9.81 m/s^2", "m/s^2", 9.81},
        {"1 rpm", "rad/s", 2 * PI / 60}, {"90 deg/s", "rad/s", PI / 2}, {"5 kN", "N", 5000}, {"12 V", "V", 12},
        {"0.2 ohm", "ohm", 0.2}, {"6 W", "W", 6}, {"1 kWh", "J", 3.6e6}, {"3 bar", "Pa", 3e5}, {"20 degC", "K", 293.15},
        {"50 %", "1", 0.5}, {"0.5", "1", 0.5}, {"7", "", 7}, {"10 l", "m^3", 0.01}, {"1 g/cm^3", "kg/m^3", 1000},
        {"+.5 m", "m", 0.5}, {"5. m", "m", 5}, {"1 Ah", "C", 3600},
    };
    check_cases(cases, (int)(sizeof cases / sizeof *cases));
}

TEST(products_quotients_and_powers_in_every_spelling)
{
    static const Case cases[] = {
        {"2 N m", "N*m", 2}, {"2 N*m", "N m", 2}, {"2 N.m", "N*m", 2}, {"2 N\xc2\xb7m", "N*m", 2}, {"200 N cm", "N*m", 2},
        {"3 N*m/rad", "N*m/rad", 3}, {"3 N m", "N*m/rad", 3}, {"4 J/(kg K)", "J/(kg K)", 4}, {"4 J/kg/K", "J/(kg K)", 4},
        {"1 m2", "m^2", 1}, {"1 m\xc2\xb2", "m^2", 1}, {"1 cm^3", "m^3", 1e-6}, {"2 s^-1", "Hz", 2}, {"2 1/s", "Hz", 2},
        {"1 kg m s^-2", "N", 1}, {"1 (m/s)^2", "J/kg", 1}, {"1 W/(m^2 K)", "W/(m^2*K)", 1}, {"5 (N)", "N", 5},
    };
    check_cases(cases, (int)(sizeof cases / sizeof *cases));
}

TEST(a_null_or_any_unit_takes_whatever_is_written)
{
    char why[200];
    double x = 0;
    CHECK_INT(dig_unit_parse("1 mm/s", NULL, &x, why, sizeof why), DIG_OK);
    CHECK_NEAR(x, 1e-3, 1e-18);
    CHECK_INT(dig_unit_parse("42", NULL, &x, why, sizeof why), DIG_OK);
    CHECK_NEAR(x, 42, 0);
}

static void refused(const char *text, const char *want, const char *sentence)
{
    char why[200] = "";
    double x = -77;
    CHECK(dig_unit_parse(text, want, &x, why, sizeof why) != DIG_OK);
    CHECK_TEXT(why, sentence);
    CHECK_NEAR(x, -77, 0);
}

TEST(the_wrong_dimension_is_named)
{
    refused("5 kg", "m", "wants a length; '5 kg' is a mass");
    refused("5 cm", "kg", "wants a mass; '5 cm' is a length");
    refused("3 s", "m/s", "wants a speed; '3 s' is a time");
    refused("5 N", "N*m", "wants a torque; '5 N' is a force");
    refused("5 J", "N", "wants a force; '5 J' is an energy");
    refused("5 N m", "N", "wants a force; '5 N m' is a torque");
    refused("5 Hz", "rad/s", "wants an angular speed; '5 Hz' is a frequency");
    refused("5 m", "1", "wants a plain number; '5 m' is a length");
    refused("5 kg^3", "m", "wants a length; '5 kg^3' is not");
}

TEST(what_is_no_quantity_is_refused)
{
    refused("5", "m", "'5' has no unit (write '5 m' or a plain number)");
    refused("5 furlong", "m", "'5 furlong': unknown unit 'furlong'");
    refused("5 kmin", "s", "'5 kmin': unknown unit 'kmin' (did you mean 'min'?)");
    refused("5 cmm", "m", "'5 cmm': unknown unit 'cmm' (did you mean 'mm'?)");
    refused("5 kgs", "kg", "'5 kgs': unknown unit 'kgs' (did you mean 'kg'?)");
    refused("5 Nm", "N*m", "'5 Nm': unknown unit 'Nm' (did you mean 'N m'?)");
    refused("5 m/ss", "m/s", "'5 m/ss': unknown unit 'ss' (did you mean 'm/s'?)");
    refused("4 in", "m", "'4 in': unknown unit 'in' (1 in is 2.54 cm)");
    refused("90 degrees", "rad", "'90 degrees': unknown unit 'degrees' (did you mean 'deg'?)");
    refused("3 KG", "kg", "'3 KG': unknown unit 'KG' (did you mean 'kg'?)");
    refused("30 mph", "m/s", "'30 mph': unknown unit 'mph' (1 mph is 0.44704 m/s)");
    refused("1,5 m", "m", "'1,5 m': unknown unit ',5 m' (decimals follow a point: 1.5)");
    refused("20 C", "K", "wants a temperature; '20 C' is an electric charge (write '20 degC' or '293.15 K')");
    refused("68 F", "K", "wants a temperature; '68 F' is a capacitance (write '20 degC' or '293.15 K')");
    refused("", "m", "'' is not a number with a unit");
    refused("cm", "m", "'cm' is not a number with a unit");
    refused("nan m", "m", "'nan m' is not a number with a unit");
    refused("inf m", "m", "'inf m' is not a number with a unit");
    refused("1e999 m", "m", "'1e999 m' is too large a number");
    refused("1e308 km", "m", "'1e308 km' is too large a number");
    refused("5 m^", "m", "'5 m^': unknown unit '^'");
    refused("5 (m", "m", "'5 (m': unknown unit ''");
}

/* No text of the alphabet of units may do anything but succeed or leave a sentence. */
TEST(every_short_text_ends_in_an_answer)
{
    static const char alphabet[] = "5 mN/*^-(1)gk.\xc2\xb2%e";
    const int n = (int)sizeof alphabet - 1;
    char text[6] = "", why[200];
    for (int i = 0; i < n * n * n * n; i++) {
        double x = 0;
        text[0] = alphabet[i % n];
        text[1] = alphabet[i / n % n];
        text[2] = alphabet[i / n / n % n];
        text[3] = alphabet[i / n / n / n];
        why[0] = '\0';
        dig_status s = dig_unit_parse(text, "m", &x, why, sizeof why);
        if (s == DIG_OK ? !isfinite(x) : why[0] == '\0')
            fail_msg("'%s' -> status %d, %g, '%s'", text, (int)s, x, why);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(common_quantities_become_si), unit_test(products_quotients_and_powers_in_every_spelling),
              unit_test(a_null_or_any_unit_takes_whatever_is_written), unit_test(the_wrong_dimension_is_named),
              unit_test(what_is_no_quantity_is_refused), unit_test(every_short_text_ends_in_an_answer));
}
