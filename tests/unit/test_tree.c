/* test_tree - the dynamic tree against brute force, and its invariants under random use. */
#include "check.h"
#include "collide_fixture.h"

#include <stdlib.h>

#include "geom/tree.h"

enum { BOXES = 10000 };

static box3 random_box(Random *r, real room, real size)
{
    vec3 low = random_vec3(r, room);
    vec3 extent = {random_between(r, 0, size), random_between(r, 0, size), random_between(r, 0, size)};
    return (box3){low, vec3_add(low, extent)};
}

typedef struct Field { Tree tree; box3 box[BOXES]; int32_t leaf[BOXES]; } Field;

static Field *open_field(Random *r, int count)
{
    Field *f = malloc(sizeof *f);
    tree_open(&f->tree);
    for (int i = 0; i < count; i++) {
        f->box[i] = random_box(r, 20, 1);
        CHECK_INT(tree_insert(&f->tree, f->box[i], (uint32_t)i, &f->leaf[i]), DIG_OK);
    }
    return f;
}

static void close_field(Field *f)
{
    tree_close(&f->tree);
    free(f);
}

typedef struct Count { long pairs; uint32_t self; } Count;

static bool count_later(void *context, uint32_t user)
{
    Count *c = context;
    c->pairs += user > c->self;
    return true;
}

static long pairs_by_tree(const Field *f, int count)
{
    Count c = {0, 0};
    for (int i = 0; i < count; i++) {
        c.self = (uint32_t)i;
        tree_query(&f->tree, f->box[i], count_later, &c);
    }
    return c.pairs;
}

static long pairs_by_force(const Field *f, int count)
{
    long pairs = 0;
    for (int i = 0; i < count; i++)
        for (int j = i + 1; j < count; j++)
            pairs += box3_overlap(f->box[i], f->box[j]);
    return pairs;
}

TEST(pairs_of_ten_thousand_boxes_equal_brute_force)
{
    Random r = {1};
    Field *f = open_field(&r, BOXES);
    CHECK(tree_check(&f->tree));
    long want = pairs_by_force(f, BOXES);
    CHECK(want > 500);
    CHECK_INT(pairs_by_tree(f, BOXES), want);
    close_field(f);
}

TEST(pairs_stay_right_while_boxes_move_come_and_go)
{
    Random r = {2};
    int count = 1000;
    Field *f = open_field(&r, count);
    for (int round = 0; round < 5; round++) {
        for (int i = 0; i < count; i++) {
            f->box[i] = random_box(&r, 8, 1.5);
            if (i % 3 == 0) {
                tree_remove(&f->tree, f->leaf[i]);
                CHECK_INT(tree_insert(&f->tree, f->box[i], (uint32_t)i, &f->leaf[i]), DIG_OK);
            } else {
                tree_move(&f->tree, f->leaf[i], f->box[i]);
            }
        }
        CHECK(tree_check(&f->tree));
        long want = pairs_by_force(f, count);
        CHECK(want > 100);
        CHECK_INT(pairs_by_tree(f, count), want);
    }
    for (int i = 0; i < count; i++)
        tree_remove(&f->tree, f->leaf[i]);
    CHECK(tree_check(&f->tree));
    CHECK_INT(f->tree.count, 0);
    CHECK_INT(f->tree.root, -1);
    close_field(f);
}

TEST(moving_and_asking_never_allocate)
{
    Random r = {3};
    Field *f = open_field(&r, 500);
    const TreeNode *nodes = f->tree.nodes;
    int capacity = f->tree.capacity, used = f->tree.count;
    for (int i = 0; i < 5000; i++) {
        tree_move(&f->tree, f->leaf[i % 500], random_box(&r, 20, 1));
        CHECK(f->tree.nodes == nodes);
        CHECK_INT(f->tree.capacity, capacity);
        CHECK_INT(f->tree.count, used);
    }
    close_field(f);
}

TEST(reserve_makes_room_for_that_many_leaves)
{
    Random r = {4};
    Tree t;
    int32_t leaf;
    tree_open(&t);
    CHECK_INT(tree_reserve(&t, 300), DIG_OK);
    const TreeNode *nodes = t.nodes;
    for (uint32_t i = 0; i < 300; i++)
        CHECK_INT(tree_insert(&t, random_box(&r, 5, 1), i, &leaf), DIG_OK);
    CHECK(t.nodes == nodes);
    CHECK(tree_check(&t));
    tree_close(&t);
}

