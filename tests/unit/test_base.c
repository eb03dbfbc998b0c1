/* test_base.c - scratch memory, the hash map and sorting against models of what they should do. */
#define _DEFAULT_SOURCE         /* sysconf */
#include <stdlib.h>

#include "check.h"
#include "resident.h"

#include "base/arena.h"
#include "base/block.h"
#include "base/index.h"
#include "base/list.h"
#include "base/map.h"
#include "base/sort.h"
#include "base/text.h"
#include "math/vec.h"

/* Repeatable noise: x' = x * a + c mod 2^64 (Knuth's MMIX constants), upper half returned. */
static uint32_t noise(uint64_t *x)
{
    *x = *x * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*x >> 32);
}

/* ---- arena ---- */

TEST(pieces_are_aligned_and_do_not_overlap)
{
    Arena a = {0};
    uint64_t seed = 1;
    enum { COUNT = 2000 };
    unsigned char *piece[COUNT];
    size_t size[COUNT];
    for (int i = 0; i < COUNT; i++) {
        size[i] = noise(&seed) % 700;
        piece[i] = arena_alloc(&a, size[i]);
        CHECK(piece[i] != NULL);
        CHECK_INT((uintptr_t)piece[i] % 32, 0);
        memset(piece[i], i & 0xFF, size[i]);
    }
    for (int i = 0; i < COUNT; i++)
        for (size_t k = 0; k < size[i]; k++)
            CHECK_INT(piece[i][k], i & 0xFF);
    CHECK(arena_live(&a) <= arena_bytes(&a));
    arena_close(&a);
    CHECK_INT(arena_bytes(&a), 0);
}

TEST(zeroed_pieces_are_zero_even_in_used_memory)
{
    Arena a = {0};
    unsigned char *p = arena_alloc(&a, 1000);
    memset(p, 0x5A, 1000);
    arena_reset(&a);
    unsigned char *q = arena_zero(&a, 1000);
    CHECK(p == q);                      /* the same memory again, or the test shows nothing */
    for (int i = 0; i < 1000; i++)
        CHECK_INT(q[i], 0);
    arena_close(&a);
}

TEST(rewinding_gives_back_what_was_taken_since_the_mark_and_keeps_the_rest)
{
    Arena a = {0};
    char *outer = arena_alloc(&a, 100);
    memset(outer, 'o', 100);
    ArenaMark m = arena_mark(&a);
    void *first = arena_alloc(&a, 64);
    ArenaMark inner = arena_mark(&a);
    for (int i = 0; i < 100; i++)
        CHECK(arena_alloc(&a, 10000) != NULL);          /* many chunks */
    arena_rewind(&a, inner);
    arena_rewind(&a, m);
    CHECK_INT(arena_live(&a), 128);
    CHECK(arena_alloc(&a, 64) == first);
    for (int i = 0; i < 100; i++)
        CHECK_INT(outer[i], 'o');
    arena_close(&a);
}

TEST(spare_memory_is_used_first_and_its_pieces_do_not_overlap)
{
    Arena a = {0};
    Spare *spare = NULL;
    unsigned char *dead = arena_alloc(&a, 4096), *kept = arena_alloc(&a, 64), *more = arena_alloc(&a, 4096);
    memset(kept, 7, 64);
    spare_add(&spare, dead + 5, 4096 - 5);              /* its start need not be aligned */
    spare_add(&spare, more, 4096);
    spare_add(&spare, kept + 5, 50);                    /* too small to matter: left as it is */
    size_t live = arena_live(&a);
    unsigned char *piece[8];
    int fills = 0;
    for (int i = 0; i < 8; i++) {                       /* four fit into the one, three into the other: 3 * 1024 <= 4096 - 64 < 4 * 1024 */
        piece[i] = spare_take(&spare, &a, 1000);
        CHECK((uintptr_t)piece[i] % ARENA_ALIGN == 0);
        memset(piece[i], i + 1, 1000);
        CHECK_INT(arena_live(&a) > live, i == 7);
        CHECK_INT((piece[i] >= dead && piece[i] + 1000 <= more + 4096), i < 7);
    }
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 1000; k++)
            fills += piece[i][k] != i + 1;
    CHECK_INT(fills, 0);
    CHECK_INT(kept[0] + kept[63], 14);
    CHECK(spare_take(&spare, &a, SIZE_MAX - 8) == NULL);
    arena_close(&a);
}

