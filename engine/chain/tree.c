/* chain/tree.c - the bodies and joints of a group, put in the order in which the step's equations are solved. */
#include "chain/system.h"

/* End 2 j + side of the group's joint j. */
typedef struct End {
    int body;                   /* < 0: one that does not move by itself */
    int next;                   /* at that body, ascending; < 0 = none  */
} End;

/* A body among the joints. */
typedef struct Node {
    int first, count;           /* of its ends                          */
    int link;                   /* its place in the tree; < 0 = none yet */
    int up;                     /* its end of the joint towards the root; < 0 = none */
} Node;

typedef struct Order { End *end; Node *node; int *body; } Order;        /* body: of each link; < 0 = none */

static dig_status reserve(Chain *c, Order *o)
{
    const Group *g = c->g;
    const size_t bodies = (size_t)g->moving_count, joints = (size_t)g->joint_count;
    o->end = arena_alloc(g->arena, 2 * joints * sizeof *o->end);
    o->node = arena_alloc(g->arena, bodies * sizeof *o->node);
    o->body = arena_alloc(g->arena, bodies * LANES * sizeof *o->body);
    c->tree = arena_alloc(g->arena, bodies * sizeof *c->tree);
    c->tie = arena_alloc(g->arena, joints * sizeof *c->tie);
    c->owned = arena_alloc(g->arena, joints * sizeof *c->owned);
    return o->end && o->node && o->body && c->tree && c->tie && c->owned ? DIG_OK : DIG_E_MEMORY;
}

/* The first members of a group do, where none of them sleeps (way.c). */
static bool moves_by_itself(const Group *g, int body)
{
    DIG_ASSERT(body < 0 || g->member[body].moves == (body < g->moving_count));
    return (unsigned)body < (unsigned)g->moving_count;
}

static void list_ends(const Chain *c, const Order *o)
{
    const Group *g = c->g;
    for (int i = 0; i < g->moving_count; i++)
        o->node[i] = (Node){-1, 0, -1, -1};
    for (int e = 2 * g->joint_count - 1; e >= 0; e--) {
        const GroupJoint *j = &g->joints[e / 2];
        int body = e % 2 ? j->b : j->a;
        o->end[e] = (End){-1, -1};
        c->tie[e / 2].end[e % 2] = -1;
        if (!moves_by_itself(g, body))
            continue;
        Node *node = &o->node[body];
        o->end[e] = (End){body, node->first};
        node->first = e;
        node->count++;
    }
}

/* Breadth first from a body. False: there is a ring, or a body with too many joints. */
static bool reach(Chain *c, const Order *o, int root)
{
    const int first = c->link_count, ties = c->owned_count;
    o->body[c->link_count] = root;
    o->node[root].link = c->link_count++;
    for (int n = first; n < c->link_count; n++) {
        const Node *node = &o->node[o->body[n]];
        if (node->count > LINK_ENDS)
            return false;
        for (int e = node->first; e >= 0; e = o->end[e].next) {
            int to = o->end[e ^ 1].body;
            if (e == node->up)
                continue;
            c->owned[c->owned_count++] = e / 2;
            if (to < 0)
                continue;
            if (o->node[to].link >= 0)
                return false;
            o->body[c->link_count] = to;
            o->node[to].link = c->link_count++;
            o->node[to].up = e ^ 1;
        }
    }
    while (c->link_count % LANES != 0)
        o->body[c->link_count++] = -1;
    c->tree[c->trees++] = (Linkage){first / LANES, c->link_count / LANES, ties, c->owned_count};
    return true;
}

