/* test_graph.c - identity of DIGs, batches, links, memory: small cases worked out by hand. The properties against brute force are
 * in test_graph_random.c, the costs in test_graph_cost.c. */
#include "graph_fixture.h"

/* ---- identity ---- */

TEST(the_larger_keeps_its_id_and_a_tie_goes_to_the_lower_id)
{
    Graph *g = graph_with(6);           /* ids 1..6 */
    join(g, 4, 1);
    CHANGES(g, {GRAPH_MERGED, 2, 5});   /* tie */
    join(g, 0, 4);
    CHANGES(g, {GRAPH_MERGED, 2, 1});   /* two against one, although 1 is lower */
    join(g, 3, 2);
    join(g, 5, 3);
    CHECK_INT(graph_of(g, 5), 3);
    join(g, 5, 1);
    CHANGES(g, {GRAPH_MERGED, 2, 3});   /* three against three */
    CHECK_INT(graph_size(g, 2), 6);
    CHECK_INT(graph_size(g, 3), 0);
    CHECK_INT(graph_count(g), 1);
    graph_close(g);
}

TEST(of_several_that_merge_at_once_the_largest_before_keeps_its_id)
{
    Graph *g = graph_with(7);
    join(g, 4, 5);
    join(g, 5, 6);                      /* id 5: three nodes */
    join(g, 0, 1);                      /* id 1: two         */
    join(g, 2, 3);                      /* id 3: two         */
    graph_begin(g);
    join(g, 1, 2);                      /* 1 and 3 make four, more than three */
    join(g, 3, 4);
    CHECK_INT(graph_end(g), DIG_OK);
    CHANGES(g, {GRAPH_MERGED, 5, 1}, {GRAPH_MERGED, 5, 3});
    graph_close(g);
}

TEST(the_largest_part_keeps_its_id_and_a_tie_goes_to_the_lowest_slot)
{
    Graph *g = graph_with(8);
    uint32_t link[8];
    for (uint32_t i = 0; i < 7; i++)
        link[i] = join(g, i, i + 1);    /* id 1, from 0 to 7 */
    graph_link_remove(g, link[2]);      /* 0..2 and 3..7 */
    CHANGES(g, {GRAPH_SPLIT, 1, 9});
    CHECK_INT(graph_of(g, 7), 1);
    CHECK_INT(graph_of(g, 0), 9);
    graph_link_remove(g, link[6]);      /* 3..6 and 7 */
    CHECK_INT(graph_of(g, 7), 10);
    graph_link_remove(g, link[4]);      /* 3,4 and 5,6: tie */
    CHECK_INT(graph_of(g, 4), 1);
    CHECK_INT(graph_of(g, 5), 11);
    CHECK(graph_check(g));
    graph_close(g);
}

TEST(of_three_parts_the_largest_keeps_whatever_the_order_of_removal)
{
    for (int order = 0; order < 2; order++) {
        Graph *g = graph_with(9);
        uint32_t link[8];
        for (uint32_t i = 0; i < 8; i++)
            link[i] = join(g, i, i + 1);
        graph_begin(g);                 /* 0..1, 2..4, 5..8 */
        graph_link_remove(g, link[order ? 4 : 1]);
        graph_link_remove(g, link[order ? 1 : 4]);
        CHECK_INT(graph_end(g), DIG_OK);
        CHANGES(g, {GRAPH_SPLIT, 1, 10}, {GRAPH_SPLIT, 1, 11});
        CHECK_INT(graph_of(g, 5), 1);
        CHECK(graph_of(g, 0) != graph_of(g, 2));
        graph_close(g);
    }
}

TEST(the_users_number_stays_with_the_id_and_goes_to_new_parts)
{
    Graph *g = graph_with(5);
    for (uint32_t id = 1; id <= 5; id++)
        graph_set_user(g, id, id * 100);
    join(g, 3, 4);
    uint32_t bridge = join(g, 3, 0);
    CHECK_INT(graph_of(g, 0), 4);
    CHECK_INT(graph_user(g, 4), 400);
    CHECK_INT(graph_user(g, 1), 0);     /* gone */
    graph_link_remove(g, bridge);
    CHECK_INT(graph_user(g, 4), 400);
    CHECK_INT(graph_user(g, graph_of(g, 0)), 400);
    CHECK_INT(graph_user(g, 2), 200);
    graph_close(g);
}

/* ---- batches ---- */

