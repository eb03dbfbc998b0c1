/* lua/pattern.c - Lua's patterns, compiled and matched without recursion. */

#include "pattern.h"

#include <ctype.h>
#include <string.h>

enum { CHARGE_EVERY = 4096 };
enum { CHOICES = 200 };         /* repetitions in a pattern: more could not be matched in any time */

/* ---- sets of characters ------------------------------------------------------------ */

static inline bool set_has(const PatternItem *i, unsigned char c)
{
    return i->set[c >> 6] >> (c & 63) & 1;
}

static void set_add(PatternItem *i, unsigned char c)
{
    i->set[c >> 6] |= (uint64_t)1 << (c & 63);
}

static void set_invert(PatternItem *i)
{
    for (int k = 0; k < 4; k++)
        i->set[k] = ~i->set[k];
}

static int in_zero(int c) { return c == 0; }

/* What follows %: a class by its letter (a capital letter is its complement), or the character itself. */
static void set_add_class(PatternItem *i, unsigned char letter)
{
    static const struct { char letter; int (*is)(int); } classes[] = {
        {'a', isalpha}, {'c', iscntrl}, {'d', isdigit}, {'g', isgraph}, {'l', islower}, {'p', ispunct},
        {'s', isspace}, {'u', isupper}, {'w', isalnum}, {'x', isxdigit}, {'z', in_zero},
    };
    for (size_t k = 0; k < sizeof classes / sizeof *classes; k++) {
        if (tolower(letter) != classes[k].letter)
            continue;
        for (int c = 0; c < 256; c++)
            if ((classes[k].is(c) != 0) == (islower(letter) != 0))
                set_add(i, (unsigned char)c);
        return;
    }
    set_add(i, letter);
}

/* ---- compiling ------------------------------------------------------------------------ */

typedef struct Reader { const unsigned char *p, *end; } Reader;

/* After [. The first ] is a plain character; a range has a plain character on both sides. */
static const char *read_set(Reader *r, PatternItem *i)
{
    bool inverted = r->p < r->end && *r->p == '^', first = true;
    r->p += inverted;
    for (;; first = false) {
        if (r->p == r->end)
            return "malformed pattern (missing ']')";
        unsigned char c = *r->p++;
        if (c == ']' && !first)
            break;
        if (c == '%') {
            if (r->p == r->end)
                return "malformed pattern (missing ']')";
            set_add_class(i, *r->p++);
        } else if (r->end - r->p >= 2 && r->p[0] == '-' && r->p[1] != ']') {
            for (int k = c; k <= r->p[1]; k++)
                set_add(i, (unsigned char)k);
            r->p += 2;
        } else {
            set_add(i, c);
        }
    }
    if (inverted)
        set_invert(i);
    return NULL;
}

static const char *read_class(Reader *r, PatternItem *i)
{
    unsigned char c = *r->p++;
    if (c == '.') {
        set_invert(i);
    } else if (c == '[') {
        return read_set(r, i);
    } else if (c == '%') {
        if (r->p == r->end)
            return "malformed pattern (ends with '%')";
        set_add_class(i, *r->p++);
    } else {
        set_add(i, c);
    }
    return NULL;
}

static const char *read_single(Reader *r, PatternItem *i)
{
    const char *wrong = read_class(r, i);
    if (wrong)
        return wrong;
    i->kind = ITEM_ONE;
    if (r->p < r->end && *r->p && strchr("*+-?", *r->p))
        switch (*r->p++) {
        case '*': i->kind = ITEM_MANY; break;
        case '+': i->kind = ITEM_SOME; break;
        case '-': i->kind = ITEM_FEW; break;
        default: i->kind = ITEM_MAYBE; break;
        }
    return NULL;
}

typedef struct Captures {       /* while compiling */
    int  count;
    bool open[PATTERN_CAPTURES];
} Captures;

static const char *read_open(Reader *r, PatternItem *i, Captures *c)
{
    if (c->count == PATTERN_CAPTURES)
        return "too many captures";
    i->capture = (unsigned char)c->count;
    i->kind = r->p + 1 < r->end && r->p[1] == ')' ? ITEM_PLACE : ITEM_OPEN;
    r->p += i->kind == ITEM_PLACE ? 2 : 1;
    c->open[c->count++] = i->kind == ITEM_OPEN;
    return NULL;
}

