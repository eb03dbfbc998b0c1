/* math/unit.c - SI units: symbols, prefixes, products, quotients and powers.
 *
 * Source of names, sizes and prefixes: BIPM, The International System of Units,
 * 9th edition (2019), tables 2 to 8. The radian is carried as a seventh
 * dimension, so that "5 Hz" is not taken for an angular speed.
 */

#include "math/unit.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>

enum { POWER_LIMIT = 9, DEPTH_LIMIT = 8 };

typedef struct Unit {
    const char *symbol;
    real        scale;      /* size in SI */
    Dimension   d;
    bool        prefixed;   /* takes SI prefixes */
} Unit;

/* Exponents in the order m kg s A K rad. */
static const Unit units[] = {
    {"m", 1, {.m = 1}, true},
    {"g", 1e-3, {.kg = 1}, true},
    {"t", 1e3, {.kg = 1}, false},
    {"s", 1, {.s = 1}, true},
    {"min", 60, {.s = 1}, false},
    {"h", 3600, {.s = 1}, false},
    {"d", 86400, {.s = 1}, false},
    {"A", 1, {.A = 1}, true},
    {"K", 1, {.K = 1}, true},
    {"rad", 1, {.rad = 1}, true},
    {"deg", DIG_PI / 180, {.rad = 1}, false},
    {"\xc2\xb0", DIG_PI / 180, {.rad = 1}, false},
    {"rev", 2 * DIG_PI, {.rad = 1}, false},
    {"turn", 2 * DIG_PI, {.rad = 1}, false},
    {"rpm", 2 * DIG_PI / 60, {.s = -1, .rad = 1}, false},
    {"Hz", 1, {.s = -1}, true},
    {"N", 1, {.m = 1, .kg = 1, .s = -2}, true},
    {"Pa", 1, {.m = -1, .kg = 1, .s = -2}, true},
    {"bar", 1e5, {.m = -1, .kg = 1, .s = -2}, true},
    {"J", 1, {.m = 2, .kg = 1, .s = -2}, true},
    {"Wh", 3600, {.m = 2, .kg = 1, .s = -2}, true},
    {"W", 1, {.m = 2, .kg = 1, .s = -3}, true},
    {"V", 1, {.m = 2, .kg = 1, .s = -3, .A = -1}, true},
    {"ohm", 1, {.m = 2, .kg = 1, .s = -3, .A = -2}, true},
    {"\xce\xa9", 1, {.m = 2, .kg = 1, .s = -3, .A = -2}, true},
    {"S", 1, {.m = -2, .kg = -1, .s = 3, .A = 2}, true},
    {"C", 1, {.s = 1, .A = 1}, true},
    {"Ah", 3600, {.s = 1, .A = 1}, true},
    {"F", 1, {.m = -2, .kg = -1, .s = 4, .A = 2}, true},
    {"H", 1, {.m = 2, .kg = 1, .s = -2, .A = -2}, true},
    {"T", 1, {.kg = 1, .s = -2, .A = -1}, true},
    {"Wb", 1, {.m = 2, .kg = 1, .s = -2, .A = -1}, true},
    {"l", 1e-3, {.m = 3}, true},
    {"L", 1e-3, {.m = 3}, true},
    {"ha", 1e4, {.m = 2}, false},
    {"%", 1e-2, {0}, false},
};

typedef struct Prefix { const char *symbol; real scale; } Prefix;

static const Prefix prefixes[] = {
    {"p", 1e-12}, {"n", 1e-9}, {"u", 1e-6}, {"\xc2\xb5", 1e-6}, {"\xce\xbc", 1e-6}, {"m", 1e-3}, {"c", 1e-2}, {"d", 1e-1},
    {"da", 1e1}, {"h", 1e2}, {"k", 1e3}, {"M", 1e6}, {"G", 1e9}, {"T", 1e12},
};

typedef struct Name { Dimension d; const char *hint, *name; } Name;

