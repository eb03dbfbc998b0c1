/* lua/pattern.h - Lua's patterns (manual of Lua 5.4, section 6.4.1), compiled and matched without recursion.
 *
 * A pattern becomes a list of items; an item is one character class with its repetition, the edge of a capture, or one of %b, %f,
 * %1 and $. Since nothing but single classes repeats, a match goes through the items once from left to right, and at most one way
 * back is kept for each: the matcher needs no C stack, and no more memory than the pattern. Every step is counted, so that the
 * caller can stop a match that takes for ever.
 */
#ifndef DIGBOX_PATTERN_H
#define DIGBOX_PATTERN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { PATTERN_CAPTURES = 32 };

typedef enum ItemKind {
    ITEM_ONE, ITEM_MANY, ITEM_SOME, ITEM_FEW, ITEM_MAYBE,       /* class; class*; class+; class-; class? */
    ITEM_OPEN, ITEM_CLOSE, ITEM_PLACE,                          /* of a capture; ()                      */
    ITEM_SAME, ITEM_BALANCE, ITEM_FRONTIER, ITEM_END            /* %1; %bxy; %f[set]; $ at the end       */
} ItemKind;

typedef struct PatternItem {
    uint64_t set[4];            /* one bit a character                                           */
    ItemKind kind;
    unsigned char capture;      /* its index, 0 where there is none                              */
    unsigned char a, b;         /* the two characters of %b                                      */
} PatternItem;

typedef struct PatternBack {    /* what an item still can try: */
    size_t least, at;           /* greedy: to end earlier than `at`, down to `least`; lazy: to take one more at `at` */
} PatternBack;

typedef struct PatternCapture {
    size_t    start;
    ptrdiff_t length;           /* or one of: */
} PatternCapture;
enum { CAPTURE_OPEN = -1, CAPTURE_PLACE = -2 };

typedef struct Pattern {
    PatternItem *items;
    PatternBack *back;          /* [count]: room for one way back an item */
    size_t       count;
    bool         anchored;      /* ^ at the start */
    bool         complex;       /* more choices than could be tried: not to be matched */
    int          capture_count;
} Pattern;

typedef struct PatternMatch {
    const char *text;
    size_t      length;
    size_t      start, end;     /* of the whole match, 0-based, end exclusive */
    PatternCapture captures[PATTERN_CAPTURES];
    size_t      steps;          /* since the last call of `charge`                                          */
    void      (*charge)(void *data, size_t steps);      /* may leave with longjmp */
    void       *data;
} PatternMatch;

/* Items that a pattern of so many bytes can need. */
static inline size_t pattern_room(size_t length) { return length + 1; }

/* Fills `items` and the rest of p (not back). Returns NULL, or what is wrong with the pattern. ^ is a plain character unless
 * `anchors`. */
const char *pattern_compile(Pattern *p, const char *text, size_t length, bool anchors);

/* Matches with the first item at `from`: true and m->start, end, captures. */
bool pattern_match_at(const Pattern *p, PatternMatch *m, size_t from);

/* The first match at `from` or later (only there when anchored). */
bool pattern_find(const Pattern *p, PatternMatch *m, size_t from);

#endif
