/* geom/tree_save.c - the tree of boxes as bytes: node by node, so that the tree that is read is the same tree.
 *
 * Written are the boxes of leaves and the children of branches; parents, heights and the boxes of branches follow. Nodes that
 * were never used (the end of the free list, in the order in which growing adds them) are left out, so that trees that behave
 * alike are written alike, whatever room they have.
 */
#include "geom/save.h"

#include "base/block.h"

#include <stdlib.h>

enum { NODE_FREE, NODE_LEAF, NODE_BRANCH, NODE_KINDS };
enum { NODE_BYTES = 5 };        /* at least */

static uint8_t kind_of(const TreeNode *n)
{
    return n->height < 0 ? NODE_FREE : n->child[0] < 0 ? NODE_LEAF : NODE_BRANCH;
}

/* ---- writing ---- */

/* Number of nodes without the unused ones at the end; *last is the last free node that stays, < 0 = none. */
static int nodes_in_use(const Tree *t, int32_t *last)
{
    int32_t run = -1, before_run = -1, previous = -1;
    for (int32_t i = t->free; i >= 0; i = t->nodes[i].parent) {
        if (run < 0 || i != previous + 1) {
            run = i;
            before_run = previous;
        }
        previous = i;
    }
    bool unused = previous >= 0 && previous == t->capacity - 1;
    *last = unused ? before_run : previous;
    return unused ? run : t->capacity;
}

static void write_node(Pack *p, const TreeNode *from, bool end)
{
    TreeNode n = *from;
    uint8_t kind = kind_of(&n);
    pack_u8(p, &kind);
    if (kind == NODE_LEAF) {
        pack_u32(p, &n.user);
        pack_vec3(p, &n.box.low, 0, "");
        pack_vec3(p, &n.box.high, 0, "");
    } else if (kind == NODE_BRANCH) {
        pack_i32(p, &n.child[0]);
        pack_i32(p, &n.child[1]);
    } else {
        n.parent = end ? -1 : n.parent;
        pack_i32(p, &n.parent);
    }
}

static void write_tree(Pack *p, const Tree *t)
{
    int32_t last, root = t->root;
    int count = nodes_in_use(t, &last);
    int32_t first_free = last < 0 ? -1 : t->free;
    pack_count(p, (uint32_t)count, NODE_BYTES, "boxes");
    pack_i32(p, &root);
    pack_i32(p, &first_free);
    for (int i = 0; i < count; i++)
        write_node(p, &t->nodes[i], i == last);
}

/* ---- reading ---- */

static void read_node(Pack *p, TreeNode *n, uint32_t users)
{
    uint8_t kind = 0;
    *n = (TreeNode){.parent = -1, .child = {-1, -1}, .height = -1};
    pack_small(p, &kind, NODE_KINDS, "kind of a box");
    if (kind == NODE_LEAF) {
        n->height = 0;
        pack_index(p, &n->user, users, false, "solid in a box");
        pack_vec3(p, &n->box.low, 1e31, "box");
        pack_vec3(p, &n->box.high, 1e31, "box");
        pack_check(p, n->box.low.x <= n->box.high.x && n->box.low.y <= n->box.high.y && n->box.low.z <= n->box.high.z, "a box is inside out");
    } else if (kind == NODE_BRANCH) {
        n->height = 1;
        pack_i32(p, &n->child[0]);
        pack_i32(p, &n->child[1]);
    } else {
        pack_i32(p, &n->parent);
    }
}

/* Gives every child its parent. Each node has one parent at most and the root none, so that what is below the root is a tree. */
static bool hang_children(Tree *t)
{
    for (int32_t i = 0; i < t->capacity; i++)
        for (int k = 0; t->nodes[i].height > 0 && k < 2; k++) {
            int32_t c = t->nodes[i].child[k];
            if (c < 0 || c >= t->capacity || c == t->root || t->nodes[c].height < 0 || t->nodes[c].parent >= 0)
                return false;
            t->nodes[c].parent = i;
        }
    return true;
}

/* All nodes below the root, parents before children; returns their number. */
static int list_nodes(const Tree *t, int32_t *order)
{
    int count = 0;
    if (t->root >= 0)
        order[count++] = t->root;
    for (int i = 0; i < count; i++)
        for (int k = 0; t->nodes[order[i]].height > 0 && k < 2; k++)
            order[count++] = t->nodes[order[i]].child[k];
    return count;
}

static void derive_branches(Tree *t, const int32_t *order)
{
    for (int i = t->count - 1; i >= 0; i--) {
        TreeNode *n = &t->nodes[order[i]];
        if (n->height == 0)
            continue;
        const TreeNode *a = &t->nodes[n->child[0]], *b = &t->nodes[n->child[1]];
        n->box = box3_union(a->box, b->box);
        n->height = 1 + int_max(a->height, b->height);
    }
}

/* Is the free list as long as there are free nodes, and ends? Free nodes keep the next one in `parent`. */
static bool free_list_is_sound(const Tree *t, int unused)
{
    int count = 0;
    for (int32_t i = t->free; i != -1; i = t->nodes[i].parent)
        if (i < 0 || i >= t->capacity || t->nodes[i].height >= 0 || ++count > unused)
            return false;
    return count == unused;
}

static bool connect(Pack *p, Tree *t)
{
    int used = 0;
    for (int i = 0; i < t->capacity; i++)
        used += t->nodes[i].height >= 0;
    if (t->root < -1 || t->root >= t->capacity || (t->root >= 0 && t->nodes[t->root].height < 0))
        return false;
    if (!free_list_is_sound(t, t->capacity - used) || !hang_children(t))
        return false;
    int32_t *order = malloc(((size_t)used + 1) * sizeof *order);
    if (!order) {
        pack_fail_memory(p);
        return false;
    }
    t->count = list_nodes(t, order);
    bool whole = t->count == used;
    if (whole)
        derive_branches(t, order);
    free(order);
    return whole;
}

static void read_tree(Pack *p, Tree *t, uint32_t users)
{
    uint32_t count = pack_count(p, 0, NODE_BYTES, "boxes");
    int32_t root = -1, first_free = -1;
    pack_i32(p, &root);
    pack_i32(p, &first_free);
    if (!pack_good(p))
        return;
    t->nodes = block_resize(NULL, 0, (size_t)count * sizeof *t->nodes);      /* as the tree itself grows and closes it */
    if (count > 0 && !t->nodes) {
        pack_fail_memory(p);
        return;
    }
    t->capacity = (int)count;
    t->root = root;
    t->free = first_free;
    for (uint32_t i = 0; i < count && pack_good(p); i++)
        read_node(p, &t->nodes[i], users);
    if (!pack_good(p) || !connect(p, t)) {
        pack_fail(p, "the boxes are no tree");
        tree_close(t);
    }
}

void tree_pack(Pack *p, Tree *t, uint32_t users)
{
    if (p->reading)
        read_tree(p, t, users);
    else
        write_tree(p, t);
}
