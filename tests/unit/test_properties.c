/* test_properties.c - what holds of DIGs and messages in any world: P1 to P6 and P8 to P11 (P7, asking changes nothing, is in
 * test_ask.c). Each on random worlds, a few of them here, with DIGBOX_FULL=1 1000 of each.
 *
 * Random graphs are made of links of the range layer, which need no physics; stacks and desks are stepped.
 */
#include "physics_fixture.h"

#include "base/rng.h"

#include <stdlib.h>

enum { BODIES = 24, WIRES = 60, LAYER = DIG_LAYER_RANGE };

static int seeds(void) { return getenv("DIGBOX_FULL") ? 1000 : 12; }

static int below(uint64_t *seed, int n) { return (int)(rng_real(seed) * n) % n; }

/* ---- random graphs ---- */

typedef struct Net {
    dig_world *w;
    dig_body   body[BODIES];
    int        count;
    struct { int a, b; bool bound; dig_wire wire; } link[WIRES];
    int        links;
} Net;

static dig_body ball(dig_world *w, vec3 at) { return add_ball(w, look(0.5, 0), 0.1, 1, at, vec3_zero()); }

static Net net_of(int count)
{
    Net n = {.w = open_world(1.0 / 60, "sketch", false), .count = count};
    for (int i = 0; i < count; i++)
        n.body[i] = ball(n.w, (vec3){i, 0, 0});
    return n;
}

static void join(Net *n, int a, int b, bool bound)
{
    const dig_wire_def def = {LAYER, n->body[a], n->body[b], bound, 0};
    CHECK(n->links < WIRES);
    n->link[n->links].a = a;
    n->link[n->links].b = b;
    n->link[n->links].bound = bound;
    if (dig_wire_add(n->w, &def, &n->link[n->links].wire) != DIG_OK)
        fail_msg("%s", dig_error(n->w));
    n->links++;
}

static void cut(Net *n, int link)
{
    CHECK_INT(dig_wire_remove(n->w, n->link[link].wire), DIG_OK);
    n->link[link] = n->link[--n->links];
}

/* The last body is the boundary: links to it are bound. */
static void random_links(Net *n, uint64_t *seed, int links)
{
    for (int i = 0; i < links; i++) {
        int a = below(seed, n->count - 1), b = (a + 1 + below(seed, n->count - 2)) % (n->count - 1);
        bool bound = rng_real(seed) < 0.15;
        join(n, a, bound ? n->count - 1 : b, bound);
    }
}

/* Lowest body of the component, by brute force; -1: without a link. */
static void components(const Net *n, int *part)
{
    for (int i = 0; i < n->count; i++)
        part[i] = -1;
    for (int k = 0; k < n->links; k++) {
        part[n->link[k].a] = n->link[k].a;
        if (!n->link[k].bound)
            part[n->link[k].b] = n->link[k].b;
    }
    for (bool changed = true; changed;) {
        changed = false;
        for (int k = 0; k < n->links; k++) {
            int a = n->link[k].a, b = n->link[k].b, low = n->link[k].bound || part[a] < part[b] ? part[a] : part[b];
            changed |= !n->link[k].bound && part[a] != part[b];
            part[a] = low;
            if (!n->link[k].bound)
                part[b] = low;
        }
    }
}

static uint32_t id_of(const Net *n, int i) { return dig_of_layer(n->w, n->body[i], LAYER).id; }

static void check_partition(const Net *n)
{
    int part[BODIES], sum = 0;
    dig_dig all[BODIES];
    components(n, part);
    for (int i = 0; i < n->count; i++) {
        CHECK_INT(id_of(n, i) != 0, part[i] >= 0);
        for (int k = 0; k < i; k++)
            if (part[i] >= 0 && part[k] >= 0)
                CHECK_INT(id_of(n, i) == id_of(n, k), part[i] == part[k]);
    }
    CHECK_INT(id_of(n, n->count - 1), 0);                       /* P2: the boundary is in none */
    int digs = dig_digs_of_layer(n->w, LAYER, all, BODIES);
    for (int i = 0; i < digs; i++)
        sum += dig_members(n->w, all[i], NULL, 0);
    for (int i = 0; i < n->count; i++)
        sum -= part[i] >= 0;
    CHECK_INT(sum, 0);                                          /* P3: each in exactly one */
    CHECK_INT(dig_world_check(n->w), DIG_OK);
}

