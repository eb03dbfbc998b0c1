/* tests/unit/test_direct.c - stacks that Gauss-Seidel sweeps cannot hold: heavy things on light ones, towers, arches, pyramids.
 *
 * Groups of at most twelve bodies are traced in the default plan, so the small ones are also run in the coarsest, which does not
 * trace. Nothing sleeps here unless a test says so: what creeps must not be stopped by sleep. */
#include "physics_fixture.h"
#include "solve/blocks.h"

#include <stdlib.h>

#define STEP (1.0 / 60)
#define MOST 64

static const Look dull = {0.6, NAN, 0, 0};

typedef struct Pile { dig_world *w; dig_body b[MOST]; vec3 start[MOST]; int count; real fastest; } Pile;

static void open_pile(Pile *p, const char *plan, int threads)
{
    dig_world_def def = dig_world_defaults();
    def.gravity = (vec3){0, -GRAVITY, 0};
    def.step = STEP;
    def.sleeping = false;
    def.threads = threads;
    snprintf(def.accuracy.s, sizeof def.accuracy.s, "%s", plan);
    memset(p, 0, sizeof *p);
    p->w = open_with(def);
}

static void put_sized(Pile *p, real size, real mass, vec3 at)
{
    p->start[p->count] = at;
    p->b[p->count++] = add_box(p->w, dull, (vec3){size, size, size}, mass, at, quat_identity());
}

static void put(Pile *p, real mass, vec3 at) { put_sized(p, 1, mass, at); }

/* Unit boxes on each other, 1 kg but for the top; each `aside` m off the one below, to and fro. */
static void tower(Pile *p, const char *plan, int count, real top, real aside)
{
    open_pile(p, plan, 1);
    add_floor(p->w, dull);
    for (int i = 0; i < count; i++)
        put(p, i == count - 1 ? top : 1, (vec3){aside * (i % 2), i + 0.5, aside * (i / 2 % 2)});
}

/* The greatest speed counts from the middle of the run on. */
static void run(Pile *p, real seconds)
{
    int steps = (int)lround(seconds / STEP);
    for (int i = 0; i < steps; i++) {
        step(p->w, 1);
        for (int k = 0; 2 * i >= steps && k < p->count; k++)
            p->fastest = real_max(p->fastest, vec3_length(state_of(p->w, p->b[k]).velocity));
    }
}

static real drift(const Pile *p)
{
    real most = 0;
    for (int i = 0; i < p->count; i++) {
        vec3 x = state_of(p->w, p->b[i]).position;
        most = real_max(most, hypot(x.x - p->start[i].x, x.z - p->start[i].z));
    }
    return most;
}

static real sag(const Pile *p)
{
    real most = 0;
    for (int i = 0; i < p->count; i++)
        most = real_max(most, p->start[i].y - state_of(p->w, p->b[i]).position.y);
    return most;
}

static void check_stands(Pile *p, real seconds, real most_drift, real most_sag)
{
    run(p, seconds);
    CHECK_NEAR(drift(p), 0, most_drift);
    CHECK_NEAR(sag(p), 0, most_sag);
    CHECK_NEAR(p->fastest, 0, 1e-3);
    check_world(p->w);
    dig_world_close(p->w);
}

/* ---- the factorisation ---- */

enum { N = 9 };

/* Of what does not turn the last three unknowns are linked with nothing but each other. */
static bool has_entry(const unsigned char *links, const bool *narrow, const int *who, int r, int c)
{
    int a = who[r / 6], b = who[c / 6];
    bool turns = (r % 6 > 2 && narrow[a]) || (c % 6 > 2 && narrow[b]);
    return a == b ? !turns || (r % 6 > 2) == (c % 6 > 2) : links[a * N + b] && !turns;
}

/* Its lower half, into s. */
static void put_matrix(Blocks *s, real (*full)[6 * N])
{
    blocks_clear(s);
    for (int r = 0; r < 6 * N; r++)
        for (int c = 0; c < 6 * N; c++) {
            int a = r / 6, b = c / 6, stride = a > b ? blocks_stride(s, b) : 6;
            if (a == b)
                s->diagonal[BLOCK * a + 6 * (r % 6) + c % 6] = full[r][c];
            else if (a > b && full[r][c] != 0)
                blocks_at(s, a, b)[stride * (r % 6) + c % 6] = full[r][c];
        }
}

static size_t below_bytes(const Blocks *s) { return (size_t)s->at[s->first[N]] * sizeof(real); }

