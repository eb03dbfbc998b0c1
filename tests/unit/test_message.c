/* test_message.c - the message log: one order, one counter, a fixed size. */
#include "check.h"

#include <stdlib.h>

#include "world/message.h"

static MessageLog *log_new(void)
{
    MessageLog *log = malloc(sizeof *log);
    CHECK(log != NULL);
    memset(log, 0xA5, sizeof *log);             /* message_open must not rely on clean memory */
    message_open(log);
    return log;
}

static dig_message at_time(real time)
{
    dig_message m = {.time = time, .from = {1, 2}, .to = {3, 4}, .kind = "touch", .value = {time, 0, 0, 0}};
    return m;
}

TEST(ids_count_up_from_one_and_what_was_sent_is_kept)
{
    MessageLog *log = log_new();
    CHECK_INT(message_count(log), 0);
    CHECK(message_at(log, 0) == NULL);
    dig_message m = {.id = 99, .time = 0.5, .from = {7, 1}, .to = {8, 2}, .kind = "impact", .value = {1, 2, 3, 4},
                     .direction = {0, -1, 0}};
    CHECK_INT(message_post(log, &m), 1);
    CHECK_INT(message_post(log, &m), 2);
    const dig_message *got = message_at(log, 1);
    CHECK_INT(got->id, 2);
    CHECK_NEAR(got->time, 0.5, 0);
    CHECK_INT(got->from.slot, 7);
    CHECK_INT(got->to.gen, 2);
    CHECK_TEXT(got->kind, "impact");
    CHECK_NEAR(got->value[3], 4, 0);
    CHECK_NEAR(got->direction.y, -1, 0);
    CHECK(message_find(log, 1) == message_at(log, 0));
    CHECK(message_find(log, 3) == NULL);
    free(log);
}

TEST(the_log_is_ordered_by_time_then_id_whatever_the_order_of_posting)
{
    MessageLog *log = log_new();
    uint32_t x = 12345;
    for (int i = 0; i < 20000; i++) {
        x = x * 1664525u + 1013904223u;                         /* Numerical Recipes LCG */
        dig_message m = at_time(i / 100 + (int)(x >> 29));     /* many equal times, up to 8 s out of order */
        message_post(log, &m);
        for (int k = message_count(log) - 1; k > 0 && k > message_count(log) - 900; k -= 7) {
            const dig_message *a = message_at(log, k - 1), *b = message_at(log, k);
            CHECK(a->time < b->time || (a->time == b->time && a->id < b->id));
        }
    }
    CHECK_INT(message_count(log), MESSAGE_KEPT);
    for (int k = 1; k < message_count(log); k++) {
        const dig_message *a = message_at(log, k - 1), *b = message_at(log, k);
        CHECK(a->time < b->time || (a->time == b->time && a->id < b->id));
    }
    free(log);
}

TEST(the_last_4096_are_kept_and_the_counter_goes_on)
{
    MessageLog *log = log_new();
    for (int i = 1; i <= 10000; i++) {
        dig_message m = at_time(i * 0.01);
        CHECK_INT(message_post(log, &m), i);
    }
    CHECK_INT(message_count(log), 4096);
    CHECK_INT(message_at(log, 0)->id, 10000 - 4096 + 1);
    CHECK_INT(message_at(log, 4095)->id, 10000);
    CHECK(message_at(log, 4096) == NULL);
    dig_message late = at_time(0.001);                          /* older than all: numbered, not kept */
    CHECK_INT(message_post(log, &late), 10001);
    CHECK(message_find(log, 10001) == NULL);
    CHECK_INT(message_at(log, 0)->id, 10000 - 4096 + 1);
    dig_message *out = calloc(5000, sizeof *out);
    CHECK_INT(message_list(log, out, 5000), 4096);
    CHECK_INT(out[4095].id, 10000);
    CHECK_INT(out[4096].id, 0);
    out[10].id = 1;
    CHECK_INT(message_list(log, out, 10), 4096);
    CHECK_INT(out[0].id, 5905);
    CHECK_INT(out[10].id, 1);                                   /* not written beyond the capacity */
    free(out);
    free(log);
}