TEST(p1_p2_p3_labels_are_components_without_the_boundary)
{
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 1;
        Net n = net_of(6 + below(&seed, BODIES - 6));
        check_partition(&n);
        for (int round = 0; round < 10; round++) {
            random_links(&n, &seed, below(&seed, 6));
            for (int k = below(&seed, 6); k > 0 && n.links > 0; k--)
                cut(&n, below(&seed, n.links));
            check_partition(&n);
        }
        dig_world_close(n.w);
    }
}

/* The same links, but no longer bound: the boundary and all that was bound to it are one DIG with their own. */
TEST(p2_a_boundary_that_becomes_a_body_joins_those_that_rest_on_it)
{
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 100;
        Net n = net_of(6 + below(&seed, BODIES - 6));
        int last = n.count - 1, part[BODIES], resting[BODIES] = {0};
        random_links(&n, &seed, 14);
        components(&n, part);
        for (int k = 0; k < n.links; k++)
            if (n.link[k].bound)
                for (int m = 0; m < last; m++)
                    resting[m] |= part[m] == part[n.link[k].a];
        int ends[WIRES], bound = 0;
        for (int k = n.links - 1; k >= 0; k--) {
            if (!n.link[k].bound)
                continue;
            ends[bound++] = n.link[k].a;
            cut(&n, k);
        }
        resting[last] = bound > 0;
        for (int k = 0; k < bound; k++)
            join(&n, ends[k], last, false);
        for (int a = 0; a < n.count; a++)
            for (int b = 0; b < a; b++)
                if (resting[a] || resting[b])
                    CHECK_INT(id_of(&n, a) == id_of(&n, b) && id_of(&n, a) != 0, resting[a] && resting[b]);
        dig_world_close(n.w);
    }
}

/* ---- P4: exactly once ---- */

/* Messages of a kind that each body got. */
static void heard(const Net *n, const char *kind, int *count)
{
    dig_message *all = malloc(4096 * sizeof *all);
    CHECK(all != NULL);
    int total = dig_messages(n->w, all, 4096);
    memset(count, 0, BODIES * sizeof *count);
    for (int i = 0; i < total; i++)
        for (int k = 0; k < n->count; k++)
            count[k] += strcmp(all[i].kind, kind) == 0 && all[i].to.slot == n->body[k].slot;
    free(all);
}

static int post(const Net *n, dig_route route, const char *kind, int from)
{
    dig_post p = dig_post_defaults();
    dig_receipt r;
    snprintf(p.kind, sizeof p.kind, "%s", kind);
    p.route = route;
    p.layer = LAYER;
    p.from = n->body[from];
    CHECK_INT(dig_message_post(n->w, &p, &r), DIG_OK);
    return r.reached;
}

static void check_once(const Net *n, int from)
{
    int part[BODIES], count[BODIES], flooded = 0, told = 0;
    components(n, part);
    int by_flood = post(n, DIG_ROUTE_FLOOD, "flood", from), by_dig = post(n, DIG_ROUTE_DIG, "dig", from);
    heard(n, "flood", count);
    for (int i = 0; i < n->count; i++, flooded += count[i - 1])
        CHECK_INT(count[i], i != from && part[i] >= 0 && part[i] == part[from]);
    heard(n, "dig", count);
    for (int i = 0; i < n->count; i++, told += count[i - 1])
        CHECK_INT(count[i], part[i] >= 0 && part[i] == part[from]);
    CHECK_INT(by_flood, flooded);
    CHECK_INT(by_dig, told);
}