/* The hint tells apart what shares a dimension; the row without one comes last. */
static const Name names[] = {
    {{0}, NULL, "a plain number"},
    {{.m = 1}, NULL, "a length"},
    {{.kg = 1}, NULL, "a mass"},
    {{.s = 1}, NULL, "a time"},
    {{.A = 1}, NULL, "an electric current"},
    {{.K = 1}, NULL, "a temperature"},
    {{.rad = 1}, NULL, "an angle"},
    {{.m = 2}, NULL, "an area"},
    {{.m = 3}, NULL, "a volume"},
    {{.s = -1}, NULL, "a frequency"},
    {{.m = 1, .s = -1}, NULL, "a speed"},
    {{.m = 1, .s = -2}, NULL, "an acceleration"},
    {{.s = -1, .rad = 1}, NULL, "an angular speed"},
    {{.s = -2, .rad = 1}, NULL, "an angular acceleration"},
    {{.m = 1, .kg = 1, .s = -2}, NULL, "a force"},
    {{.m = 1, .kg = 1, .s = -1}, NULL, "an impulse"},
    {{.m = 2, .kg = 1, .s = -1}, NULL, "an angular impulse"},
    {{.m = 2, .kg = 1, .s = -2}, "N", "a torque"},
    {{.m = 2, .kg = 1, .s = -2}, NULL, "an energy"},
    {{.m = 2, .kg = 1, .s = -3}, NULL, "a power"},
    {{.m = -1, .kg = 1, .s = -2}, NULL, "a pressure"},
    {{.m = -3, .kg = 1}, NULL, "a density"},
    {{.m = 2, .kg = 1}, NULL, "a moment of inertia"},
    {{.kg = 1, .s = -2}, NULL, "a stiffness"},
    {{.kg = 1, .s = -1}, NULL, "a damping"},
    {{.m = 2, .kg = 1, .s = -2, .rad = -1}, NULL, "a torsional stiffness"},
    {{.m = 2, .kg = 1, .s = -1, .rad = -1}, NULL, "a torsional damping"},
    {{.m = 3, .s = -1}, NULL, "a flow"},
    {{.m = 2, .s = -2, .K = -1}, NULL, "a specific heat capacity"},
    {{.m = 2, .kg = 1, .s = -2, .K = -1}, NULL, "a heat capacity"},
    {{.m = 1, .kg = 1, .s = -3, .K = -1}, NULL, "a thermal conductivity"},
    {{.m = 2, .kg = 1, .s = -3, .K = -1}, NULL, "a thermal conductance"},
    {{.kg = 1, .s = -3, .K = -1}, NULL, "a heat transfer coefficient"},
    {{.m = 2, .kg = 1, .s = -3, .A = -1}, NULL, "a voltage"},
    {{.m = 2, .kg = 1, .s = -3, .A = -2}, NULL, "a resistance"},
    {{.m = 3, .kg = 1, .s = -3, .A = -2}, NULL, "a resistivity"},
    {{.m = -2, .kg = -1, .s = 3, .A = 2}, NULL, "a conductance"},
    {{.s = 1, .A = 1}, NULL, "an electric charge"},
    {{.m = -2, .kg = -1, .s = 4, .A = 2}, NULL, "a capacitance"},
    {{.m = 2, .kg = 1, .s = -2, .A = -2}, NULL, "an inductance"},
    {{.kg = 1, .s = -2, .A = -1}, NULL, "a magnetic flux density"},
};

enum { UNIT_COUNT = sizeof units / sizeof *units, PREFIX_COUNT = sizeof prefixes / sizeof *prefixes,
       NAME_COUNT = sizeof names / sizeof *names };

static bool same_but_angle(Dimension a, Dimension b)
{
    return a.m == b.m && a.kg == b.kg && a.s == b.s && a.A == b.A && a.K == b.K;
}

static bool same_dimension(Dimension a, Dimension b)
{
    return same_but_angle(a, b) && a.rad == b.rad;
}

