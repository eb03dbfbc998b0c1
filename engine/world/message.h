/* world/message.h - the log of messages between bodies: the last 4096, in one total order.
 *
 * Every message gets the next number of one counter of the world when it is posted. The log keeps messages ordered by
 * (time, id), whatever the order of posting: a step may post what happened in one DIG after what happened later in another.
 * The last message of each receiver (id, kind, time, sender: the debug record of a body) is kept by the caller, from what
 * message_post returns.
 *
 * Owns:      nothing: a MessageLog is plain memory without pointers, about 0.5 MB; it is copied by assignment or, where it is
 *            mostly empty, by message_copy; a zeroed one is empty. Unused bytes are always zero, so that equal logs are equal byte by byte.
 * Invariant: the log holds the MESSAGE_KEPT greatest messages by (time, id) posted so far.
 * Floor:     world, but needs base only.
 */
#ifndef DIG_MESSAGE_H
#define DIG_MESSAGE_H

#include "base/base.h"

#define MESSAGE_KEPT 4096u

typedef struct MessageLog {
    uint64_t    last_id;                /* messages posted so far; ids count up from 1 */
    uint32_t    start, count;           /* ring: the oldest, how many                  */
    dig_message ring[MESSAGE_KEPT];
} MessageLog;

void     message_open(MessageLog *log);                         /* empties it and starts the ids again */
void     message_copy(MessageLog *to, const MessageLog *from);  /* costs what either holds, not what both could */
/* Logs a message; the id in it is ignored, the kind is cut at 31 bytes. Returns its new id, or 0, and logs nothing, when a
 * number in it is not finite. A message older than all of a full log gets an id but is not kept. */
uint64_t message_post(MessageLog *log, const dig_message *message);
/* The two halves of message_post, for many messages at once: the next `count` ids (returns the first of them), and one message
 * under an id so given, `m->id`. Dropped when a number in it is not finite. Messages of the same time in ascending order. */
uint64_t message_ids(MessageLog *log, uint64_t count);
void     message_keep(MessageLog *log, const dig_message *m);
/* message_keep for many of one kind: all numbers are finite, and the bytes of `kind` after its end are zero. */
static inline void message_append(MessageLog *log, const dig_message *m)
{
    uint32_t end = (log->start + log->count) % MESSAGE_KEPT;
    if (log->count > 0 && m->time < log->ring[(end + MESSAGE_KEPT - 1) % MESSAGE_KEPT].time) {
        message_keep(log, m);                   /* not the last */
        return;
    }
    log->ring[end] = *m;
    if (log->count < MESSAGE_KEPT)
        log->count++;
    else
        log->start = (log->start + 1) % MESSAGE_KEPT;
}
int      message_count(const MessageLog *log);
const dig_message *message_at(const MessageLog *log, int index);        /* 0 = oldest; NULL: no such; valid until the next post */
const dig_message *message_find(const MessageLog *log, uint64_t id);    /* NULL: forgotten or never posted; searches the log */
/* Copies at most `capacity` messages, oldest first; returns how many there are. */
int      message_list(const MessageLog *log, dig_message *out, int capacity);
uint64_t message_hash(const MessageLog *log);                   /* of the counter and all kept: same log, same value */

#endif
