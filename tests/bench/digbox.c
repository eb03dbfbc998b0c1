/* tests/bench/digbox.c - driver of digbox through its C API, at the default plan unless PLAN names another.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "digbox.h"
#include "engine.h"

enum { TIMED_EVERY = 16, MOST_SAMPLES = 64, PHASES = 6 };

const char *const bench_engine = "digbox";

static struct {
    dig_world        *world;
    dig_body         *body;
    const BenchScene *scene;
    double            sample[PHASES][MOST_SAMPLES];     /* us; of the timed steps */
    int               samples;
    uint64_t          allocations;                      /* when the first step that counts had been made */
    bool              counting;
    int               iterations, most_iterations;
} dig;

static const char *const phase_name[PHASES] = {"us_sense", "us_touch", "us_graph", "us_advance", "us_commit", "us_report"};

static void fail(const char *what)
{
    fprintf(stderr, "digbox: %s: %s\n", what, dig_error(dig.world));
    exit(1);
}

static void add_body(const BenchBody *b, dig_body *out)
{
    static const char *const type[BENCH_KINDS] = {"sphere", "box", "capsule", "hull"};
    dig_sphere_def sphere = {b->size[0]};
    dig_box_def box = {{2 * b->size[0], 2 * b->size[1], 2 * b->size[2]}};
    dig_capsule_def capsule = {b->size[0], 2 * b->size[1]};
    vec3 point[HULL_POINTS];
    dig_hull_def hull = {{point, HULL_POINTS}};
    if (b->kind == BENCH_HULL) {
        Icosahedron ico;
        bench_icosahedron(&ico);
        for (int i = 0; i < HULL_POINTS; i++)
            point[i] = (vec3){ico.point[i][0] * b->size[0], ico.point[i][1] * b->size[0], ico.point[i][2] * b->size[0]};
    }
    const void *const data[BENCH_KINDS] = {&sphere, &box, &capsule, &hull};
    dig_shape_def shape = {.type = type[b->kind], .data = data[b->kind], .colour = {-1, -1, -1}};
    dig_body_def def = dig_body_defaults();
    def.at = (vec3){b->at[0], b->at[1], b->at[2]};
    def.rotation = (quat){b->turn[0], b->turn[1], b->turn[2], b->turn[3]};
    def.density = 1000;
    def.friction = 0.5;
    def.restitution = 0;
    def.rolling_friction = 0;
    def.fixed = b->fixed;
    def.shapes = &shape;
    def.shape_count = 1;
    if (dig_body_create(dig.world, &def, out) != DIG_OK)
        fail("body");
}

static void add_joint(const BenchJoint *j)
{
    const dig_schema *ball = dig_schema_find("joint", "ball");
    void *data = calloc(1, ball->size);
    dig_joint_def def = dig_joint_defaults();
    dig_joint joint;
    if (!data)
        abort();
    dig_schema_defaults(ball, data);
    def.type = "ball";
    def.a = dig.body[j->a];
    def.b = dig.body[j->b];
    def.at = (vec3){j->at[0], j->at[1], j->at[2]};
    def.data = data;
    if (dig_joint_create(dig.world, &def, &joint) != DIG_OK)
        fail("joint");
    free(data);
}

bool bench_open(const BenchScene *scene, int threads)
{
    char why[256] = "";
    dig_world_def def = dig_world_defaults();
    const char *plan = getenv("PLAN");
    def.step = 1.0 / 60;
    def.threads = threads;
    def.sleeping = scene->sleeping;
    if (plan && *plan) {
        def.tolerance = NAN;
        snprintf(def.accuracy.s, sizeof def.accuracy.s, "%s", plan);
    }
    if (dig_world_open(&def, &dig.world, why, sizeof why) != DIG_OK) {
        fprintf(stderr, "digbox: %s\n", why);
        return false;
    }
    dig.scene = scene;
    dig.body = calloc((size_t)scene->bodies, sizeof *dig.body);
    for (int i = 0; dig.body && i < scene->bodies; i++)
        add_body(&scene->body[i], &dig.body[i]);
    for (int i = 0; dig.body && i < scene->joints; i++)
        add_joint(&scene->joint[i]);
    return dig.body;
}

void bench_step(void)
{
    if (dig_world_step(dig.world) != DIG_OK)
        fail("step");
}

void bench_sample(void)
{
    dig_stats s = dig_world_stats(dig.world);
    if (!dig.counting)
        dig.allocations = s.allocations;
    dig.counting = true;
    dig.iterations = s.iterations;
    dig.most_iterations = s.iterations > dig.most_iterations ? s.iterations : dig.most_iterations;
    if (s.steps % TIMED_EVERY != 1 || dig.samples == MOST_SAMPLES)
        return;
    const double us[PHASES] = {s.us_sense, s.us_touch, s.us_graph, s.us_advance, s.us_commit, s.us_report};
    for (int i = 0; i < PHASES; i++)
        dig.sample[i][dig.samples] = us[i];
    dig.samples++;
}

void bench_pose(int body, BenchPose *out)
{
    dig_body_state state;
    if (dig_body_get(dig.world, dig.body[body], &state) != DIG_OK)
        fail("pose");
    *out = (BenchPose){{state.position.x, state.position.y, state.position.z},
                       {state.rotation.x, state.rotation.y, state.rotation.z, state.rotation.w}};
}

int bench_awake(void) { return dig_world_stats(dig.world).awake; }

void bench_kick(int body, const double v[3])
{
    vec3 velocity = {v[0], v[1], v[2]}, still = {0, 0, 0};
    if (dig_body_teleport(dig.world, dig.body[body], NULL, NULL, &velocity, &still) != DIG_OK)
        fail("kick");
}

static int by_size(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

void bench_report(FILE *out)
{
    dig_stats s = dig_world_stats(dig.world);
    for (int i = 0; i < PHASES && dig.samples; i++) {
        qsort(dig.sample[i], (size_t)dig.samples, sizeof dig.sample[i][0], by_size);
        fprintf(out, ", %s = %.4g", phase_name[i], dig.sample[i][dig.samples / 2]);
    }
    fprintf(out, ", contacts = %d, pairs = %d, groups = %d, sweeps = %d, sweeps_most = %d, substeps = %d, awake = %d", s.contacts, s.pairs,
            s.groups, s.iterations, dig.most_iterations, s.substeps, s.awake);
    fprintf(out, ", traced = %d, conserved = %d, swept = %d, world_mb = %.1f, allocations = %llu", s.traced, s.conserved, s.swept,
            (double)s.bytes / 1048576, dig.counting ? (unsigned long long)(s.allocations - dig.allocations) : 0ULL);
    fprintf(out, ", checksum = '%016llx'", (unsigned long long)dig_world_checksum(dig.world));
}