/* x is 1, 2, 3, 4, 5, 1, ... */
static void check_known(const Blocks *s, real (*full)[6 * N])
{
    real x[6 * N] = {0};
    for (int r = 0; r < 6 * N; r++)
        for (int c = 0; c < 6 * N; c++)
            x[r] += full[r][c] * (1 + c % 5);
    blocks_solve(s, x);
    for (int r = 0; r < 6 * N; r++)
        CHECK_NEAR(x[r], 1 + r % 5, 1e-13);
}

/* A ring of bodies and one that all touch: the solution of A x = b is known, and again after the blocks of the late ones have changed. */
static int check_solved(const bool *narrow, const bool *late)
{
    Arena arena = {0};
    Blocks s;
    unsigned char links[N * N] = {0};
    int link[4 * N], count = 0;
    for (int i = 0; i < N - 1; i++) {
        int next = (i + 1) % (N - 1);
        links[i * N + next] = links[next * N + i] = links[i * N + N - 1] = links[(N - 1) * N + i] = 1;
        link[count++] = i;
        link[count++] = next;
        link[count++] = N - 1;
        link[count++] = i;
    }
    CHECK(blocks_plan(&s, &arena, &(BlockLinks){N, count / 2, link, narrow, late, 0}) && blocks_reserve(&s, &arena));
    real full[6 * N][6 * N] = {{0}};
    int who[N];
    for (int i = 0; i < N; i++)
        who[s.place[i]] = i;
    for (int r = 0; r < 6 * N; r++)
        for (int c = 0; c <= r; c++)
            if (has_entry(links, narrow, who, r, c))
                full[r][c] = full[c][r] = r == c ? 60 : sin(r + 3.0 * c);
    put_matrix(&s, full);
    CHECK(blocks_begin(&s, false));
    blocks_keep(&s);
    CHECK(blocks_factor(&s, false));
    check_known(&s, full);
    real *diagonal = arena_alloc(&arena, sizeof(real) * N * BLOCK), *below = arena_alloc(&arena, below_bytes(&s) + 1);
    memcpy(diagonal, s.diagonal, sizeof(real) * N * BLOCK);
    memcpy(below, s.below, below_bytes(&s));
    put_matrix(&s, full);
    CHECK(blocks_begin(&s, true) && blocks_factor(&s, true));
    CHECK(memcmp(diagonal, s.diagonal, sizeof(real) * N * BLOCK) == 0);         /* the same bits by all instructions */
    CHECK(memcmp(below, s.below, below_bytes(&s)) == 0);
    blocks_back(&s);
    for (int i = 0; i < N; i++)
        for (int k = 0; late[who[i]] && i >= s.early && k < 6; k++) {
            full[6 * i + k][6 * i + k] += 7 * k;
            s.diagonal[BLOCK * i + 7 * k] += 7 * k;
        }
    CHECK(blocks_factor(&s, false));
    check_known(&s, full);
    arena_close(&arena);
    return s.early;
}

TEST(a_linked_matrix_is_factored_and_solved)
{
    static const bool none[N] = {false}, last[N] = {[N - 1] = true}, two[N] = {[2] = true, [6] = true};
    check_solved(none, none);
    check_solved((bool[N]){true, true, true, true, true, true, true, true, true}, none);
    CHECK_INT(check_solved(none, last), N - 1);
    CHECK_INT(check_solved(none, none), 0);
    for (int i = 1; i < 1 << N; i += 37) {      /* some turn, and others do not */
        const bool narrow[N] = {i & 1, i & 2, i & 4, i & 8, i & 16, i & 32, i & 64, i & 128, i & 256};
        check_solved(narrow, none);
        check_solved(narrow, last);
        check_solved(narrow, two);
    }
}

/* A chain has no fill: 2 n blocks at most, whatever its numbering. */
TEST(a_chain_is_factored_without_fill)
{
    enum { COUNT = 40 };
    Arena arena = {0};
    Blocks s;
    int link[2 * COUNT];
    for (int i = 0; i + 1 < COUNT; i++) {
        link[2 * i] = i * 7 % COUNT;
        link[2 * i + 1] = (i + 1) * 7 % COUNT;
    }
    CHECK(blocks_plan(&s, &arena, &(BlockLinks){.n = COUNT, .links = COUNT - 1, .link = link}));
    CHECK_INT(s.first[COUNT], COUNT - 1);
    arena_close(&arena);
}

/* A grid of which one corner changes: what stays is eliminated once. Where one in five changes, and the rest
 * would fill them in, all go as they come. */
