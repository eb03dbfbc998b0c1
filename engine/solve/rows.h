/* solve/rows.h - constraint rows of joints: the shared parts every joint is built from.
 *
 * A row is one scalar equation or bound on the velocities of at most four bodies,
 *
 *     rate = sum_i  lin_i . v_i + ang_i . w_i          (m/s or rad/s)
 *
 * and its impulse p changes  v_i by p lin_i / m_i  and  w_i by I_i^-1 (p ang_i).
 * A joint does not solve itself: it writes rows. Warm starting, static bodies,
 * softness and sleeping are thus written once, in the solver.
 *
 * With J(x) the row's Jacobian, rate = J v and d(rate)/dt = J dv/dt + drift: the drift is (dJ/dt) v, what the rate gains
 * where no velocity changes (v and w of every body constant in world axes).
 *
 * Kinds:  HARD    rate = 0 now and `error` = 0 in position; all hard rows of a joint are solved as one block
 *         LIMIT   one-sided: rate >= 0 when error <= 0 (error = distance to the stop, > 0 while free; the solver
 *                 lets the joint approach the stop at error / h); impulse >= 0
 *         MOTOR   rate = `rate`, |force| <= hi
 *         SOFT    force = -stiffness error - damping rate, implicit, stable for any step
 *         DRY     dry friction: rate = 0, |force| <= hi
 *
 * Floor:  solve. Includes base and math.
 */
#ifndef DIG_ROWS_H
#define DIG_ROWS_H

#include "math/quat.h"

typedef enum RowKind { ROW_HARD, ROW_LIMIT, ROW_MOTOR, ROW_SOFT, ROW_DRY } RowKind;

#define ROW_BODIES 4

typedef struct Row {
    RowKind kind;
    int     count;                      /* bodies in use, 1..4                                             */
    int     body[ROW_BODIES];           /* local index in the group; < 0 = the world (does not move)       */
    vec3    lin[ROW_BODIES];            /* 1    Jacobian of v                                              */
    vec3    ang[ROW_BODIES];            /* m or 1, Jacobian of w                                           */
    real    error;                      /* m or rad; MOTOR: how far it is to the stop ahead of it, INFINITY = none */
    real    rate;                       /* m/s or rad/s, wanted (MOTOR)                                    */
    real    drift;                      /* m/s^2 or rad/s^2, (dJ/dt) v: what the rate gains without accelerations */
    real    hi;                         /* N or N m, bound on |force| (MOTOR, DRY), INFINITY = none        */
    real    stiffness, damping;         /* SOFT: N/m, N s/m or N m/rad, N m s/rad                          */
    int     slot;                       /* 0..JOINT_SLOTS-1, the same for the same row in every step: warm starting */
    bool    angular;                    /* unit of the row: rad, N m (else m, N)                           */
} Row;

#define JOINT_SLOTS 12

typedef struct RowList { Row *rows; int count, capacity; } RowList;    /* capacity is JOINT_SLOTS for one joint */

/* One end of a joint, in world axes, now. */
typedef struct JointEnd {
    int  body;          /* local index, < 0 = the world                     */
    vec3 x;             /* m   centre of mass                               */
    vec3 v, w;          /* m/s, rad/s                                       */
    vec3 r;             /* m   anchor - x                                   */
    vec3 p;             /* m   anchor                                       */
    vec3 axis, u, n;    /*     joint frame fixed in this body: axis, u, n = axis x u; all unit */
} JointEnd;

typedef struct JointView JointView;
struct JointView {
    const void *params;             /* the type's own struct                                   */
    real        breaks_at;          /* N   0 = never                                           */
    JointEnd    a, b;
    real       *memory;             /* [JOINT_MEMORY] kept between steps, part of the state; angle unwinding */
    const JointView *other[2];      /* for gear and rack: the joints they couple, else NULL    */
    const struct JointType *type;
    bool        followed;           /* the motion is followed in time: friction is a force against it, not what a substep may take */
    bool        swept;              /* its rows are for a substep */
    bool        passing;            /* an instant within a step: no angle need be unwound but where something acts by it */
};

#define JOINT_MEMORY 4

/* ---- builders -------------------------------------------------------------
 *
 * Sense: a moves against b. Coordinates, rates and directions are those of a as
 * seen from b: a door (a) hinged to the world (b) has the angle of the door, a
 * drawer (a) in its cabinet (b) is out by a positive distance along the axis.
 * Directions d are unit and fixed in b. Every row's rate is the exact time
 * derivative of its error, at any pose, its drift that of the rate without
 * accelerations, and its impulse neither makes linear nor angular momentum.
 *
 * Each adds its rows and returns the first one added. */