const char *unit_dimension_name(Dimension d, const char *hint)
{
    for (int i = 0; i < NAME_COUNT; i++)
        if (same_dimension(names[i].d, d) && (!names[i].hint || (hint && strstr(hint, names[i].hint))))
            return names[i].name;
    return NULL;
}

/* ---- reading ------------------------------------------------------------------ */

typedef struct Reader {
    const char *p;          /* the next byte                           */
    const char *bad;        /* start of what is not understood, or NULL */
    int         depth;      /* open brackets                           */
} Reader;

/* Bytes of the multiplication sign at p: "*", "." or the middle dot; 0 = none. */
static int sign_of_product(const char *p)
{
    if (*p == '*' || *p == '.')
        return 1;
    return strncmp(p, "\xc2\xb7", 2) == 0 ? 2 : 0;
}

static void skip_blanks(Reader *r)
{
    while (*r->p == ' ' || *r->p == '\t')
        r->p++;
}

static bool symbol_byte(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%' || (unsigned char)c >= 0x80;
}

/* Length of the symbol at p. Middle dot and raised 2 and 3 end it although they are above 0x7f. */
static size_t symbol_length(const char *p)
{
    size_t n = 0;
    while (symbol_byte(p[n]) && strncmp(p + n, "\xc2\xb7", 2) != 0 && strncmp(p + n, "\xc2\xb2", 2) != 0 &&
           strncmp(p + n, "\xc2\xb3", 2) != 0)
        n++;
    return n;
}

static const Unit *find_symbol(const char *text, size_t length, bool only_prefixed)
{
    for (int i = 0; i < UNIT_COUNT; i++)
        if (strlen(units[i].symbol) == length && memcmp(units[i].symbol, text, length) == 0 &&
            (units[i].prefixed || !only_prefixed))
            return &units[i];
    return NULL;
}

static bool read_symbol(Reader *r, Dimension *d, real *scale)
{
    size_t length = symbol_length(r->p);
    const Unit *u = length > 0 ? find_symbol(r->p, length, false) : NULL;
    *scale = 1;
    for (int i = 0; i < PREFIX_COUNT && !u && length > 0; i++) {
        size_t skip = strlen(prefixes[i].symbol);
        if (skip < length && memcmp(prefixes[i].symbol, r->p, skip) == 0) {
            u = find_symbol(r->p + skip, length - skip, true);
            *scale = prefixes[i].scale;
        }
    }
    if (!u) {
        r->bad = r->p;
        return false;
    }
    *d = u->d;
    *scale *= u->scale;
    r->p += length;
    return true;
}

/* "^2", "^-1", "2", "-1" or a raised 2 or 3; 1 when there is none. */
static bool read_power(Reader *r, int *power)
{
    const char *start = r->p;
    *power = 1;
    if (strncmp(r->p, "\xc2\xb2", 2) == 0 || strncmp(r->p, "\xc2\xb3", 2) == 0) {
        *power = (unsigned char)r->p[1] == 0xb2 ? 2 : 3;
        r->p += 2;
        return true;
    }
    bool caret = *r->p == '^';
    if (caret)
        r->p++;
    int sign = *r->p == '-' ? -1 : 1;
    if (*r->p == '-' || (caret && *r->p == '+'))
        r->p++;
    if (*r->p < '0' || *r->p > '9') {
        r->bad = r->p == start ? NULL : start;
        return r->p == start;
    }
    int value = 0;
    while (*r->p >= '0' && *r->p <= '9' && value <= POWER_LIMIT)
        value = value * 10 + (*r->p++ - '0');
    if (value > POWER_LIMIT) {
        r->bad = start;
        return false;
    }
    *power = sign * value;
    return true;
}

static Dimension raise_dimension(Dimension d, int power)
{
    return (Dimension){d.m * power, d.kg * power, d.s * power, d.A * power, d.K * power, d.rad * power};
}

static real raise_scale(real scale, int power)
{
    real out = 1;
    for (int i = 0; i < (power < 0 ? -power : power); i++)
        out *= scale;
    return power < 0 ? 1 / out : out;
}