TEST(what_changes_goes_last_where_that_saves_work)
{
    enum { SIDE = 12, COUNT = SIDE * SIDE };
    Arena arena = {0};
    Blocks whole, corner, all;
    int link[4 * COUNT], links = 0;
    bool few[COUNT] = {false}, many[COUNT], narrow[COUNT];
    for (int i = 0; i < COUNT; i++) {
        int down = i + SIDE < COUNT ? i + SIDE : i, right = (i + 1) % SIDE ? i + 1 : i;
        link[links++] = i;
        link[links++] = down;
        link[links++] = right;
        link[links++] = i;
        few[i] = i / SIDE < 3 && i % SIDE < 3;
        many[i] = i % 5 == 0;
        narrow[i] = true;
    }
    CHECK(blocks_plan(&whole, &arena, &(BlockLinks){COUNT, links / 2, link, narrow, NULL, 0}));
    CHECK(blocks_plan(&corner, &arena, &(BlockLinks){COUNT, links / 2, link, narrow, few, 0}));
    CHECK(blocks_plan(&all, &arena, &(BlockLinks){COUNT, links / 2, link, narrow, many, 0}));
    CHECK_INT(corner.early, COUNT - 9);
    CHECK(corner.late_work < 0.02 * whole.late_work);       /* 9 of 144 in a dense triangle: 0.017 */
    CHECK_INT(all.early, 0);
    CHECK(all.work == whole.work);
    CHECK(blocks_plan(&all, &arena, &(BlockLinks){COUNT, links / 2, link, narrow, NULL, 0.9 * whole.work}));
    CHECK(all.work == whole.work && !all.row);
    arena_close(&arena);
}

TEST(an_indefinite_matrix_is_refused)
{
    Arena arena = {0};
    Blocks s;
    CHECK(blocks_plan(&s, &arena, &(BlockLinks){.n = 1}) && blocks_reserve(&s, &arena));
    blocks_clear(&s);
    for (int i = 0; i < 6; i++)
        s.diagonal[7 * i] = i == 4 ? -1 : 1;
    CHECK(!blocks_factor(&s, false));
    arena_close(&arena);
}

/* ---- heavy on light ---- */

TEST(five_light_boxes_carry_a_heavy_one)
{
    static const real heavy[] = {10, 100, 1000, 10000};
    static const char *const plans[] = {"sketch", "play"};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 2; k++) {
            Pile p;
            tower(&p, plans[k], 6, heavy[i], 0);
            check_stands(&p, SANITIZED ? 3 : 20, 0.01, heavy[i] > 5000 ? 0.055 : 5.5e-3);
        }
}

TEST(thirteen_light_boxes_not_quite_above_each_other_carry_a_heavy_one)
{
    Pile p;
    tower(&p, "play", 14, 1000, 0.04);
    check_stands(&p, SANITIZED ? 2 : 10, 0.01, 0.013);
}

/* From 1 m: the blow is taken, and the stack stands. */
TEST(a_stack_of_fourteen_stands_when_a_heavy_box_is_dropped_on_it)
{
    Pile p;
    open_pile(&p, "play", 1);
    add_floor(p.w, dull);
    for (int i = 0; i < 14; i++)
        put(&p, i == 13 ? 1000 : 1, (vec3){0, i + (i == 13 ? 1.5 : 0.5), 0});
    p.start[13].y -= 1;
    check_stands(&p, 3, 0.01, 0.014);
}

TEST(pyramid_of_fifty_five_carries_three_hundred_times_its_box)
{
    Pile p;
    open_pile(&p, "play", 1);
    add_floor(p.w, dull);
    for (int row = 0; row < 10; row++)
        for (int i = 0; i < 10 - row; i++)
            put(&p, row == 9 ? 300 : 1, (vec3){1.1 * (i - 0.5 * (9 - row)), row + 0.5, 0});
    check_stands(&p, SANITIZED ? 1 : 10, 1e-3, 1e-3);
}

/* ---- towers ---- */

TEST(tower_of_twenty_stands)
{
    Pile p;
    tower(&p, "play", 20, 1, 0);
    check_stands(&p, SANITIZED ? 3 : 60, 0.01, 0.02);
}

TEST(tower_of_forty_stands)
{
    Pile p;
    tower(&p, "play", 40, 1, 0);
    check_stands(&p, SANITIZED ? 1 : 20, 0.01, 0.04);
}

TEST(tower_falls_asleep)
{
    Pile p;
    tower(&p, "play", 20, 1, 0.02);
    dig_world_close(p.w);
    p.w = open_world(STEP, "play", true);
    add_floor(p.w, dull);
    for (int i = p.count = 0; i < 20; i++)
        put(&p, 1, (vec3){0.02 * (i % 2), i + 0.5, 0.02 * (i / 2 % 2)});
    run(&p, 3);
    CHECK_INT(dig_world_stats(p.w).awake, 0);
    CHECK_NEAR(drift(&p), 0, 1e-4);
    dig_world_close(p.w);
}

