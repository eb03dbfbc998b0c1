/* tests/unit/test_network.c - the nodal solver against closed forms: heat (T1 to T5, T7, T10 of the heat cases), a bridge of
 * resistors, and what must hold of any network. */
#include "check.h"

#include "base/rng.h"
#include "solve/network.h"

#include <stdlib.h>

#define FRAME (1.0 / 60)
#define SIGMA 5.670374419e-8    /* W/(m^2 K^4) */

typedef struct Bench { Arena arena; Network net; int boundary, branch; } Bench;

static void bench_open(Bench *b, int nodes, int boundaries, int branches)
{
    memset(b, 0, sizeof *b);
    CHECK(network_open(&b->net, &b->arena, nodes, boundaries, branches) == DIG_OK);
}

static void bench_close(Bench *b) { arena_close(&b->arena); }

static int join(Bench *b, int from, int to, real g)
{
    b->net.branch[b->branch] = (NetBranch){.a = from, .b = to, .line = {g, 0}};
    return b->branch++;
}

static void node(Bench *b, int i, real capacity, real effort)
{
    b->net.capacity[i] = capacity;
    b->net.effort[i] = effort;
}

static void run(Bench *b, real seconds, real frame)
{
    for (long i = 0; i < lround(seconds / frame); i++) {
        network_advance(&b->net, frame);
        CHECK(!b->net.failed);
    }
}

static NetLine radiation(const NetBranch *b, real xa, real xb, real h)
{
    (void)h;
    real ta = real_max(xa, 0), g = 4 * b->p[0] * ta * ta * ta;
    return (NetLine){g, b->p[0] * (pow(ta, 4) - pow(xb, 4)) - g * (xa - xb)};
}

/* Two things that touch: the difference dies out with tau = 1 / (G (1/C1 + 1/C2)). */
static void touch(Bench *b, real tolerance)
{
    bench_open(b, 2, 0, 1);
    node(b, 0, 450, 200);
    node(b, 1, 4186, 20);
    join(b, 0, 1, 12);
    CHECK(network_plan(&b->net, &b->arena) == DIG_OK);
    b->net.tolerance = tolerance;
    run(b, 60, FRAME);
}

TEST(two_that_touch_meet)
{
    Bench b;
    touch(&b, 0);
    CHECK_NEAR(b.net.effort[0], 65.10048, 0.1);
    CHECK_NEAR(b.net.effort[1], 34.50186, 0.1);
    bench_close(&b);
    touch(&b, 1e-6);
    CHECK_NEAR(b.net.effort[0], 65.10048, 1e-5);
    CHECK_NEAR(b.net.effort[1], 34.50186, 1e-5);
    b.net.tolerance = 0;
    run(&b, 3000, 1);
    CHECK_NEAR(b.net.effort[0], 37.47196, 1e-5);
    CHECK_NEAR(b.net.effort[0], b.net.effort[1], 1e-9);
    bench_close(&b);
}

TEST(a_mug_cools)
{
    Bench b;
    bench_open(&b, 1, 1, 1);
    node(&b, 0, 0.3 * 4186, 90);
    b.net.effort[1] = 20;
    join(&b, 0, 1, 1.5);
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    run(&b, 600, FRAME);
    CHECK_NEAR(b.net.effort[0], 54.18615, 0.02);
    bench_close(&b);
}

/* Films, brick, wool, board between a room at 20 and a street at -1. */
TEST(a_wall_of_layers)
{
    Bench b;
    bench_open(&b, 4, 2, 5);
    b.net.effort[4] = 20;
    b.net.effort[5] = -1;
    const int way[6] = {4, 0, 1, 2, 3, 5};
    const real ohm[5] = {1 / 8.0, 0.1 / 0.77, 0.05 / 0.035, 0.0125 / 0.17, 1 / 23.0};
    for (int i = 0; i < 5; i++)
        join(&b, way[i], way[i + 1], 1 / ohm[i]);
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    network_settle(&b.net);
    const real want[4] = {18.5420, 17.0273, 0.3647, -0.4929};
    real sum = 0;
    for (int i = 0; i < 5; i++)
        sum += ohm[i];
    CHECK_NEAR(sum, 1.800449, 1e-6);
    CHECK_NEAR(21 / sum, 11.66376, 1e-5);
    real flow = (20 - b.net.effort[0]) / ohm[0];
    CHECK_NEAR(flow, 21 / sum, 1e-12);
    real at = 20;
    for (int i = 0; i < 4; i++) {
        at -= 21 / sum * ohm[i];
        CHECK_NEAR(b.net.effort[i], at, 1e-12);
        CHECK_NEAR(b.net.effort[i], want[i], 6e-5);     /* as printed, to four places */
    }
    bench_close(&b);
}

