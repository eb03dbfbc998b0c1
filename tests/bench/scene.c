/* tests/bench/scene.c - the performance scenes, built from their name and size.
 *
 * Sizes and places are those of the published tables: pyramid (base n), towers (n of ten boxes), chains (n of twenty
 * capsules), pile_mixed and pile_spheres (n bodies dropped into a shaft of 10 x 10 m), sleeping (n boxes asleep and one ball),
 * large_world (n fixed boxes, 100 spheres), room (n mixed bodies, 20 layers, in a closed room).
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "scene.h"

typedef struct { uint32_t state; } Random;

static double random_next(Random *r)        /* 0 <= x < 1 */
{
    r->state = r->state * 1664525u + 1013904223u;
    return (double)(r->state >> 8) / 16777216.0;
}

static void random_turn(Random *r, double q[4])
{
    double sum;
    do {
        sum = 0;
        for (int i = 0; i < 4; i++) {
            q[i] = 2 * random_next(r) - 1;
            sum += q[i] * q[i];
        }
    } while (sum > 1 || sum < 0.01);
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(sum);
}

/* Room for one more entry; a benchmark that finds no memory has nothing to say. */
static void *grow(void *list, int count, int *room, size_t size)
{
    if (count < *room)
        return list;
    *room = *room ? 2 * *room : 256;
    list = realloc(list, (size_t)*room * size);
    if (!list)
        abort();
    return list;
}

static int add(BenchScene *s, int kind, const double size[3], double x, double y, double z)
{
    s->body = grow(s->body, s->bodies, &s->body_room, sizeof *s->body);
    BenchBody *b = &s->body[s->bodies];
    *b = (BenchBody){.kind = kind, .at = {x, y, z}, .turn = {0, 0, 0, 1}};
    memcpy(b->size, size, sizeof b->size);
    return s->bodies++;
}

static int add_top(BenchScene *s, int body, bool top)
{
    if (top) {
        s->top = grow(s->top, s->tops, &s->top_room, sizeof *s->top);
        s->top[s->tops++] = body;
    }
    return body;
}

static void add_fixed(BenchScene *s, double a, double b, double c, double x, double y, double z, bool wall)
{
    int i = add(s, BENCH_BOX, (double[3]){a, b, c}, x, y, z);
    s->body[i].fixed = true;
    s->body[i].wall = wall;
}

static void add_plane(BenchScene *s, double x, double y, double z, double offset)
{
    double plane[4] = {x, y, z, offset};
    memcpy(s->plane[s->planes++], plane, sizeof plane);
}

static void add_ground(BenchScene *s, double half)
{
    add_fixed(s, half, 1, half, 0, -1, 0, true);
    add_plane(s, 0, 1, 0, 0);
}

static void add_room(BenchScene *s, double half, double height)
{
    double outer = half + 2, mid = height / 2;
    add_fixed(s, outer, 1, outer, 0, -1, 0, true);
    add_fixed(s, outer, 1, outer, 0, height + 1, 0, true);
    add_fixed(s, 1, mid, outer, -half - 1, mid, 0, true);
    add_fixed(s, 1, mid, outer, half + 1, mid, 0, true);
    add_fixed(s, half, mid, 1, 0, mid, -half - 1, true);
    add_fixed(s, half, mid, 1, 0, mid, half + 1, true);
    add_plane(s, 0, 1, 0, 0);
    add_plane(s, 0, -1, 0, height);
    add_plane(s, 1, 0, 0, half);
    add_plane(s, -1, 0, 0, half);
    add_plane(s, 0, 0, 1, half);
    add_plane(s, 0, 0, -1, half);
}

static const double half_metre[3] = {0.5, 0.5, 0.5};

static void pyramid(BenchScene *s)
{
    add_ground(s, 100);
    for (int i = 0; i < s->n; i++)
        for (int j = 0; j < s->n - i; j++)
            add_top(s, add(s, BENCH_BOX, half_metre, (j - 0.5 * (s->n - i - 1)) * 1.1, 0.5 + i, 0), i == s->n - 1);
}