TEST(sorted_insertion_keeps_the_tree_low)
{
    Tree t;
    int32_t leaf;
    tree_open(&t);
    for (uint32_t i = 0; i < 4096; i++) {
        box3 b = {{i, 0, 0}, {i + 0.5, 1, 1}};
        CHECK_INT(tree_insert(&t, b, i, &leaf), DIG_OK);
    }
    CHECK(tree_check(&t));
    CHECK(t.nodes[t.root].height <= 36);        /* three times log2 4096 */
    tree_close(&t);
}

typedef struct First { const Field *f; vec3 from, along; int calls; } First;

static bool take_all(void *context, uint32_t user, real *length)
{
    First *first = context;
    (void)user;
    (void)length;
    first->calls++;
    return true;
}

static bool slab(box3 b, vec3 from, vec3 along, real length)
{
    real enter = 0, leave = length;
    for (int k = 0; k < 3; k++) {
        real t0 = (vec3_at(b.low, k) - vec3_at(from, k)) / vec3_at(along, k);
        real t1 = (vec3_at(b.high, k) - vec3_at(from, k)) / vec3_at(along, k);
        enter = real_max(enter, real_min(t0, t1));
        leave = real_min(leave, real_max(t0, t1));
    }
    return enter <= leave;
}

TEST(rays_meet_the_same_boxes_as_brute_force)
{
    Random r = {5};
    int count = 2000, met = 0;
    Field *f = open_field(&r, count);
    for (int i = 0; i < 3000; i++) {
        First first = {f, random_vec3(&r, 25), random_direction(&r), 0};
        real length = random_between(&r, 1, 40);
        int want = 0;
        for (int k = 0; k < count; k++)
            want += slab(f->box[k], first.from, first.along, length);
        tree_ray(&f->tree, first.from, first.along, length, take_all, &first);
        CHECK_INT(first.calls, want);
        met += want;
    }
    CHECK(met > 200);
    close_field(f);
}

static bool shorten(void *context, uint32_t user, real *length)
{
    First *first = context;
    first->calls++;
    *length = real_min(*length, first->f->box[user].low.x - first->from.x);
    return true;
}

TEST(a_shortened_ray_leaves_out_what_lies_behind)
{
    Field *f = malloc(sizeof *f);
    tree_open(&f->tree);
    for (int i = 0; i < 100; i++) {
        f->box[i] = (box3){{i + 1, -1, -1}, {i + 1.5, 1, 1}};
        CHECK_INT(tree_insert(&f->tree, f->box[i], (uint32_t)i, &f->leaf[i]), DIG_OK);
    }
    First first = {f, {0, 0, 0}, {1, 0, 0}, 0};
    tree_ray(&f->tree, first.from, first.along, 1000, shorten, &first);
    CHECK(first.calls >= 1);
    CHECK(first.calls < 100);
    close_field(f);
}

static bool stop_at_third(void *context, uint32_t user)
{
    (void)user;
    return ++*(int *)context < 3;
}

TEST(a_query_stops_when_told)
{
    Random r = {6};
    Field *f = open_field(&r, 100);
    int calls = 0;
    tree_query(&f->tree, (box3){{-99, -99, -99}, {99, 99, 99}}, stop_at_third, &calls);
    CHECK_INT(calls, 3);
    close_field(f);
}

/* Boxes one behind the other, each inner node with a leaf and all that is left: `leaves` - 1 high. No sequence of calls is known to make one. */
static void open_list(Tree *t, int leaves, const box3 *box)
{
    tree_open(t);
    CHECK_INT(tree_reserve(t, leaves), DIG_OK);
    for (int i = 0; i < leaves - 1; i++)
        t->nodes[i] = (TreeNode){.parent = i - 1, .child = {leaves - 1 + i, i + 1}};
    for (int i = 0; i < leaves; i++)
        t->nodes[leaves - 1 + i] = (TreeNode){.box = box[i], .parent = i < leaves - 1 ? i : leaves - 2, .none = -1, .user = (uint32_t)i};
    t->nodes[leaves - 2].child[1] = 2 * leaves - 2;
    for (int i = leaves - 2; i >= 0; i--) {
        const TreeNode *a = &t->nodes[t->nodes[i].child[0]], *b = &t->nodes[t->nodes[i].child[1]];
        t->nodes[i].box = box3_union(a->box, b->box);
        t->nodes[i].height = 1 + (a->height > b->height ? a->height : b->height);
    }
    t->root = 0;
    t->count = 2 * leaves - 1;
    t->free = -1;
}