TEST(a_link_replaced_in_one_batch_is_no_change)
{
    Graph *g = graph_with(4);
    uint32_t link = join(g, 0, 1);
    join(g, 2, 3);
    graph_begin(g);
    graph_link_remove(g, link);         /* first removed, then added: the order in the batch does not count */
    join(g, 1, 0);
    CHECK_INT(graph_of(g, 1), 1);
    CHECK_INT(graph_end(g), DIG_OK);
    NO_CHANGES(g);
    CHECK_INT(graph_of(g, 1), 1);
    CHECK(graph_link(g, link) == NULL);
    CHECK(graph_check(g));
    graph_close(g);
}

TEST(until_the_end_of_the_batch_the_graph_reads_as_before)
{
    Graph *g = graph_with(4);
    uint32_t old = join(g, 0, 1);
    graph_begin(g);
    uint32_t fresh = join(g, 2, 3);
    graph_link_remove(g, old);
    CHECK_INT(graph_of(g, 3), 4);
    CHECK_INT(graph_of(g, 1), 1);
    CHECK_INT(graph_link_first(g, 0), old);
    CHECK_INT(graph_link_first(g, 2), GRAPH_END);
    CHECK(graph_link(g, fresh) != NULL);
    CHECK(graph_check(g));
    CHECK_INT(graph_end(g), DIG_OK);
    CHANGES(g, {GRAPH_MERGED, 3, 4}, {GRAPH_SPLIT, 1, 5});
    graph_close(g);
}

TEST(touching_and_parting_within_one_batch_is_no_change)
{
    Graph *g = graph_with(4);
    join(g, 0, 1);
    join(g, 2, 3);
    uint64_t before = graph_hash(g);
    graph_begin(g);
    graph_link_remove(g, join(g, 1, 2));
    CHECK_INT(graph_end(g), DIG_OK);
    NO_CHANGES(g);
    CHECK(graph_hash(g) == before);
    CHECK(graph_check(g));
    graph_close(g);
}

/* What held A together is replaced by a way round through B. */
TEST(a_dig_that_falls_apart_and_is_held_by_another_one_only_merges)
{
    Graph *g = graph_with(6);
    uint32_t middle = (join(g, 0, 1), join(g, 1, 2));
    join(g, 2, 3);                      /* A = id 1 = 0..3, B = 5 = 4, 5 */
    join(g, 4, 5);
    graph_begin(g);
    join(g, 0, 4);
    join(g, 5, 3);
    graph_link_remove(g, middle);
    CHECK_INT(graph_end(g), DIG_OK);
    CHANGES(g, {GRAPH_MERGED, 1, 5});
    CHECK_INT(graph_size(g, 1), 6);
    CHECK(graph_check(g));
    graph_close(g);
}

/* One node changes over: the larger old DIG keeps its id where most of its members are; the visits show that neither of the
 * two was walked through. */
TEST(a_node_that_changes_over_costs_itself)
{
    Graph *g = graph_with(2001);
    for (uint32_t i = 0; i < 999; i++)
        join(g, i, i + 1);              /* A: 0..999, id 1        */
    for (uint32_t i = 1001; i < 2000; i++)
        join(g, i, i + 1);              /* B: 1001..2000          */
    uint32_t held = join(g, 0, 1000), a = graph_of(g, 0), b = graph_of(g, 1500);
    uint64_t before = graph_visits(g);
    graph_begin(g);
    graph_link_remove(g, held);
    join(g, 1000, 1001);
    CHECK_INT(graph_end(g), DIG_OK);
    CHECK(graph_visits(g) - before < 10);
    CHANGES(g, {GRAPH_MERGED, a, b}, {GRAPH_SPLIT, a, 2002});
    CHECK_INT(graph_of(g, 500), a);
    CHECK_INT(graph_size(g, a), 1000);
    CHECK_INT(graph_of(g, 1000), 2002);
    CHECK_INT(graph_of(g, 1500), 2002);
    CHECK(graph_check(g));
    graph_close(g);
}

TEST(a_node_added_in_a_batch_counts_as_there_before_it)
{
    Graph *g = graph_with(2);
    graph_begin(g);
    CHECK_INT(graph_node_add(g, 7), DIG_OK);
    join(g, 7, 1);
    CHECK_INT(graph_end(g), DIG_OK);
    CHANGES(g, {GRAPH_MERGED, 2, 3});
    graph_close(g);
}

/* ---- links ---- */

TEST(parallel_links_hold_until_the_last_is_gone)
{
    Graph *g = graph_with(2);
    uint32_t link[3] = {join(g, 0, 1), join(g, 1, 0), join(g, 0, 1)};
    graph_link_remove(g, link[1]);
    NO_CHANGES(g);
    graph_link_remove(g, link[0]);
    NO_CHANGES(g);
    graph_link_remove(g, link[2]);
    CHANGES(g, {GRAPH_SPLIT, 1, 3});
    CHECK_INT(graph_link_first(g, 0), GRAPH_END);
    graph_close(g);
}

