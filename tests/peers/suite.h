/* tests/peers/suite.h - the scenes of suite A as the peers are given them, with the exact results they are judged by. */
#ifndef DIGBOX_PEER_SUITE_H
#define DIGBOX_PEER_SUITE_H
#include "peer.h"

enum { RUN_SAMPLES = 1 + 60 * 10, RUN_TRACKED = 8 };

/* What was seen at the frame times k/60 s; sample[0] is the start. */
typedef struct {
    int       frames;
    PeerState sample[RUN_SAMPLES][RUN_TRACKED];
} PeerRun;

enum { PEER_ENERGY = 1, PEER_MOMENTUM = 2 };   /* what a scene conserves; momentum: angular momentum as well */

typedef struct {
    const char *id;
    int         variant;     /* what its functions are told */
    double      seconds;
    int         tracked;     /* the first bodies, which are recorded */
    int         conserves;
    void      (*build)(PeerScene *scene, int variant);
    void      (*drive)(double t, int variant);   /* sets the movers before the frame that begins at t; or none */
    double    (*error)(const PeerRun *run, int variant);
} PeerCase;

extern const PeerCase peer_cases[];   /* ends with a row without an id */

/* tests/peers/exact.c: references without a closed form. Each returns an array of frames+1 rows, computed once. */
typedef struct { double angle[2]; } TwoAngles;
typedef struct { double turn[4]; } Orientation;
const TwoAngles *exact_pendulum(int rods);          /* angles from straight down, released level; 10 s */
const Orientation *exact_rotor(void);               /* of A09's box at the frame times; 10 s */

double vector_distance(const double a[3], const double b[3]);
double angle_between(const double p[4], const double q[4]);   /* of two orientations, rad */
#endif