typedef struct Order { uint32_t user[256]; int count; } Order;

static bool note_order(void *context, uint32_t user)
{
    Order *o = context;
    o->user[o->count++] = user;
    return o->count < 256;
}

TEST(a_tree_as_high_as_it_has_leaves_is_asked_in_the_same_order)
{
    enum { LEAVES = 200 };
    Random r = {9};
    box3 box[LEAVES];
    Tree high;
    for (int i = 0; i < LEAVES; i++)
        box[i] = random_box(&r, 5, 2);
    open_list(&high, LEAVES, box);
    CHECK_INT(high.nodes[high.root].height, LEAVES - 1);
    for (int q = 0; q < 100; q++) {
        box3 ask = random_box(&r, 5, 2);
        Order order = {.count = 0};
        int at = 0;
        tree_query(&high, ask, note_order, &order);
        for (int i = 0; i < LEAVES; i++)
            if (box3_overlap(ask, box[i]))
                CHECK(at < order.count && order.user[at++] == (uint32_t)i);
        CHECK_INT(order.count, at);
    }
    tree_close(&high);
}

TEST(a_copy_has_the_same_nodes_and_grows_alike)
{
    Random r = {7};
    Field *f = open_field(&r, 100);
    Tree copy, larger;
    tree_open(&copy);
    tree_open(&larger);
    CHECK_INT(tree_reserve(&larger, 1000), DIG_OK);
    CHECK_INT(tree_copy(&copy, &f->tree), DIG_OK);
    CHECK_INT(tree_copy(&larger, &f->tree), DIG_OK);
    CHECK(tree_check(&copy) && tree_check(&larger));
    for (uint32_t i = 0; i < 400; i++) {
        int32_t one, two, three;
        box3 b = random_box(&r, 20, 1);
        CHECK_INT(tree_insert(&f->tree, b, i, &one), DIG_OK);
        CHECK_INT(tree_insert(&copy, b, i, &two), DIG_OK);
        CHECK_INT(tree_insert(&larger, b, i, &three), DIG_OK);
        CHECK_INT(two, one);
        CHECK_INT(three, one);
    }
    CHECK_INT(copy.root, f->tree.root);
    CHECK_INT(larger.root, f->tree.root);
    tree_close(&copy);
    tree_close(&larger);
    close_field(f);
}

TEST(the_check_sees_a_wrong_box)
{
    Random r = {8};
    Field *f = open_field(&r, 50);
    CHECK(tree_check(&f->tree));
    f->tree.nodes[f->leaf[10]].box.high.x += 100;
    CHECK(!tree_check(&f->tree));
    f->tree.nodes[f->leaf[10]].box.high.x -= 100;
    f->tree.nodes[f->tree.root].height++;
    CHECK(!tree_check(&f->tree));
    close_field(f);
}

int main(void)
{
    RUN_TESTS(unit_test(pairs_of_ten_thousand_boxes_equal_brute_force), unit_test(pairs_stay_right_while_boxes_move_come_and_go),
              unit_test(moving_and_asking_never_allocate), unit_test(reserve_makes_room_for_that_many_leaves),
              unit_test(sorted_insertion_keeps_the_tree_low), unit_test(rays_meet_the_same_boxes_as_brute_force),
              unit_test(a_shortened_ray_leaves_out_what_lies_behind), unit_test(a_query_stops_when_told),
              unit_test(a_tree_as_high_as_it_has_leaves_is_asked_in_the_same_order),
              unit_test(a_copy_has_the_same_nodes_and_grows_alike), unit_test(the_check_sees_a_wrong_box));
}
