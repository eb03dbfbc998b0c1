/* tests/peers/peer.h - the one description of a scene that every peer engine is given, and the calls its driver answers.
 *
 * SI units, z up, double precision. A driver builds the scene from the description, steps it, and hands states back;
 * what is measured, against what, and how the time is taken stands in suite.c and is the same for every engine.
 */
#ifndef DIGBOX_PEER_H
#define DIGBOX_PEER_H

#ifdef __cplusplus
extern "C" {
#endif

enum { PEER_SPHERE, PEER_BOX, PEER_DISC, PEER_GROUND };   /* ground: the half space z < 0; disc: a cylinder about z */
enum { PEER_BODIES = 16, PEER_HINGES = 4 };

typedef struct {
    int    kind;
    double size[3];          /* sphere: radius; box: half edges; disc: radius and half height */
    double mass;             /* 0: not moved by forces */
    double at[3], turn[4];   /* centre of mass, and quaternion (w, x, y, z) from body to world axes */
    double v[3], spin[3];    /* of the centre of mass, and about world axes */
    int    mover;            /* 1: moves as peer_move says, whatever hits it */
} PeerBody;

typedef struct {
    int    from, to;         /* from = -1: the world */
    double at[3], axis[3];
} PeerHinge;

typedef struct {
    const char *id;
    PeerBody    body[PEER_BODIES];
    int         bodies;
    PeerHinge   hinge[PEER_HINGES];
    int         hinges;
    double      gravity[3];
    double      friction, restitution;   /* of every contact in the scene */
} PeerScene;

typedef struct {
    double at[3], turn[4], v[3], spin[3];
} PeerState;

/* A row of a driver's table of settings. The default comes first. */
typedef struct {
    const char *name;
    int         rate;        /* steps per simulated second, a multiple of 60 */
    int         variant;     /* what else is set: the driver's own affair */
    int         iterations;  /* 0: the engine's default */
    int         calls;       /* evaluations of the equations of motion per step; 0: unknown */
} PeerSetting;

extern const char *const peer_name;
extern const PeerSetting peer_settings[];   /* ends with a row without a name */

int  peer_open(const PeerScene *scene, const PeerSetting *setting);    /* 0 when the engine cannot express it */
void peer_move(int body, const double v[3], const double spin[3]);      /* a mover's velocity from now on */
void peer_advance(int steps);                                           /* the only call that is timed */
void peer_state(int body, PeerState *state);
long peer_failures(void);                                               /* since peer_open, of its solver or its state; 0 when it tells none */
void peer_close(void);

#ifdef __cplusplus
}
#endif
#endif
