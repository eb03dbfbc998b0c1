/* tests/unit/test_drawn.c - what a picture shows of joints between two points, bars and coils from end to end, of sheets, and of the room. */
#include "physics_fixture.h"

#include <stdlib.h>

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
    dig_body door = add_ball(w, look(0, 0), 0.1, 1, (vec3){5, 2, 0}, vec3_zero());
    dig_joint other = join_bodies(w, "hinge", door, (dig_body){0, 0}, (vec3){5, 3, 0}, (vec3){0, 0, 1});
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

enum { SIDE = 3 };          /* particles each way */

typedef struct Cloth { dig_world *w; dig_body body[SIDE][SIDE]; dig_joint across[SIDE][SIDE]; } Cloth;

static dig_joint tie(dig_world *w, dig_body a, dig_body b)
{
    real params[64];
    const dig_schema *s = dig_schema_find("joint", "strut");
    dig_schema_defaults(s, params);
    *(real *)(void *)((char *)params + param_find(s->rows, "stiffness")->offset) = 100;
    *(real *)(void *)((char *)params + param_find(s->rows, "radius")->offset) = 0.01;
    return create_joint(w, "strut", a, b, vec3_zero(), (vec3){0, 1, 0}, params);
}

/* Sheet 7: columns along x, rows down, 1 m apart; the first row is fixed and has no threads of its own. */
static Cloth cloth(void)
{
    Cloth c = {.w = open_world(1.0 / 60, NULL, true)};
    for (int j = 0; j < SIDE; j++)
        for (int i = 0; i < SIDE; i++) {
            dig_body_def d = body_with(look(0, 0), (vec3){i, 5 - j, 0}, quat_identity());
            d.sheet = (vec3){7, i + 1, j + 1};
            d.fixed = j == 0;
            d.colour = (vec3){1, 0, 0};
            c.body[j][i] = add_body(c.w, d, "sphere", &(dig_sphere_def){0.1});
        }
    for (int j = 0; j < SIDE; j++)
        for (int i = 0; i < SIDE; i++) {
            if (j > 0 && i > 0)
                c.across[j][i] = tie(c.w, c.body[j][i - 1], c.body[j][i]);
            if (j > 0)
                tie(c.w, c.body[j - 1][i], c.body[j][i]);
        }
    return c;
}

static const ViewItem *sheet_of(const View *v)
{
    for (int i = 0; i < v->item_count; i++)
        if (v->meshes[v->items[i].mesh].taken)
            return &v->items[i];
    return NULL;
}

static int count_apart(const View *v)
{
    int count = 0;
    for (int i = 0; i < v->item_count; i++)
        count += !v->items[i].woven;
    return count;
}

TEST(particles_in_rows_that_struts_join_are_one_surface)
{
    Cloth c = cloth();
    View *v = picture(c.w);
    const ViewItem *sheet = sheet_of(v);
    CHECK(sheet != NULL);
    CHECK_INT(v->quad_count, 4);
    CHECK_INT(count_apart(v), 1);               /* neither balls nor struts */
    CHECK_INT(sheet->body, c.body[0][0].slot + 1);
    CHECK_NEAR(sheet->colour[0], 1, 1e-6);
    CHECK(sheet->dig != 0);
    const ViewMesh *m = &v->meshes[sheet->mesh];
    CHECK_INT(m->vertex_count, SIDE * SIDE);
    CHECK_INT(m->index_count, 6 * 4);
    for (int i = 0; i < m->vertex_count; i++)
        CHECK_NEAR(fabsf(m->normals[3 * i + 2]), 1, 1e-6);
    dig_view_free(v);
    dig_world_close(c.w);
}

/* A thread that is gone takes the quads beside it: what they joined is seen by itself where nothing else of the sheet is there. */
TEST(a_sheet_opens_where_it_is_torn)
{
    Cloth c = cloth();
    CHECK_INT(dig_joint_remove(c.w, c.across[2][2]), DIG_OK);           /* at its lower edge, beside one quad */
    View *v = picture(c.w);
    CHECK_INT(v->quad_count, 3);
    CHECK_INT(count_apart(v), 3);               /* the sheet, the particle in the corner and the thread it hangs by */
    dig_view_free(v);
    CHECK_INT(dig_joint_remove(c.w, c.across[1][1]), DIG_OK);           /* between two */
    v = picture(c.w);
    CHECK_INT(v->quad_count, 1);
    dig_view_free(v);
    dig_world_close(c.w);
}

/* Films show moments between steps: there the vertices are between, too. */
TEST(a_sheet_is_blended_between_two_pictures)
{
    Cloth c = cloth();
    View *a = picture(c.w);
    step(c.w, 1);
    View *b = picture(c.w);
    ViewPose *from = view_poses(a), *to = view_poses(b);
    const ViewItem *now = sheet_of(b), *was = sheet_of(a);
    int low = 0;                                /* the vertex that fell most */
    for (int i = 0; i < SIDE * SIDE; i++)
        low = b->meshes[now->mesh].taken[3 * i + 1] < b->meshes[now->mesh].taken[3 * low + 1] ? i : low;
    double before = (double)was->p[1] + (double)a->meshes[was->mesh].vertices[3 * low + 1];
    double after = (double)now->p[1] + (double)b->meshes[now->mesh].vertices[3 * low + 1];
    CHECK(after < before - 1e-3);
    for (int k = 0; k <= 4; k++) {
        view_blend(a, from, b, to, k / 4.0);
        CHECK_NEAR(now->p[1] + b->meshes[now->mesh].vertices[3 * low + 1], before + k / 4.0 * (after - before), 1e-6);
    }
    free(from);
    free(to);
    dig_view_free(a);
    dig_view_free(b);
    dig_world_close(c.w);
}

/* Parts of the room that are level and lie at its floor, and all. */
static void count_room(const View *v, real floor, int *below, int *all)
{
    *below = *all = 0;
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        const float *size = v->meshes[item->mesh].size;
        real top = (real)item->p[1] + 0.5 * (real)size[1] + v->origin[1];
        *all += item->room;
        *below += item->room && size[0] > 3.9f && size[2] > 5.9f && top < floor && top > floor - 1e-3;
        CHECK(!item->room || (item->body == 0 && item->joint == 0 && item->fixed));
    }
}

/* Without them what lies in a room seems to float in the air. */
TEST(a_room_is_seen_by_its_floor_and_its_edges)
{
    dig_world *w = open_world(1.0 / 60, NULL, false);
    dig_room_def room = {.size = {4, 3, 6}, .at = {1, 0.5, 0}, .friction = 0.5};
    int below, all;
    add_ball(w, look(0, 0), 0.1, 1, (vec3){0, 0.6, 0}, vec3_zero());
    CHECK_INT(dig_room_set(w, &room), DIG_OK);
    View *v = picture(w);
    count_room(v, 0.5, &below, &all);
    CHECK_INT(below, 1);
    CHECK_INT(all, 13);
    dig_view_free(v);
    CHECK_INT(dig_room_open(w, "-y", true), DIG_OK);
    v = picture(w);
    count_room(v, 0.5, &below, &all);
    CHECK_INT(below, 0);
    CHECK_INT(all, 12);
    dig_view_free(v);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(a_room_is_seen_by_its_floor_and_its_edges),
              unit_test(particles_in_rows_that_struts_join_are_one_surface),
              unit_test(a_sheet_opens_where_it_is_torn),
              unit_test(a_sheet_is_blended_between_two_pictures),
              unit_test(ropes_rods_and_springs_are_seen_from_end_to_end),
              unit_test(the_faces_of_a_coil_look_away_from_its_wire));
}