TEST(p4_flood_and_dig_reach_each_member_once)
{
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 7;
        int shape = i % 4, count = 3 + below(&seed, 6);
        Net n = net_of(count);
        for (int a = 0; a < count && shape == 0; a++)           /* each with each */
            for (int b = 0; b < a; b++)
                join(&n, a, b, false);
        for (int a = 0; a < count && shape == 1; a++)           /* a ring, every link twice */
            for (int twice = 0; twice < 2; twice++)
                join(&n, a, (a + 1) % count, false);
        if (shape >= 2)
            random_links(&n, &seed, 4 + below(&seed, 12));
        const dig_wire_def self = {LAYER, n.body[0], n.body[0], false, 0};
        dig_wire none;
        CHECK_INT(dig_wire_add(n.w, &self, &none), DIG_E_ARG);  /* no link joins a body to itself */
        check_once(&n, below(&seed, count - (shape >= 2)));
        dig_world_close(n.w);
    }
}

/* ---- P6, P8 ---- */

TEST(p6_the_order_of_creation_decides_about_ids_only)
{
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 900;
        Net one = net_of(16), two = net_of(16);
        int order[WIRES], links = 4 + below(&seed, 20);
        random_links(&one, &seed, links);
        for (int k = 0; k < links; k++)
            order[k] = k;
        for (int k = links - 1; k > 0; k--) {
            int m = below(&seed, k + 1), t = order[k];
            order[k] = order[m];
            order[m] = t;
        }
        for (int k = 0; k < links; k++) {                       /* body i of the one is body 14 - i of the other */
            int a = one.link[order[k]].a, b = one.link[order[k]].b;
            bool bound = one.link[order[k]].bound;
            join(&two, bound ? 14 - a : 14 - b, bound ? 15 : 14 - a, bound);
        }
        for (int a = 0; a < 15; a++)
            for (int b = 0; b < a; b++)
                CHECK_INT(id_of(&one, a) && id_of(&one, a) == id_of(&one, b), id_of(&two, 14 - a) && id_of(&two, 14 - a) == id_of(&two, 14 - b));
        dig_world_close(one.w);
        dig_world_close(two.w);
    }
}

TEST(p8_a_link_that_comes_and_goes_leaves_everybody_where_they_were)
{
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 5000;
        Net n = net_of(20);
        random_links(&n, &seed, 20);
        for (int round = 0; round < 6; round++) {
            int part[BODIES], after[BODIES], a = below(&seed, 19), b = (a + 1 + below(&seed, 18)) % 19;
            uint32_t id[BODIES];
            components(&n, part);
            for (int k = 0; k < n.count; k++)
                id[k] = id_of(&n, k);
            join(&n, a, b, false);
            cut(&n, n.links - 1);
            components(&n, after);
            CHECK_INT(memcmp(part, after, (size_t)n.count * sizeof *part), 0);
            check_partition(&n);
            for (int k = 0; k < n.count; k++)                   /* who was not concerned has the same id */
                if (part[k] >= 0 && part[k] != part[a] && part[k] != part[b])
                    CHECK_INT(id_of(&n, k), id[k]);
        }
        dig_world_close(n.w);
    }
}

/* ---- P5: events rebuild the labels ---- */

static void replay(const Net *n, uint32_t *label)
{
    const dig_event *e;
    int events = dig_events(n->w, &e);
    for (int i = 0; i < events; i++) {
        if (e[i].layer != DIG_LAYER_MECHANICAL)
            continue;
        for (int k = 0; k < n->count; k++) {
            if (e[i].kind == DIG_EVENT_MERGED && label[k] == e[i].other_dig)
                label[k] = e[i].dig;
            if (e[i].kind == DIG_EVENT_SPLIT && dig_of(n->w, n->body[k]).id == e[i].other_dig)
                label[k] = e[i].other_dig;
        }
    }
}

