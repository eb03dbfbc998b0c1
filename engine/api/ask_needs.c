/* api/ask_needs.c - how much would it need? It is drawn slowly by a push that is an unknown of the solver, and the answer is read off.
 *
 * That is the push at which it starts, where nothing speeds up or slows down: friction, weight, what has to be tipped or lifted. Not so
 * where there is a gap before the next thing, or where what sticks is held by more than what slides, or by a spring. So the answer
 * must agree with pushes that were tried; else it is searched for. Speeds after a few steps are linear in the push above the
 * threshold, so that two of them say where it is; then halving.
 */
#include "api/ask.h"

#define SHARP 2e-3              /* of the force needed, relative */
#define GENTLE 0.05             /* of the weight */

/* One more push between those two. */
static dig_status halve(Ask *k, real push, real *low, real *high, real *rate)
{
    bool does;
    real r;
    if (!(push > *low && push < *high))
        return DIG_OK;
    DIG_TRY(ask_starts(k, push, &does, &r));
    *(does ? high : low) = push;
    *rate = does ? r : *rate;
    return DIG_OK;
}

/* Between a push that does not start it and one that does, after which it is that fast. Where it would start by the line through
 * two such points is tried from both sides; where that is not it (what sticks is held by more than what slides), halves. */
static dig_status narrow(Ask *k, real low, real high, real rate, real *needs)
{
    for (int i = 0; i < 12 && high - low > SHARP * high; i++) {
        bool does;
        real r, beyond = 1.1 * high;
        DIG_TRY(ask_starts(k, beyond, &does, &r));
        real root = r > rate ? high - rate * (beyond - high) / (r - rate) : 0;
        DIG_TRY(halve(k, root * (1 + 0.4 * SHARP), &low, &high, &rate));
        DIG_TRY(halve(k, root * (1 - 0.4 * SHARP), &low, &high, &rate));
        if (high - low > SHARP * high)
            DIG_TRY(halve(k, 0.5 * (low + high), &low, &high, &rate));
    }
    *needs = high;
    return DIG_OK;
}

/* From a push that starts it down to one that does not. */
static dig_status search_down(Ask *k, real high, real rate, real *needs)
{
    bool does = true;
    real r;
    while (high > ASK_FREE * ask_weight(k)) {
        real low = 0.25 * high;
        DIG_TRY(ask_starts(k, low, &does, &r));
        if (!does)
            return narrow(k, low, high, rate, needs);
        high = low;
        rate = r;
    }
    *needs = high;
    return DIG_OK;
}

/* From a push that does not start it up, by fours. drawn: what drawing it took, NaN: nobody knows; what is below it is not tried. */
static dig_status search_up(Ask *k, real low, real drawn, real *needs)
{
    bool does;
    real rate, most = ASK_MOST * ask_weight(k);
    for (; low < most; low *= 4) {
        if (4 * low <= drawn)
            continue;
        DIG_TRY(ask_starts(k, 4 * low, &does, &rate));
        if (does && low <= drawn) {
            *needs = drawn;
            return DIG_OK;
        }
        if (does)
            return narrow(k, low, 4 * low, rate, needs);
    }
    *needs = INFINITY;
    return DIG_OK;
}

/* Does a contact here hold more while it sticks? */
static bool sticks(const World *w)
{
    bool more = false;
    for (int i = 0; i < w->pairs.count && !more; i++) {
        Rub rub = w->pairs.data[i].alive ? pair_rub(w, &w->pairs.data[i]) : (Rub){0, 0, 0, 0};
        more = rub.friction_dynamic < rub.friction;
    }
    return more || strcmp(w->def.friction_law.s, "decay") == 0;
}

dig_status ask_needs(Ask *k, real push, bool known, real *needs)
{
    bool does = false;
    real rate = 0, drawn = NAN, most = ASK_MOST * ask_weight(k);
    if (!known)
        DIG_TRY(ask_starts(k, push, &does, &rate));
    if (!sticks(k->part.world))
        DIG_TRY(ask_draw(k, most, &drawn));
    if (does) {
        *needs = real_max(0, drawn);
        return drawn <= push ? DIG_OK : search_down(k, push, rate, needs);
    }
    if (isinf(drawn) && push < most) {
        *needs = INFINITY;
        DIG_TRY(ask_starts(k, most, &does, &rate));
        return does ? search_up(k, push, NAN, needs) : DIG_OK;
    }
    if (!known && drawn <= push) {      /* it was drawn along, and that push took it to what is near */
        *needs = real_max(0, drawn);
        return DIG_OK;
    }
    if (!known && isnan(drawn)) {       /* or a gentle one starts it, that does not */
        DIG_TRY(ask_starts(k, GENTLE * ask_weight(k), &does, &rate));
        if (does)
            return search_down(k, GENTLE * ask_weight(k), rate, needs);
    }
    return search_up(k, push, drawn > push ? drawn : NAN, needs);
}