static void cooker(Bench *b, real g)
{
    bench_open(b, 2, 1, 3);
    node(b, 0, 600, 20);
    node(b, 1, 6679, 20);
    b->net.effort[2] = 20;
    b->net.source[0] = 1500;
    join(b, 0, 1, g);
    join(b, 0, 2, 1.2);
    join(b, 1, 2, 2);
    CHECK(network_plan(&b->net, &b->arena) == DIG_OK);
}

TEST(ring_and_pan)
{
    Bench b;
    cooker(&b, 30);
    real lost = 0;
    for (int i = 0; i < 300 * 60; i++) {
        network_advance(&b.net, FRAME);
        lost += b.net.branch[1].through + b.net.branch[2].through;
    }
    real stored = 600 * (b.net.effort[0] - 20) + 6679 * (b.net.effort[1] - 20);
    CHECK_NEAR(b.net.effort[0], 115.6647, 0.2);
    CHECK_NEAR(b.net.effort[1], 72.9085, 0.2);
    CHECK_NEAR((stored + lost) / 450000, 1, 1e-12);
    CHECK_NEAR(stored, 410774.6, 450000 * 1e-5);
    CHECK_NEAR(lost, 39225.4, 450000 * 1e-5);
    real time = 300;
    while (b.net.effort[1] < 100) {
        network_advance(&b.net, FRAME);
        time += FRAME;
    }
    CHECK_NEAR(time, 459.1425, 0.2);
    CHECK_NEAR(b.net.effort[0], 141.9344, 0.2);
    bench_close(&b);
    cooker(&b, 0);              /* the pan lifted off */
    run(&b, 300, FRAME);
    CHECK_NEAR(b.net.effort[0], 583.985, 0.2);
    CHECK_NEAR(b.net.effort[1], 20, 1e-12);
    bench_close(&b);
}

static real glow(real ambient, real tolerance, real frame)
{
    Bench b;
    bench_open(&b, 1, 1, 1);
    node(&b, 0, 500, 1000);
    b.net.effort[1] = ambient;
    b.net.branch[join(&b, 0, 1, 0)] = (NetBranch){.a = 0, .b = 1, .law = radiation, .p = {SIGMA * 0.04}};
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    b.net.tolerance = tolerance;
    real lost = 0;
    for (long i = 0; i < lround(600 / frame); i++) {
        network_advance(&b.net, frame);
        lost += b.net.branch[0].through;
    }
    CHECK_NEAR(lost / (500 * (1000 - b.net.effort[0])), 1, 1e-11);
    real end = b.net.effort[0];
    bench_close(&b);
    return end;
}

TEST(radiation_cools)
{
    CHECK_NEAR(glow(0, 0, FRAME), 477.84145, 0.2);
    CHECK_NEAR(glow(293.15, 0, FRAME), 487.35305, 0.2);
    CHECK_NEAR(glow(0, 1e-6, FRAME), 477.84145, 1e-4);
    CHECK_NEAR(glow(293.15, 1e-6, FRAME), 487.35305, 1e-4);
    CHECK_NEAR(glow(293.15, 1e-6, 60), 487.35305, 1e-4);        /* substeps are taken as they are needed */
    /* first order: the error falls with the step */
    real coarse = glow(293.15, 0, 2) - 487.35305, half = glow(293.15, 0, 1) - 487.35305;
    CHECK_NEAR(coarse / half, 2, 0.02);
}

/* The first sine of a rod whose ends are held at 0, in cells of the length L / N. */
TEST(a_rod_evens_out)
{
    enum { CELLS = 20 };
    Bench b;
    real length = 0.5, alpha = 1.11e-4, cell = length / CELLS;
    bench_open(&b, CELLS - 1, 2, CELLS);
    for (int i = 0; i < CELLS - 1; i++)
        node(&b, i, cell, sin(DIG_PI * (i + 1) / CELLS));
    for (int i = 0; i < CELLS; i++)
        join(&b, i == 0 ? CELLS - 1 : i - 1, i == CELLS - 1 ? CELLS : i, alpha / cell);
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    run(&b, 100, FRAME);
    CHECK_NEAR(b.net.effort[CELLS / 2 - 1], 0.645771, 1e-3);
    bench_close(&b);
}

static real kettle(real g)
{
    Bench b;
    bench_open(&b, 1, 1, 1);
    node(&b, 0, 4186, 15);
    b.net.effort[1] = 20;
    b.net.source[0] = 2000;
    join(&b, 0, 1, g);
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    real time = 0;
    while (b.net.effort[0] < 100) {
        network_advance(&b.net, FRAME);
        time += FRAME;
    }
    bench_close(&b);
    return time;
}