Row *rows_add(RowList *list, RowKind kind, int slot);
/* The anchors coincide: 3 HARD rows along the frame of b (slots slot .. slot+2). */
void rows_point(RowList *list, const JointView *j, int slot);
/* HARD row: distance of the anchors along d is zero; error = d . (pa - pb). */
Row *rows_along(RowList *list, const JointView *j, vec3 d, int slot);
/* Row of any kind on the translation of a's anchor relative to b's along d: error = d . (pa - pb), and rate its derivative,
 * with the lever of b taken at a's anchor, so that no spurious torque appears. */
Row *rows_translation(RowList *list, const JointView *j, RowKind kind, vec3 d, int slot);
/* Row on the relative spin of a to b about d: rate = d . (wa - wb). Its drift is 0, right for a d at rest in the world, until
 * row_turns says how d turns. */
Row *rows_spin(RowList *list, const JointView *j, RowKind kind, vec3 d, int slot);
/* Gives a spin row about d its drift; turn = dd/dt, 1/s (wb x d where d is fixed in b). */
void row_turns(Row *r, const JointView *j, vec3 turn);
/* Row on joint_angle: a spin row about joint_twist. */
Row *rows_twist(RowList *list, const JointView *j, RowKind kind, int slot);
/* 2 HARD rows: the axes of a and b stay parallel. */
void rows_parallel(RowList *list, const JointView *j, int slot);
/* 3 HARD rows: the frames of a and b stay aligned. */
void rows_aligned(RowList *list, const JointView *j, int slot);
/* The joint with its axes (axis, u, n) named anew: axis `turn` of them first, the others after it. turn = 0, 1, 2. */
JointView joint_turned(const JointView *j, int turn);
/* Row on the length |pa - pb|: rate of the length; NULL when the ends coincide (no direction). *length gets it. */
Row *rows_length(RowList *list, const JointView *j, RowKind kind, real *length, int slot);
/* m and m/s: |pa - pb| and its rate, the coordinate and speed of what acts along the line of its ends. */
real joint_length(const JointView *j);
real joint_length_rate(const JointView *j);         /* 0 where the ends coincide */
/* Limits lo <= coordinate <= hi by up to two LIMIT rows copied from `like` (its Jacobian), slots slot and slot+1: nothing
 * for bounds that are infinite or NaN. */
void rows_limits(RowList *list, const Row *like, real coordinate, real lo, real hi, int slot);

/* Angle of a against b about the axis, unwound through +-pi with the help of *memory (last angle): right as long as it changes
 * by less than pi between calls. Where the axes are not parallel it is the twist left after the shortest rotation that makes
 * them so. */
real joint_angle(const JointView *j, real *memory);
/* The vector d with d(joint_angle)/dt = d . (wa - wb). */
vec3 joint_twist(const JointView *j);
/* Rate of a row of j at the velocities in the view, m/s or rad/s. */
real joint_rate(const JointView *j, const Row *r);

/* ---- what drives a free coordinate ----
 * Parameters that several types share; the rows that describe them are the types' own, as names and units differ. */

typedef struct DriveMotor  { real speed, most; } DriveMotor;                    /* m/s, N or rad/s, N m; speed NaN or most 0 = off */
typedef struct DriveSpring { real stiffness, damping, rest; } DriveSpring;      /* N/m, N s/m, m or N m/rad, N m s/rad, rad */

typedef struct Drive {
    real        limits[2];      /* m or rad; NaN = none         */
    DriveMotor  motor;
    DriveSpring spring;
    real        friction;       /* N or N m, dry; 0 or NaN = none */
} Drive;

enum { DRIVE_LO, DRIVE_HI, DRIVE_MOTOR, DRIVE_SPRING, DRIVE_FRICTION, DRIVE_SLOTS };     /* slots of rows_drive, after its first */

/* Rows with the Jacobian of `like`; x is its coordinate. What is off adds nothing. */
void rows_motor(RowList *list, const Row *like, const DriveMotor *m, int slot);
void rows_spring(RowList *list, const Row *like, real x, const DriveSpring *s, int slot);
void rows_friction(RowList *list, const Row *like, real friction, int slot);
bool drive_acts(const Drive *d);                                /* would rows_drive add any? */
void rows_drive(RowList *list, const Row *like, real x, const Drive *d, int slot);

real spring_energy(const DriveSpring *s, real x);               /* J */
bool at_limits(real x, real lo, real hi);                       /* within 1e-4 of a stop, or past it */

/* ---- couplings ----
 * HARD row between the coordinates x0, x1 of the two joints j->other:  k0 x0 + k1 x1 = what it was when the coupling, or its
 * k0 or k1, was new. That is kept in j->memory[0..2]. NULL when a joint is missing or has no coordinate_row. */
Row *rows_coupled(RowList *list, const JointView *j, real k0, real k1, int slot);

#endif
