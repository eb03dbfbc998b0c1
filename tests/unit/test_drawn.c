/* tests/unit/test_drawn.c - what a picture shows of joints between two points: bars and coils from end to end. */
#include "physics_fixture.h"

#include "base/param.h"
#include "view/view.h"

/* A ball of radius 0.1 m at x, 1 m below a point of the world, on a joint of that type. */
static dig_joint hang(dig_world *w, const char *type, real x)
{
    real params[64];
    const dig_schema *s = dig_schema_find("joint", type);
    dig_body b = add_ball(w, look(0, 0), 0.1, 1, (vec3){x, 2, 0}, vec3_zero());
    dig_schema_defaults(s, params);
    const dig_param *stiffness = param_find(s->rows, "stiffness"), *end = param_find(s->rows, "at_b");
    if (stiffness)
        *(real *)(void *)((char *)params + stiffness->offset) = 500;
    *(vec3 *)(void *)((char *)params + end->offset) = (vec3){x, 3, 0};
    return create_joint(w, type, b, (dig_body){0, 0}, (vec3){x, 3, 0}, (vec3){0, 1, 0}, params);
}

static View *picture(dig_world *w)
{
    View *v;
    CHECK_INT(dig_view_take(w, &v), DIG_OK);
    return v;
}

static const ViewItem *item_of(const View *v, dig_joint j)
{
    for (int i = 0; i < v->item_count; i++)
        if (v->items[i].joint == j.slot + 1)
            return &v->items[i];
    return NULL;
}

/* m  How far the vertices of a mesh that stands along y lie from its axis, at most, and from its middle along it. */
static void extents(const ViewMesh *m, real *aside, real *along)
{
    *aside = *along = 0;
    for (int i = 0; i < m->vertex_count; i++) {
        *aside = real_max(*aside, hypot((real)m->vertices[3 * i], (real)m->vertices[3 * i + 2]));
        *along = real_max(*along, fabs((real)m->vertices[3 * i + 1]));
    }
}

TEST(ropes_rods_and_springs_are_seen_from_end_to_end)
{
    static const char *const types[] = {"rope", "distance", "spring"};
    static const real most[] = {0.01, 0.01, 0.05};      /* m, radius beside a ball of 0.1 m */
    dig_world *w = open_world(1.0 / 60, NULL, false);
    dig_joint j[3];
    for (int i = 0; i < 3; i++)
        j[i] = hang(w, types[i], i);
    dig_joint other = join_bodies(w, "hinge", add_ball(w, look(0, 0), 0.1, 1, (vec3){5, 2, 0}, vec3_zero()), (dig_body){0, 0}, (vec3){5, 3, 0}, (vec3){0, 0, 1});
    View *v = picture(w);
    for (int i = 0; i < 3; i++) {
        const ViewItem *item = item_of(v, j[i]);
        real aside, along;
        CHECK(item != NULL);
        CHECK_INT(v->meshes[item->mesh].form, i == 2 ? VIEW_MESH : VIEW_CYLINDER);
        extents(&v->meshes[item->mesh], &aside, &along);
        CHECK_NEAR(along, 0.5, 0.01);                   /* 1 m from end to end; a wire has a thickness */
        CHECK(aside > 0.001 && aside <= most[i]);
        CHECK_NEAR(item->p[0], i, 1e-6);
        CHECK_NEAR(item->p[1], 2.5, 1e-6);
    }
    CHECK(item_of(v, other) == NULL);                   /* no bar from point to point */
    dig_view_free(v);
    dig_world_close(w);
}

/* The wire's surface looks outwards: to a two-sided shader, too, that is its front. */
TEST(the_faces_of_a_coil_look_away_from_its_wire)
{
    dig_world *w = open_world(1.0 / 60, NULL, false);
    dig_joint j = hang(w, "spring", 0);
    View *v = picture(w);
    const ViewMesh *m = &v->meshes[item_of(v, j)->mesh];
    for (int i = 0; i < m->index_count; i += 3) {
        vec3 p[3], n = vec3_zero();
        for (int k = 0; k < 3; k++) {
            const float *at = m->vertices + 3 * m->indices[i + k], *normal = m->normals + 3 * m->indices[i + k];
            p[k] = (vec3){(real)at[0], (real)at[1], (real)at[2]};
            n = vec3_add(n, (vec3){(real)normal[0], (real)normal[1], (real)normal[2]});
        }
        CHECK(vec3_dot(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])), n) > 0);
    }
    dig_view_free(v);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(ropes_rods_and_springs_are_seen_from_end_to_end),
              unit_test(the_faces_of_a_coil_look_away_from_its_wire));
}
