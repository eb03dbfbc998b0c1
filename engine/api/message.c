/* api/message.c - messages: sending them, and reading those of the past. */
#include "api/api.h"
#include "api/command.h"

#include <stdio.h>

dig_post dig_post_defaults(void) { return (dig_post){.link = -1, .factor = 1}; }

/* ---- what may be posted ---- */

static dig_status check_ends(const World *w, const dig_post *p)
{
    bool along = p->route == DIG_ROUTE_NEIGHBOURS || p->route == DIG_ROUTE_FLOOD || p->route == DIG_ROUTE_PATH;
    bool to = p->route == DIG_ROUTE_TO || p->route == DIG_ROUTE_PATH;
    if ((to && !api_body(w, p->to, "send")) || (p->from.gen && !api_body(w, p->from, "send")))
        return DIG_E_DEAD;
    if (!p->from.gen && (along || (p->route == DIG_ROUTE_DIG && p->dig.id == 0)))
        return world_fail(w, DIG_E_ARG, "message '%s': this route begins at a body, so it needs a sender", p->kind);
    if (p->layer >= DIG_LAYERS || p->dig.layer >= DIG_LAYERS)
        return world_fail(w, DIG_E_ARG, "message '%s': layer = %u, must be below %d", p->kind, p->layer, DIG_LAYERS);
    const Graph *g = layer_graph(w, p->dig.layer);
    if (p->route == DIG_ROUTE_DIG && p->dig.id && (!g || graph_size(g, p->dig.id) == 0))
        return world_fail(w, DIG_E_DEAD, "broadcast: DIG %u is no more", p->dig.id);
    dig_region r = p->region;
    if (p->route == DIG_ROUTE_REGION && (r.slot >= (uint32_t)w->regions.count || !w->regions.data[r.slot].alive || w->regions.data[r.slot].gen != r.gen))
        return world_fail(w, DIG_E_DEAD, "send: this region was removed");
    return DIG_OK;
}

static dig_status check_post(const World *w, const dig_post *p)
{
    if ((unsigned)p->route >= DIG_ROUTES || (unsigned)p->transform >= DIG_TRANSFORMS)
        return world_fail(w, DIG_E_ARG, "send: there is no route %d with the transform %d", (int)p->route, (int)p->transform);
    if (!p->kind[0] || !memchr(p->kind, 0, sizeof p->kind))
        return world_fail(w, DIG_E_ARG, "send: a message needs a kind of 1 to %zu bytes", sizeof p->kind - 1);
    for (int i = 0; i < 4; i++)
        if (!isfinite(p->value[i]))
            return world_fail(w, DIG_E_ARG, "message '%s': its values must be finite", p->kind);
    if (!(p->after >= 0 && p->after <= 1e9))
        return world_fail(w, DIG_E_ARG, "message '%s': after = %g s, must be 0 to 1e9 s", p->kind, p->after);
    if (!isfinite(p->factor) || p->hops < 0)
        return world_fail(w, DIG_E_ARG, "message '%s': factor = %g and hops = %d, must be finite and not negative", p->kind, p->factor, p->hops);
    return check_ends(w, p);
}

/* ---- cascades ---- */

static const Letter *root_letter(const Mail *m, uint64_t root)
{
    for (int i = m->roots.count - 1; i >= 0; i--)
        if (m->roots.data[i].root == root)
            return &m->roots.data[i];
    return NULL;
}

/* How the cascade began is noted at its first answer: the log may have forgotten it when that matters. */
static void note_root(World *w, uint64_t root)
{
    Mail *m = &w->mail;
    if (root_letter(m, root) || list_push(&m->roots, &w->allocations) != DIG_OK)
        return;
    Letter *letter = &m->roots.data[m->roots.count - 1];
    const dig_message *first = message_find(&w->messages, root);
    letter->root = root;
    if (!first)
        return;
    memcpy(letter->kind, first->kind, sizeof letter->kind);
    letter->from = first->from;
    letter->to = first->to;
}

static const char *name_of(const World *w, dig_body b, char text[BODY_TEXT_SIZE])
{
    const Body *body = world_body(w, b);
    if (!b.gen)
        return "the world";
    if (!body)
        return "a body that is gone";
    return body_text(w, body, text);
}

