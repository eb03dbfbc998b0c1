/* base/hash.h - a 64-bit hash of raw bits (FNV-1a over 8-byte words, then mixed), for checksums of the state.
 *
 * Floor: base.
 */
#ifndef DIG_HASH_H
#define DIG_HASH_H

#include "base/base.h"

#define HASH_START 0xcbf29ce484222325u

static inline uint64_t hash_u64(uint64_t h, uint64_t v)
{
    h = (h ^ v) * 0x100000001b3u;
    return h ^ (h >> 29);
}

/* Minus zero and zero differ; so do the payloads of NaN: bits are bits. */
static inline uint64_t hash_real(uint64_t h, real x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return hash_u64(h, bits);
}

static inline uint64_t hash_vec3(uint64_t h, vec3 v) { return hash_real(hash_real(hash_real(h, v.x), v.y), v.z); }
static inline uint64_t hash_quat(uint64_t h, quat q) { return hash_real(hash_vec3(h, (vec3){q.x, q.y, q.z}), q.w); }

static inline uint64_t hash_bytes(uint64_t h, const void *data, size_t size)
{
    const unsigned char *p = data;
    for (size_t i = 0; i < size; i++)
        h = hash_u64(h, p[i]);
    return h;
}

#endif