TEST(a_kettle_boils)
{
    CHECK_NEAR(kettle(0), 177.905, 0.2);
    CHECK_NEAR(kettle(1.5), 183.1191, 0.2);
}

/* Wheatstone's bridge: 10 V on 100 over 200 Ohm and 150 over 250, 50 Ohm between. */
TEST(a_bridge_of_resistors)
{
    Bench b;
    bench_open(&b, 2, 2, 5);
    b.net.effort[2] = 10;
    join(&b, 2, 0, 1 / 100.0);
    join(&b, 0, 3, 1 / 200.0);
    join(&b, 2, 1, 1 / 150.0);
    join(&b, 1, 3, 1 / 250.0);
    join(&b, 0, 1, 1 / 50.0);
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    CHECK_INT(b.net.parts, 1);
    network_settle(&b.net);
    CHECK_NEAR(b.net.effort[0], 660 / 101.0, 1e-12);
    CHECK_NEAR(b.net.effort[1], 650 / 101.0, 1e-12);
    bench_close(&b);
}

/* TR-BDF2 is of second order: with frames half as long the error is a quarter. The tolerance is out of its reach. */
static real fine_error(real frame)
{
    Bench b;
    bench_open(&b, 1, 1, 1);
    node(&b, 0, 1, 1);
    join(&b, 0, 1, 1);
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    b.net.tolerance = 1e9;
    run(&b, 1, frame);
    real error = b.net.effort[0] - exp(-1);
    bench_close(&b);
    return error;
}

TEST(fine_steps_are_of_second_order)
{
    CHECK_NEAR(fine_error(0.05) / fine_error(0.025), 4, 0.15);
    CHECK(fabs(fine_error(0.025)) < 1e-4);
}

/* A square net of nodes, larger than what is dense, with random conductances: Kirchhoff's law holds, and no effort leaves
 * the range of what it hangs on. */
enum { SIDE = 16, NODES = SIDE * SIDE };

static void square_by(Bench *b, uint64_t *seed, int direct)
{
    bench_open(b, NODES, 2, 2 * SIDE * (SIDE - 1) + 2);
    for (int i = 0; i < NODES; i++) {
        node(b, i, 1 + rng_real(seed), 300);
        if (i % SIDE + 1 < SIDE)
            join(b, i, i + 1, 0.01 + rng_real(seed));
        if (i + SIDE < NODES)
            join(b, i + SIDE, i, 0.01 + rng_real(seed));
    }
    b->net.effort[NODES] = 400;
    b->net.effort[NODES + 1] = 280;
    join(b, NODES, 0, 1);
    join(b, NODES - 1, NODES + 1, 1);
    b->net.direct = direct;
    CHECK(network_plan(&b->net, &b->arena) == DIG_OK);
    CHECK_INT(b->net.parts, 1);
    CHECK(!b->net.part[0].matrix.dense);
}

static void square(Bench *b, uint64_t *seed) { square_by(b, seed, 0); }

/* Directly and by iteration, from steps in which hardly anything happens to such in which all evens out. */
TEST(large_nets_may_be_iterated)
{
    for (int rule = 0; rule < 2; rule++)
        for (real frame = 1e-3; frame < 1e7; frame *= 1000) {
            uint64_t seed[2] = {5, 5};
            Bench b[2];
            for (int k = 0; k < 2; k++) {
                square_by(&b[k], &seed[k], k ? 64 : 0);
                CHECK(b[k].net.part[0].swept == (k > 0));
                b[k].net.tolerance = rule ? 1e-3 : 0;
                b[k].net.branch[7] = (NetBranch){.a = b[k].net.branch[7].a, .b = b[k].net.branch[7].b, .law = radiation, .p = {1e-9}};
                network_advance(&b[k].net, frame);
                network_advance(&b[k].net, frame);
                CHECK(!b[k].net.failed);
            }
            for (int i = 0; i < NODES; i++)
                CHECK_NEAR(b[1].net.effort[i], b[0].net.effort[i], 1e-9);
            bench_close(&b[0]);
            bench_close(&b[1]);
        }
}

TEST(large_nets_are_sparse_and_right)
{
    uint64_t seed = 7;
    Bench b;
    square(&b, &seed);
    CHECK(b.net.part[0].matrix.values < NODES * 16);
    network_settle(&b.net);
    real out[NODES] = {0};
    for (int i = 0; i < b.net.branches; i++) {
        const NetBranch *e = &b.net.branch[i];
        real flow = e->line.g * (b.net.effort[e->a] - b.net.effort[e->b]);
        if (e->a < NODES)
            out[e->a] += flow;
        if (e->b < NODES)
            out[e->b] -= flow;
    }
    for (int i = 0; i < NODES; i++) {
        CHECK_NEAR(out[i], 0, 1e-11);
        CHECK(b.net.effort[i] > 280 && b.net.effort[i] < 400);
    }
    bench_close(&b);
}