/* Where the ends and fronts of each four links are. */
static dig_status reserve_links(Chain *c, const Order *o)
{
    const int blocks = c->link_count / LANES;
    int ends = 0, numbers = 0, turns = 0;
    c->links = arena_alloc(c->g->arena, (size_t)blocks * sizeof *c->links);
    if (!c->links)
        return DIG_E_MEMORY;
    for (int i = 0; i < blocks; i++) {
        Links *l = &c->links[i];
        l->ends = 0;
        for (int k = 0; k < LANES; k++) {
            int body = l->body[k] = o->body[i * LANES + k];
            l->count[k] = body < 0 ? 0 : o->node[body].count;
            l->own[k] = body >= 0 && o->node[body].up >= 0;
            l->ends = int_max(l->ends, l->count[k]);
        }
        l->end = ends;
        l->turn = turns;
        l->front = numbers;
        ends += l->ends;
        turns += l->ends * TIE_ROWS;
        numbers += LANES * l->ends * l->ends * TIE_ROWS;
    }
    c->ends = arena_alloc(c->g->arena, (size_t)ends * sizeof *c->ends);
    c->number = arena_alloc(c->g->arena, (size_t)numbers * sizeof *c->number);
    c->turn = arena_alloc(c->g->arena, (size_t)turns * sizeof *c->turn);
    return c->ends && c->number && c->turn ? DIG_OK : DIG_E_MEMORY;
}

/* What is looked at in lanes without a joint that the link owns. */
static const four nothing;

/* Lanes that no joint takes, or no link owns, are to stay 0. */
static void clear_ends(const Chain *c, const Links *l)
{
    for (int n = 0; n < l->ends; n++) {
        Ends *e = &c->ends[l->end + n];
        e->side = four_all(0);
        e->arm = e->p = e->error = four3_zero();
        e->owned = (four_int){0};
        for (int k = 0; k < LANES; k++) {
            e->other[k] = &nothing;
            e->below[k] = NULL;
        }
    }
}

/* End e of the group's joints becomes end n of the link. */
static void put_end(const Chain *c, const Links *l, int lane, int n, int e)
{
    const GroupJoint *j = &c->g->joints[e / 2];
    Ends *to = &c->ends[l->end + n];
    to->side[lane] = e % 2 ? -1 : 1;
    four3_put(&to->arm, lane, e % 2 ? j->rb : j->ra);
    c->tie[e / 2].end[e % 2] = (l->end + n) * LANES + lane;
}

/* The same of one whose joint the link owns; child: its node, NULL at an anchor. */
static void put_own_end(const Chain *c, const Links *l, int lane, int n, int e, const Node *child)
{
    Ends *to = &c->ends[l->end + n];
    put_end(c, l, lane, n, e);
    to->owned[lane] = -1;
    to->other[lane] = &c->tie[e / 2].fixed;
    if (!child)
        return;
    Links *below = links_of(c, child->link);
    to->other[lane] = &below->hung[lane_of(child->link)];
    to->below[lane] = front_at(c, below, lane_of(child->link));
}

/* What is eliminated last comes first: the joint towards the root, then what hangs on the body, then anchors. */
static void put_ends(const Chain *c, const Order *o, const Links *l, int lane)
{
    const Node *node = &o->node[l->body[lane]];
    int n = 0, anchors = 0;
    if (node->up >= 0)
        put_end(c, l, lane, n++, node->up);
    for (int e = node->first; e >= 0; e = o->end[e].next) {
        int to = o->end[e ^ 1].body;
        if (to < 0)
            anchors++;
        else if (e != node->up)
            put_own_end(c, l, lane, n++, e, &o->node[to]);
    }
    for (int e = node->first; anchors > 0; e = o->end[e].next)
        if (o->end[e ^ 1].body < 0) {
            put_own_end(c, l, lane, n++, e, NULL);
            anchors--;
        }
}

static void fill_links(const Chain *c, const Order *o)
{
    for (int i = 0; i < c->link_count / LANES; i++) {
        Links *l = &c->links[i];
        clear_ends(c, l);
        l->first = 1;
        for (int k = 0; k < LANES && l->body[k] >= 0; k++) {
            put_ends(c, o, l, k);
            l->first = int_min(l->first, l->own[k]);
        }
    }
}

dig_status tree_make(Chain *c, bool *fits)
{
    Order o;
    DIG_TRY(reserve(c, &o));
    list_ends(c, &o);
    *fits = true;
    for (int i = 0; i < c->g->moving_count && *fits; i++)
        if (o.node[i].link < 0)
            *fits = reach(c, &o, i);
    if (!*fits)
        return DIG_OK;
    DIG_TRY(reserve_links(c, &o));
    fill_links(c, &o);
    return DIG_OK;
}
