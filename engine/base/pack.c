/* base/pack.c - records as bytes, and back. */
#include "base/pack.h"

#include <stdio.h>
#include <stdlib.h>

#define FIRST_CAPACITY 4096u    /* bytes */

Pack pack_writer(void) { return (Pack){.reading = false}; }
Pack pack_reader(const void *data, size_t size) { return (Pack){.from = data, .size = size, .reading = true}; }

void pack_close(Pack *p)
{
    free(p->data);
    *p = (Pack){0};
}

/* ---- failure ---- */

void pack_fail(Pack *p, const char *format, ...)
{
    va_list args;
    if (!pack_good(p))
        return;
    va_start(args, format);
    vsnprintf(p->why, sizeof p->why, format, args);
    va_end(args);
}

void pack_fail_memory(Pack *p)
{
    p->no_memory = p->no_memory || pack_good(p);
    pack_fail(p, "not enough memory");
}

bool pack_check(Pack *p, bool fine, const char *what)
{
    if (p->reading && !fine)
        pack_fail(p, "%s", what);
    return pack_good(p);
}

void pack_end(Pack *p)
{
    if (p->reading && p->at != p->size)
        pack_fail(p, "%zu bytes are left over", p->size - p->at);
}

/* ---- bytes ---- */

static bool make_room(Pack *p, size_t size)
{
    if (p->capacity - p->size >= size)
        return true;
    size_t capacity = p->capacity < FIRST_CAPACITY ? FIRST_CAPACITY : p->capacity + p->capacity / 2;
    if (capacity < p->size + size)
        capacity = p->size + size;
    unsigned char *data = realloc(p->data, capacity);
    if (!data) {
        pack_fail_memory(p);
        return false;
    }
    p->data = data;
    p->capacity = capacity;
    return true;
}

void pack_bytes(Pack *p, void *bytes, size_t size)
{
    if (!p->reading) {
        if (pack_good(p) && size > 0 && make_room(p, size)) {
            memcpy(p->data + p->size, bytes, size);
            p->size += size;
        }
        return;
    }
    if (size > p->size - p->at)
        pack_fail(p, "it ends in the middle of a record");
    if (!pack_good(p)) {
        memset(bytes, 0, size);
        return;
    }
    memcpy(bytes, p->from + p->at, size);
    p->at += size;
}

unsigned char *pack_space(Pack *p, size_t size)
{
    if (!pack_good(p) || !make_room(p, size))
        return NULL;
    p->size += size;
    return p->data + p->size - size;
}

const unsigned char *pack_take(Pack *p, size_t size)
{
    if (size > p->size - p->at)
        pack_fail(p, "it ends in the middle of a record");
    if (!pack_good(p))
        return NULL;
    p->at += size;
    return p->from + p->at - size;
}

void pack_u8(Pack *p, uint8_t *x)
{
    pack_bytes(p, x, 1);
}

/* The lowest `size` bytes of a number, lowest first. */
static uint64_t pack_whole(Pack *p, uint64_t x, size_t size)
{
    unsigned char bytes[8];
    for (size_t i = 0; i < size; i++)
        bytes[i] = (unsigned char)(x >> 8 * i);
    pack_bytes(p, bytes, size);
    uint64_t y = 0;
    for (size_t i = 0; i < size; i++)
        y |= (uint64_t)bytes[i] << 8 * i;
    return p->reading ? y : x;
}

void pack_u16(Pack *p, uint16_t *x) { *x = (uint16_t)pack_whole(p, *x, 2); }
void pack_u32(Pack *p, uint32_t *x) { *x = (uint32_t)pack_whole(p, *x, 4); }
void pack_u64(Pack *p, uint64_t *x) { *x = pack_whole(p, *x, 8); }

/* Two's complement; memcpy gives the bits the sign that they stand for. */
void pack_i32(Pack *p, int32_t *x)
{
    uint32_t bits;
    memcpy(&bits, x, sizeof bits);
    pack_u32(p, &bits);
    memcpy(x, &bits, sizeof bits);
}