TEST(spare_memory_side_by_side_is_one_piece_whatever_came_first)
{
    for (int first = 0; first < 3; first++)
        for (int second = 0; second < 3; second++) {
            if (first == second)
                continue;
            Arena a = {0};
            Spare *spare = NULL;
            unsigned char *part[3];
            for (int i = 0; i < 3; i++)
                part[i] = arena_alloc(&a, 4000);        /* 4032 with what nobody has */
            spare_add(&spare, part[first], 4000);
            spare_add(&spare, part[second], 4000);
            spare_add(&spare, part[3 - first - second], 4000);
            CHECK(spare_find(&spare, 3 * 4032 + 1) == NULL);
            CHECK(spare_find(&spare, 3 * 4032) == part[0]);
            CHECK(spare == NULL);
            arena_close(&a);
        }
}

TEST(small_spare_pieces_are_used_up_before_large_ones_and_a_piece_gives_back_what_it_does_not_need)
{
    Arena a = {0};
    Spare *spare = NULL;
    unsigned char *large = arena_alloc(&a, 8192), *other = arena_alloc(&a, 64), *small = arena_alloc(&a, 2048);
    spare_add(&spare, small, 2048);
    spare_add(&spare, large, 8192);
    for (int i = 0; i < 2; i++) {
        unsigned char *piece = spare_take(&spare, &a, 1024);
        CHECK(piece >= small && piece < small + 2048);
    }
    unsigned char *piece = spare_take(&spare, &a, 4096);
    CHECK(piece == large + 4096);
    spare_trim(&spare, &a, piece, 4096, 100);
    CHECK(spare_find(&spare, 4096 - 128) == piece + 128);
    unsigned char *last = arena_alloc(&a, 4096);
    spare_trim(&spare, &a, last, 4096, 100);
    CHECK(arena_alloc(&a, 64) == last + 128);
    CHECK(other + 64 == small);
    arena_close(&a);
}

TEST(lent_memory_is_given_in_whole_units_only)
{
    Spare *spare = NULL;
    unsigned char *lent = malloc(8192), guard = 9;
    CHECK(lent != NULL);
    memset(lent, guard, 8192);
    spare_lend(&spare, lent + 1, 8190);
    for (unsigned char *p = spare_find(&spare, 100); p; p = spare_find(&spare, 100)) {
        CHECK((uintptr_t)p % ARENA_ALIGN == 0);
        memset(p, 1, 128);
    }
    CHECK_INT(lent[0] + lent[8191], 2 * guard);
    spare = NULL;
    spare_lend(&spare, NULL, 0);
    CHECK(spare == NULL);
    free(lent);
}

TEST(after_one_reset_the_same_step_never_allocates_again)
{
    Arena a = {0};
    for (int step = 0; step < 20; step++) {
        uint64_t before = a.allocations;
        for (int i = 0; i < 1000; i++)
            CHECK(arena_alloc(&a, 999) != NULL);
        if (step > 0)
            CHECK_INT(a.allocations, before);
        arena_reset(&a);
        if (step > 0)
            CHECK_INT(a.allocations, before);
        CHECK_INT(arena_live(&a), 0);
    }
    CHECK_INT(a.high, 1000 * 1024);
    arena_close(&a);
}

TEST(a_rewound_chain_of_chunks_is_filled_again_without_the_allocator)
{
    Arena a = {0};
    ArenaMark empty = arena_mark(&a);
    for (int i = 0; i < 30; i++)
        arena_alloc(&a, 50000);
    uint64_t allocations = a.allocations;
    CHECK(allocations > 1);
    for (int pass = 0; pass < 5; pass++) {
        arena_rewind(&a, empty);
        for (int i = 0; i < 30; i++)
            CHECK(arena_alloc(&a, 50000) != NULL);
    }
    CHECK_INT(a.allocations, allocations);
    arena_close(&a);
}

