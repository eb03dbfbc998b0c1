/* geom/tree.h - a dynamic tree of bounding boxes: which boxes may overlap.
 *
 * Incremental insertion by least surface growth with rotations (as described by
 * Catto, GDC 2019, "Dynamic bounding volume hierarchies"). Leaves hold fat boxes: the caller decides how fat.
 *
 * Owns:      its nodes, one array that may move when it grows (tree_reserve, tree_insert).
 * Invariant: the shape of the tree depends only on the sequence of calls. No allocation in tree_move and tree_query.
 * Floor:     geom.
 */
#ifndef DIG_TREE_H
#define DIG_TREE_H

#include "math/vec.h"

typedef struct TreeNode {       /* 64 bytes: a line of the cache */
    box3    box;
    int32_t parent;
    union {
        int32_t child[2];       /* child[0] < 0 for a leaf */
        struct { int32_t none; uint32_t user; };        /* of a leaf: none < 0, and the caller's number */
    };
    int32_t height;             /* 0: a leaf, -1: a free node; these chain through parent */
} TreeNode;

typedef struct Tree {
    TreeNode *nodes;
    int       capacity, count, root, free;      /* count: nodes in use, 2 leaves - 1; root < 0 = empty */
} Tree;

void       tree_open(Tree *t);
void       tree_close(Tree *t);
dig_status tree_reserve(Tree *t, int leaves);
dig_status tree_insert(Tree *t, box3 box, uint32_t user, int32_t *leaf);
void       tree_remove(Tree *t, int32_t leaf);
void       tree_move(Tree *t, int32_t leaf, box3 box);          /* in place, or removed and inserted anew where the boxes are apart */
static inline box3 tree_box(const Tree *t, int32_t leaf) { return t->nodes[leaf].box; }

/* Calls hit(context, user) for every leaf whose box meets `box`; stops when it returns false. Depth-first, in a fixed order. */
typedef bool TreeHit(void *context, uint32_t user);
void       tree_query(const Tree *t, box3 box, TreeHit *hit, void *context);

/* Leaves whose box meets the ray; hit may shorten it by writing *length. */
typedef bool TreeRayHit(void *context, uint32_t user, real *length);
void       tree_ray(const Tree *t, vec3 from, vec3 along, real length, TreeRayHit *hit, void *context);

/* Every structural invariant, for tests. */
bool       tree_check(const Tree *t);
dig_status tree_copy(Tree *to, const Tree *from);               /* same nodes, same indices */

#endif