static void towers(BenchScene *s)
{
    int side = (int)ceil(sqrt(s->n));
    add_ground(s, side * 1.5 + 10);
    for (int t = 0; t < s->n; t++)
        for (int i = 0; i < 10; i++)
            add_top(s, add(s, BENCH_BOX, half_metre, (t % side - 0.5 * side) * 3, 0.5 + i, (t / side - 0.5 * side) * 3), i == 9);
}

/* Capsules of 0.7 m from tip to tip, straight at 45 degrees to the vertical, hung from a fixed box. */
static void chains(BenchScene *s)
{
    const double c = sqrt(0.5), length = 0.7, eighth = acos(-1) / 8;
    for (int k = 0; k < s->n; k++) {
        double x = k % 10 * 32.0 - 160, y = 20, z = k / 10 * 2.0;
        int before = s->bodies;
        add_fixed(s, 0.1, 0.1, 0.1, x, y + 0.3, z, false);
        for (int i = 0; i < 20; i++) {
            double mid = length * (i + 0.5) * c, end = length * i * c;
            int link = add_top(s, add(s, BENCH_CAPSULE, (double[3]){0.1, 0.25, 0}, x + mid, y - mid, z), i == 19);
            s->body[link].turn[2] = sin(eighth);
            s->body[link].turn[3] = cos(eighth);
            s->joint = grow(s->joint, s->joints, &s->joint_room, sizeof *s->joint);
            s->joint[s->joints++] = (BenchJoint){before, link, {x + end, y - end, z}};
            before = link;
        }
    }
    s->linked = true;
}

static void pile_spheres(BenchScene *s)
{
    Random random = {12345};
    add_room(s, 5, (s->n + 255) / 256 * 0.6 + 2);
    for (int i = 0; i < s->n; i++) {
        double x = (i % 16 - 7.5) * 0.6 + 0.08 * (random_next(&random) - 0.5);
        double z = (i / 16 % 16 - 7.5) * 0.6 + 0.08 * (random_next(&random) - 0.5);
        add_top(s, add(s, BENCH_SPHERE, (double[3]){0.25, 0, 0}, x, 0.4 + i / 256 * 0.6, z), i >= s->n - 256);
    }
}

/* Layers of side x side bodies of four kinds at any angle, 0.8 m apart. */
static void drop_mixed(BenchScene *s, int side, double half)
{
    static const double size[BENCH_KINDS][3] = {{0.25, 0, 0}, {0.25, 0.25, 0.25}, {0.18, 0.2, 0}, {0.3, 0, 0}};
    Random random = {12345};
    int layer = side * side;
    add_room(s, half, (s->n + layer - 1) / layer * 0.8 + 2);
    for (int i = 0; i < s->n; i++) {
        double x = (i % side - 0.5 * (side - 1)) * 0.8 + 0.1 * (random_next(&random) - 0.5);
        double z = (i / side % side - 0.5 * (side - 1)) * 0.8 + 0.1 * (random_next(&random) - 0.5);
        int kind = (i + i / layer) % BENCH_KINDS;
        int body = add_top(s, add(s, kind, size[kind], x, 0.6 + i / layer * 0.8, z), i >= s->n - layer);
        random_turn(&random, s->body[body].turn);
    }
}

static void pile_mixed(BenchScene *s) { drop_mixed(s, 12, 5); }

static void room(BenchScene *s)
{
    int side = (int)ceil(sqrt(s->n / 20.0));
    drop_mixed(s, side, 0.4 * side + 0.2);
}

static void sleeping(BenchScene *s)
{
    int side = (int)ceil(sqrt(s->n));
    add_ground(s, side + 10);
    for (int i = 0; i < s->n; i++)
        add_top(s, add(s, BENCH_BOX, half_metre, (i % side - side / 2) * 2.0, 0.5, (i / side - side / 2) * 2.0), i % 97 == 0);
    s->ball = add(s, BENCH_SPHERE, (double[3]){0.4, 0, 0}, -60, 0.4, 1);
    s->sleeping = true;
}