/* A step begins with what the last one gave back: its first piece is taken as quickly as the others. */
TEST(once_all_is_given_back_the_first_chunk_is_at_hand)
{
    Arena a = {0};
    ArenaMark empty = arena_mark(&a);
    void *first = arena_alloc(&a, 100);
    for (int way = 0; way < 2; way++) {
        for (int i = 0; i < 20; i++)
            CHECK(arena_alloc(&a, 50000) != NULL);      /* some chunks */
        if (way == 0)
            arena_rewind(&a, empty);
        else
            arena_reset(&a);
        CHECK_INT(arena_live(&a), 0);
        if (way == 0)
            CHECK(arena_next(&a) == first);
        CHECK(a.end - a.next >= 100);
        ArenaMark again = arena_mark(&a);
        CHECK(arena_alloc(&a, 100) != NULL);
        arena_rewind(&a, again);
        CHECK_INT(arena_live(&a), 0);
    }
    arena_close(&a);
}

TEST(a_demand_beyond_all_memory_is_refused_and_changes_nothing)
{
    Arena a = {0};
    char *p = arena_alloc(&a, 10);
    size_t held = arena_bytes(&a);
    CHECK(arena_alloc(&a, SIZE_MAX) == NULL);
    CHECK(arena_alloc(&a, SIZE_MAX / 2) == NULL);
    CHECK(arena_zero(&a, SIZE_MAX - 8) == NULL);
    CHECK_INT(arena_bytes(&a), held);
    CHECK_INT(arena_live(&a), ARENA_ALIGN);
    CHECK((char *)arena_alloc(&a, 10) == p + ARENA_ALIGN);
    arena_close(&a);
}

TEST(with_dig_debug_fresh_and_given_back_memory_reads_as_nan)
{
#ifdef DIG_DEBUG
    Arena a = {0};
    ArenaMark m = arena_mark(&a);
    real *x = arena_alloc(&a, 4 * sizeof *x);
    CHECK(isnan(x[0]) && isnan(x[3]));
    x[0] = x[3] = 1;
    arena_rewind(&a, m);
    CHECK(isnan(x[0]) && isnan(x[3]));          /* the chunk is still held */
    arena_close(&a);
#else
    skip();
#endif
}

/* ---- map ---- */

enum { KEYS = 512 };

static MapKey key_at(int i)
{
    return (MapKey){(uint32_t)i % 8, (uint32_t)i / 8 % 8, (uint32_t)i / 64};
}

TEST(a_map_agrees_with_a_plain_table_over_many_random_calls)
{
    Map m = {0};
    bool there[KEYS] = {false};
    uint32_t value[KEYS] = {0};
    uint32_t count = 0;
    uint64_t seed = 7;
    for (int round = 0; round < 200000; round++) {
        int i = (int)(noise(&seed) % KEYS);
        uint32_t got = 0xABCD, fresh = noise(&seed);
        switch (noise(&seed) % 3) {
        case 0:
            CHECK_INT(map_put(&m, key_at(i), fresh), DIG_OK);
            count += !there[i];
            there[i] = true;
            value[i] = fresh;
            break;
        case 1:
            CHECK_INT(map_remove(&m, key_at(i)), there[i]);
            count -= there[i];
            there[i] = false;
            break;
        default:
            CHECK_INT(map_find(&m, key_at(i), &got), there[i]);
            CHECK_INT(got, there[i] ? value[i] : 0xABCD);
        }
        CHECK_INT(m.count, count);
    }
    for (int i = 0; i < KEYS; i++) {
        uint32_t got = 0;
        CHECK_INT(map_find(&m, key_at(i), &got), there[i]);
        CHECK_INT(got, there[i] ? value[i] : 0);
    }
    map_close(&m);
}

TEST(nothing_is_allocated_within_the_reserve)
{
    Map m = {0};
    CHECK_INT(map_reserve(&m, 1000), DIG_OK);
    size_t bytes = map_bytes(&m);
    for (int round = 0; round < 100; round++) {
        for (uint32_t i = 0; i < 1000; i++)
            CHECK_INT(map_put(&m, (MapKey){i, (uint32_t)round, 0}, i), DIG_OK);
        CHECK_INT(m.count, 1000);
        for (uint32_t i = 0; i < 1000; i++)
            CHECK(map_remove(&m, (MapKey){i, (uint32_t)round, 0}));
    }
    CHECK_INT(m.allocations, 1);
    CHECK_INT(map_bytes(&m), bytes);
    CHECK_INT(m.count, 0);
    for (uint32_t i = 0; i < m.size; i++)               /* nothing rots: the table is as empty as a new one */
        CHECK_INT(m.entries[i].hash, 0);
    map_close(&m);
}