TEST(links_of_a_node_are_listed_newest_first_with_what_was_given)
{
    Graph *g = graph_with(3);
    uint32_t l0 = join(g, 0, 1), l1 = rest_on_floor(g, 0), l2 = 0;
    CHECK_INT(graph_link_add(g, 2, 0, false, DIG_LINK_JOINT, 77, 1.25, &l2), DIG_OK);
    CHECK_INT(graph_link_first(g, 0), l2);
    CHECK_INT(graph_link_next(g, 0, l2), l1);
    CHECK_INT(graph_link_next(g, 0, l1), l0);
    CHECK_INT(graph_link_next(g, 0, l0), GRAPH_END);
    CHECK_INT(graph_link_first(g, 2), l2);
    CHECK_INT(graph_link_next(g, 2, l2), GRAPH_END);
    const GraphLink *l = graph_link(g, l2);
    CHECK(l && l->a == 2 && l->b == 0 && l->kind == DIG_LINK_JOINT && !l->bound);
    CHECK_INT(l->user, 77);
    CHECK_NEAR(l->began, 1.25, 0);
    graph_link_set_user(g, l2, 78);
    CHECK_INT(graph_link(g, l2)->user, 78);
    CHECK(graph_link(g, l1)->bound);
    CHECK_INT(graph_link(g, l1)->b, FLOOR);
    graph_link_remove(g, l1);
    CHECK_INT(graph_link_next(g, 0, l2), l0);
    graph_close(g);
}

/* P2 and P9: two desks on one floor are two DIGs, and what happens on one is not seen on the other. */
TEST(what_shares_a_floor_is_not_joined_by_it)
{
    Graph *g = graph_with(200);
    for (uint32_t i = 0; i < 200; i++)
        rest_on_floor(g, i);
    for (uint32_t i = 100; i < 199; i++)
        join(g, i, i + 1);              /* desk B */
    join(g, 0, 2);
    uint32_t book = join(g, 0, 1);      /* desk A and two books */
    CHECK(graph_of(g, 0) != graph_of(g, 150));
    CHECK_INT(graph_of(g, FLOOR), GRAPH_NONE);
    uint64_t before = graph_visits(g);
    graph_link_remove(g, book);
    CHECK(graph_visits(g) - before <= 10);      /* three nodes, two bound links and a link seen from both ends, one moved */
    CHECK(graph_check(g));
    graph_close(g);
}

TEST(what_is_not_there_is_refused)
{
    Graph *g = graph_with(3);
    uint32_t link = 5;
    CHECK_INT(graph_link_add(g, 0, 9, false, 0, 0, 0, &link), DIG_E_ARG);
    CHECK_INT(graph_link_add(g, 9, 0, false, 0, 0, 0, &link), DIG_E_ARG);
    CHECK_INT(graph_link_add(g, FLOOR, 0, true, 0, 0, 0, &link), DIG_E_ARG);
    CHECK_INT(graph_link_add(g, 1, 1, false, 0, 0, 0, &link), DIG_E_ARG);
    CHECK_INT(link, 5);
    CHECK_INT(graph_node_add(g, 2), DIG_E_ARG);
    CHECK_INT(graph_node_add(g, UINT32_MAX), DIG_E_FULL);
    CHECK_INT(graph_reserve(g, -1, 0), DIG_E_ARG);
    CHECK_INT(graph_of(g, 3), GRAPH_NONE);
    CHECK_INT(graph_first(g, 99), GRAPH_END);
    CHECK_INT(graph_size(g, 0), 0);
    CHECK_INT(graph_by_index(g, 3), GRAPH_NONE);
    CHECK(graph_link(g, 0) == NULL);
    CHECK(graph_check(g));
    graph_close(g);
}

TEST(removed_nodes_leave_no_trace_and_their_ids_are_not_used_again)
{
    Graph *g = graph_with(3);
    graph_link_remove(g, join(g, 0, 1));        /* ids 1, 4, 3 */
    graph_node_remove(g, 1);
    CHECK(!graph_has_node(g, 1));
    CHECK_INT(graph_count(g), 2);
    CHECK(graph_check(g));
    CHECK_INT(graph_node_add(g, 1), DIG_OK);
    CHECK_INT(graph_of(g, 1), 5);
    CHECK(graph_check(g));
    graph_close(g);
}

/* ---- copies, memory, checksum ---- */

