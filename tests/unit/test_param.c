/* test_param.c - parameter rows: defaults, checks with value, unit and bound, and suggestions. */

#include "base/param.h"
#include "check.h"

typedef struct Motor { real speed, max_torque; } Motor;
typedef struct Thing {
    real     mass, angle;
    int64_t  count, choice;
    bool     on;
    vec3     at, axis, size, colour;
    quat     turn;
    real     limits[2], teeth[2];
    dig_text name;
    Motor    motor;
    dig_points points;
    dig_body   body;
} Thing;

static const char *const choices[] = {"red", "green", NULL};

static const dig_param motor_rows[] = {
    {"speed", DIG_REAL, "rad/s", "", NAN, -1e3, 1e3, offsetof(Motor, speed), NULL, NULL, false, 0},
    {"max_torque", DIG_REAL, "N*m", "", INFINITY, 0, INFINITY, offsetof(Motor, max_torque), NULL, NULL, false, 0},
    {.name = NULL},
};

static const dig_param rows[] = {
    {"mass", DIG_REAL, "kg", "", NAN, 1e-9, 1e9, offsetof(Thing, mass), NULL, NULL, false, 0},
    {"angle", DIG_REAL, "rad", "", 0.5, -1, 1, offsetof(Thing, angle), NULL, NULL, false, 0},
    {"count", DIG_INT, "1", "", 3, 0, 10, offsetof(Thing, count), NULL, NULL, false, 0},
    {"choice", DIG_CHOICE, "", "", 1, 0, 0, offsetof(Thing, choice), NULL, choices, false, 0},
    {"on", DIG_BOOL, "", "", 1, 0, 0, offsetof(Thing, on), NULL, NULL, false, 0},
    {"at", DIG_VEC3, "m", "", 0, 0, 0, offsetof(Thing, at), NULL, NULL, false, 0},
    {"axis", DIG_DIR, "1", "", NAN, 0, 0, offsetof(Thing, axis), NULL, NULL, false, 0},
    {"size", DIG_SIZE3, "m", "", 1, 0, 0, offsetof(Thing, size), NULL, NULL, false, 0},
    {"colour", DIG_COLOUR, "1", "", -1, 0, 1, offsetof(Thing, colour), NULL, NULL, false, 0},
    {"turn", DIG_QUAT, "", "", 0, 0, 0, offsetof(Thing, turn), NULL, NULL, false, 0},
    {"limits", DIG_RANGE, "rad", "", NAN, -INFINITY, INFINITY, offsetof(Thing, limits), NULL, NULL, false, 0},
    {"teeth", DIG_PAIR, "1", "", 1, -100, 100, offsetof(Thing, teeth), NULL, NULL, false, 0},
    {"name", DIG_TEXT, "", "", 0, 0, 0, offsetof(Thing, name), NULL, NULL, false, 0},
    {"motor", DIG_TABLE, "", "", 0, 0, 0, offsetof(Thing, motor), motor_rows, NULL, false, 0},
    {"points", DIG_POINTS, "m", "", 0, 0, 0, offsetof(Thing, points), NULL, NULL, false, 0},
    {"body", DIG_BODY, "", "", 0, 0, 0, offsetof(Thing, body), NULL, NULL, false, 0},
    {.name = NULL},
};

static const dig_schema schema = {"thing", "", rows, sizeof(Thing)};

static Thing fresh(void)
{
    Thing t;
    memset(&t, 0x55, sizeof t);
    dig_schema_defaults(&schema, &t);
    return t;
}

static void refused(const Thing *t, const char *sentence)
{
    char why[200] = "";
    CHECK_INT(param_check(rows, t, "body 'plank 7'", why, sizeof why), DIG_E_ARG);
    CHECK_TEXT(why, sentence);
}

static void accepted(const Thing *t)
{
    char why[200] = "";
    if (param_check(rows, t, "thing", why, sizeof why) != DIG_OK)
        fail_msg("refused: %s", why);
}

TEST(defaults_fill_every_kind_and_pass_their_own_check)
{
    Thing t = fresh();
    CHECK(isnan(t.mass) && isnan(t.axis.x) && isnan(t.limits[0]) && isnan(t.motor.speed));
    CHECK_NEAR(t.angle, 0.5, 0);
    CHECK_INT(t.count, 3);
    CHECK_INT(t.choice, 1);
    CHECK(t.on);
    CHECK_NEAR(t.size.y, 1, 0);
    CHECK_NEAR(t.colour.x, -1, 0);
    CHECK_NEAR(t.turn.w, 1, 0);
    CHECK_TEXT(t.name.s, "");
    CHECK(isinf(t.motor.max_torque));
    CHECK_INT(t.points.count, 0);
    CHECK_INT(t.body.gen, 0);
    accepted(&t);
}