static bool read_product(Reader *r, Dimension *d, real *scale);

static bool read_factor(Reader *r, Dimension *d, real *scale)
{
    int power;
    if (*r->p == '(') {
        if (++r->depth > DEPTH_LIMIT) {
            r->bad = r->p;
            return false;
        }
        r->p++;
        if (!read_product(r, d, scale))
            return false;
        if (*r->p != ')') {
            r->bad = r->p;
            return false;
        }
        r->p++;
        r->depth--;
    } else if (r->p[0] == '1' && !(r->p[1] >= '0' && r->p[1] <= '9')) {
        r->p++;
        *d = (Dimension){0};
        *scale = 1;
        return true;
    } else if (!read_symbol(r, d, scale)) {
        return false;
    }
    if (!read_power(r, &power))
        return false;
    *d = raise_dimension(*d, power);
    *scale = raise_scale(*scale, power);
    return true;
}

static bool read_product(Reader *r, Dimension *d, real *scale)
{
    bool divide = false;
    *d = (Dimension){0};
    *scale = 1;
    for (;;) {
        Dimension f;
        real size;
        skip_blanks(r);
        if (!read_factor(r, &f, &size))
            return false;
        f = raise_dimension(f, divide ? -1 : 1);
        *d = (Dimension){d->m + f.m, d->kg + f.kg, d->s + f.s, d->A + f.A, d->K + f.K, d->rad + f.rad};
        *scale = divide ? *scale / size : *scale * size;
        skip_blanks(r);
        if (*r->p == '\0' || *r->p == ')')
            return true;
        divide = *r->p == '/';
        r->p += divide ? 1 : sign_of_product(r->p);
    }
}

dig_status unit_read(const char *text, Dimension *dimension, real *scale, char *bad, size_t capacity)
{
    Reader r = {text, NULL, 0};
    if (read_product(&r, dimension, scale) && *r.p == '\0')
        return DIG_OK;
    const char *from = r.bad ? r.bad : r.p;
    size_t length = symbol_length(from);
    snprintf(bad, capacity, "%.*s", length > 0 ? (int)real_min((real)length, 30) : 30, from);
    return DIG_E_FORMAT;
}

/* Bytes of a decimal number at text, 0 when there is none. No hexadecimal, no "inf", and no locale. */
static size_t number_length(const char *text)
{
    const char *p = text;
    int digits = 0;
    if (*p == '+' || *p == '-')
        p++;
    for (; *p >= '0' && *p <= '9'; p++)
        digits++;
    if (*p == '.')
        p++;
    for (; *p >= '0' && *p <= '9'; p++)
        digits++;
    if (digits == 0)
        return 0;
    if (*p == 'e' || *p == 'E') {
        const char *q = p + 1;
        if (*q == '+' || *q == '-')
            q++;
        if (*q >= '0' && *q <= '9') {
            while (*q >= '0' && *q <= '9')
                q++;
            p = q;
        }
    }
    return (size_t)(p - text);
}

static bool read_number(const char **text, real *value)
{
    char copy[64];
    size_t length = number_length(*text);
    if (length == 0 || length >= sizeof copy)
        return false;
    memcpy(copy, *text, length);
    copy[length] = '\0';
    *value = strtod(copy, NULL);
    *text += length;
    return true;
}

/* ---- the public call -------------------------------------------------------------- */

/* Degrees in which temperatures are told, of which C and F are coulomb and farad: " (write '20 degC' or '293.15 K')". */
static void suggest_degrees(const char *text, real x, char *out, size_t capacity)
{
    char unit = text[strlen(text) - 1];
    real celsius = unit == 'F' ? (x - 32) / 1.8 : x;
    if (unit == 'C' || unit == 'F')
        snprintf(out, capacity, " (write '%.6g degC' or '%.6g K')", celsius, celsius + 273.15);
}