static const char *read_close(Reader *r, PatternItem *i, Captures *c)
{
    int k = c->count - 1;
    while (k >= 0 && !c->open[k])
        k--;
    if (k < 0)
        return "invalid pattern capture";
    c->open[k] = false;
    i->kind = ITEM_CLOSE;
    i->capture = (unsigned char)k;
    r->p++;
    return NULL;
}

/* %b, %f and %1 to %9; any other % is a class. *taken says whether it was one of them. */
static const char *read_special(Reader *r, PatternItem *i, const Captures *c, bool *taken)
{
    unsigned char what = r->end - r->p >= 2 ? r->p[1] : 0;
    *taken = true;
    if (what == 'b') {
        if (r->end - r->p < 4)
            return "malformed pattern (missing arguments to '%b')";
        i->kind = ITEM_BALANCE;
        i->a = r->p[2];
        i->b = r->p[3];
        r->p += 4;
    } else if (what == 'f') {
        r->p += 2;
        if (r->p == r->end || *r->p != '[')
            return "missing '[' after '%f' in pattern";
        i->kind = ITEM_FRONTIER;
        r->p++;
        return read_set(r, i);
    } else if (what >= '0' && what <= '9') {
        int k = what - '1';
        if (k < 0 || k >= c->count || c->open[k])
            return "invalid capture index in pattern";
        i->kind = ITEM_SAME;
        i->capture = (unsigned char)k;
        r->p += 2;
    } else {
        *taken = false;
    }
    return NULL;
}

static const char *read_item(Reader *r, PatternItem *i, Captures *c)
{
    bool taken = false;
    const char *wrong = NULL;
    if (*r->p == '(')
        return read_open(r, i, c);
    if (*r->p == ')')
        return read_close(r, i, c);
    if (*r->p == '$' && r->p + 1 == r->end) {
        i->kind = ITEM_END;
        r->p++;
        return NULL;
    }
    if (*r->p == '%')
        wrong = read_special(r, i, c, &taken);
    return taken ? wrong : read_single(r, i);
}

const char *pattern_compile(Pattern *p, const char *text, size_t length, bool anchors)
{
    Reader r = {(const unsigned char *)text, (const unsigned char *)text + length};
    Captures c = {0, {false}};
    p->count = 0;
    p->complex = false;
    p->anchored = anchors && length > 0 && text[0] == '^';
    r.p += p->anchored;
    for (int choices = 0; r.p < r.end; ) {
        PatternItem *i = &p->items[p->count++];
        memset(i, 0, sizeof *i);
        const char *wrong = read_item(&r, i, &c);
        choices += i->kind >= ITEM_MANY && i->kind <= ITEM_MAYBE;
        if (wrong)
            return wrong;
        p->complex = choices > CHOICES;
    }
    p->capture_count = c.count;
    for (int k = 0; k < c.count; k++)
        if (c.open[k])
            return "unfinished capture";
    return NULL;
}

/* ---- matching -------------------------------------------------------------------------- */

static inline void count_steps(PatternMatch *m, size_t steps)
{
    m->steps += steps;
    if (m->steps >= CHARGE_EVERY) {
        steps = m->steps;
        m->steps = 0;
        m->charge(m->data, steps);
    }
}

/* How many characters of the set follow, `most` at most. */
static size_t run_length(const PatternItem *i, PatternMatch *m, size_t at, size_t most)
{
    size_t n = 0;
    while (n < most && at + n < m->length && set_has(i, (unsigned char)m->text[at + n]))
        n++;
    count_steps(m, n);
    return n;
}

/* Where the balanced text that starts at `at` ends, or 0. */
static size_t balance(const PatternItem *i, PatternMatch *m, size_t at)
{
    size_t depth = 0;
    if (at >= m->length || (unsigned char)m->text[at] != i->a)
        return 0;
    for (size_t k = at; k < m->length; k++) {
        unsigned char c = (unsigned char)m->text[k];
        if (c == i->b && k > at) {
            if (--depth == 0) {
                count_steps(m, k - at);
                return k + 1;
            }
        } else if (c == i->a) {
            depth++;
        }
        if ((k & (CHARGE_EVERY - 1)) == 0)
            count_steps(m, CHARGE_EVERY);
    }
    return 0;
}

