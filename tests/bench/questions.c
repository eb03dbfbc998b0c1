/* tests/bench/questions.c - what a question costs, in steps of the DIG it is about: `make bench SCENE=questions`.
 *
 * The door of worlds/bolted_door.lua with a box of 20 kg behind it, on a floor: alone, and in a street of a hundred more. The yardstick
 * is a step of the world in which that door is alone and is pushed; both are CPU time of one run.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "math/quat.h"

enum { OTHERS = 100, STEPS = 300, ASKED = 60, ROUNDS = 5 };

typedef struct Door { dig_body leaf, frame; } Door;

/* us of CPU time */
static double now_us(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e6 + (double)t.tv_nsec * 1e-3;
}

static void need(const dig_world *w, bool good)
{
    if (good)
        return;
    fprintf(stderr, "bench: questions: %s\n", w ? dig_error(w) : "out of memory");
    exit(1);
}

static dig_body add_box(dig_world *w, vec3 at, vec3 size, double mass, double friction, double turned)
{
    const dig_box_def box = {size};
    const dig_shape_def shape = {.type = "box", .data = &box, .colour = {-1, -1, -1}};
    dig_body_def def = dig_body_defaults();
    dig_body b;
    def.at = at;
    def.rotation = quat_exp((vec3){0, turned, 0});
    def.fixed = !(mass > 0);
    def.mass = mass > 0 ? mass : NAN;
    def.friction = friction;
    def.shapes = &shape;
    def.shape_count = 1;
    need(w, dig_body_create(w, &def, &b) == DIG_OK);
    return b;
}

/* The box stands against the door with one edge, 0.40 m from the hinge. */
static Door add_door(dig_world *w, vec3 at, bool bolted)
{
    Door d;
    const double half = 0.15 * sqrt(2);
    d.frame = add_box(w, vec3_add(at, (vec3){-0.06, 1.1, 0}), (vec3){0.1, 2.2, 0.1}, 0, 0.5, 0);
    d.leaf = add_box(w, vec3_add(at, (vec3){0.4, 1.01, 0}), (vec3){0.8, 2, 0.04}, 10, 0, 0);
    add_box(w, vec3_add(at, (vec3){0.4, 0.15, -0.02 - half}), (vec3){0.3, 0.3, 0.3}, 20, 0.5, atan(1));
    dig_joint_def def = dig_joint_defaults();
    dig_joint j;
    def.type = "hinge";
    def.a = d.leaf;
    def.b = d.frame;
    def.at = vec3_add(at, (vec3){0, 1, 0});
    def.axis = (vec3){0, 1, 0};
    need(w, dig_joint_create(w, &def, &j) == DIG_OK);
    def.type = "bolt";
    def.at = vec3_add(at, (vec3){0.4, 1, 0});
    if (bolted)
        need(w, dig_joint_create(w, &def, &j) == DIG_OK);
    return d;
}

static dig_world *street(int others, bool sleeping, bool bolted, Door *door)
{
    dig_world_def def = dig_world_defaults();
    dig_world *w = NULL;
    char why[256];
    def.gravity = (vec3){0, -9.80665, 0};
    def.sleeping = sleeping;
    need(NULL, dig_world_open(&def, &w, why, sizeof why) == DIG_OK);
    const dig_plane_def plane = {{0, 1, 0}, 0};
    const dig_shape_def shape = {.type = "plane", .data = &plane, .colour = {-1, -1, -1}};
    dig_body_def ground = dig_body_defaults();
    dig_body floor;
    ground.fixed = true;
    ground.friction = 0.5;
    ground.shapes = &shape;
    ground.shape_count = 1;
    need(w, dig_body_create(w, &ground, &floor) == DIG_OK);
    *door = add_door(w, (vec3){0, 0, 0}, bolted);
    for (int i = 1; i <= others; i++)
        add_door(w, (vec3){4.0 * (i % 10), 0, 4.0 * (i / 10 + 1)}, false);
    for (int i = 0; i < 60; i++)
        need(w, dig_world_step(w) == DIG_OK);
    return w;
}

static double least(double a, double b) { return a < b ? a : b; }

/* us of a step of that DIG alone, while it is pushed in vain */
static double step_us(void)
{
    Door d;
    double best = 1e30;
    dig_world *w = street(0, false, false, &d);
    need(w, dig_body_push(w, d.leaf, (vec3){0, 0, -40}, (vec3){0.75, 1, 0}, true, 1e6) == DIG_OK);
    for (int r = 0; r < ROUNDS; r++) {
        double start = now_us();
        for (int i = 0; i < STEPS; i++)
            need(w, dig_world_step(w) == DIG_OK);
        best = least(best, (now_us() - start) / STEPS);
    }
    dig_world_close(w);
    return best;
}

static double ask_us(dig_world *w, const dig_question *q, dig_answer *a)
{
    double best = 1e30;
    for (int r = 0; r < ROUNDS; r++) {
        double start = now_us();
        for (int i = 0; i < ASKED / ROUNDS; i++)
            need(w, dig_ask(w, q, a) == DIG_OK);
        best = least(best, (now_us() - start) / (ASKED / ROUNDS));
    }
    return best;
}

static void ask(const char *what, double with, bool bolted, double step)
{
    for (int others = 0; others <= OTHERS; others += OTHERS) {
        Door d;
        dig_answer a;
        dig_world *w = street(others, true, bolted, &d);
        dig_question q = dig_question_defaults();
        q.body = d.leaf;
        q.along = (vec3){0, 0, -1};
        q.at = (vec3){0.75, 1, 0};
        q.has_at = true;
        q.by = 0.2;
        q.with = with;
        double us = ask_us(w, &q, &a);
        printf("  %-26s %5d %9s %8.2f %6d %6d %9.1f %9.1f %9.2f\n", what, others, dig_verdict_name(a.verdict), a.needs, a.trials, a.steps, us,
               us / step, us / step / a.steps);
        dig_world_close(w);
    }
}

int main(void)
{
    double step = step_us();
    printf("a step of the DIG alone: %.1f us\n", step);
    printf("  %-26s %5s %9s %8s %6s %6s %9s %9s %9s\n", "asked", "other", "verdict", "needs/N", "trials", "steps", "us", "in steps", "per step");
    ask("40 N, the box holds", 40, false, step);
    ask("how much, the box holds", NAN, false, step);
    ask("40 N, the bolt holds", 40, true, step);
    ask("60 N, it opens 20 cm", 60, false, step);
    return 0;
}