static dig_status wrong_dimension(const char *text, real x, Dimension got, Dimension wanted, const char *want, char *why, size_t capacity)
{
    const char *is = unit_dimension_name(got, text);
    const char *wants = unit_dimension_name(wanted, want);
    char other[48];
    if (!wants) {
        snprintf(other, sizeof other, "a quantity in %.30s", want);
        wants = other;
    }
    char meant[64] = "";
    if (same_dimension(wanted, (Dimension){.K = 1}))
        suggest_degrees(text, x, meant, sizeof meant);
    if (is)
        snprintf(why, capacity, "wants %s; '%.40s' is %s%s", wants, text, is, meant);
    else
        snprintf(why, capacity, "wants %s; '%.40s' is not", wants, text);
    return DIG_E_ARG;
}

/* A torsional stiffness is often written "N m": a missing "per radian" is filled in, a missing radian above the line is not. */
static bool fits(Dimension got, Dimension wanted)
{
    return same_dimension(got, wanted) || (same_but_angle(got, wanted) && got.rad == 0 && wanted.rad < 0);
}

/* How units are called in full or elsewhere, in small letters and without an s at the end; those that have a scale are no units here. */
static const struct { const char *word, *unit; real scale; } words[] = {
    {"degree", "deg", 0}, {"radian", "rad", 0}, {"metre", "m", 0}, {"meter", "m", 0}, {"centimetre", "cm", 0}, {"centimeter", "cm", 0},
    {"millimetre", "mm", 0}, {"millimeter", "mm", 0}, {"kilometre", "km", 0}, {"kilometer", "km", 0}, {"sec", "s", 0}, {"second", "s", 0},
    {"millisecond", "ms", 0}, {"minute", "min", 0}, {"hour", "h", 0}, {"hr", "h", 0}, {"kg", "kg", 0}, {"kilo", "kg", 0}, {"kilogram", "kg", 0},
    {"gram", "g", 0}, {"ton", "t", 0}, {"tonne", "t", 0}, {"newton", "N", 0}, {"nm", "N m", 0}, {"joule", "J", 0}, {"watt", "W", 0},
    {"volt", "V", 0}, {"amp", "A", 0}, {"ampere", "A", 0}, {"pascal", "Pa", 0}, {"litre", "l", 0}, {"liter", "l", 0}, {"percent", "%", 0},
    {"kelvin", "K", 0}, {"celsiu", "degC", 0}, {"kmh", "km/h", 0}, {"kph", "km/h", 0}, {"mp", "m/s", 0}, {"hertz", "Hz", 0},
    {"revolution", "rev", 0}, {"m", "m", 0}, {"in", "cm", 2.54}, {"inch", "cm", 2.54}, {"inche", "cm", 2.54}, {"ft", "m", 0.3048},
    {"foot", "m", 0.3048}, {"feet", "m", 0.3048}, {"yard", "m", 0.9144}, {"yd", "m", 0.9144}, {"mile", "km", 1.609344},
    {"mph", "m/s", 0.44704}, {"lb", "kg", 0.45359237}, {"pound", "kg", 0.45359237}, {"oz", "g", 28.349523125}, {"lbf", "N", 4.4482216},
    {"psi", "kPa", 6.8947573}, {"atm", "Pa", 101325}, {"cal", "J", 4.184}, {"kcal", "kJ", 4.184}, {"hp", "W", 745.7}, {"knot", "m/s", 0.514444},
};

/* " (did you mean 'deg'?)" for "degrees", " (1 ft is 0.3048 m)" for "ft". */
static bool suggest_word(const char *unit, char *out, size_t capacity)
{
    char word[16];
    size_t n = 0;
    if (unit[0] == ',')
        return snprintf(out, capacity, " (decimals follow a point: 1.5)") > 0;
    for (; n < sizeof word - 1 && unit[n]; n++)
        word[n] = (char)tolower((unsigned char)unit[n]);
    word[n] = '\0';
    if (n > 1 && word[n - 1] == 's')
        word[n - 1] = '\0';
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(words[i].word, word) != 0)
            continue;
        if (words[i].scale > 0)
            snprintf(out, capacity, " (1 %.16s is %.10g %s)", unit, words[i].scale, words[i].unit);
        else
            snprintf(out, capacity, " (did you mean '%s'?)", words[i].unit);
        return true;
    }
    return false;
}

