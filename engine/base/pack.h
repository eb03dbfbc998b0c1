/* base/pack.h - records as bytes, and back: one function per record says its fields, for writing and for reading.
 *
 *   static void pack_ball(Pack *p, Ball *b)
 *   {
 *       pack_real_in(p, &b->radius, 1e-4, 1e5, "ball radius");
 *       pack_bool(p, &b->filled);
 *   }
 *
 * Writing never changes the fields; reading sets them and checks them. All numbers are little-endian, reals are the bits of an
 * IEEE 754 double, so that what is read is what was written, bit for bit. The first failure is kept, in words; after it every
 * read gives zero and every write does nothing, so that callers ask once, at the end.
 *
 * Reading trusts nothing: pack_count refuses a number of records that the bytes left cannot hold, and is to be asked before
 * memory for them is taken.
 *
 * Owns:      when writing, `data` (pack_close frees it); when reading, nothing: `data` is borrowed.
 * Floor:     base.
 */
#ifndef DIG_PACK_H
#define DIG_PACK_H

#include "base/base.h"

typedef struct Pack {
    unsigned char *data;        /* written, grows                              */
    const unsigned char *from;  /* read                                        */
    size_t size, at;            /* bytes: of `data` or `from`; read so far     */
    size_t capacity;            /* bytes of `data`                             */
    bool   reading, no_memory;
    char   why[200];            /* the first failure, "" = none                */
} Pack;

Pack pack_writer(void);
Pack pack_reader(const void *data, size_t size);
void pack_close(Pack *p);
static inline bool pack_good(const Pack *p) { return p->why[0] == '\0'; }
void pack_fail(Pack *p, const char *format, ...) DIG_PRINTF(2, 3);
void pack_fail_memory(Pack *p);
/* Fails unless `fine`; reading only. Returns whether all is well so far. */
bool pack_check(Pack *p, bool fine, const char *what);
void pack_end(Pack *p);                                 /* reading: fails when bytes are left */

void pack_bytes(Pack *p, void *bytes, size_t size);
/* So many bytes of what is written, to be filled, or of what is read. NULL after a failure. Valid until the next call. */
unsigned char *pack_space(Pack *p, size_t size);
const unsigned char *pack_take(Pack *p, size_t size);
void pack_u8(Pack *p, uint8_t *x);
void pack_u16(Pack *p, uint16_t *x);
void pack_u32(Pack *p, uint32_t *x);
void pack_u64(Pack *p, uint64_t *x);
void pack_i32(Pack *p, int32_t *x);
void pack_i64(Pack *p, int64_t *x);
void pack_bool(Pack *p, bool *x);                       /* 0 or 1 */
void pack_real(Pack *p, real *x);                       /* any bits */
/* At most size - 1 bytes, none of them 0; the rest of s is zeroed when reading. */
void pack_text(Pack *p, char *s, size_t size);

/* With bounds, inclusive; NaN is never inside. `what` names the field in the sentence. */
void pack_real_in(Pack *p, real *x, real low, real high, const char *what);
void pack_real_or_nan(Pack *p, real *x, real low, real high, const char *what);
void pack_vec3(Pack *p, vec3 *v, real limit, const char *what);         /* every |component| <= limit */
void pack_quat(Pack *p, quat *q, const char *what);                     /* |q| = 1 to 1e-12 */
void pack_small(Pack *p, uint8_t *x, unsigned count, const char *what); /* 0 .. count - 1 */
/* 0 .. count - 1, or UINT32_MAX where `none` allows it. */
void pack_index(Pack *p, uint32_t *i, uint32_t count, bool none, const char *what);
/* Number of records that follow, each at least `least` bytes long. Returns it, when reading 0 after a failure. */
uint32_t pack_count(Pack *p, uint32_t count, size_t least, const char *what);

/* An enum or other small whole number, through a byte. */
#define pack_enum(p, field, count, what)            \
    do {                                            \
        uint8_t byte_ = (uint8_t)*(field);          \
        pack_small((p), &byte_, (count), (what));   \
        *(field) = byte_;                           \
    } while (0)

/* CRC-32 of ISO 3309 (polynomial 0x04C11DB7, as in gzip and PNG). */
uint32_t pack_crc32(const void *data, size_t size);

#endif