static bool at_frontier(const PatternItem *i, const PatternMatch *m, size_t at)
{
    unsigned char before = at > 0 ? (unsigned char)m->text[at - 1] : 0, after = at < m->length ? (unsigned char)m->text[at] : 0;
    return !set_has(i, before) && set_has(i, after);
}

/* The items that match in one way only. */
static bool match_fixed(const PatternItem *i, PatternMatch *m, size_t *at)
{
    const PatternCapture *c = &m->captures[i->capture];
    size_t end;
    switch (i->kind) {
    case ITEM_ONE:
        if (*at >= m->length || !set_has(i, (unsigned char)m->text[*at]))
            return false;
        (*at)++;
        return true;
    case ITEM_SAME:
        if (c->length < 0 || (size_t)c->length > m->length - *at || memcmp(m->text + c->start, m->text + *at, (size_t)c->length) != 0)
            return false;
        count_steps(m, (size_t)c->length / 16);
        *at += (size_t)c->length;
        return true;
    case ITEM_BALANCE:
        end = balance(i, m, *at);
        *at = end ? end : *at;
        return end != 0;
    case ITEM_FRONTIER:
        return at_frontier(i, m, *at);
    default:                            /* ITEM_END */
        return *at == m->length;
    }
}

/* One item, and the way back that it leaves (none when `least` and `at` leave no choice). */
static bool match_item(const PatternItem *i, PatternMatch *m, size_t *at, PatternBack *back)
{
    PatternCapture *c = &m->captures[i->capture];
    size_t n;
    *back = (PatternBack){.least = *at, .at = *at};
    switch (i->kind) {
    case ITEM_OPEN:
    case ITEM_PLACE:
        *c = (PatternCapture){*at, i->kind == ITEM_OPEN ? CAPTURE_OPEN : CAPTURE_PLACE};
        return true;
    case ITEM_CLOSE:
        c->length = (ptrdiff_t)(*at - c->start);
        return true;
    case ITEM_MANY:
    case ITEM_SOME:
    case ITEM_MAYBE:
        n = run_length(i, m, *at, i->kind == ITEM_MAYBE ? 1 : SIZE_MAX);
        if (n == 0 && i->kind == ITEM_SOME)
            return false;
        back->least = *at + (i->kind == ITEM_SOME);
        *at += n;
        back->at = *at;
        return true;
    case ITEM_FEW:
        return true;
    default:
        return match_fixed(i, m, at);
    }
}

/* The next thing that an earlier item can try. */
static bool try_again(const PatternItem *i, const PatternMatch *m, PatternBack *back, size_t *at)
{
    switch (i->kind) {
    case ITEM_MANY:
    case ITEM_SOME:
    case ITEM_MAYBE:
        if (back->at <= back->least)
            return false;
        *at = --back->at;
        return true;
    case ITEM_FEW:
        if (back->at >= m->length || !set_has(i, (unsigned char)m->text[back->at]))
            return false;
        *at = ++back->at;
        return true;
    default:
        return false;
    }
}

/* The captures need no undoing: an item in front of a capture that tries again is followed by all items behind it anew, and a
 * capture's end is set before anything reads it. */
bool pattern_match_at(const Pattern *p, PatternMatch *m, size_t from)
{
    size_t at = from, k = 0;
    while (k < p->count) {
        count_steps(m, 1);
        bool fits = match_item(&p->items[k], m, &at, &p->back[k]);
        if (!fits) {
            do {
                if (k == 0)
                    return false;
                k--;
                count_steps(m, 1);
            } while (!try_again(&p->items[k], m, &p->back[k], &at));
        }
        k++;
    }
    m->start = from;
    m->end = at;
    return true;
}

bool pattern_find(const Pattern *p, PatternMatch *m, size_t from)
{
    for (; from <= m->length; from++) {
        count_steps(m, 1);
        if (pattern_match_at(p, m, from))
            return true;
        if (p->anchored)
            return false;
    }
    return false;
}