/* Balls and boxes that fall on each other, meet, bounce and part. */
TEST(p5_p1_merged_and_split_rebuild_the_labels)
{
    int merged = 0, split = 0;
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 77;
        uint32_t label[BODIES];
        Net n = {.w = open_world(1.0 / 60, "sketch", true), .count = 10};
        add_floor(n.w, look(0.4, 0.4));
        for (int k = 0; k < n.count; k++) {
            vec3 at = {0.4 * rng_real(&seed), 0.15 + 0.25 * k, 0.4 * rng_real(&seed)}, v = {rng_real(&seed) - 0.5, -2 * rng_real(&seed), rng_real(&seed) - 0.5};
            n.body[k] = rng_real(&seed) < 0.5 ? add_ball(n.w, look(0.4, 0.6), 0.12, 1, at, v)
                                              : add_box(n.w, look(0.4, 0.2), (vec3){0.2, 0.2, 0.2}, 1, at, quat_identity());
            label[k] = dig_of(n.w, n.body[k]).id;
        }
        for (int step = 0; step < 90; step++) {
            CHECK_INT(dig_world_step(n.w), DIG_OK);
            replay(&n, label);
            for (int k = 0; k < n.count; k++)
                CHECK_INT(label[k], dig_of(n.w, n.body[k]).id);
            merged += count_events(n.w, DIG_EVENT_MERGED);
            split += count_events(n.w, DIG_EVENT_SPLIT);
            if (step % 10 == 0)
                CHECK_INT(dig_world_check(n.w), DIG_OK);        /* labels are components: world/graph_check.c */
        }
        dig_world_close(n.w);
    }
    print_message("    %d merges, %d splits\n", merged, split);
    CHECK(merged > 10 && split > 10);
}

/* ---- P9: two desks on one floor ---- */

static int desk(dig_world *w, uint64_t *seed, real x, dig_body *out)
{
    int n = 0, books = 1 + below(seed, 4);
    out[n++] = add_box(w, look(0.5, 0), (vec3){1, 0.7, 1}, 20, (vec3){x, 0.35, 0}, quat_identity());
    for (int i = 0; i < books; i++)
        out[n++] = add_box(w, look(0.5, 0), (vec3){0.3, 0.05, 0.2}, 0.5 + rng_real(seed), (vec3){x + 0.1 * rng_real(seed), 0.725 + 0.05 * i, 0},
                           quat_identity());
    return n;
}

TEST(p9_what_happens_to_one_desk_visits_nobody_of_the_other)
{
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 31;
        dig_world *w = open_world(1.0 / 60, "play", true);
        dig_body a[8], b[8];
        dig_body_state was[8], now;
        add_floor(w, look(0.5, 0));
        int na = desk(w, &seed, 0, a), nb = desk(w, &seed, 2, b);
        for (int s = 0; s < 90; s++)
            CHECK_INT(dig_world_step(w), DIG_OK);
        CHECK(dig_of(w, a[0]).id != dig_of(w, b[0]).id);
        CHECK_INT(dig_members(w, dig_of(w, a[0]), NULL, 0), na);
        for (int k = 0; k < nb; k++) {
            CHECK_INT(dig_body_get(w, b[k], &was[k]), DIG_OK);
            CHECK(!was[k].awake);
        }
        uint64_t delivered = dig_world_stats(w).delivered;
        dig_post p = dig_post_defaults();
        dig_receipt r;
        memcpy(p.kind, "push", 5);
        p.route = DIG_ROUTE_FLOOD;
        p.from = a[0];
        CHECK_INT(dig_message_post(w, &p, &r), DIG_OK);
        CHECK_INT(r.reached, na - 1);
        CHECK_INT(dig_world_stats(w).delivered - delivered, na - 1);
        CHECK_INT(dig_body_push(w, a[0], (vec3){-30 - 100 * rng_real(&seed), 0, 0}, vec3_zero(), false, 0.3), DIG_OK);
        for (int s = 0; s < 20; s++) {
            CHECK_INT(dig_world_step(w), DIG_OK);
            CHECK(dig_world_stats(w).awake <= na);
            CHECK_INT(dig_world_stats(w).groups <= na, 1);
        }
        for (int k = 0; k < nb; k++) {
            CHECK_INT(dig_body_get(w, b[k], &now), DIG_OK);
            CHECK(!now.awake && memcmp(&now.position, &was[k].position, sizeof now.position) == 0);
        }
        dig_world_close(w);
    }
}

/* ---- P10: stacked spheres ---- */