void pack_i64(Pack *p, int64_t *x)
{
    uint64_t bits;
    memcpy(&bits, x, sizeof bits);
    pack_u64(p, &bits);
    memcpy(x, &bits, sizeof bits);
}

void pack_real(Pack *p, real *x)
{
    uint64_t bits;
    memcpy(&bits, x, sizeof bits);
    pack_u64(p, &bits);
    memcpy(x, &bits, sizeof bits);
}

void pack_bool(Pack *p, bool *x)
{
    uint8_t byte = *x;
    pack_u8(p, &byte);
    if (byte > 1)
        pack_fail(p, "a yes or no is %u", byte);
    *x = byte == 1;
}

void pack_text(Pack *p, char *s, size_t size)
{
    const char *end = p->reading ? NULL : memchr(s, '\0', size);
    uint8_t length = (uint8_t)(p->reading ? 0 : end ? (size_t)(end - s) : size - 1);
    pack_u8(p, &length);
    if (length >= size)
        pack_fail(p, "a text has %u bytes, at most %zu", length, size - 1);
    if (p->reading)
        memset(s, 0, size);
    if (pack_good(p))
        pack_bytes(p, s, length);
    if (p->reading && memchr(s, '\0', length))
        pack_fail(p, "a text holds a zero byte");
    if (!pack_good(p) && p->reading)
        s[0] = '\0';
}

/* ---- with bounds ---- */

void pack_real_in(Pack *p, real *x, real low, real high, const char *what)
{
    pack_real(p, x);
    if (p->reading && !(*x >= low && *x <= high))
        pack_fail(p, "%s = %g, must be %g to %g", what, *x, low, high);
}

void pack_real_or_nan(Pack *p, real *x, real low, real high, const char *what)
{
    pack_real(p, x);
    if (p->reading && !isnan(*x) && !(*x >= low && *x <= high))
        pack_fail(p, "%s = %g, must be %g to %g", what, *x, low, high);
}

void pack_vec3(Pack *p, vec3 *v, real limit, const char *what)
{
    pack_real_in(p, &v->x, -limit, limit, what);
    pack_real_in(p, &v->y, -limit, limit, what);
    pack_real_in(p, &v->z, -limit, limit, what);
}

void pack_quat(Pack *p, quat *q, const char *what)
{
    pack_real(p, &q->x);
    pack_real(p, &q->y);
    pack_real(p, &q->z);
    pack_real(p, &q->w);
    real n = q->x * q->x + q->y * q->y + q->z * q->z + q->w * q->w;
    if (p->reading && !(fabs(n - 1) <= 1e-12))
        pack_fail(p, "%s has the square length %g, must be 1", what, n);
}

void pack_small(Pack *p, uint8_t *x, unsigned count, const char *what)
{
    pack_u8(p, x);
    if (p->reading && *x >= count) {
        pack_fail(p, "%s = %u, must be less than %u", what, *x, count);
        *x = 0;
    }
}

void pack_index(Pack *p, uint32_t *i, uint32_t count, bool none, const char *what)
{
    pack_u32(p, i);
    if (p->reading && *i >= count && !(none && *i == UINT32_MAX))
        pack_fail(p, "%s = %u of %u", what, *i, count);
}

uint32_t pack_count(Pack *p, uint32_t count, size_t least, const char *what)
{
    pack_u32(p, &count);
    if (!p->reading)
        return count;
    if (count > INT32_MAX || (uint64_t)count * least > p->size - p->at)
        pack_fail(p, "%u %s, more than its %zu bytes can hold", count, what, p->size - p->at);
    return pack_good(p) ? count : 0;
}

/* ---- checksum ---- */

/* Four bits at a time; the polynomial reflected. A table of 16 is as fast as files need. */
uint32_t pack_crc32(const void *data, size_t size)
{
    static const uint32_t table[16] = {
        0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
        0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c,
    };
    const unsigned char *bytes = data;
    uint32_t crc = 0xffffffff;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        crc = crc >> 4 ^ table[crc & 15];
        crc = crc >> 4 ^ table[crc & 15];
    }
    return ~crc;
}
