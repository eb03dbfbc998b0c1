/* tests/unit/test_shape_make.c - making, sharing and refusing shapes; the rows that describe them. */
#include "check.h"
#include "geom/shape.h"

static void check_refused(const char *type, const void *def, dig_status status, const char *sentence)
{
    Shape s;
    char why[256] = "";
    CHECK_INT(shape_make(type, def, &s, why, sizeof why), status);
    CHECK_TEXT(why, sentence);
    CHECK(s.type == NULL && s.data == NULL && s.refs == NULL);
}

TEST(numbers_out_of_range_are_named_with_unit_and_bounds)
{
    check_refused("sphere", &(dig_sphere_def){-1}, DIG_E_ARG, "sphere radius = -1 m, must be 0.0001 to 100000 m");
    check_refused("sphere", &(dig_sphere_def){0}, DIG_E_ARG, "sphere radius = 0 m, must be 0.0001 to 100000 m");
    check_refused("sphere", &(dig_sphere_def){NAN}, DIG_E_FINITE, "sphere radius = nan m, must be 0.0001 to 100000 m");
    check_refused("sphere", &(dig_sphere_def){INFINITY}, DIG_E_FINITE, "sphere radius = inf m, must be 0.0001 to 100000 m");
    check_refused("box", &(dig_box_def){{1, 9e-5, 1}}, DIG_E_ARG, "box size.y = 9e-05 m, must be 0.0001 to 100000 m");
    check_refused("capsule", &(dig_capsule_def){1, -2}, DIG_E_ARG, "capsule length = -2 m, must be 0.0001 to 100000 m");
    check_refused("cylinder", &(dig_cylinder_def){1, 2e5}, DIG_E_ARG, "cylinder height = 200000 m, must be 0.0001 to 100000 m");
    check_refused("cone", &(dig_cone_def){0, 1}, DIG_E_ARG, "cone radius = 0 m, must be 0.0001 to 100000 m");
    check_refused("plane", &(dig_plane_def){{0, 0, 0}, 0}, DIG_E_ARG, "plane normal = {0, 0, 0}, must have a direction");
    check_refused("plane", &(dig_plane_def){{0, 1, 0}, NAN}, DIG_E_FINITE, "plane offset = nan m, must be -100000 to 100000 m");
    check_refused("torus", &(dig_sphere_def){0.7}, DIG_E_ARG, "there is no shape 'torus'");
    check_refused("box", NULL, DIG_E_ARG, "box has no data");
}

TEST(the_limits_themselves_are_allowed)
{
    Shape s;
    char why[128] = "";
    CHECK_INT(shape_make("sphere", &(dig_sphere_def){SHAPE_LENGTH_MIN}, &s, why, sizeof why), DIG_OK);
    shape_free(&s);
    CHECK_INT(shape_make("box", &(dig_box_def){{SHAPE_LENGTH_MAX, SHAPE_LENGTH_MIN, SHAPE_LENGTH_MAX}}, &s, why, sizeof why), DIG_OK);
    shape_free(&s);
}

TEST(shapes_are_shared_until_the_last_goes)
{
    Shape a;
    char why[128];
    CHECK_INT(shape_make("box", &(dig_box_def){{1, 2, 3}}, &a, why, sizeof why), DIG_OK);
    Shape b = shape_keep(&a), c = shape_keep(&b);
    CHECK_INT(*a.refs, 3);
    CHECK_INT(shape_bytes(&a), sizeof(BoxData));
    shape_free(&a);
    CHECK(a.data == NULL && a.refs == NULL);
    CHECK_INT(*b.refs, 2);
    shape_free(&c);
    CHECK_NEAR(((const BoxData *)b.data)->half.z, 1.5, 0);
    shape_free(&b);
    shape_free(&b);             /* a zeroed shape is nothing */
}

/* What the manual, the checks and Lua read must fit the structs. */
TEST(parameter_rows_are_sound)
{
    int types = 0;
    for (; shape_types[types]; types++) {
        const ShapeType *t = shape_types[types];
        CHECK(shape_type_find(t->name) == t);
        CHECK(strlen(t->doc) > 8 && t->doc[strlen(t->doc) - 1] == '.');
        CHECK(t->make && t->bounds && t->ray && t->contains && t->mesh);
        CHECK((t->convex || t->foot) == (t->support != NULL) && t->convex == (t->face != NULL));
        CHECK(!t->solid || t->mass);
        CHECK((t->pieces != NULL) == (t->piece != NULL) && (t->pieces != NULL) == (t->neighbour != NULL));
        for (const dig_param *row = t->params; row->name; row++) {
            CHECK(row->offset < t->def_size && row->min < row->max && row->doc[0] && row->unit);
            CHECK(row->required ? isnan(row->fallback) : row->fallback >= row->min && row->fallback <= row->max);
        }
    }
    CHECK_INT(types, 9);
    CHECK(shape_type_find("nothing") == NULL && shape_type_find(NULL) == NULL);
}

int main(void)
{
    RUN_TESTS(unit_test(numbers_out_of_range_are_named_with_unit_and_bounds),
              unit_test(the_limits_themselves_are_allowed),
              unit_test(shapes_are_shared_until_the_last_goes),
              unit_test(parameter_rows_are_sound));
}