/* A tower that leans too far must fall: nothing is glued. */
TEST(tower_that_leans_too_far_falls)
{
    Pile p;
    open_pile(&p, "play", 1);
    add_floor(p.w, dull);
    for (int i = 0; i < 14; i++)            /* centre of the upper thirteen: 0.12 * 7 > 0.5 m off the lowest box's */
        put(&p, 1, (vec3){0.12 * i, i + 0.5, 0});
    run(&p, 4);
    CHECK(p.start[13].y - state_of(p.w, p.b[13]).position.y > 5);
    dig_world_close(p.w);
}

/* On a slope the tower of boxes slides as one: g (sin a - mu cos a). */
TEST(stack_on_a_steep_slope_slides_by_coulombs_law)
{
    Pile p;
    open_pile(&p, "play", 1);
    real a = 0.35, mu = 0.3;
    Look slick = {mu, NAN, 0, 0}, rough = {2, NAN, 0, 0};
    vec3 normal = {sin(a), cos(a), 0}, down = {cos(a), -sin(a), 0};
    add_slope(p.w, slick, normal);
    for (int i = 0; i < 14; i++) {          /* 14 plates, 2 m wide: they do not tip */
        p.start[i] = vec3_scale(0.05 + 0.1 * i, normal);
        p.b[p.count++] = add_box(p.w, i == 0 ? slick : rough, (vec3){2, 0.1, 2}, 1, p.start[i], quat_exp((vec3){0, 0, -a}));
    }
    run(&p, 1);
    real want = 0.5 * GRAVITY * (sin(a) - mu * cos(a)), law = vec3_dot(down, vec3_sub(state_of(p.w, p.b[0]).position, p.start[0]));
    CHECK_NEAR(law, want, 2e-3 * want);
    CHECK_NEAR(vec3_dot(down, vec3_sub(state_of(p.w, p.b[13]).position, p.start[13])), want, 2e-3 * want);
    dig_world_close(p.w);
}

/* ---- joints that carry what is heavy ---- */

/* Sixteen planks of 1 kg and 0.5 m, hinged in a line between two fixed points as far apart as they are long; boxes of 60 kg. */
static void bridge(Pile *p, real drop, dig_joint ends[2])
{
    open_pile(p, "play", 1);
    for (int i = 0; i < 16; i++) {
        p->start[i] = (vec3){0.5 * i + 0.25, 0, 0};
        p->b[p->count++] = add_box(p->w, dull, (vec3){0.5, 0.1, 1}, 1, p->start[i], quat_identity());
    }
    for (int i = 0; i < 17; i++) {
        dig_body a = i < 16 ? p->b[i] : p->b[15], b = i > 0 && i < 16 ? p->b[i - 1] : (dig_body){0};
        dig_joint j = join_bodies(p->w, "hinge", a, b, (vec3){0.5 * i, 0, 0}, (vec3){0, 0, 1});
        if (i % 16 == 0)
            ends[i / 16] = j;
    }
    for (int i = 0; i < 4; i++)
        put_sized(p, 0.4, 60, (vec3){1 + 2 * i, 0.25 + drop, 0});
}

static void check_carries(Pile *p, const dig_joint ends[2])
{
    real up = 0, weight = (16 + 4 * 60) * GRAVITY;
    for (int i = 0; i < 2; i++) {
        dig_joint_state s;
        CHECK_INT(dig_joint_get(p->w, ends[i], &s), DIG_OK);
        up += s.force.y;
    }
    CHECK_NEAR(up, weight, 1e-3 * weight);
    CHECK_NEAR(dig_world_stats(p->w).joint_error, 0, 1e-4);
    for (int i = 0; i < p->count; i++)
        CHECK_NEAR(state_of(p->w, p->b[i]).position.y, i < 16 ? 0 : 0.25, 1e-3);
}

TEST(bridge_of_light_planks_carries_heavy_boxes)
{
    Pile p;
    dig_joint ends[2];
    bridge(&p, 0, ends);
    run(&p, 3);
    check_carries(&p, ends);
    CHECK_NEAR(p.fastest, 0, 1e-3);
    dig_world_close(p.w);
}