/* What waits to be handled of this cascade goes, and all else stays. */
static void cut_off(World *w, uint64_t root)
{
    Mail *m = &w->mail;
    int letters = 0, events = 0;
    for (int i = 0, k = 0; i < w->pending.count; i++) {
        dig_event e = w->pending.data[i];
        if (e.kind == DIG_EVENT_MESSAGE) {
            dig_message letter = m->waiting.data[k++];
            if (letter.root == root) {
                w->stats.dropped++;
                continue;
            }
            m->waiting.data[letters++] = letter;
        }
        w->pending.data[events++] = e;
    }
    w->pending.count = events;
    m->waiting.count = letters;
}

static dig_status storm(World *w)
{
    char from[BODY_TEXT_SIZE], to[BODY_TEXT_SIZE];
    uint64_t root = w->mail.answering;
    const Letter *first = root_letter(&w->mail, root);
    if (w->mail.answers == MAIL_STORM + 1) {
        w->stats.storms++;
        cut_off(w, root);
    }
    if (!first || !first->kind[0])
        return world_fail(w, DIG_E_FULL, "message storm: more than %d answers at t = %.6g s to message %llu; what is left of it is dropped",
                          MAIL_STORM, world_time(w), (unsigned long long)root);
    return world_fail(w, DIG_E_FULL, "message storm: more than %d answers at t = %.6g s to message %llu, '%s' from %s to %s; what is left of it is dropped",
                      MAIL_STORM, world_time(w), (unsigned long long)root, first->kind, name_of(w, first->from, from), name_of(w, first->to, to));
}

dig_status run_answering(World *w, CommandArg *a)
{
    w->mail.answering = a[0].whole;
    return DIG_OK;
}

void dig_message_answering(dig_world *w, uint64_t root)
{
    if (w->tap && w->mail.answering != root)
        command_do(w, COMMAND_ANSWERING, (CommandArg[COMMAND_ARGS]){{.whole = root}});
    w->mail.answering = root;
}

/* ---- posting ---- */

/* Fills what the world knows of the post; DIG_E_FULL: a storm. */
static dig_status prepare(World *w, const dig_post *what, Post *p)
{
    real now = world_time(w);
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "send: no message can be sent while the world is stepping");
    DIG_TRY(check_post(w, what));
    *p = (Post){.root = w->mail.answering, .time = now + what->after, .what = *what};
    memset(p->what.kind, 0, sizeof p->what.kind);
    memcpy(p->what.kind, what->kind, strlen(what->kind));
    mail_at(&w->mail, now);
    if (p->root) {
        note_root(w, p->root);
        if (++w->mail.answers > MAIL_STORM)
            return storm(w);
    }
    return DIG_OK;
}

static dig_status do_post(World *w, const dig_post *what, dig_receipt *receipt)
{
    Post p;
    if (receipt)
        *receipt = (dig_receipt){0};
    DIG_TRY(prepare(w, what, &p));
    if (what->after > 0) {
        p.id = w->messages.last_id + 1;
        if (mail_queue(&w->mail, &p, &w->allocations) != DIG_OK)
            return world_fail(w, DIG_E_MEMORY, "message '%s': not enough memory", what->kind);
        message_ids(&w->messages, 1);
    } else {
        deliver_post(w, &p, receipt);
    }
    w->stats.posted++;
    return DIG_OK;
}

dig_status run_post(World *w, CommandArg *a)
{
    return do_post(w, a[0].what, a[1].place);
}

dig_status dig_message_post(dig_world *w, const dig_post *what, dig_receipt *receipt)
{
    return COMMAND(w, COMMAND_POST, do_post(w, what, receipt), {.what = what}, {.place = receipt});
}

static dig_status do_list(World *w, const dig_post *what, const dig_body *to, const real *value, int count)
{
    Post p;
    dig_post each = *what;
    each.route = DIG_ROUTE_DIG;             /* needs a sender, and no receiver of its own */
    each.after = 0;
    for (int i = 0; i < count; i++)
        if (!isfinite(value[i]))
            return world_fail(w, DIG_E_ARG, "message '%s': its values must be finite", what->kind);
    DIG_TRY(prepare(w, &each, &p));
    deliver_list(w, &p, to, value, count);
    w->stats.posted++;
    return DIG_OK;
}

