/* test_tell.c - collision messages of steps with more of them than the log holds. */
#include "physics_fixture.h"

#include <stdlib.h>

enum { N = 70, KEPT = 4096 };

static void join(dig_world *w, dig_body a, dig_body b, vec3 at)
{
    const dig_schema *type = dig_schema_find("joint", "ball");
    void *data = calloc(1, type->size);
    CHECK(data != NULL);
    dig_schema_defaults(type, data);
    dig_joint_def def = dig_joint_defaults();
    dig_joint joint;
    def.type = "ball";
    def.a = a;
    def.b = b;
    def.at = at;
    def.data = data;
    CHECK_INT(dig_joint_create(w, &def, &joint), DIG_OK);
    free(data);
}

/* N balls in a chain, each struck by a ball of its own in the first step: N strikes tell N members and one striker each. */
static dig_world *struck_chain(dig_body target[N], dig_body striker[N])
{
    dig_world *w = open_world(1.0 / 60, "sketch", false);
    for (int i = 0; i < N; i++) {
        target[i] = add_ball(w, look(0, 0.5), 0.3, 1, (vec3){2.0 * i, 0, 0}, vec3_zero());
        striker[i] = add_ball(w, look(0, 0.5), 0.3, 1, (vec3){2.0 * i, 1, 0}, (vec3){0, -30, 0});
        if (i > 0)
            join(w, target[i - 1], target[i], (vec3){2.0 * i - 1, 0, 0});
    }
    step(w, 1);
    return w;
}

TEST(every_member_remembers_the_last_strike_and_the_log_the_last_4096)
{
    static dig_message messages[KEPT];
    dig_body target[N], striker[N];
    dig_world *w = struck_chain(target, striker);
    CHECK_INT(dig_messages(w, messages, KEPT), KEPT);
    uint64_t last = 0;
    for (int i = 0; i < KEPT; i++) {
        const dig_message *m = &messages[i];
        CHECK(i == 0 || m->time > messages[i - 1].time || (m->time == messages[i - 1].time && m->id > messages[i - 1].id));
        CHECK_TEXT(m->kind, "collision");
        CHECK_NEAR(m->value[0], 30, 1e-6);
        last = m->id > last ? m->id : last;
    }
    CHECK_INT(last, N * N + N);
    dig_body_debug first, debug;
    CHECK_INT(dig_body_inspect(w, target[0], &first), DIG_OK);
    for (int i = 0; i < N; i++) {
        CHECK_INT(dig_body_inspect(w, target[i], &debug), DIG_OK);
        CHECK_TEXT(debug.mess_type, "collision");
        CHECK_INT(debug.origin.slot, first.origin.slot);            /* all heard of the same last one */
        CHECK(debug.m_id > N * (N - 1) && debug.m_id <= N * N + N);
        for (int k = 0; k < KEPT; k++)
            if (messages[k].id == debug.m_id) {
                CHECK_INT(messages[k].to.slot, target[i].slot);
                CHECK_NEAR(messages[k].time, debug.mess_time, 0);
            }
        CHECK_INT(dig_body_inspect(w, striker[i], &debug), DIG_OK);
        CHECK_INT(debug.origin.slot, target[i].slot);
    }
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(every_member_remembers_the_last_strike_and_the_log_the_last_4096));
}