TEST(a_refusal_names_value_unit_and_bound)
{
    Thing t = fresh();
    t.mass = -3;
    refused(&t, "body 'plank 7': mass = -3 kg, must be > 0");
    t.mass = 1e-12;
    refused(&t, "body 'plank 7': mass = 1e-12 kg, must be at least 1e-09 kg");
    t.mass = INFINITY;
    refused(&t, "body 'plank 7': mass = inf kg, must be at most 1e+09 kg");
    t = fresh();
    t.angle = NAN;
    refused(&t, "body 'plank 7': angle = nan rad, must be a finite number");
    t = fresh();
    t.count = -1;
    refused(&t, "body 'plank 7': count = -1, must be >= 0");
    t.count = 11;
    refused(&t, "body 'plank 7': count = 11, must be at most 10");
    t = fresh();
    t.at.y = NAN;
    refused(&t, "body 'plank 7': at.y = nan m, must be a finite number");
    t = fresh();
    t.size.z = 0;
    refused(&t, "body 'plank 7': size.z = 0 m, must be > 0");
    t = fresh();
    t.axis = (vec3){0, 0, 0};
    refused(&t, "body 'plank 7': axis = {0, 0, 0}, must not be zero: it is a direction");
    t = fresh();
    t.motor.max_torque = -2;
    refused(&t, "body 'plank 7': motor: max_torque = -2 N*m, must be >= 0");
}

TEST(odd_values_of_every_other_kind_are_refused)
{
    Thing t = fresh();
    t.limits[0] = 1;
    t.limits[1] = -1;
    refused(&t, "body 'plank 7': limits = {1, -1} rad, must have the lower bound first");
    t = fresh();
    t.teeth[0] = 40;            /* a pair has no order, but bounds */
    t.teeth[1] = -20;
    accepted(&t);
    t.teeth[1] = -101;
    refused(&t, "body 'plank 7': teeth[2] = -101, must be at least -100");
    t = fresh();
    t.turn = (quat){0, 0, 0, 0};
    refused(&t, "body 'plank 7': turn = {0, 0, 0, 0}, must be finite and not zero: it is a rotation");
    t = fresh();
    t.choice = 2;
    refused(&t, "body 'plank 7': choice = 2 is not one of its 2 choices");
    t = fresh();
    t.colour = (vec3){0.5, 2, 0};
    refused(&t, "body 'plank 7': colour.y = 2, must be at most 1");
    t = fresh();
    strcpy(t.name.s, "a\nb");
    refused(&t, "body 'plank 7': name holds a control character");
    t = fresh();
    memset(t.name.s, 'x', sizeof t.name.s);
    refused(&t, "body 'plank 7': name is longer than 63 bytes");
    t = fresh();
    vec3 bad[2] = {{0, 0, 0}, {0, INFINITY, 0}};
    t.points = (dig_points){bad, 2};
    refused(&t, "body 'plank 7': points[2] = {0, inf, 0} m, must be finite");
}

TEST(rows_are_found_by_name_and_by_path)
{
    size_t offset = 0;
    CHECK(param_find(rows, "limits") == &rows[10]);
    CHECK(param_find(rows, "limit") == NULL);
    CHECK_INT(param_count(rows), 16);
    CHECK(param_find_path(rows, "motor.max_torque", &offset) == &motor_rows[1]);
    CHECK_INT(offset, offsetof(Thing, motor) + offsetof(Motor, max_torque));
    CHECK(param_find_path(rows, "mass.x", &offset) == NULL);
    CHECK(param_find_path(rows, "motor.", &offset) == NULL);
}

TEST(suggestions_come_within_a_third_of_the_length)
{
    static const char *const names[] = {"radius", "mass", "ball", "friction", "at"};
    CHECK_TEXT(dig_suggest("radus", names, 5), "radius");
    CHECK_TEXT(dig_suggest("bll", names, 5), "ball");
    CHECK_TEXT(dig_suggest("frcition", names, 5), "friction");      /* a swap costs one */
    CHECK_TEXT(dig_suggest("frictoin", names, 5), "friction");
    CHECK(dig_suggest("bounciness", names, 5) == NULL);
    CHECK(dig_suggest("xy", names, 5) == NULL);
    CHECK(dig_suggest("a", NULL, 0) == NULL);
    CHECK_TEXT(dig_suggest("a", names, 5), "at");
}

int main(void)
{
    RUN_TESTS(unit_test(defaults_fill_every_kind_and_pass_their_own_check), unit_test(a_refusal_names_value_unit_and_bound),
              unit_test(odd_values_of_every_other_kind_are_refused), unit_test(rows_are_found_by_name_and_by_path),
              unit_test(suggestions_come_within_a_third_of_the_length));
}
