/* solve/joint_type.h - what a joint type must supply. One type is one file in joint/ ending in one const table.
 *
 * Floor: solve.
 */
#ifndef DIG_JOINT_TYPE_H
#define DIG_JOINT_TYPE_H

#include "solve/rows.h"

typedef struct JointType {
    union {                         /* the same four fields, as the public API shows them */
        dig_schema schema;
        struct {
            const char      *name;          /* Lua key: world:hinge{...}             */
            const char      *doc;           /* one sentence                          */
            const dig_param *params;        /* rows of the params struct             */
            size_t           params_size;
        };
    };
    int              free_axes;     /* degrees of freedom left, 0..6                 */
    int              couples;       /* 0, or 2: a and b are joints, not bodies: the params struct then begins with two dig_joint */
    bool             no_axis;       /* the type ignores `axis`                       */
    bool             has_up;        /* params begin with a vec3 (world, at creation; x NaN = any): the u axis of the frame is that way */
    bool             elastic;       /* a part of a structure that gives: its soft rows carry the load, and are to be solved directly */
    bool             driven;        /* params are a Drive, of the free coordinate */
    bool             lower_pair;    /* what it allows is a group: relative motions that it allows, one after the other, are one */
    bool             fuses;         /* a and b are parts of one thing: where a face of one lies on the other, it is none of its surface */
    bool             at_point;      /* it holds one point of both: what other such joints hold there does not touch, see joint_forbids_contact() */
    bool             two_anchors;   /* params begin with vec3 at_a, at_b (world points at creation; x NaN = centre of mass of that body,
                                     * or the common `at` for a world end): anchors differ */
    /* Checks what ranges cannot (limits against each other, ...). why gets one sentence. May complete params (a length left NaN
     * = the present distance). May be NULL. */
    dig_status (*check)(void *params, const JointView *now, char *why, size_t capacity);
    /* The same of what must hold when it is made, and may be otherwise later: a winch takes its rope in. May be NULL. */
    dig_status (*check_new)(const void *params, const JointView *now, char *why, size_t capacity);
    /* Writes the rows of this joint for the present poses. Pure but for j->memory. */
    void       (*rows)(const JointView *j, RowList *out);
    /* Are the rows of rows_point in slots 0..2 all that acts: no stop, motor, spring or friction? NULL = no. */
    bool       (*only_point)(const void *params);
    /* Has it stops alone, and holds nothing between them? NULL = no. */
    bool       (*only_limits)(const void *params);
    /* Does nothing act on the free coordinate: no stop, motor, spring or friction? Then there is no energy and no limit either. NULL = no. */
    bool       (*loose)(const void *params);
    /* The free coordinate (rad or m), and its rate. NULL when it has none. */
    real       (*coordinate)(const JointView *j);
    real       (*speed)(const JointView *j);
    bool         angular;           /* coordinate is an angle                        */
    /* Adds a row of any kind whose rate is `speed`, for gears and racks. NULL = cannot be coupled. */
    Row       *(*coordinate_row)(RowList *list, const JointView *j, RowKind kind, int slot);
    /* Energy stored in springs, J. NULL = none. */
    real       (*energy)(const JointView *j);
    /* Load over what it bears: it breaks above 1. force, couple: N, N m, what it does to a, at a's anchor, world axes.
     * NULL: |force| / breaks_at. */
    real       (*share)(const JointView *j, vec3 force, vec3 couple);
    /* At the end of a step, under the mean load of it: what lies past the elastic limit stays (j->memory). J lost. NULL: nothing yields. */
    real       (*settle)(const JointView *j, vec3 force, vec3 couple);
    /* N m/rad  A stop that turns with what is pressed against it resists being passed across as a pendulum does: how stiffly, by the forces of
     * its rows or the mean couple on a, and what spin does so (*across, unit). NULL: none does. */
    real       (*sways)(const JointView *j, const real *force, vec3 couple, vec3 *across);
    /* Is the coordinate at a limit (within 1e-4)? NULL = no limits. */
    bool       (*at_limit)(const JointView *j);
} JointType;

/* The row of one end of a type with two_anchors. */
#define JOINT_END(key, text, params, field)                                                      \
    {.name = (key), .kind = DIG_VEC3, .unit = "m", .doc = (text), .fallback = NAN, .min = -1e9, .max = 1e9, \
     .offset = offsetof(params, field)}

/* For JointRec.plain. */
static inline bool joint_plain(const JointType *t, const void *params) { return t->only_point && t->only_point(params); }
static inline bool joint_stores(const JointView *j) { return j->type->energy && !(j->type->loose && j->type->loose(j->params)); }

/* Load over what the joint bears, 0 where nothing breaks it. */
real joint_share(const JointView *j, vec3 force, vec3 couple);

extern const JointType *const joint_types[];        /* NULL-terminated; defined in joint/joints.c */

#endif