/* Backward Euler is monotone at any step, TR-BDF2 is at least stable; both keep the books. */
TEST(books_are_kept_at_any_step)
{
    for (int rule = 0; rule < 2; rule++)
        for (real frame = 1e-3; frame < 1e7; frame *= 100) {
            uint64_t seed = 11;
            Bench b;
            square(&b, &seed);
            b.net.tolerance = rule ? 1e-3 : 0;
            real in = 0, before = 0, after = 0;
            for (int i = 0; i < NODES; i++)
                before += b.net.capacity[i] * b.net.effort[i];
            for (int i = 0; i < 3; i++) {
                network_advance(&b.net, frame);
                in += b.net.branch[b.branch - 2].through - b.net.branch[b.branch - 1].through;
            }
            for (int i = 0; i < NODES; i++) {
                after += b.net.capacity[i] * b.net.effort[i];
                CHECK(b.net.effort[i] >= 280 - 1e-2 && b.net.effort[i] <= 400 + 1e-2);
            }
            CHECK_NEAR(after - before, in, 1e-9 * (fabs(in) + after * 1e-3));
            bench_close(&b);
        }
}

/* What does not hang together does not know of each other: bit by bit the same with and without. */
TEST(parts_are_alone)
{
    Bench both, one;
    bench_open(&both, 4, 1, 4);
    bench_open(&one, 2, 1, 2);
    for (int i = 0; i < 4; i++)
        node(&both, i, 100 + i, 300 + 10 * i);
    for (int i = 0; i < 2; i++)
        node(&one, i, 100 + 2 * i + 1, 300 + 10 * (2 * i + 1));
    join(&both, 1, 3, 5);
    join(&both, 0, 2, 500);
    join(&both, 3, 4, 2);
    join(&both, 0, 4, 1);
    join(&one, 0, 1, 5);
    join(&one, 1, 2, 2);
    both.net.effort[4] = one.net.effort[2] = 290;
    CHECK(network_plan(&both.net, &both.arena) == DIG_OK && network_plan(&one.net, &one.arena) == DIG_OK);
    CHECK_INT(both.net.parts, 2);       /* nothing is connected through a boundary */
    both.net.tolerance = one.net.tolerance = 1e-7;
    run(&both, 10, FRAME);
    run(&one, 10, FRAME);
    CHECK(both.net.effort[1] == one.net.effort[0] && both.net.effort[3] == one.net.effort[1]);
    bench_close(&both);
    bench_close(&one);
}

/* Nothing changes, nothing is solved; but what flows through is booked. */
TEST(what_is_at_rest_costs_nothing)
{
    Bench b;
    bench_open(&b, 1, 1, 1);
    node(&b, 0, 100, 300);
    b.net.effort[1] = 300;
    join(&b, 0, 1, 2);
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    network_advance(&b.net, FRAME);
    CHECK_INT(b.net.iterations, 0);
    b.net.source[0] = 20;
    b.net.effort[0] = 310;
    network_advance(&b.net, FRAME);
    CHECK_INT(b.net.iterations, 0);
    CHECK_NEAR(b.net.branch[0].through, 20 * FRAME, 1e-15);
    bench_close(&b);
}

/* A node with nothing to hold it has no solution: that is said, and nothing moves. */
TEST(without_solution_nothing_moves)
{
    Bench b;
    bench_open(&b, 2, 0, 1);
    node(&b, 0, 0, 300);
    node(&b, 1, 0, 310);
    join(&b, 0, 1, 2);
    b.net.source[0] = 1;
    CHECK(network_plan(&b.net, &b.arena) == DIG_OK);
    network_advance(&b.net, FRAME);
    CHECK(b.net.failed);
    CHECK_NEAR(b.net.effort[0], 300, 0);
    CHECK_NEAR(b.net.part[0].passed, 0, 0);
    CHECK_NEAR(b.net.branch[0].through, 0, 0);
    bench_close(&b);
}

int main(void)
{
    RUN_TESTS(unit_test(two_that_touch_meet), unit_test(a_mug_cools), unit_test(a_wall_of_layers), unit_test(ring_and_pan),
              unit_test(radiation_cools), unit_test(a_rod_evens_out), unit_test(a_kettle_boils), unit_test(a_bridge_of_resistors),
              unit_test(fine_steps_are_of_second_order), unit_test(large_nets_are_sparse_and_right), unit_test(large_nets_may_be_iterated),
              unit_test(books_are_kept_at_any_step), unit_test(parts_are_alone), unit_test(what_is_at_rest_costs_nothing),
              unit_test(without_solution_nothing_moves));
}