/* A floor of fixed cubes side by side, and spheres over the whole of it. */
static void large_world(BenchScene *s)
{
    int side = (int)ceil(sqrt(s->n));
    for (int i = 0; i < s->n; i++)
        add_fixed(s, 0.5, 0.5, 0.5, i % side - 0.5 * (side - 1), -0.5, i / side - 0.5 * (side - 1), false);
    for (int i = 0; i < 100; i++) {
        double x = (i % 10 - 4.5) * side / 11, z = (i / 10 - 4.5) * side / 11;
        add_top(s, add(s, BENCH_SPHERE, (double[3]){0.25, 0, 0}, x, 1 + 0.02 * i, z), true);
    }
}

static const struct { const char *name; void (*build)(BenchScene *); int n, steps; } scenes[] = {
    {"pyramid", pyramid, 30, 300},          {"towers", towers, 1000, 120},      {"chains", chains, 100, 300},
    {"pile_mixed", pile_mixed, 4000, 300},  {"pile_spheres", pile_spheres, 8000, 300},
    {"sleeping", sleeping, 50000, 300},     {"large_world", large_world, 1000000, 120}, {"room", room, 100000, 120},
};

bool bench_scene(BenchScene *s, const char *name, int n)
{
    memset(s, 0, sizeof *s);
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
        if (strcmp(scenes[i].name, name) == 0) {
            s->name = scenes[i].name;
            s->n = n > 0 ? n : scenes[i].n;
            s->steps = scenes[i].steps;
            s->ball = -1;
            scenes[i].build(s);
            return true;
        }
    return false;
}

double bench_volume(const BenchBody *b)
{
    const double pi = acos(-1), *r = b->size;
    double ball = 4.0 / 3 * pi * r[0] * r[0] * r[0];
    switch (b->kind) {
    case BENCH_SPHERE:  return ball;
    case BENCH_BOX:     return 8 * r[0] * r[1] * r[2];
    case BENCH_CAPSULE: return ball + pi * r[0] * r[0] * 2 * r[1];
    default:            return r[0] * r[0] * r[0] * 2.0 / 3 * sqrt(10 + 2 * sqrt(5.0));      /* icosahedron, by its circumradius */
    }
}

static double distance2(const double a[3], const double b[3])
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

/* Corners are the even permutations of (0, +-1, +-golden ratio), scaled; neighbours are 1.0515 circumradii apart. */
void bench_icosahedron(Icosahedron *ico)
{
    const double golden = (1 + sqrt(5.0)) / 2, scale = 1 / sqrt(1 + golden * golden), near = 1.2;
    int edges = 0, faces = 0;
    memset(ico, 0, sizeof *ico);
    for (int i = 0; i < HULL_POINTS; i++) {
        int axis = i / 4;
        ico->point[i][(axis + 1) % 3] = i & 1 ? -scale : scale;
        ico->point[i][(axis + 2) % 3] = (i & 2 ? -scale : scale) * golden;
    }
    for (int i = 0; i < HULL_POINTS; i++)
        for (int j = i + 1; j < HULL_POINTS; j++) {
            if (distance2(ico->point[i], ico->point[j]) > near)
                continue;
            ico->edge[edges][0] = i;
            ico->edge[edges++][1] = j;
            for (int k = j + 1; k < HULL_POINTS; k++) {
                const double *p = ico->point[i], *q = ico->point[j], *r = ico->point[k];
                if (distance2(p, r) > near || distance2(q, r) > near)
                    continue;
                double centre[3], length = 0, turn = 0;
                for (int a = 0; a < 3; a++) {
                    centre[a] = p[a] + q[a] + r[a];
                    length += centre[a] * centre[a];
                    turn += p[a] * (q[(a + 1) % 3] * r[(a + 2) % 3] - q[(a + 2) % 3] * r[(a + 1) % 3]);
                }
                int corner[3] = {i, turn > 0 ? j : k, turn > 0 ? k : j};
                memcpy(ico->face[faces], corner, sizeof corner);
                for (int a = 0; a < 3; a++)
                    ico->normal[faces][a] = centre[a] / sqrt(length);
                faces++;
            }
        }
}
