/* replay/past.c - what was before a frame (view/past.h), read from the frames themselves. */
#include "replay/inside.h"
#include "view/past.h"

static dig_status read_points(Replay *r, int frame, Past *past)
{
    DIG_TRY(replay_go(r, frame, true));
    const Look *l = &r->now.look;
    past_begin(past, r->info.first_step + (uint64_t)frame);
    for (int i = 0; i < look_count(l, LOOK_BODIES); i++) {
        const LookBody *b = &look_bodies(l)[i];
        if (b->there && b->kind == DIG_DYNAMIC && past_point(past, (uint32_t)i, b->gen, look_poses(l)[i].x) != DIG_OK)
            return replay_fail(r, DIG_E_MEMORY, "not enough memory for the trails");
    }
    return DIG_OK;
}

dig_status replay_past(Replay *r, int from, int frame, bool points, bool energies, Past *past)
{
    uint64_t last = r->info.first_step + (uint64_t)frame;
    for (int k = from; k <= frame; k++) {
        uint64_t step = r->info.first_step + (uint64_t)k;
        if (energies && step > past->first) {
            DIG_TRY(replay_go(r, k, false));
            past_energy(past, step, &kept_state(&r->now)->energy);
        }
        if (points && past_wants_points(past, step, last))
            DIG_TRY(read_points(r, k, past));
    }
    return DIG_OK;
}
