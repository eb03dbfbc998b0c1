/* world/mail.c - the queue as a binary heap, and what was heard at this instant. */
#include "world/mail.h"

#include "base/hash.h"

void mail_close(Mail *m)
{
    list_close(&m->queue);
    list_close(&m->waiting);
    list_close(&m->shown);
    list_close(&m->roots);
    list_close(&m->reach);
    list_close(&m->seen);
    map_close(&m->heard);
}

dig_status mail_copy(Mail *to, const Mail *from, uint64_t *allocations)
{
    to->instant = from->instant;
    to->answers = from->answers;
    DIG_TRY(list_copy(&to->queue, &from->queue, allocations));
    DIG_TRY(list_copy(&to->waiting, &from->waiting, allocations));
    DIG_TRY(list_copy(&to->shown, &from->shown, allocations));
    DIG_TRY(list_copy(&to->roots, &from->roots, allocations));
    return map_copy(&to->heard, &from->heard);
}

size_t mail_bytes(const Mail *m)
{
    return list_bytes(&m->queue) + list_bytes(&m->waiting) + list_bytes(&m->shown) + list_bytes(&m->roots) + list_bytes(&m->reach)
         + list_bytes(&m->seen) + map_bytes(&m->heard);
}

/* Without generations, which differ between equal worlds. */
uint64_t mail_hash(uint64_t h, const Mail *m)
{
    for (int i = 0; i < m->queue.count; i++) {
        const Post *p = &m->queue.data[i];
        const dig_post *d = &p->what;
        h = hash_real(hash_u64(hash_u64(h, p->id), p->root), p->time);
        h = hash_u64(hash_u64(h, (uint64_t)d->route | (uint64_t)d->transform << 8), (uint64_t)d->layer << 32 | (uint32_t)d->link);
        h = hash_u64(h, (uint64_t)d->from.slot << 32 | d->to.slot);
        h = hash_u64(h, (uint64_t)d->dig.id << 32 | d->region.slot);
        h = hash_real(hash_u64(h, (uint64_t)d->hops), d->factor);
        h = hash_bytes(h, d->kind, strlen(d->kind));
        for (int k = 0; k < 4; k++)
            h = hash_real(h, d->value[k]);
    }
    return h;
}

/* ---- the queue ---- */

static bool before(const Post *a, const Post *b) { return a->time != b->time ? a->time < b->time : a->id < b->id; }

dig_status mail_queue(Mail *m, const Post *p, uint64_t *allocations)
{
    DIG_TRY(list_push(&m->queue, allocations));
    Post *heap = m->queue.data;
    int i = m->queue.count - 1;
    for (; i > 0 && before(p, &heap[(i - 1) / 2]); i = (i - 1) / 2)
        heap[i] = heap[(i - 1) / 2];
    heap[i] = *p;
    return DIG_OK;
}

bool mail_due(const Mail *m, real now) { return m->queue.count > 0 && m->queue.data[0].time <= now; }

Post mail_take(Mail *m)
{
    Post *heap = m->queue.data, first = heap[0], last = heap[--m->queue.count];
    int i = 0;
    for (int child; (child = 2 * i + 1) < m->queue.count; i = child) {
        if (child + 1 < m->queue.count && before(&heap[child + 1], &heap[child]))
            child++;
        if (!before(&heap[child], &last))
            break;
        heap[i] = heap[child];
    }
    heap[i] = last;
    return first;
}

bool mail_in_order(const Mail *m)
{
    for (int i = 1; i < m->queue.count; i++)
        if (!before(&m->queue.data[(i - 1) / 2], &m->queue.data[i]))
            return false;
    return true;
}

/* ---- what was heard at this instant ---- */

void mail_at(Mail *m, real now)
{
    if (m->instant == now)
        return;
    m->instant = now;
    m->answers = 0;
    m->roots.count = 0;
    if (m->heard.count)
        memset(m->heard.entries, 0, m->heard.size * sizeof *m->heard.entries);
    m->heard.count = 0;
}

static MapKey key_of(uint64_t root, const char *kind, uint32_t body)
{
    uint64_t h = hash_bytes(hash_u64(HASH_START, root), kind, strlen(kind));
    return (MapKey){(uint32_t)(h >> 32), (uint32_t)h, body};
}

bool mail_heard(const Mail *m, uint64_t root, const char *kind, uint32_t body)
{
    return m->heard.count > 0 && map_find(&m->heard, key_of(root, kind, body), NULL);
}

void mail_note(Mail *m, uint64_t root, const char *kind, uint32_t body)
{
    (void)map_put(&m->heard, key_of(root, kind, body), 1);      /* without memory a message may come twice */
}
