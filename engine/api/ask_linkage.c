/* api/ask_linkage.c - the first, cheap look of a question: gears pass a turn on along their ratios. A wheel that is reached twice
 * must turn at one speed; where the two differ, the train contradicts itself and nothing in it can turn: three wheels in a
 * triangle jam, four in a ring turn.
 */
#include "api/ask.h"

#include <stdlib.h>

#define SAME 1e-9               /* of two speeds that should be equal, relative */

typedef struct Flood {
    const World *w;
    real     *speed;            /* of a joint's coordinate, first one = 1; 0 = not reached */
    uint32_t *from;             /* joint it was reached from */
    uint32_t *queue;
    int       tail;
} Flood;

/* The coupling's ratio as `rate of b over rate of a`. */
static bool ratio_of(const JointRec *r, real *ratio)
{
    if (!r->alive || r->other[0] == NONE || r->other[1] == NONE || strcmp(r->type->name, "gear") != 0)
        return false;
    const real *given = &r->params[2];          /* after two handles: ratio[2], speed of a * first = speed of b * second */
    *ratio = given[0] / given[1];
    return true;
}

/* Passes the speed of `joint` on through one gear; false: the other wheel has another speed. */
static bool pass_on(Flood *f, uint32_t joint, const JointRec *gear, real ratio)
{
    bool first = gear->other[0] == joint;
    uint32_t next = gear->other[first ? 1 : 0];
    real speed = first ? f->speed[joint] * ratio : f->speed[joint] / ratio;
    if (f->speed[next] == 0) {
        f->speed[next] = speed;
        f->from[next] = joint;
        f->queue[f->tail++] = next;
        return true;
    }
    return fabs(f->speed[next] - speed) <= SAME * (fabs(speed) + fabs(f->speed[next]));
}

/* The wheel of a hinge: that of its bodies which moves. */
static uint32_t wheel(const World *w, uint32_t joint)
{
    const JointRec *r = &w->joints.data[joint];
    return r->a != NONE && w->bodies.data[r->a].kind == DIG_DYNAMIC ? r->a : r->b;
}

static void add_wheel(const World *w, uint32_t joint, dig_part *loop, int *count)
{
    uint32_t body = wheel(w, joint);
    for (int i = 0; i < *count; i++)
        if (loop[i].body.slot == body)
            return;
    if (body != NONE && *count < DIG_ANSWER_PARTS)
        loop[(*count)++] = (dig_part){.body = body_handle(w, body)};
}

/* Both ways back to where the flood began. */
static void tell_loop(const Flood *f, uint32_t one, uint32_t other, dig_part *loop, int *count)
{
    for (uint32_t j = one; ; j = f->from[j]) {
        add_wheel(f->w, j, loop, count);
        if (f->from[j] == j)
            break;
    }
    for (uint32_t j = other; f->from[j] != j; j = f->from[j])
        add_wheel(f->w, j, loop, count);
}

static bool flood(Flood *f, uint32_t start, dig_part *loop, int *count)
{
    const World *w = f->w;
    f->speed[start] = 1;
    f->from[start] = start;
    f->queue[f->tail++] = start;
    for (int head = 0; head < f->tail; head++)
        for (int i = 0; i < w->joints.count; i++) {
            const JointRec *gear = &w->joints.data[i];
            uint32_t joint = f->queue[head];
            real ratio;
            if (!ratio_of(gear, &ratio) || (gear->other[0] != joint && gear->other[1] != joint))
                continue;
            if (!pass_on(f, joint, gear, ratio)) {
                tell_loop(f, joint, gear->other[gear->other[0] == joint ? 1 : 0], loop, count);
                return true;
            }
        }
    return false;
}

bool ask_conflict(const World *w, uint32_t body, dig_part *loop, int *count)
{
    bool geared = false, conflict = false;
    *count = 0;
    for (int i = 0; i < w->joints.count && !geared; i++) {
        real ratio;
        geared = ratio_of(&w->joints.data[i], &ratio);
    }
    size_t n = (size_t)w->joints.count;
    Flood f = {.w = w, .speed = geared ? calloc(n, sizeof(real)) : NULL, .from = geared ? calloc(n, sizeof(uint32_t)) : NULL,
               .queue = geared ? calloc(n, sizeof(uint32_t)) : NULL};
    for (uint32_t j = w->bodies.data[body].joint_first; f.speed && f.from && f.queue && j != NONE && !conflict; j = joint_next(w, j, body))
        conflict = f.speed[j] == 0 && flood(&f, j, loop, count);
    free(f.speed);
    free(f.from);
    free(f.queue);
    return conflict;
}