TEST(a_long_kind_is_cut_and_zero_terminated)
{
    MessageLog *log = log_new();
    dig_message m = at_time(1);
    memset(m.kind, 'k', sizeof m.kind);
    message_post(log, &m);
    CHECK_INT(strlen(message_at(log, 0)->kind), 31);
    free(log);
}

TEST(numbers_that_are_not_finite_are_refused)
{
    MessageLog *log = log_new();
    dig_message m = at_time(NAN);
    CHECK_INT(message_post(log, &m), 0);
    m = at_time(1);
    m.value[2] = INFINITY;
    CHECK_INT(message_post(log, &m), 0);
    m = at_time(1);
    m.direction.z = NAN;
    CHECK_INT(message_post(log, &m), 0);
    CHECK_INT(message_count(log), 0);
    CHECK_INT(log->last_id, 0);
    free(log);
}

TEST(a_copy_is_the_same_log_and_bytes_do_not_depend_on_the_sender)
{
    MessageLog *log = log_new(), *other = log_new();
    for (int i = 0; i < 5000; i++) {
        dig_message clean, dirty;
        memset(&clean, 0x00, sizeof clean);
        memset(&dirty, 0xFF, sizeof dirty);                     /* padding and the rest of kind differ */
        clean.time = dirty.time = i;
        clean.root = dirty.root = 0;
        clean.from = dirty.from = clean.to = dirty.to = (dig_body){(uint32_t)i, 1};
        strcpy(clean.kind, "same");
        strcpy(dirty.kind, "same");
        for (int k = 0; k < 4; k++)
            clean.value[k] = dirty.value[k] = k;
        clean.direction = dirty.direction = (vec3){1, 2, 3};
        message_post(log, &clean);
        message_post(other, &dirty);
    }
    CHECK_INT(memcmp(log, other, sizeof *log), 0);
    *other = *log;                                              /* the snapshot */
    uint64_t before = message_hash(log);
    dig_message m = at_time(6000);
    message_post(log, &m);
    CHECK(message_hash(log) != before);
    CHECK(message_hash(other) == before);
    *log = *other;
    CHECK_INT(message_post(log, &m), 5001);                     /* the counter came back with it */
    free(other);
    free(log);
}

TEST(many_messages_at_once_leave_the_log_that_one_by_one_would)
{
    MessageLog *one = log_new(), *many = log_new();
    uint32_t x = 99;
    for (int round = 0; round < 40; round++) {
        x = x * 1664525u + 1013904223u;
        int count = 1 + (int)(x >> 22);                         /* up to 1024 of one time */
        dig_message m = at_time(round + (int)(x >> 30));
        m.id = message_ids(many, (uint64_t)count);
        for (int i = 0; i < count; i++, m.id++) {
            message_keep(many, &m);
            CHECK_INT(message_post(one, &m), m.id);
        }
    }
    dig_message bad = at_time(NAN);
    bad.id = message_ids(many, 1);
    message_keep(many, &bad);
    message_ids(one, 1);
    CHECK_INT(message_count(one), 4096);
    CHECK(message_hash(one) == message_hash(many));
    free(one);
    free(many);
}

int main(void)
{
    RUN_TESTS(
        unit_test(ids_count_up_from_one_and_what_was_sent_is_kept),
        unit_test(the_log_is_ordered_by_time_then_id_whatever_the_order_of_posting),
        unit_test(the_last_4096_are_kept_and_the_counter_goes_on),
        unit_test(a_long_kind_is_cut_and_zero_terminated),
        unit_test(numbers_that_are_not_finite_are_refused),
        unit_test(a_copy_is_the_same_log_and_bytes_do_not_depend_on_the_sender),
        unit_test(many_messages_at_once_leave_the_log_that_one_by_one_would)
    );
}