/* Mean number of places looked at is 1/2 (1 + 1/(1-load)) for linear probing with good hashing (Knuth 6.4, theorem K);
 * at the largest load of 2/3 that is 2. Regular keys must not do worse than twice that. */
TEST(regular_keys_stay_near_their_home)
{
    Map m = {0};
    for (uint32_t i = 0; i < 300; i++)
        for (uint32_t j = 0; j < 145; j++)
            CHECK_INT(map_put(&m, (MapKey){i, j, 0}, 1), DIG_OK);
    double places = 0;
    for (uint32_t i = 0; i < m.size; i++)
        if (m.entries[i].hash)
            places += 1 + ((i - m.entries[i].hash) & (m.size - 1));
    double load = (double)m.count / m.size, mean = places / m.count;
    CHECK(load > 0.6);
    CHECK_NEAR(mean, 0.5 * (1 + 1 / (1 - load)), 0.5);
    map_close(&m);
}

TEST(a_copy_is_the_same_table_and_lives_on_its_own)
{
    Map m = {0}, copy = {0};
    for (uint32_t i = 0; i < 100; i++)
        map_put(&m, map_key((uint64_t)i << 30), i);
    CHECK_INT(map_copy(&copy, &m), DIG_OK);
    CHECK_INT(copy.size, m.size);
    CHECK_INT(memcmp(copy.entries, m.entries, m.size * sizeof *m.entries), 0);
    map_remove(&m, map_key((uint64_t)5 << 30));
    uint32_t value = 0;
    CHECK(map_find(&copy, map_key((uint64_t)5 << 30), &value));
    CHECK_INT(value, 5);
    uint64_t allocations = copy.allocations;
    CHECK_INT(map_copy(&copy, &m), DIG_OK);             /* same size: memory is used again */
    CHECK_INT(copy.allocations, allocations);
    CHECK(!map_find(&copy, map_key((uint64_t)5 << 30), NULL));
    Map empty = {0};
    CHECK_INT(map_copy(&copy, &empty), DIG_OK);
    CHECK(!map_find(&copy, map_key((uint64_t)6 << 30), NULL));
    CHECK_INT(map_bytes(&copy), 0);
    map_close(&copy);
    map_close(&m);
}

TEST(an_impossible_reserve_is_refused)
{
    Map m = {0};
    CHECK_INT(map_reserve(&m, -1), DIG_E_ARG);
    CHECK_INT(map_reserve(&m, INT32_MAX), DIG_E_ARG);
    CHECK_INT(map_bytes(&m), 0);
    CHECK(!map_remove(&m, map_key(1)));
}

/* ---- sorting ---- */

static void check_sorted(uint32_t *list, int count, Arena *a)
{
    uint64_t sum = 0, mixed = 0, after = 0, mixed_after = 0;
    for (int i = 0; i < count; i++) {
        sum += list[i];
        mixed ^= list[i] * 0x9E3779B97F4A7C15u;
    }
    CHECK_INT(sort_u32(list, count, a), DIG_OK);
    for (int i = 0; i < count; i++) {
        CHECK(i == 0 || list[i - 1] <= list[i]);
        after += list[i];
        mixed_after ^= list[i] * 0x9E3779B97F4A7C15u;
    }
    CHECK(sum == after && mixed == mixed_after);        /* the same numbers */
    CHECK_INT(arena_live(a), 0);
}

TEST(numbers_of_any_size_and_count_come_out_ascending)
{
    enum { MOST = 5000 };
    static const int counts[] = {0, 1, 2, 3, 47, 48, 49, 300, MOST};
    static const uint32_t masks[] = {0, 1, 0xFF, 0xFFFF, 0xFF00FF00, UINT32_MAX};
    uint32_t list[MOST];
    Arena a = {0};
    uint64_t seed = 7;
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (size_t m = 0; m < sizeof masks / sizeof *masks; m++) {
            for (int i = 0; i < counts[c]; i++)
                list[i] = noise(&seed) & masks[m];
            check_sorted(list, counts[c], &a);
            for (int i = 0; i < counts[c]; i++)
                list[i] = (uint32_t)(counts[c] - i) << 4;       /* descending */
            check_sorted(list, counts[c], &a);
        }
    arena_close(&a);
}

/* ---- lists ---- */