dig_status run_post_list(World *w, CommandArg *a)
{
    const CommandList *l = a[1].what;
    return do_list(w, a[0].what, l->to, l->value, l->count);
}

dig_status dig_message_list(dig_world *w, const dig_post *what, const dig_body *to, const real *value, int count)
{
    const CommandList l = {to, value, count};
    return COMMAND(w, COMMAND_POST_LIST, do_list(w, what, to, value, count), {.what = what}, {.what = &l});
}

/* A name that is longer than a message holds is cut. */
static dig_post simple(dig_route route, dig_body from, const char *kind, const real value[4])
{
    dig_post p = dig_post_defaults();
    p.route = route;
    p.from = from;
    snprintf(p.kind, sizeof p.kind, "%s", kind);
    if (value)
        memcpy(p.value, value, sizeof p.value);
    return p;
}

dig_status dig_message_send(dig_world *w, dig_body from, dig_body to, const char *kind, const real value[4])
{
    dig_post p = simple(DIG_ROUTE_TO, from, kind, value);
    p.to = to;
    return dig_message_post(w, &p, NULL);
}

dig_status dig_message_broadcast(dig_world *w, dig_dig d, dig_body from, const char *kind, const real value[4])
{
    dig_post p = simple(DIG_ROUTE_DIG, from, kind, value);
    p.dig = d;
    if (d.id == 0)
        return world_fail(w, DIG_E_DEAD, "broadcast: DIG 0 is no more");
    return dig_message_post(w, &p, NULL);
}

/* ---- reading ---- */

int dig_messages(const dig_world *w, dig_message *out, int capacity) { return message_list(&w->messages, out, capacity); }

const dig_message *dig_message_of(const dig_world *w, const dig_event *e)
{
    int low = 0, high = w->mail.shown.count;            /* ids rise */
    while (low < high) {
        int middle = (low + high) / 2;
        if (w->mail.shown.data[middle].id < e->message)
            low = middle + 1;
        else
            high = middle;
    }
    bool found = e->kind == DIG_EVENT_MESSAGE && low < w->mail.shown.count && w->mail.shown.data[low].id == e->message;
    return found ? &w->mail.shown.data[low] : e->kind == DIG_EVENT_MESSAGE ? message_find(&w->messages, e->message) : NULL;
}

static int take(World *w)
{
    Mail *m = &w->mail;
    int count = m->waiting.count, events = 0;
    if (count == 0 || w->busy || list_reserve(&w->events, w->events.count + count, &w->allocations) != DIG_OK
        || list_reserve(&m->shown, m->shown.count + count, &w->allocations) != DIG_OK)
        return 0;
    memcpy(&m->shown.data[m->shown.count], m->waiting.data, (size_t)count * sizeof *m->waiting.data);
    m->shown.count += count;
    m->waiting.count = 0;
    for (int i = 0; i < w->pending.count; i++) {
        if (w->pending.data[i].kind == DIG_EVENT_MESSAGE)
            w->events.data[w->events.count++] = w->pending.data[i];
        else
            w->pending.data[events++] = w->pending.data[i];
    }
    w->pending.count = events;
    return count;
}

/* Nothing waits: nothing was done. */
dig_status run_take(World *w, CommandArg *a)
{
    int count = take(w);
    if (a[0].place)
        memcpy(a[0].place, &count, sizeof count);
    return count > 0 ? DIG_OK : DIG_E_ARG;
}

int dig_message_take(dig_world *w)
{
    int count = 0;
    if (!w->tap)
        return take(w);
    command_do(w, COMMAND_TAKE, (CommandArg[COMMAND_ARGS]){{.place = &count}});
    return count;
}

dig_status run_dropped(World *w, CommandArg *a)
{
    w->stats.dropped += a[0].whole;
    return DIG_OK;
}

void dig_message_dropped(dig_world *w, int count)
{
    CommandArg a[COMMAND_ARGS] = {{.whole = (uint64_t)int_max(0, count)}};
    if (w->tap && count > 0)
        command_do(w, COMMAND_DROPPED, a);
    else
        run_dropped(w, a);
}