/* " (did you mean 'cm'?)" for "cmm": the nearest unit of the dimension that is wanted; nothing when none is near. */
static void suggest(const char *unit, const char *bad, Dimension wanted, char *out, size_t capacity)
{
    static const char *const products[] = {"m/s", "m/s^2", "rad/s", "N m", "N/m", "N s", "N s/m", "N m/rad", "kg/m^3", "kg m^2", "W/(m K)",
                                           "W/(m^2 K)", "J/(kg K)"};
    enum { PRODUCTS = sizeof products / sizeof *products, MOST = PRODUCTS + (PREFIX_COUNT + 1) * 8 };
    char text[MOST][12], none[64];
    const char *candidates[MOST];
    int n = 0;
    for (int i = 0; i < UNIT_COUNT; i++)
        for (int k = -1; same_dimension(units[i].d, wanted) && k < (units[i].prefixed ? PREFIX_COUNT : 0) && n < MOST; k++)
            snprintf(text[n++], sizeof *text, "%s%s", k < 0 ? "" : prefixes[k].symbol, units[i].symbol);
    for (int i = 0; i < PRODUCTS && n < MOST; i++) {
        Dimension d = {0};
        real scale;
        if (unit_read(products[i], &d, &scale, none, sizeof none) == DIG_OK && fits(d, wanted))
            snprintf(text[n++], sizeof *text, "%s", products[i]);
    }
    for (int i = 0; i < n; i++)
        candidates[i] = text[i];
    const char *near = strlen(bad) > 1 ? dig_suggest(unit, candidates, n) : NULL;
    out[0] = '\0';
    if (near)
        snprintf(out, capacity, " (did you mean '%s'?)", near);
}

static dig_status finish(const char *text, real x, real scale, real *value, char *why, size_t capacity)
{
    real result = x * scale;
    if (!isfinite(result)) {
        snprintf(why, capacity, "'%.40s' is too large a number", text);
        return DIG_E_ARG;
    }
    *value = result;
    return DIG_OK;
}

dig_status dig_unit_parse(const char *text, const char *want, real *value, char *why, size_t capacity)
{
    const char *p = text + strspn(text, " \t");
    Dimension got = {0}, wanted = {0};
    real x, scale = 1, wanted_scale = 1;
    char bad[64];

    if (want && *want && unit_read(want, &wanted, &wanted_scale, bad, sizeof bad) != DIG_OK) {
        snprintf(why, capacity, "'%.30s' is no unit that digbox knows", want);
        return DIG_E_FORMAT;
    }
    if (!read_number(&p, &x)) {
        snprintf(why, capacity, "'%.40s' is not a number with a unit", text);
        return DIG_E_FORMAT;
    }
    p += strspn(p, " \t");
    if (strcmp(p, "degC") == 0 || strcmp(p, "\xc2\xb0" "C") == 0) {
        got.K = 1;
        x += 273.15;        /* ice point, K: BIPM 2.3.1 */
    } else if (*p && unit_read(p, &got, &scale, bad, sizeof bad) != DIG_OK) {
        char meant[48] = "";
        if (!suggest_word(p, meant, sizeof meant) && want)
            suggest(p, bad, wanted, meant, sizeof meant);
        snprintf(why, capacity, "'%.40s': unknown unit '%s'%s", text, bad, meant);
        return DIG_E_FORMAT;
    } else if (!*p && want && !fits(got, wanted)) {
        snprintf(why, capacity, "'%.40s' has no unit (write '%.40s %s' or a plain number)", text, text, want);
        return DIG_E_ARG;
    }
    if (want && !fits(got, wanted))
        return wrong_dimension(text, x, got, wanted, want, why, capacity);
    return finish(text, x, scale, value, why, capacity);
}