TEST(a_trimmed_list_keeps_what_it_holds_and_little_more)
{
    LIST(int) list = {NULL, 0, 0};
    uint64_t allocations = 0;
    CHECK_INT(list_reserve(&list, 1000, &allocations), DIG_OK);
    for (int i = 0; i < 10; i++) {
        CHECK_INT(list_push(&list, &allocations), DIG_OK);
        list.data[i] = i;
    }
    CHECK_INT(allocations, 1);
    list_trim(&list, 2000);             /* it has no more than 1000 */
    CHECK_INT(list.capacity, 1000);
    list_trim(&list, 100);
    CHECK_INT(list.capacity, 100);
    list_trim(&list, 3);                /* but holds 10 */
    CHECK_INT(list.capacity, 10);
    for (int i = 0; i < 10; i++)
        CHECK_INT(list.data[i], i);
    list_close(&list);
}

/* Back and forth across the size from which blocks are the system's pages. */
TEST(a_list_of_any_size_keeps_its_items_and_what_is_new_is_zero)
{
    const int large = (int)(BLOCK_LARGE / sizeof(uint32_t));
    const int room[] = {100, large - 1, large, 5 * large, 3 * large + 7, 4 * large, large - 1, 10, large + 1, 2 * large};
    LIST(uint32_t) list = {NULL, 0, 0};
    for (int r = 0; r < (int)(sizeof room / sizeof *room); r++) {
        list.count = 10;
        list_trim(&list, room[r]);
        CHECK_INT(list_reserve(&list, room[r], NULL), DIG_OK);
        CHECK(list.capacity >= room[r]);
        bool kept = true, zero = true;
        for (int i = 0; i < list.capacity; i++) {
            if (r > 0 && i < 10)
                kept = kept && list.data[i] == 7u * (uint32_t)i;
            else if (r > 0 && i >= room[r - 1])
                zero = zero && list.data[i] == 0;
        }
        CHECK(kept && zero);
        for (int i = 0; i < list.capacity; i++)
            list.data[i] = 7u * (uint32_t)i;
        list_trim(&list, room[r]);
    }
    list_close(&list);
    CHECK(!list.data && list.capacity == 0);
}

TEST(a_shrunk_piece_makes_room_for_the_next_one)
{
    Arena a = {0};
    char *first = arena_alloc(&a, 100), *piece = arena_alloc(&a, 10000);
    size_t live = arena_live(&a);
    memset(first, 1, 100);
    memset(piece, 2, 10000);
    arena_shrink(&a, piece, 90);
    CHECK(arena_live(&a) < live - 9000);
    CHECK(arena_alloc(&a, 50) == piece + 2 * ARENA_ALIGN);
    CHECK_INT(first[99], 1);
    CHECK_INT(piece[89], 2);
    arena_close(&a);
}

TEST(what_is_not_needed_for_long_is_given_back)
{
    Arena a = {0};
    CHECK(arena_alloc(&a, 10000000) != NULL);
    for (int i = 0; i < 300; i++) {
        arena_reset(&a);
        CHECK(arena_bytes(&a) >= 10000000 || i > 100);
        CHECK(arena_alloc(&a, 1000000) != NULL);
    }
    CHECK(arena_bytes(&a) < 1200000);
    uint64_t allocations = a.allocations;
    for (int i = 0; i < 300; i++) {
        arena_reset(&a);
        CHECK(arena_alloc(&a, 1000000) != NULL);
    }
    CHECK_INT(a.allocations, allocations);
    arena_close(&a);
}

TEST(what_is_forgotten_of_a_block_takes_no_memory_until_it_is_written_to)
{
    const size_t size = (size_t)4 << 20, from = 1000, part = (size_t)2 << 20;
    unsigned char *block = block_open(size);
    CHECK(block != NULL);
    memset(block, 1, size);
    block_forget(block + from, part);
    CHECK_INT(resident_pages(block + from, part), 0);
    CHECK(block[from - 1] == 1 && block[from + part] == 1 && block[size - 1] == 1);
    memset(block + from, 2, part);
    CHECK(block[from - 1] == 1 && block[from] == 2 && block[from + part - 1] == 2 && block[from + part] == 1);
    block_free(block, size);
}