TEST(p10_stacked_spheres_are_one_dig)
{
    const int heights[] = {3, 4, 10, 100};
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 3;
        int n = i < 4 ? heights[i] : heights[below(&seed, 3)], order[100];
        dig_body body[100];
        dig_world *w = open_world(1.0 / 60, "play", true);
        add_floor(w, look(0.5, 0));
        for (int k = 0; k < n; k++)
            order[k] = k;
        for (int k = n - 1; k > 0; k--) {
            int m = below(&seed, k + 1), t = order[k];
            order[k] = order[m];
            order[m] = t;
        }
        for (int k = 0; k < n; k++)
            body[order[k]] = add_ball(w, look(0.5, 0), 0.1, 1, (vec3){0, 0.1 + 0.2 * order[k], 0}, vec3_zero());
        for (int s = 0; s < 3; s++)
            CHECK_INT(dig_world_step(w), DIG_OK);
        CHECK_INT(dig_members(w, dig_of(w, body[0]), NULL, 0), n);
        CHECK_INT(dig_digs(w, NULL, 0), 1);
        dig_world_close(w);
    }
}

/* ---- P11: storms ---- */

/* Everybody answers every message by telling all neighbours, with a kind of its own when `fresh`. Returns the status that ended it. */
static dig_status cascade(const Net *n, bool fresh, uint64_t *posts)
{
    const dig_event *e;
    dig_status s = DIG_OK;
    uint64_t before = dig_world_stats(n->w).posted;
    post(n, DIG_ROUTE_NEIGHBOURS, "spark", n->link[0].a);
    for (int taken, kinds = 0; s == DIG_OK && (taken = dig_message_take(n->w)) > 0;) {
        int count = dig_events(n->w, &e);
        for (int k = count - taken; s == DIG_OK && k < count; k++) {
            const dig_message m = *dig_message_of(n->w, &e[k]);
            dig_post p = dig_post_defaults();
            snprintf(p.kind, sizeof p.kind, fresh ? "spark %d" : "spark", kinds++);
            p.route = DIG_ROUTE_NEIGHBOURS;
            p.layer = LAYER;
            p.from = m.to;
            dig_message_answering(n->w, m.root);
            s = dig_message_post(n->w, &p, NULL);
            dig_message_answering(n->w, 0);
        }
    }
    *posts = dig_world_stats(n->w).posted - before;
    return s;
}

TEST(p11_a_cascade_ends_and_a_storm_is_stopped_at_the_cap)
{
    for (int i = 0; i < seeds(); i++) {
        uint64_t seed = (uint64_t)i + 11, posts;
        Net n = net_of(8);
        int count[BODIES];
        for (int k = 0; k < 7; k++)                             /* a ring at least: what goes out comes back */
            join(&n, k, (k + 1) % 7, false);
        random_links(&n, &seed, 4);
        CHECK_INT(cascade(&n, false, &posts), DIG_OK);
        heard(&n, "spark", count);
        for (int k = 0; k < 7; k++)
            CHECK_INT(count[k], 1);
        CHECK(posts <= 9);                                      /* the spark, and one answer of each that heard it */
        CHECK_INT(dig_world_stats(n.w).storms, 0);
        CHECK_INT(dig_world_step(n.w), DIG_OK);
        CHECK_INT(cascade(&n, true, &posts), DIG_E_FULL);
        CHECK_INT(posts, 10001);
        CHECK_INT(dig_world_stats(n.w).storms, 1);
        CHECK(strstr(dig_error(n.w), "storm") && strstr(dig_error(n.w), "'spark'"));
        CHECK_INT(dig_message_take(n.w), 0);                    /* nothing of it is left */
        CHECK_INT(dig_world_step(n.w), DIG_OK);
        CHECK_INT(cascade(&n, false, &posts), DIG_OK);
        dig_world_close(n.w);
    }
}

int main(void)
{
    RUN_TESTS(
        unit_test(p1_p2_p3_labels_are_components_without_the_boundary),
        unit_test(p2_a_boundary_that_becomes_a_body_joins_those_that_rest_on_it),
        unit_test(p4_flood_and_dig_reach_each_member_once),
        unit_test(p5_p1_merged_and_split_rebuild_the_labels),
        unit_test(p6_the_order_of_creation_decides_about_ids_only),
        unit_test(p8_a_link_that_comes_and_goes_leaves_everybody_where_they_were),
        unit_test(p9_what_happens_to_one_desk_visits_nobody_of_the_other),
        unit_test(p10_stacked_spheres_are_one_dig),
        unit_test(p11_a_cascade_ends_and_a_storm_is_stopped_at_the_cap)
    );
}
