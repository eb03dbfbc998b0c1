/* base/forest.h - disjoint sets of numbers 0, 1, ...: parent[i] is another of the same set, or i at its root.
 *
 * Floor: base.
 */
#ifndef DIG_FOREST_H
#define DIG_FOREST_H

static inline int forest_root(const int *parent, int i)
{
    while (parent[i] != i)
        i = parent[i];
    return i;
}

/* One set of two; the lower root stays. */
static inline void forest_unite(int *parent, int a, int b)
{
    a = forest_root(parent, a);
    b = forest_root(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

#endif
