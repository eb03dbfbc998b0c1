/* tests/hard/peers/peer.h - the scene that a hard case describes, and the calls that another engine's driver answers.
 *
 * SI units, y up, double precision. A case of tests/hard runs unchanged: shim.lua gives it a world, module.c keeps what it
 * describes in a PeerScene, a driver builds and steps that. What is measured is measured here, from the states, for all alike.
 */
#ifndef DIGBOX_HARD_PEER_H
#define DIGBOX_HARD_PEER_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { PEER_SPHERE, PEER_BOX, PEER_CYLINDER, PEER_HULL, PEER_PLANE };       /* cylinder: about y */
enum { PEER_POINTS = 16, PEER_FACES = 28, PEER_CORNERS = 8 };

typedef struct {
    double at[3], turn[4], v[3], spin[3];       /* of the centre of mass; turn: w, x, y, z from body to world; spin in world axes */
} PeerState;

typedef struct {
    double normal[3], offset;                   /* normal . x = offset on the face, below it inside */
    int    corner[PEER_CORNERS], corners;       /* counter-clockwise seen from outside */
} PeerFace;

typedef struct {
    double   point[PEER_POINTS][3];             /* about the centre of mass, in principal axes */
    int      points;
    PeerFace face[PEER_FACES];
    int      faces;
} PeerHull;

typedef struct {
    int       kind;
    double    size[3];          /* sphere: radius; box: half edges; cylinder: radius, half height; plane: normal */
    double    offset;           /* of a plane */
    double    mass;             /* 0: fixed or driven */
    double    inertia[3];       /* kg m^2, principal */
    double    friction;         /* of a pair: the geometric mean */
    double    rolling;          /* m, lever arm of the rolling resistance */
    double    restitution;
    int       group;            /* bodies of the same group do not touch; 0: none */
    bool      ghost, driven, gone;
    PeerHull *hull;
    PeerState start;            /* when the engine was opened */
    double    drive[2][3];      /* velocity and spin of a driven body, from now on */
} PeerBody;

enum { PEER_BALL, PEER_HINGE, PEER_SLIDER, PEER_SPRING };

typedef struct {
    int    kind;
    int    a, b;                                /* b = -1: the world */
    double at[2][3], axis[3];                   /* ends on a and on b, world, when the engine was opened: apart for a spring only */
    double length, stiffness, damping;          /* of a spring */
    bool   limited;
    double lower, upper;                        /* rad, of a hinge */
    double motor_speed, motor_torque;           /* torque 0: no motor */
    double local[2][3], local_axis[2][3];       /* the ends and the axis as the bodies carry them */
} PeerJoint;

typedef struct {
    PeerBody  *body;
    int        bodies, body_room;
    PeerJoint *joint;
    int        joints, joint_room;
    double     gravity[3], step;                /* m/s^2; s, frame step */
    double     restitution;                     /* the largest of the bodies': a pair takes the larger */
} PeerScene;

typedef struct { int a, b; double force[3]; } PeerTouch;        /* force on b, N; -1: nothing that was described */

typedef struct Peer Peer;

extern const char *const peer_name;

Peer *peer_open(const PeerScene *scene, char *why, size_t room);        /* NULL: this engine cannot express it, with the reason */
void  peer_step(Peer *p);                                               /* one frame step; the only call that is timed */
void  peer_states(Peer *p, PeerState *out);                             /* of all bodies; those that do not move are left alone */
void  peer_push(Peer *p, int body, const double impulse[3]);            /* at its centre, N s, with the next step */
bool  peer_joint_force(Peer *p, int joint, double force[3]);            /* false: not told */
int   peer_touches(Peer *p, PeerTouch *out, int room);                  /* how many were written */
void  peer_close(Peer *p);

/* solids.c: what a body weighs, and how far it reaches. */
bool   peer_hull_make(PeerHull *hull, const double *points, int count, double density, PeerBody *body);     /* sets mass, inertia, start */
void   peer_inertia(PeerBody *body);
double peer_reach(const PeerBody *body);
void   peer_turned(const double turn[4], const double v[3], double out[3]);
void   peer_turned_back(const double turn[4], const double v[3], double out[3]);
double peer_penetration(const PeerScene *scene, const PeerState *state);        /* m, the deepest; infinite when a body is lost */

#ifdef __cplusplus
}
#endif
#endif