TEST(pages_that_a_few_steps_have_not_needed_are_given_back_without_the_allocator)
{
    const size_t most = (size_t)20 << 20, now = (size_t)18 << 20, enough = (size_t)19 << 20;
    Arena a = {0};
    memset(arena_alloc(&a, most), 1, most);
    arena_reset(&a);
    uint64_t allocations = a.allocations;
    for (int i = 0; i < 40; i++) {
        memset(arena_alloc(&a, now), 1, now);
        arena_reset(&a);
    }
    CHECK_INT(a.allocations, allocations);
    CHECK_INT(resident_pages(a.first->data + enough, most - enough), 0);
    memset(arena_alloc(&a, most), 1, most);
    CHECK_INT(a.allocations, allocations);
    arena_close(&a);
}

TEST(the_rest_of_a_full_chunk_takes_no_memory)
{
    const size_t first = (size_t)9 << 20, kept = (size_t)5 << 20, large = (size_t)8 << 20;
    Arena a = {0};
    memset(arena_alloc(&a, first), 1, first);
    arena_reset(&a);
    unsigned char *piece = arena_alloc(&a, kept);
    memset(piece, 2, kept);
    CHECK(arena_alloc(&a, large) != NULL && a.first->next != NULL);
    CHECK_INT(resident_pages(piece + kept, first - kept), 0);
    CHECK(piece[0] == 2 && piece[kept - 1] == 2);
    arena_close(&a);
}

#define RECORDS 3000

static bool is_record(const void *records, uint32_t record, MapKey key)
{
    const MapKey *k = (const MapKey *)records + record;
    return k->a == key.a && k->b == key.b && k->c == key.c;
}

/* Records are put in, half taken out, and the rest moved up. */
TEST(an_index_finds_records_by_their_keys_and_follows_when_they_move)
{
    static MapKey key[RECORDS];
    static uint32_t to[RECORDS];
    Index x = {0}, copy = {0};
    uint32_t found, n = 0;
    for (uint32_t i = 0; i < RECORDS; i++) {
        key[i] = (MapKey){i / 50, i % 50, i % 3};
        CHECK(!index_find(&x, key[i], is_record, key, &found));
        CHECK_INT(index_add(&x, key[i], i), DIG_OK);
    }
    for (uint32_t i = 0; i < RECORDS; i++)
        CHECK(index_find(&x, key[i], is_record, key, &found) && found == i);
    CHECK_INT(index_copy(&copy, &x), DIG_OK);
    size_t bytes = index_bytes(&x);
    for (uint32_t i = 0; i < RECORDS; i++) {
        if (i % 4 > 0)
            index_remove(&x, key[i], i);
        to[i] = i % 4 == 0 ? n++ : UINT32_MAX;
    }
    CHECK_INT(x.count, n);
    for (uint32_t i = 0; i < RECORDS; i++)
        CHECK_INT(index_find(&x, key[i], is_record, key, &found), i % 4 == 0);
    Arena scratch = {0};
    index_renumber(&x, to, &scratch);
    arena_close(&scratch);
    for (uint32_t i = 0; i < RECORDS; i += 4)
        key[to[i]] = key[i];
    for (uint32_t i = 0; i < n; i++)
        CHECK(index_find(&x, key[i], is_record, key, &found) && found == i);
    CHECK(index_bytes(&x) < bytes);
    CHECK_INT(copy.count, RECORDS);
    index_close(&x);
    index_close(&copy);
}

/* ---- text ---- */

/* The bytes of a character as RFC 3629 writes them; 0 for those that are none. */
static size_t encode(uint32_t c, char out[5])
{
    size_t n = c < 0x80 ? 1 : c < 0x800 ? 2 : c < 0x10000 ? 3 : 4;
    memset(out, 0, 5);
    out[0] = (char)(n == 1 ? c : (0xf0u << (4 - n)) | c >> 6 * (n - 1));
    for (size_t i = 1; i < n; i++)
        out[i] = (char)(0x80u | (c >> 6 * (n - 1 - i) & 0x3fu));
    return n;
}

