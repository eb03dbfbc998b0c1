/* tests/fuzz/target_save.c - any bytes as a saved world (a .dig file), with its checksums made good so that what is inside is judged.
 *
 * What must hold: refused with a sentence, or a sound world that goes on for some steps, stays sound, and saved again is the world
 * that it then is. engine/api/save.h has the bytes.
 */
#include "state.h"

#include <stdlib.h>
#include <string.h>

#include "base/pack.h"

enum { HEADER_AT = 12, COUNT_AT = 40, TABLE_AT = 44, ENTRY = 24, STEPS = 3, BODIES = 64 };

static uint32_t u32_at(const unsigned char *p) { return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24; }

static void put_u32(unsigned char *p, uint32_t x)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(x >> 8 * i);
}

/* As one who wants to do damage would. */
static void mend_checksums(unsigned char *data, size_t size)
{
    if (size < TABLE_AT)
        return;
    uint32_t count = u32_at(data + COUNT_AT), header = u32_at(data + HEADER_AT);
    for (uint32_t i = 0; i < count && TABLE_AT + (size_t)(i + 1) * ENTRY <= size; i++) {
        unsigned char *e = data + TABLE_AT + (size_t)i * ENTRY;
        uint32_t offset = u32_at(e + 8), bytes = u32_at(e + 16);
        if (offset <= size && bytes <= size - offset)
            put_u32(e + 4, pack_crc32(data + offset, bytes));
    }
    if (header >= 4 && header <= size)
        put_u32(data + header - 4, pack_crc32(data, header - 4));
}

static void save_seeds(FuzzGive *give, void *context)
{
    for (int i = 0; fuzz_rooms[i]; i++) {
        FuzzState *f = fuzz_open("fuzz.lua", 100000000);
        void *bytes = NULL;
        size_t size = 0;
        if (fuzz_run(f, fuzz_rooms[i], strlen(fuzz_rooms[i])) != EXIT_FINE)
            fuzz_fail("room %d: %s", i, lua_tostring(fuzz_lua(f), -1));
        if (dig_world_pack(fuzz_world(f), &bytes, &size) != DIG_OK)
            fuzz_fail("room %d: %s", i, dig_error(fuzz_world(f)));
        give(context, bytes, size);
        free(bytes);
        fuzz_close(f);
    }
}

/* It goes on; a step that the world refuses is undone. */
static void go_on(dig_world *w)
{
    for (int i = 0; i < STEPS && dig_world_stats(w).bodies <= BODIES; i++) {
        dig_world_step(w);
        if (dig_world_check(w) != DIG_OK)
            fuzz_fail("after step %d: %s", i + 1, dig_error(w));
    }
}

static void save_again(dig_world *w)
{
    char why[600] = "";
    void *bytes = NULL;
    size_t size = 0;
    dig_world *copy = NULL;
    if (dig_world_pack(w, &bytes, &size) != DIG_OK)
        fuzz_fail("packing: %s", dig_error(w));
    if (dig_world_unpack(bytes, size, &copy, why, sizeof why) != DIG_OK)
        fuzz_fail("what was packed is refused: %s", why);
    if (dig_world_checksum(copy) != dig_world_checksum(w))
        fuzz_fail("what was packed is another world");
    dig_world_close(copy);
    free(bytes);
}

static void save_run(const unsigned char *data, size_t size)
{
    char why[600] = "";
    dig_world *w = NULL;
    unsigned char *copy = malloc(size + 1);
    if (!copy)
        fuzz_fail("no memory");
    memcpy(copy, data, size);
    mend_checksums(copy, size);
    dig_status s = dig_world_unpack(copy, size, &w, why, sizeof why);
    free(copy);
    if (s != DIG_OK && (w || !why[0]))
        fuzz_fail("refused without a sentence, or with a world");
    if (s != DIG_OK)
        return;
    if (dig_world_check(w) != DIG_OK)
        fuzz_fail("loaded: %s", dig_error(w));
    save_again(w);
    go_on(w);
    save_again(w);
    dig_world_close(w);
}

const FuzzTarget fuzz_save = {.name = "save", .longest = 1 << 16, .seeds = save_seeds, .run = save_run};
