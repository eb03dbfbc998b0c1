/* chain/tree.c - the bodies and joints of a group, put in the order in which the step's equations are solved. */
#include "chain/system.h"

/* A joint at a body, and what it holds it to; < 0: that does not move by itself. */
typedef struct Next { int joint, body; } Next;

/* Joints of each body: from[b] .. from[b + 1] in list. */
typedef struct Near { int *from; Next *list; } Near;

static int mover(const Group *g, int body) { return body >= 0 && g->member[body].moves ? body : -1; }

static dig_status list_joints(const Group *g, Near *near)
{
    near->from = arena_zero(g->arena, (size_t)(g->moving_count + 2) * sizeof *near->from);
    near->list = arena_alloc(g->arena, (size_t)(2 * g->joint_count + 1) * sizeof *near->list);
    int (*ends)[2] = arena_alloc(g->arena, (size_t)(g->joint_count + 1) * sizeof *ends);
    if (!near->from || !near->list || !ends)
        return DIG_E_MEMORY;
    int *next = near->from + 1;             /* while filling: where the next joint of body b goes */
    for (int i = 0; i < g->joint_count; i++)
        for (int side = 0; side < 2; side++) {
            int body = ends[i][side] = mover(g, side ? g->joints[i].b : g->joints[i].a);
            if (body >= 0)
                next[body + 1]++;
        }
    for (int b = 1; b <= g->moving_count; b++)
        next[b] += next[b - 1];
    for (int i = 0; i < g->joint_count; i++)
        for (int side = 0; side < 2; side++)
            if (ends[i][side] >= 0)
                near->list[next[ends[i][side]]++] = (Next){i, ends[i][!side]};
    return DIG_OK;
}

typedef struct Place { int link, joint; } Place;        /* of a body in the tree: its link, the joint towards the root; < 0 = none */

typedef struct Order { Near near; Place *place; int *body; } Order;     /* body: of each link; < 0 = none */

/* Breadth first from a body. False: there is a ring. */
static bool reach(Chain *c, Order *o, int root)
{
    const int first = c->link_count;
    o->body[c->link_count] = root;
    o->place[root] = (Place){c->link_count++, -1};
    for (int n = first; n < c->link_count; n++) {
        int body = o->body[n];
        for (int i = o->near.from[body]; i < o->near.from[body + 1]; i++) {
            const Next to = o->near.list[i];
            if (to.joint == o->place[body].joint || to.body < 0)
                continue;
            if (o->place[to.body].link >= 0)
                return false;
            o->body[c->link_count] = to.body;
            o->place[to.body] = (Place){c->link_count++, to.joint};
        }
    }
    while (c->link_count % LANES != 0)
        o->body[c->link_count++] = -1;
    c->tree[c->trees++] = (Linkage){first / LANES, c->link_count / LANES};
    return true;
}

static int ends_at(const Order *o, int body) { return body < 0 ? 0 : o->near.from[body + 1] - o->near.from[body]; }

/* Lanes that no joint takes, or no link owns, are to stay 0. */
static void clear_end(Ends *e)
{
    e->side = four_all(0);
    e->arm = e->p = e->change = e->error = four3_zero();
}

/* Where the ends and numbers of each four links are. */
static dig_status reserve_links(Chain *c, const Order *o)
{
    const int blocks = c->link_count / LANES;
    int ends = 0, numbers = 0, turns = 0;
    c->links = arena_alloc(c->g->arena, (size_t)(blocks + 1) * sizeof *c->links);
    if (!c->links)
        return DIG_E_MEMORY;
    for (int i = 0; i < blocks; i++) {
        Links *l = &c->links[i];
        l->ends = 0;
        for (int k = 0; k < LANES; k++) {
            l->ends = int_max(l->ends, ends_at(o, o->body[i * LANES + k]));
            l->own[k] = l->count[k] = 0;
        }
        int rows = l->ends * TIE_ROWS;
        l->end = ends;
        l->front = numbers;
        l->turn = turns;
        ends += l->ends;
        numbers += rows * (rows + 1);
        turns += rows;
    }
    c->ends = arena_alloc(c->g->arena, (size_t)(ends + 1) * sizeof *c->ends);
    c->number = arena_alloc(c->g->arena, (size_t)(numbers + 1) * sizeof *c->number);
    c->turn = arena_alloc(c->g->arena, (size_t)(turns + 1) * sizeof *c->turn);
    for (int i = 0; i < ends && c->ends; i++)
        clear_end(&c->ends[i]);
    return c->ends && c->number && c->turn ? DIG_OK : DIG_E_MEMORY;
}

static void add_end(Chain *c, int link, int joint, int child)
{
    const GroupJoint *j = &c->g->joints[joint];
    Links *l = links_of(c, link);
    int lane = lane_of(link), n = l->end + l->count[lane]++;
    bool a = j->a == l->body[lane];
    Ends *e = &c->ends[n];
    e->tie[lane] = joint;
    e->child[lane] = child;
    e->side[lane] = a ? 1 : -1;
    four3_put(&e->arm, lane, a ? j->ra : j->rb);
    c->tie[joint].end[!a] = n * LANES + lane;
}

/* What is eliminated last comes first: the joint towards the root, then what hangs on the body, then anchors. */
static void list_ends(Chain *c, const Order *o, int link)
{
    const int body = o->body[link];
    Links *l = links_of(c, link);
    l->body[lane_of(link)] = body;
    if (body < 0)
        return;
    if (o->place[body].joint >= 0)
        add_end(c, link, o->place[body].joint, -1);
    l->own[lane_of(link)] = l->count[lane_of(link)];
    for (int anchors = 0; anchors < 2; anchors++)
        for (int i = o->near.from[body]; i < o->near.from[body + 1]; i++) {
            const Next to = o->near.list[i];
            if (to.joint != o->place[body].joint && (to.body < 0) == anchors)
                add_end(c, link, to.joint, anchors ? -1 : o->place[to.body].link);
        }
}

static dig_status reserve(Chain *c, Order *o)
{
    Group *g = c->g;
    DIG_TRY(list_joints(g, &o->near));
    c->tree = arena_alloc(g->arena, (size_t)g->moving_count * sizeof *c->tree);
    c->tie = arena_zero(g->arena, (size_t)(g->joint_count + 1) * sizeof *c->tie);
    o->place = arena_alloc(g->arena, (size_t)g->moving_count * sizeof *o->place);
    o->body = arena_alloc(g->arena, (size_t)g->moving_count * LANES * sizeof *o->body);
    if (!c->tree || !c->tie || !o->place || !o->body)
        return DIG_E_MEMORY;
    for (int i = 0; i < g->moving_count; i++)
        o->place[i] = (Place){-1, -1};
    for (int i = 0; i < g->joint_count; i++) {
        c->tie[i].joint = i;
        c->tie[i].end[0] = c->tie[i].end[1] = -1;
    }
    return DIG_OK;
}

dig_status tree_make(Chain *c, bool *fits)
{
    Order o;
    DIG_TRY(reserve(c, &o));
    *fits = true;
    for (int i = 0; i < c->g->moving_count && *fits; i++)
        if (c->g->member[i].moves && o.place[i].link < 0)
            *fits = reach(c, &o, i);
    for (int i = 0; i < c->link_count && *fits; i++)
        *fits = ends_at(&o, o.body[i]) <= LINK_ENDS;
    if (!*fits)
        return DIG_OK;
    DIG_TRY(reserve_links(c, &o));
    for (int i = 0; i < c->link_count; i++)
        list_ends(c, &o, i);
    return DIG_OK;
}
