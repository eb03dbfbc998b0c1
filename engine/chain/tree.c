/* chain/tree.c - the bodies and joints of a group, put in the order in which the step's equations are solved. */
#include "chain/system.h"

static bool moves(const Group *g, int body) { return body >= 0 && g->member[body].moves; }

static int end_body(const Group *g, int joint, int side) { return side ? g->joints[joint].b : g->joints[joint].a; }

/* Joints of each body: from[b] .. from[b + 1] in list. */
typedef struct Near { int *from, *list; } Near;

static dig_status list_joints(const Group *g, Near *near)
{
    near->from = arena_zero(g->arena, (size_t)(g->moving_count + 2) * sizeof *near->from);
    near->list = arena_alloc(g->arena, (size_t)(2 * g->joint_count + 1) * sizeof *near->list);
    if (!near->from || !near->list)
        return DIG_E_MEMORY;
    int *next = near->from + 1;             /* while filling: where the next joint of body b goes */
    for (int i = 0; i < 2 * g->joint_count; i++)
        if (moves(g, end_body(g, i / 2, i % 2)))
            next[end_body(g, i / 2, i % 2) + 1]++;
    for (int b = 1; b <= g->moving_count; b++)
        next[b] += next[b - 1];
    for (int i = 0; i < 2 * g->joint_count; i++)
        if (moves(g, end_body(g, i / 2, i % 2)))
            near->list[next[end_body(g, i / 2, i % 2)]++] = i / 2;
    return DIG_OK;
}

typedef struct Place { int link, joint; } Place;        /* of a body in the tree: its link, the joint towards the root; < 0 = none */

/* Breadth first from a body. False: there is a ring. */
static bool reach(Chain *c, const Near *near, Place *place, int root)
{
    const Group *g = c->g;
    Linkage *t = &c->tree[c->trees++];
    *t = (Linkage){.first = c->links};
    c->link[c->links].body = root;
    place[root] = (Place){c->links++, -1};
    for (int n = t->first; n < c->links; n++) {
        int body = c->link[n].body;
        for (int i = near->from[body]; i < near->from[body + 1]; i++) {
            int joint = near->list[i], other = end_body(g, joint, end_body(g, joint, 0) == body);
            if (joint == place[body].joint || !moves(g, other))
                continue;
            if (place[other].link >= 0)
                return false;
            c->link[c->links].body = other;
            place[other] = (Place){c->links++, joint};
        }
    }
    t->links = c->links - t->first;
    return true;
}

static void add_end(Chain *c, Link *l, int joint, int child)
{
    const GroupJoint *j = &c->g->joints[joint];
    bool a = j->a == l->body;
    c->end[c->ends++] = (End){.tie = joint, .child = child, .at = l->rows, .side = a ? 1 : -1, .arm = a ? j->ra : j->rb};
    c->tie[joint].link[!a] = (int)(l - c->link);
    l->rows += TIE_ROWS;
    l->ends++;
}

/* What is eliminated first comes first: anchors, then what hangs on the body, then the joint towards the root. */
static void list_ends(Chain *c, const Near *near, const Place *place, Link *l)
{
    l->end = c->ends;
    l->ends = l->rows = l->passed = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int i = near->from[l->body]; i < near->from[l->body + 1]; i++) {
            int joint = near->list[i], other = end_body(c->g, joint, end_body(c->g, joint, 0) == l->body);
            if (joint != place[l->body].joint && moves(c->g, other) == (pass == 1))
                add_end(c, l, joint, pass ? place[other].link : -1);
        }
    if (place[l->body].joint >= 0) {
        add_end(c, l, place[l->body].joint, -1);
        l->passed = TIE_ROWS;
    }
}

static dig_status reserve(Chain *c, Near *near, Place **place)
{
    Group *g = c->g;
    DIG_TRY(list_joints(g, near));
    c->link = arena_alloc(g->arena, (size_t)g->moving_count * sizeof *c->link);
    c->tree = arena_alloc(g->arena, (size_t)g->moving_count * sizeof *c->tree);
    c->end = arena_alloc(g->arena, (size_t)(2 * g->joint_count + 1) * sizeof *c->end);
    c->tie = arena_alloc(g->arena, (size_t)(g->joint_count + 1) * sizeof *c->tie);
    *place = arena_alloc(g->arena, (size_t)g->moving_count * sizeof **place);
    if (!c->link || !c->tree || !c->end || !c->tie || !*place)
        return DIG_E_MEMORY;
    for (int i = 0; i < g->moving_count; i++)
        (*place)[i] = (Place){-1, -1};
    for (int i = 0; i < g->joint_count; i++) {
        c->tie[i].joint = i;
        c->tie[i].link[0] = c->tie[i].link[1] = -1;
    }
    return DIG_OK;
}

dig_status tree_make(Chain *c, bool *fits)
{
    Near near;
    Place *place;
    int numbers = 0, turns = 0;
    DIG_TRY(reserve(c, &near, &place));
    *fits = true;
    for (int i = 0; i < c->g->moving_count && *fits; i++)
        if (c->g->member[i].moves && place[i].link < 0)
            *fits = reach(c, &near, place, i);
    for (int i = 0; i < c->links && *fits; i++) {
        Link *l = &c->link[i];
        *fits = near.from[l->body + 1] - near.from[l->body] <= LINK_ENDS;
        if (*fits)
            list_ends(c, &near, place, l);
        l->front = numbers;
        l->turn = turns;
        numbers += l->rows * (l->rows + 1);
        turns += l->rows;
    }
    c->number = arena_alloc(c->g->arena, (size_t)(numbers + 1) * sizeof *c->number);
    c->turn = arena_alloc(c->g->arena, (size_t)(turns + 1) * sizeof *c->turn);
    return c->number && c->turn ? DIG_OK : DIG_E_MEMORY;
}
