/* tests/unit/test_own.c - effects of the caller's in C: asked at each evaluation, failing without a trace, shared with snapshots. */
#include "check.h"

#include "digbox.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct Own { int calls; dig_status end; real force; } Own;

static dig_status step(void *data, const dig_effect_call *call, char *why, size_t capacity)
{
    Own *o = data;
    o->calls++;
    for (int i = 0; i < call->count; i++)
        call->parts[i].force.x = o->force * call->parts[i].mass;
    snprintf(why, capacity, "it was told to");
    return o->end;
}

static dig_world *open_world(dig_body *body)
{
    char why[256];
    dig_world_def def = dig_world_defaults();
    dig_world *w;
    def.gravity = (vec3){0, 0, 0};
    CHECK_INT(dig_world_open(&def, &w, why, sizeof why), DIG_OK);
    const dig_sphere_def sphere = {0.1};
    const dig_shape_def shape = {.type = "sphere", .data = &sphere, .colour = {-1, -1, -1}};
    dig_body_def b = dig_body_defaults();
    b.shapes = &shape;
    b.shape_count = 1;
    CHECK_INT(dig_body_create(w, &b, body), DIG_OK);
    return w;
}

static void forces_are_added(void **state)
{
    (void)state;
    dig_body b;
    dig_body_state s;
    dig_world *w = open_world(&b);
    Own own = {.force = 3};
    const dig_effect_def def = {.name = "wind", .law = "F = m a", .stage = DIG_STAGE_FORCE, .all = true, .step = step, .data = &own};
    CHECK_INT(dig_effect_add(w, &def), DIG_OK);
    CHECK_INT(dig_effect_add(w, &def), DIG_E_ARG);
    for (int i = 0; i < 60; i++)
        CHECK_INT(dig_world_step(w), DIG_OK);
    CHECK_INT(dig_body_get(w, b, &s), DIG_OK);
    CHECK_NEAR(s.velocity.x, 3, 1e-12);
    CHECK(own.calls >= 60);
    CHECK_INT(dig_effect_drop(w, "wind"), DIG_OK);
    CHECK_INT(dig_effect_drop(w, "wind"), DIG_E_ARG);
    CHECK_INT(dig_effect_drop(w, "gravity"), DIG_E_ARG);
    dig_world_close(w);
}

static void a_failure_changes_nothing(void **state)
{
    (void)state;
    const dig_status ends[] = {DIG_E_ARG, DIG_E_BUSY, DIG_E_FINITE};
    dig_body b;
    dig_world *w = open_world(&b);
    Own own = {.force = 1};
    const dig_effect_def def = {.name = "wind", .stage = DIG_STAGE_FORCE, .all = true, .step = step, .data = &own};
    CHECK_INT(dig_effect_add(w, &def), DIG_OK);
    CHECK_INT(dig_world_step(w), DIG_OK);
    uint64_t sum = dig_world_checksum(w);
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        own.end = ends[i];
        CHECK_INT(dig_world_step(w), DIG_E_ARG);
        CHECK(strstr(dig_error(w), "effect 'wind': it was told to") != NULL);
        CHECK(dig_world_checksum(w) == sum);
    }
    own = (Own){.force = (real)INFINITY};
    CHECK_INT(dig_world_step(w), DIG_E_FINITE);
    CHECK(strstr(dig_error(w), "effect 'wind' gave") != NULL);
    CHECK(dig_world_checksum(w) == sum);
    own.force = 1;
    CHECK_INT(dig_world_step(w), DIG_OK);
    dig_world_close(w);
}

static void snapshots_share_it(void **state)
{
    (void)state;
    dig_body b;
    dig_world *w = open_world(&b);
    dig_snapshot *before, *after;
    Own own = {.force = 1};
    const dig_effect_def def = {.name = "wind", .stage = DIG_STAGE_FORCE, .step = step, .data = &own};
    CHECK_INT(dig_world_snapshot(w, &before), DIG_OK);
    CHECK_INT(dig_effect_add(w, &def), DIG_OK);
    CHECK_INT(dig_world_step(w), DIG_OK);
    CHECK_INT(own.calls, 0);                    /* nobody has joined */
    CHECK_INT(dig_effect_join(w, "wind", b, NULL, NULL), DIG_OK);
    CHECK_INT(dig_world_snapshot(w, &after), DIG_OK);
    CHECK_INT(dig_world_restore(w, before), DIG_OK);
    dig_snapshot_free(before);
    CHECK_INT(dig_effect_drop(w, "wind"), DIG_E_ARG);
    CHECK_INT(dig_world_restore(w, after), DIG_OK);
    CHECK_INT(dig_world_step(w), DIG_OK);
    CHECK(own.calls > 0);
    CHECK_INT(dig_effect_drop(w, "wind"), DIG_OK);
    dig_world_close(w);
    dig_snapshot_free(after);                   /* the last that knows it */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_are_added),
        cmocka_unit_test(a_failure_changes_nothing),
        cmocka_unit_test(snapshots_share_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
