/* world/message.c - a ring of messages that stays sorted by (time, id). */
#include "world/message.h"

static dig_message *ring_at(MessageLog *log, uint32_t index)
{
    return &log->ring[(log->start + index) % MESSAGE_KEPT];
}

/* Field by field into zeroed memory: padding and the rest of `kind` are the same in every run. */
static void store(dig_message *to, const dig_message *from, uint64_t id)
{
    memset(to, 0, sizeof *to);
    to->id = id;
    to->root = from->root ? from->root : id;
    to->time = from->time;
    to->from.slot = from->from.slot;
    to->from.gen = from->from.gen;
    to->to.slot = from->to.slot;
    to->to.gen = from->to.gen;
    const char *end = memchr(from->kind, 0, sizeof to->kind - 1);
    memcpy(to->kind, from->kind, end ? (size_t)(end - from->kind) : sizeof to->kind - 1);
    memcpy(to->value, from->value, sizeof to->value);
    to->direction.x = from->direction.x;
    to->direction.y = from->direction.y;
    to->direction.z = from->direction.z;
}

static bool finite(const dig_message *m)
{
    for (int i = 0; i < 4; i++)
        if (!isfinite(m->value[i]))
            return false;
    return isfinite(m->time) && isfinite(m->direction.x) && isfinite(m->direction.y) && isfinite(m->direction.z);
}

void message_open(MessageLog *log)
{
    memset(log, 0, sizeof *log);
}

/* Only what was ever written: the start moves only once the ring is full. */
static uint32_t written(const MessageLog *log) { return log->start > 0 ? MESSAGE_KEPT : log->count; }

void message_copy(MessageLog *to, const MessageLog *from)
{
    uint32_t most = written(to) > written(from) ? written(to) : written(from);
    memcpy(to->ring, from->ring, most * sizeof *to->ring);
    to->last_id = from->last_id;
    to->start = from->start;
    to->count = from->count;
}

uint64_t message_ids(MessageLog *log, uint64_t count)
{
    uint64_t first = log->last_id + 1;
    log->last_id += count;
    return first;
}

static void insert(MessageLog *log, const dig_message *message, uint64_t id)
{
    if (log->count == MESSAGE_KEPT) {
        if (message->time < ring_at(log, 0)->time)
            return;
        log->start = (log->start + 1) % MESSAGE_KEPT;
        log->count--;
    }
    /* Its id is the greatest of its time, so it goes behind all that are not later. */
    uint32_t place = log->count++;
    for (; place > 0 && ring_at(log, place - 1)->time > message->time; place--)
        memcpy(ring_at(log, place), ring_at(log, place - 1), sizeof(dig_message));
    store(ring_at(log, place), message, id);
}

void message_keep(MessageLog *log, const dig_message *m)
{
    if (finite(m))
        insert(log, m, m->id);
}

uint64_t message_post(MessageLog *log, const dig_message *message)
{
    if (!finite(message))
        return 0;
    uint64_t id = message_ids(log, 1);
    insert(log, message, id);
    return id;
}

int message_count(const MessageLog *log)
{
    return (int)log->count;
}

const dig_message *message_at(const MessageLog *log, int index)
{
    if (index < 0 || (uint32_t)index >= log->count)
        return NULL;
    return &log->ring[(log->start + (uint32_t)index) % MESSAGE_KEPT];
}

const dig_message *message_find(const MessageLog *log, uint64_t id)
{
    for (int i = message_count(log) - 1; i >= 0; i--)
        if (message_at(log, i)->id == id)
            return message_at(log, i);
    return NULL;
}

int message_list(const MessageLog *log, dig_message *out, int capacity)
{
    int count = message_count(log);
    for (int i = 0; i < count && i < capacity; i++)
        memcpy(&out[i], message_at(log, i), sizeof out[i]);
    return count;
}

/* FNV-1a (Fowler, Noll, Vo; 64 bits) over the bytes in order; the position in the ring does not count. */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t bytes)
{
    const unsigned char *byte = data;
    for (size_t i = 0; i < bytes; i++)
        hash = (hash ^ byte[i]) * 1099511628211u;
    return hash;
}

uint64_t message_hash(const MessageLog *log)
{
    uint64_t hash = hash_bytes(14695981039346656037u, &log->last_id, sizeof log->last_id);
    for (int i = 0; i < message_count(log); i++)
        hash = hash_bytes(hash, message_at(log, i), sizeof(dig_message));
    return hash;
}