TEST(every_character_is_known_and_nothing_else_is_one)
{
    char text[5];
    size_t n;
    for (uint32_t c = 0; c < 0x120000; c++) {
        size_t length = encode(c, text);
        bool none = (c >= 0xd800 && c < 0xe000) || c > 0x10ffff, control = c < 0x20 || (c >= 0x7f && c < 0xa0);
        TextKind kind = text_next(text, length, &n);
        if (kind != (none ? TEXT_BROKEN : control ? TEXT_CONTROL : TEXT_PLAIN) || n != (none ? 1 : length))
            fail_msg("U+%04X: kind %d, %zu bytes", (unsigned)c, (int)kind, n);
        for (size_t cut = 1; cut < length; cut++)
            CHECK(text_next(text, cut, &n) == TEXT_BROKEN && n == 1);
    }
    /* longer than need be: a NUL, a slash, an escape */
    static const char *const broken[] = {"\xc0\x80", "\xe0\x80\xaf", "\xf0\x80\x80\x9b", "\x80", "\xff", "\xf8\x88\x80\x80\x80", "\xc3("};
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++)
        CHECK(text_next(broken[i], strlen(broken[i]), &n) == TEXT_BROKEN && n == 1);
}

TEST(names_are_text_and_messages_are_cleaned)
{
    CHECK(text_fault("") == NULL && text_fault("a b, \u20ac \U0001f600") == NULL);
    CHECK_TEXT(text_fault("a\nb"), "holds a control character");
    CHECK_TEXT(text_fault("\xc2\x9b" "31m"), "holds a control character");
    CHECK_TEXT(text_fault("caf\xe9"), "is not UTF-8");
    char text[] = "\033[2J caf\xc3\xa9 caf\xe9 \xc2\x9b" "31m\x7f";
    text_clean(text);
    CHECK_TEXT(text, "?[2J caf\xc3\xa9 caf? ??31m?");
}

/* ---- vectors ---- */

/* Told by bits; the reference are comparisons. */
TEST(a_vector_is_zero_when_each_of_its_numbers_is)
{
    const real some[] = {0, -0.0, 5e-324, -5e-324, 1, -1, INFINITY, -INFINITY, NAN, -NAN};
    const int count = (int)(sizeof some / sizeof *some);
    for (int i = 0; i < count; i++)
        for (int j = 0; j < count; j++)
            for (int k = 0; k < count; k++)
                CHECK_INT(vec3_is_zero((vec3){some[i], some[j], some[k]}), some[i] == 0 && some[j] == 0 && some[k] == 0);
}

int main(void)
{
    RUN_TESTS(
        unit_test(pieces_are_aligned_and_do_not_overlap),
        unit_test(zeroed_pieces_are_zero_even_in_used_memory),
        unit_test(rewinding_gives_back_what_was_taken_since_the_mark_and_keeps_the_rest),
        unit_test(spare_memory_is_used_first_and_its_pieces_do_not_overlap),
        unit_test(spare_memory_side_by_side_is_one_piece_whatever_came_first),
        unit_test(small_spare_pieces_are_used_up_before_large_ones_and_a_piece_gives_back_what_it_does_not_need),
        unit_test(lent_memory_is_given_in_whole_units_only),
        unit_test(after_one_reset_the_same_step_never_allocates_again),
        unit_test(a_rewound_chain_of_chunks_is_filled_again_without_the_allocator),
        unit_test(a_demand_beyond_all_memory_is_refused_and_changes_nothing),
        unit_test(with_dig_debug_fresh_and_given_back_memory_reads_as_nan),
        unit_test(a_shrunk_piece_makes_room_for_the_next_one),
        unit_test(what_is_not_needed_for_long_is_given_back),
        unit_test(what_is_forgotten_of_a_block_takes_no_memory_until_it_is_written_to),
        unit_test(pages_that_a_few_steps_have_not_needed_are_given_back_without_the_allocator),
        unit_test(the_rest_of_a_full_chunk_takes_no_memory),
        unit_test(an_index_finds_records_by_their_keys_and_follows_when_they_move),
        unit_test(a_map_agrees_with_a_plain_table_over_many_random_calls),
        unit_test(nothing_is_allocated_within_the_reserve),
        unit_test(regular_keys_stay_near_their_home),
        unit_test(a_copy_is_the_same_table_and_lives_on_its_own),
        unit_test(an_impossible_reserve_is_refused),
        unit_test(numbers_of_any_size_and_count_come_out_ascending),
        unit_test(a_trimmed_list_keeps_what_it_holds_and_little_more),
        unit_test(a_list_of_any_size_keeps_its_items_and_what_is_new_is_zero),
        unit_test(every_character_is_known_and_nothing_else_is_one),
        unit_test(names_are_text_and_messages_are_cleaned),
        unit_test(once_all_is_given_back_the_first_chunk_is_at_hand),
        unit_test(a_vector_is_zero_when_each_of_its_numbers_is)
    );
}