TEST(the_order_of_links_and_growth_do_not_show_in_the_checksum_but_any_change_does)
{
    Graph *g = graph_with(4), *other = NULL;
    CHECK_INT(graph_open(&other), DIG_OK);
    CHECK_INT(graph_reserve(other, 5000, 9000), DIG_OK);
    for (uint32_t i = 0; i < 4; i++)
        CHECK_INT(graph_node_add(other, i), DIG_OK);
    join(g, 0, 1);
    join(other, 0, 1);
    CHECK(graph_hash(g) == graph_hash(other));
    uint32_t link = 0;
    CHECK_INT(graph_link_add(other, 0, 1, false, DIG_LINK_CONTACT, 0, 1e-3, &link), DIG_OK);
    CHECK(graph_hash(g) != graph_hash(other));          /* one link more, same labels */
    graph_link_remove(other, link);
    CHECK(graph_hash(g) == graph_hash(other));
    CHECK_INT(graph_link_add(other, 0, 1, false, DIG_LINK_CONTACT, 0, 1e-3, &link), DIG_OK);
    CHECK_INT(graph_link_add(g, 0, 1, false, DIG_LINK_CONTACT, 0, 2e-3, &link), DIG_OK);
    CHECK(graph_hash(g) != graph_hash(other));          /* began at another time */
    graph_close(g);
    graph_close(other);
}

TEST(nothing_is_allocated_after_the_reserve)
{
    Graph *g = NULL;
    CHECK_INT(graph_open(&g), DIG_OK);
    CHECK_INT(graph_reserve(g, 1000, 3000), DIG_OK);
    uint64_t allocations = graph_allocations(g), x = 9;
    size_t bytes = graph_bytes(g);
    uint32_t link[3000];
    for (uint32_t i = 0; i < 1000; i++)
        CHECK_INT(graph_node_add(g, i), DIG_OK);
    for (int round = 0; round < 5; round++) {
        graph_begin(g);
        for (uint32_t i = 0; i < 3000; i++) {
            uint32_t a = noise(&x) % 1000;
            link[i] = join(g, a, (a + 1 + noise(&x) % 999) % 1000);
        }
        CHECK_INT(graph_end(g), DIG_OK);
        graph_begin(g);
        for (uint32_t i = 0; i < 3000; i++)
            graph_link_remove(g, link[i]);
        CHECK_INT(graph_end(g), DIG_OK);
        CHECK_INT(graph_count(g), 1000);
    }
    CHECK_INT(graph_allocations(g), allocations);
    CHECK_INT(graph_bytes(g), bytes);
    CHECK(graph_check(g));
    graph_close(g);
}

TEST(an_empty_graph_is_sound_and_can_be_copied)
{
    Graph *g = graph_with(0), *copy = graph_with(3);
    CHECK(graph_check(g));
    CHECK_INT(graph_copy(&copy, g), DIG_OK);
    CHECK_INT(graph_count(copy), 0);
    CHECK(!graph_has_node(copy, 0));
    CHECK_INT(graph_node_add(copy, 0), DIG_OK);
    CHECK_INT(graph_of(copy, 0), 1);
    graph_begin(g);
    CHECK_INT(graph_end(g), DIG_OK);
    NO_CHANGES(g);
    graph_close(copy);
    graph_close(g);
}

int main(void)
{
    RUN_TESTS(
        unit_test(the_larger_keeps_its_id_and_a_tie_goes_to_the_lower_id),
        unit_test(of_several_that_merge_at_once_the_largest_before_keeps_its_id),
        unit_test(the_largest_part_keeps_its_id_and_a_tie_goes_to_the_lowest_slot),
        unit_test(of_three_parts_the_largest_keeps_whatever_the_order_of_removal),
        unit_test(the_users_number_stays_with_the_id_and_goes_to_new_parts),
        unit_test(a_link_replaced_in_one_batch_is_no_change),
        unit_test(until_the_end_of_the_batch_the_graph_reads_as_before),
        unit_test(touching_and_parting_within_one_batch_is_no_change),
        unit_test(a_dig_that_falls_apart_and_is_held_by_another_one_only_merges),
        unit_test(a_node_that_changes_over_costs_itself),
        unit_test(a_node_added_in_a_batch_counts_as_there_before_it),
        unit_test(parallel_links_hold_until_the_last_is_gone),
        unit_test(links_of_a_node_are_listed_newest_first_with_what_was_given),
        unit_test(what_shares_a_floor_is_not_joined_by_it),
        unit_test(what_is_not_there_is_refused),
        unit_test(removed_nodes_leave_no_trace_and_their_ids_are_not_used_again),
        unit_test(the_order_of_links_and_growth_do_not_show_in_the_checksum_but_any_change_does),
        unit_test(nothing_is_allocated_after_the_reserve),
        unit_test(an_empty_graph_is_sound_and_can_be_copied)
    );
}
