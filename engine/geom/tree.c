/* geom/tree.c - the dynamic tree of bounding boxes: insertion by least surface, rotations on the way up, queries. */
#include "geom/tree.h"

#include "base/block.h"
#include "math/pair.h"

/* Half the surface of a box, the measure of how often it is met. */
static real area_of(box3 b)
{
    vec3 d = vec3_sub(b.high, b.low);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

static bool is_leaf(const TreeNode *n) { return n->child[0] < 0; }

void tree_open(Tree *t)
{
    *t = (Tree){.root = -1, .free = -1};
}

void tree_close(Tree *t)
{
    block_free(t->nodes, (size_t)t->capacity * sizeof *t->nodes);
    tree_open(t);
}

/* From here on there is room for so many. New ones join the end of the free list, so that which number comes next does not depend
 * on when the array grew. */
static void add_free(Tree *t, int capacity)
{
    for (int i = t->capacity; i < capacity; i++)
        t->nodes[i] = (TreeNode){.parent = i + 1 < capacity ? i + 1 : -1, .child = {-1, -1}, .height = -1};
    int32_t *last = &t->free;
    while (*last >= 0)
        last = &t->nodes[*last].parent;
    *last = t->capacity < capacity ? t->capacity : -1;
    t->capacity = capacity;
}

/* Room for `capacity` nodes in all. */
static dig_status grow_to(Tree *t, int capacity)
{
    if (capacity <= t->capacity)
        return DIG_OK;
    TreeNode *nodes = block_resize(t->nodes, (size_t)t->capacity * sizeof *nodes, (size_t)capacity * sizeof *nodes);
    if (!nodes)
        return DIG_E_MEMORY;
    t->nodes = nodes;
    add_free(t, capacity);
    return DIG_OK;
}

dig_status tree_reserve(Tree *t, int leaves)
{
    return leaves > 0 ? grow_to(t, 2 * leaves) : DIG_OK;
}

static int32_t take_node(Tree *t)
{
    int32_t i = t->free;
    t->free = t->nodes[i].parent;
    t->nodes[i] = (TreeNode){.parent = -1, .child = {-1, -1}};
    t->count++;
    return i;
}

static void give_node(Tree *t, int32_t i)
{
    t->nodes[i] = (TreeNode){.parent = t->free, .child = {-1, -1}, .height = -1};
    t->free = i;
    t->count--;
}

/* Two boxes side by side. */
typedef struct Boxes { pair low_x, low_y, low_z, high_x, high_y, high_z; } Boxes;

INLINE Boxes boxes_of(const box3 *a, const box3 *b)
{
    return (Boxes){{a->low.x, b->low.x}, {a->low.y, b->low.y}, {a->low.z, b->low.z}, {a->high.x, b->high.x}, {a->high.y, b->high.y}, {a->high.z, b->high.z}};
}
INLINE Boxes boxes_union(Boxes a, Boxes b)
{
    return (Boxes){pair_min(a.low_x, b.low_x), pair_min(a.low_y, b.low_y), pair_min(a.low_z, b.low_z),
                   pair_max(a.high_x, b.high_x), pair_max(a.high_y, b.high_y), pair_max(a.high_z, b.high_z)};
}
/* As area_of. */
INLINE pair boxes_area(Boxes b)
{
    pair x = b.high_x - b.low_x, y = b.high_y - b.low_y, z = b.high_z - b.low_z;
    return x * y + y * z + z * x;
}

/* Bit k: the boxes of lane k overlap. Without branches: which side parts two boxes of a tree is anybody's guess. */
INLINE int boxes_meet(Boxes a, Boxes b)
{
    return pair_bits((a.low_x <= b.high_x) & (b.low_x <= a.high_x) & (a.low_y <= b.high_y) & (b.low_y <= a.high_y) &
                     (a.low_z <= b.high_z) & (b.low_z <= a.high_z));
}

/* The node to become the leaf's sibling: goes down as long as the surface added on the way and below is less than the
 * surface of a new parent here. */
static int32_t best_sibling(const Tree *t, box3 box)
{
    int32_t i = t->root;
    const Boxes leaf = boxes_of(&box, &box);
    real area = area_of(t->nodes[i].box), joined = area_of(box3_union(t->nodes[i].box, box));
    while (!is_leaf(&t->nodes[i])) {
        const TreeNode *n = &t->nodes[i], *a = &t->nodes[n->child[0]], *b = &t->nodes[n->child[1]];
        const Boxes both = boxes_of(&a->box, &b->box);
        pair own = boxes_area(both), with = boxes_area(boxes_union(both, leaf));
        own = (pair){is_leaf(a) ? 0 : own[0], is_leaf(b) ? 0 : own[1]};         /* a leaf would get a new parent */
        pair cost = pair_all(joined - area) + (with - own);
        int k = cost[1] < cost[0];
        if (joined <= (k ? cost[1] : cost[0]))
            break;
        joined = k ? with[1] : with[0];
        area = k ? own[1] : own[0];
        i = n->child[k];
    }
    return i;
}

static bool same_box(box3 a, box3 b) { return vec3_equal(a.low, b.low) && vec3_equal(a.high, b.high); }

/* Returns whether anything has changed. */
static bool refit(Tree *t, int32_t i)
{
    TreeNode *n = &t->nodes[i];
    const TreeNode *a = &t->nodes[n->child[0]], *b = &t->nodes[n->child[1]];
    box3 box = box3_union(a->box, b->box);
    int32_t height = 1 + int_max(a->height, b->height);
    bool changed = height != n->height || !same_box(box, n->box);
    n->box = box;
    n->height = height;
    return changed;
}

/* Exchanges a child of `top` with a grandchild on its other side where that makes the inner box smaller. */
static void rotate(Tree *t, int32_t top)
{
    TreeNode *n = t->nodes;
    real most = 0;
    int side = -1, which = -1;

    for (int k = 0; k < 2; k++) {
        const TreeNode *inner = &n[n[top].child[k]];
        const box3 *other = &n[n[top].child[1 - k]].box;
        if (is_leaf(inner))
            continue;
        const Boxes stays = boxes_of(&n[inner->child[1]].box, &n[inner->child[0]].box);
        const pair gain = pair_all(area_of(inner->box)) - boxes_area(boxes_union(stays, boxes_of(other, other)));
        for (int g = 0; g < 2; g++)             /* grandchild g goes up, `other` takes its place */
            if (gain[g] > most) {
                most = gain[g];
                side = k;
                which = g;
            }
    }
    if (side < 0)
        return;
    int32_t inner = n[top].child[side], other = n[top].child[1 - side], up = n[inner].child[which];
    n[top].child[1 - side] = up;
    n[up].parent = top;
    n[inner].child[which] = other;
    n[other].parent = inner;
    refit(t, inner);
    refit(t, top);
}

/* As far as anything changes: what is above has seen to that before. A rotation keeps the box of its top, but not the height. */
static void repair_upwards(Tree *t, int32_t i)
{
    for (bool changed = true; i >= 0 && changed; i = t->nodes[i].parent) {
        int32_t height = t->nodes[i].height;
        changed = refit(t, i);
        rotate(t, i);
        changed = changed || t->nodes[i].height != height;
    }
}

/* Puts `child` where `old` hangs below `parent`, or at the root. */
static void replace_child(Tree *t, int32_t parent, int32_t old, int32_t child)
{
    t->nodes[child].parent = parent;
    if (parent < 0)
        t->root = child;
    else
        t->nodes[parent].child[t->nodes[parent].child[0] == old ? 0 : 1] = child;
}

/* Takes one free node unless the tree is empty. */
static void link_leaf(Tree *t, int32_t leaf)
{
    if (t->root < 0) {
        t->root = leaf;
        t->nodes[leaf].parent = -1;
        return;
    }
    int32_t sibling = best_sibling(t, t->nodes[leaf].box), parent = take_node(t);
    replace_child(t, t->nodes[sibling].parent, sibling, parent);
    t->nodes[parent].child[0] = sibling;
    t->nodes[parent].child[1] = leaf;
    t->nodes[sibling].parent = parent;
    t->nodes[leaf].parent = parent;
    repair_upwards(t, parent);
}

static void unlink_leaf(Tree *t, int32_t leaf)
{
    int32_t parent = t->nodes[leaf].parent;
    if (parent < 0) {
        t->root = -1;
        return;
    }
    int32_t sibling = t->nodes[parent].child[t->nodes[parent].child[0] == leaf ? 1 : 0];
    int32_t above = t->nodes[parent].parent;
    replace_child(t, above, parent, sibling);
    give_node(t, parent);
    repair_upwards(t, above);
}

dig_status tree_insert(Tree *t, box3 box, uint32_t user, int32_t *leaf)
{
    if (t->count + 2 > t->capacity)
        DIG_TRY(grow_to(t, int_max(16, 2 * t->capacity)));
    int32_t i = take_node(t);
    t->nodes[i].box = box;
    t->nodes[i].user = user;
    link_leaf(t, i);
    *leaf = i;
    return DIG_OK;
}

void tree_remove(Tree *t, int32_t leaf)
{
    unlink_leaf(t, leaf);
    give_node(t, leaf);
}

/* So many of its lengths may a leaf go on from where it was inserted, about. */
#define HOME 1

static bool same_cell(real a, real b, real pitch) { return floor(a / pitch) == floor(b / pitch); }

/* Is a box still at the place of the tree where it was inserted? Its neighbours mostly go the same way, so that it may stay there for
 * a while. Who mixes with others must be inserted anew, or the boxes above grow: as often as the middle leaves a cell of a grid. */
static bool stays_home(box3 before, box3 now)
{
    int exponent = 0;
    vec3 a = vec3_add(before.low, before.high), b = vec3_add(now.low, now.high);
    if (!box3_overlap(before, now))
        return false;
    frexp(2 * HOME * vec3_largest(vec3_sub(now.high, now.low)), &exponent);
    real pitch = ldexp(1, exponent);
    return same_cell(a.x, b.x, pitch) && same_cell(a.y, b.y, pitch) && same_cell(a.z, b.z, pitch);
}

void tree_move(Tree *t, int32_t leaf, box3 box)
{
    if (stays_home(t->nodes[leaf].box, box)) {
        t->nodes[leaf].box = box;
        repair_upwards(t, t->nodes[leaf].parent);
        return;
    }
    unlink_leaf(t, leaf);               /* frees the parent that link_leaf takes again */
    t->nodes[leaf].box = box;
    link_leaf(t, leaf);
}

/* The next node depth-first when nothing below i is of interest: parents lead the way, so no stack can overflow. */
static int32_t after(const Tree *t, int32_t i)
{
    for (;;) {
        int32_t parent = t->nodes[i].parent;
        if (parent < 0)
            return -1;
        if (t->nodes[parent].child[0] == i)
            return t->nodes[parent].child[1];
        i = parent;
    }
}

/* As box3_overlap, without branches. */
static bool meets(const TreeNode *n, const box3 *box)
{
    return (n->box.low.x <= box->high.x) & (box->low.x <= n->box.high.x) & (n->box.low.y <= box->high.y) & (box->low.y <= n->box.high.y) &
           (n->box.low.z <= box->high.z) & (box->low.z <= n->box.high.z);
}

/* Three times log2 of the leaves, which no tree of the tests exceeds, of some 2.6 million of them. Higher ones are asked without a stack. */
#define QUERY_HEIGHT 64

/* Both children are looked at from their parent, so that their lines come from memory together. In the order of query_high. */
static void query_low(const Tree *t, box3 box, TreeHit *hit, void *context)
{
    int32_t later[QUERY_HEIGHT], i = t->root;
    const Boxes wanted = boxes_of(&box, &box);
    int count = 0;
    while (i >= 0) {
        const TreeNode *n = &t->nodes[i];
        bool leaf = is_leaf(n);
        if (leaf && !hit(context, n->user))
            return;
        int met = leaf ? 0 : boxes_meet(boxes_of(&t->nodes[n->child[0]].box, &t->nodes[n->child[1]].box), wanted);
        if (met == 3)
            later[count++] = n->child[1];
        i = met & 1 ? n->child[0] : met ? n->child[1] : count > 0 ? later[--count] : -1;
    }
}

static void query_high(const Tree *t, box3 box, TreeHit *hit, void *context)
{
    int32_t i = t->root;
    while (i >= 0) {
        const TreeNode *n = &t->nodes[i];
        bool met = meets(n, &box);
        if (met && !is_leaf(n)) {
            i = n->child[0];
            continue;
        }
        if (met && !hit(context, n->user))
            return;
        i = after(t, i);
    }
}

void tree_query(const Tree *t, box3 box, TreeHit *hit, void *context)
{
    if (t->root < 0 || !meets(&t->nodes[t->root], &box))
        return;
    (t->nodes[t->root].height < QUERY_HEIGHT ? query_low : query_high)(t, box, hit, context);
}

/* Does the ray pass the box within its length? Slabs; an axis the ray does not move along only needs to start inside. */
static bool ray_meets(box3 b, vec3 from, vec3 along, real length)
{
    real enter = 0, leave = length;
    for (int k = 0; k < 3; k++) {
        real o = vec3_at(from, k), d = vec3_at(along, k), low = vec3_at(b.low, k), high = vec3_at(b.high, k);
        if (d == 0) {
            if (o < low || o > high)
                return false;
            continue;
        }
        real t0 = (low - o) / d, t1 = (high - o) / d;
        enter = real_max(enter, real_min(t0, t1));
        leave = real_min(leave, real_max(t0, t1));
    }
    return enter <= leave * (1 + 4e-16);        /* rounding of the quotients must not lose a box of no thickness */
}

void tree_ray(const Tree *t, vec3 from, vec3 along, real length, TreeRayHit *hit, void *context)
{
    int32_t i = t->root;
    while (i >= 0) {
        const TreeNode *n = &t->nodes[i];
        bool meets = ray_meets(n->box, from, along, length);
        if (meets && !is_leaf(n)) {
            i = n->child[0];
            continue;
        }
        if (meets && !hit(context, n->user, &length))
            return;
        i = after(t, i);
    }
}

static bool check_inner(const Tree *t, int32_t i)
{
    const TreeNode *n = &t->nodes[i];
    for (int k = 0; k < 2; k++) {
        int32_t c = n->child[k];
        if (c < 0 || c >= t->capacity || t->nodes[c].parent != i || !box3_inside(n->box, t->nodes[c].box))
            return false;
    }
    const TreeNode *a = &t->nodes[n->child[0]], *b = &t->nodes[n->child[1]];
    box3 both = box3_union(a->box, b->box);
    return n->child[0] != n->child[1] && n->height == 1 + int_max(a->height, b->height) && vec3_equal(both.low, n->box.low) &&
           vec3_equal(both.high, n->box.high);
}

bool tree_check(const Tree *t)
{
    int seen = 0, unused = 0, inner = 0;
    if (t->root >= 0 && (t->root >= t->capacity || t->nodes[t->root].parent != -1))
        return false;
    for (int32_t i = t->root; i >= 0;) {
        const TreeNode *n = &t->nodes[i];
        if (++seen > t->count)
            return false;
        if (is_leaf(n)) {
            if (n->height != 0)
                return false;
            i = after(t, i);
            continue;
        }
        inner++;
        if (!check_inner(t, i))
            return false;
        i = n->child[0];
    }
    for (int32_t i = t->free; i >= 0; i = t->nodes[i].parent)
        if (i >= t->capacity || ++unused > t->capacity || t->nodes[i].height != -1)
            return false;
    return seen == t->count && seen + unused == t->capacity && (seen == 0 || seen == 2 * inner + 1);
}

dig_status tree_copy(Tree *to, const Tree *from)
{
    int capacity = int_max(to->capacity, from->capacity);
    DIG_TRY(grow_to(to, capacity));             /* every node is written anew */
    if (from->capacity > 0)
        memcpy(to->nodes, from->nodes, (size_t)from->capacity * sizeof *to->nodes);
    to->capacity = from->capacity;
    to->count = from->count;
    to->root = from->root;
    to->free = from->free;
    add_free(to, capacity);
    return DIG_OK;
}