TEST(bridge_holds_when_heavy_boxes_fall_on_it)
{
    Pile p;
    dig_joint ends[2];
    real worst = 0, fastest = 0;
    bridge(&p, 1, ends);
    for (int i = 0; i < 360; i++) {
        step(p.w, 1);
        worst = real_max(worst, dig_world_stats(p.w).joint_error);
        for (int k = 0; k < p.count; k++)
            fastest = real_max(fastest, vec3_length(state_of(p.w, p.b[k]).velocity));
    }
    CHECK_NEAR(worst, 0, 2e-3);
    CHECK(fastest < 1.05 * sqrt(2 * GRAVITY));      /* nothing is faster than what fell */
    check_carries(&p, ends);
    dig_world_close(p.w);
}

/* ---- arches ---- */

/* Half circle of `count` stones, mean radius 1 m, friction 1. Its limit is t/R = 0.1075 (Milankovitch 1907). */
static void arch(Pile *p, int count, real thickness)
{
    open_pile(p, "play", 1);
    Look stone = {1, NAN, 0, 0};
    add_floor(p->w, stone);
    for (int i = 0; i < count; i++) {
        real from = DIG_PI * i / count, to = DIG_PI * (i + 1) / count, mid = 0.5 * (from + to);
        vec3 at = {cos(mid), sin(mid), 0}, points[8];
        for (int k = 0; k < 8; k++) {
            real angle = k & 1 ? to : from, r = k & 2 ? 1 + 0.5 * thickness : 1 - 0.5 * thickness;
            points[k] = vec3_sub((vec3){r * cos(angle), r * sin(angle), k & 4 ? 0.2 : -0.2}, at);
        }
        dig_hull_def hull = {.points = {points, 8}};
        p->start[i] = at;
        p->b[p->count++] = add_body(p->w, body_with(stone, at, quat_identity()), "hull", &hull);
    }
}

TEST(arch_of_fifteen_stones_stands_when_it_is_thick)
{
    Pile p;
    arch(&p, 15, 0.15);
    check_stands(&p, SANITIZED ? 2 : 30, 1e-3, 1e-3);
}

TEST(arch_of_fifteen_stones_falls_when_it_is_thin)
{
    Pile p;
    arch(&p, 15, 0.09);
    run(&p, 2);
    CHECK(sag(&p) > 0.5);
    check_world(p.w);
    dig_world_close(p.w);
}

/* ---- bits ---- */

static void last_states(int threads, dig_body_state *states, int *count)
{
    Pile p;
    open_pile(&p, "play", threads);
    add_floor(p.w, dull);
    for (int t = 0; t < 3; t++)
        for (int i = 0; i < 14; i++)
            put(&p, i == 13 ? 500 : 1, (vec3){10 * t + 0.03 * (i % 3), i + 0.5, 0.02 * t * (i % 2)});
    run(&p, 0.5);
    *count = p.count;
    for (int i = 0; i < p.count; i++)
        states[i] = state_of(p.w, p.b[i]);
    dig_world_close(p.w);
}

TEST(any_number_of_threads_gives_the_same_bits)
{
    dig_body_state one[MOST], four[MOST];
    int n, m;
    last_states(1, one, &n);
    last_states(4, four, &m);
    CHECK_INT(n, m);
    for (int i = 0; i < n; i++) {
        CHECK(memcmp(&one[i].position, &four[i].position, sizeof(vec3)) == 0);
        CHECK(memcmp(&one[i].velocity, &four[i].velocity, sizeof(vec3)) == 0);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(a_linked_matrix_is_factored_and_solved), unit_test(a_chain_is_factored_without_fill),
              unit_test(what_changes_goes_last_where_that_saves_work),
                     unit_test(an_indefinite_matrix_is_refused), unit_test(five_light_boxes_carry_a_heavy_one),
                     unit_test(thirteen_light_boxes_not_quite_above_each_other_carry_a_heavy_one),
                     unit_test(a_stack_of_fourteen_stands_when_a_heavy_box_is_dropped_on_it),
                     unit_test(pyramid_of_fifty_five_carries_three_hundred_times_its_box), unit_test(tower_of_twenty_stands),
                     unit_test(tower_of_forty_stands), unit_test(tower_falls_asleep), unit_test(tower_that_leans_too_far_falls),
                     unit_test(stack_on_a_steep_slope_slides_by_coulombs_law),
                     unit_test(bridge_of_light_planks_carries_heavy_boxes), unit_test(bridge_holds_when_heavy_boxes_fall_on_it),
                     unit_test(arch_of_fifteen_stones_stands_when_it_is_thick),
                     unit_test(arch_of_fifteen_stones_falls_when_it_is_thin), unit_test(any_number_of_threads_gives_the_same_bits));
}
