/* tests/bench/scene.h - the one description of a performance scene that every engine is given, and what is found when it has run.
 *
 * SI units, y up. Every engine: gravity 9.81 m/s^2, friction 0.5, no restitution, density 1000 kg/m^3, no damping, 60 Hz.
 */
#ifndef DIGBOX_BENCH_SCENE_H
#define DIGBOX_BENCH_SCENE_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { BENCH_SPHERE, BENCH_BOX, BENCH_CAPSULE, BENCH_HULL, BENCH_KINDS };
enum { HULL_POINTS = 12, HULL_EDGES = 30, HULL_FACES = 20 };

typedef struct {
    int    kind;
    double size[3];             /* sphere: radius; box: half edges; capsule along y: radius, half its straight part; hull: circumradius */
    double at[3], turn[4];      /* turn: x, y, z, w, from body to world */
    bool   fixed;
    bool   wall;                /* fixed, and its face is a plane of the scene: the checker takes the plane */
} BenchBody;

typedef struct { int a, b; double at[3]; } BenchJoint;      /* ball joint at a world point */

typedef struct {
    const char *name;
    int         n;              /* size, as the scene counts it */
    int         steps;
    bool        sleeping;       /* bodies may fall asleep, and do before the clock starts */
    bool        linked;         /* neighbours in the list are joined and do not collide; no floor */
    BenchBody  *body;
    int         bodies, body_room;
    BenchJoint *joint;
    int         joints, joint_room;
    double      plane[6][4];    /* inside: normal . x + offset >= 0 */
    int         planes;
    int        *top;            /* bodies whose mean height is reported */
    int         tops, top_room;
    int         ball;           /* kicked when the clock starts, or -1 */
} BenchScene;

bool bench_scene(BenchScene *scene, const char *name, int n);       /* n = 0: the size of the published tables; false: no such scene */
double bench_volume(const BenchBody *b);                            /* m^3 */

/* A regular icosahedron of circumradius 1; the corners of a face are in counter-clockwise order seen from outside. */
typedef struct {
    double point[HULL_POINTS][3], normal[HULL_FACES][3];
    int    edge[HULL_EDGES][2], face[HULL_FACES][3];
} Icosahedron;
void bench_icosahedron(Icosahedron *ico);

typedef struct { double at[3], turn[4]; } BenchPose;

typedef struct {
    double penetration_max, penetration_mean;   /* m, over the pairs that overlap */
    double top_height;                          /* m */
    double joint_error;                         /* m, worst gap */
    int    overlaps;                            /* pairs */
    int    lost;                                /* bodies not finite, or more than a metre outside */
} BenchFound;

void bench_check(const BenchScene *scene, const BenchPose *pose, BenchFound *found);

#ifdef __cplusplus
}
#endif
#endif
