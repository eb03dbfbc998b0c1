/* lua/lib_string.c - the library `string` of scripts (manual of Lua 5.4, section 6.4): patterns by pattern.c, and every loop over a
 * text charges fuel. format, pack, packsize and unpack are Lua's own, with their work charged before and no addresses. */

#include <ctype.h>
#include <limits.h>
#include <string.h>

#include "bind.h"
#include "pattern.h"
#include "sandbox.h"

enum { BYTES_A_UNIT = 16 };     /* that a simple loop handles in the time of an instruction */

/* ---- plain functions ------------------------------------------------------------------ */

/* Positions count from 1, or from the end when negative: to 0-based. */
static size_t start_of(lua_Integer position, size_t length)
{
    if (position > 0)
        return position - 1 > (lua_Integer)length ? length : (size_t)(position - 1);
    if (position == 0 || position < -(lua_Integer)length)
        return 0;
    return length - (size_t)-position;
}

static size_t end_of(lua_Integer position, size_t length)      /* exclusive */
{
    if (position >= 0)
        return position > (lua_Integer)length ? length : (size_t)position;
    return position < -(lua_Integer)length ? 0 : length - (size_t)-position + 1;
}

static int string_len(lua_State *L)
{
    size_t length;
    luaL_checklstring(L, 1, &length);
    lua_pushinteger(L, (lua_Integer)length);
    return 1;
}

static int string_sub(lua_State *L)
{
    size_t length;
    const char *s = luaL_checklstring(L, 1, &length);
    size_t start = start_of(luaL_checkinteger(L, 2), length), end = end_of(luaL_optinteger(L, 3, -1), length);
    app_charge(L, end > start ? (end - start) / BYTES_A_UNIT : 0);
    lua_pushlstring(L, s + start, end > start ? end - start : 0);
    return 1;
}

static int string_byte(lua_State *L)
{
    size_t length;
    const char *s = luaL_checklstring(L, 1, &length);
    lua_Integer first = luaL_optinteger(L, 2, 1);
    size_t start = start_of(first, length), end = end_of(luaL_optinteger(L, 3, first), length);
    if (start >= end)
        return 0;
    if (end - start >= INT_MAX)
        return luaL_error(L, "string slice too long");
    app_charge(L, end - start);
    luaL_checkstack(L, (int)(end - start), "string slice too long");
    for (size_t i = start; i < end; i++)
        lua_pushinteger(L, (unsigned char)s[i]);
    return (int)(end - start);
}

static int string_char(lua_State *L)
{
    int n = lua_gettop(L);
    luaL_Buffer b;
    app_charge(L, (size_t)n);
    char *out = luaL_buffinitsize(L, &b, (size_t)n);
    for (int i = 1; i <= n; i++) {
        lua_Integer c = luaL_checkinteger(L, i);
        luaL_argcheck(L, c >= 0 && c <= UCHAR_MAX, i, "value out of range");
        out[i - 1] = (char)c;
    }
    luaL_pushresultsize(&b, (size_t)n);
    return 1;
}

static int convert(lua_State *L, int (*to)(int))
{
    size_t length;
    const char *s = luaL_checklstring(L, 1, &length);
    luaL_Buffer b;
    app_charge(L, length / BYTES_A_UNIT);
    char *out = luaL_buffinitsize(L, &b, length);
    for (size_t i = 0; i < length; i++)
        out[i] = (char)to((unsigned char)s[i]);
    luaL_pushresultsize(&b, length);
    return 1;
}

static int string_lower(lua_State *L) { return convert(L, tolower); }
static int string_upper(lua_State *L) { return convert(L, toupper); }

static int string_reverse(lua_State *L)
{
    size_t length;
    const char *s = luaL_checklstring(L, 1, &length);
    luaL_Buffer b;
    app_charge(L, length / BYTES_A_UNIT);
    char *out = luaL_buffinitsize(L, &b, length);
    for (size_t i = 0; i < length; i++)
        out[i] = s[length - 1 - i];
    luaL_pushresultsize(&b, length);
    return 1;
}

static int string_rep(lua_State *L)
{
    size_t length, between;
    const char *s = luaL_checklstring(L, 1, &length);
    lua_Integer n = luaL_checkinteger(L, 2);
    const char *separator = luaL_optlstring(L, 3, "", &between);
    if (n <= 0 || length + between == 0) {
        lua_pushliteral(L, "");
        return 1;
    }
    const size_t most = (size_t)(LUA_MAXINTEGER < PTRDIFF_MAX ? LUA_MAXINTEGER : PTRDIFF_MAX);
    if (length + between < length || length + between > most / (size_t)n)
        return luaL_error(L, "resulting string too large");
    size_t total = (size_t)n * length + (size_t)(n - 1) * between;
    luaL_Buffer b;
    char *out = luaL_buffinitsize(L, &b, total);        /* what is too much ends here, before any work */
    app_charge(L, total / BYTES_A_UNIT + (size_t)n);
    memcpy(out, s, length);
    if (n > 1)
        memcpy(out + length, separator, between);
    for (size_t done = length + between; n > 1 && done < total; ) {         /* copies what there is: twice as much each time */
        size_t more = done < total - done ? done : total - done;
        memcpy(out + done, out, more);
        done += more;
    }
    luaL_pushresultsize(&b, total);
    return 1;
}

/* ---- patterns ---------------------------------------------------------------------------- */

static void charge_steps(void *data, size_t steps)
{
    app_charge(data, steps);
}

/* Compiles the pattern at `index`; pushes what holds its items. */
static void push_pattern(lua_State *L, int index, bool anchors, Pattern *p)
{
    size_t length;
    const char *text = luaL_checklstring(L, index, &length);
    size_t room = pattern_room(length);
    app_charge(L, room);
    char *block = lua_newuserdatauv(L, room * (sizeof(PatternItem) + sizeof(PatternBack)), 0);
    p->items = (PatternItem *)(void *)block;
    p->back = (PatternBack *)(void *)(block + room * sizeof(PatternItem));
    const char *wrong = pattern_compile(p, text, length, anchors);
    if (wrong)
        luaL_error(L, "%s", wrong);
}

static PatternMatch begin_match(lua_State *L, int index)
{
    PatternMatch m = {.charge = charge_steps, .data = L};
    m.text = luaL_checklstring(L, index, &m.length);
    return m;
}

static void check_pattern(lua_State *L, const Pattern *p)
{
    if (p->complex)
        luaL_error(L, "pattern too complex");
}

static void end_match(lua_State *L, PatternMatch *m)
{
    size_t steps = m->steps;
    m->steps = 0;
    app_charge(L, steps);
}

static void push_capture(lua_State *L, const Pattern *p, const PatternMatch *m, int k)
{
    if (k == 0 && p->capture_count == 0)
        lua_pushlstring(L, m->text + m->start, m->end - m->start);
    else if (m->captures[k].length == CAPTURE_PLACE)
        lua_pushinteger(L, (lua_Integer)m->captures[k].start + 1);
    else
        lua_pushlstring(L, m->text + m->captures[k].start, (size_t)m->captures[k].length);
}

/* All captures; the whole match when there are none and `whole`. */
static int push_captures(lua_State *L, const Pattern *p, const PatternMatch *m, bool whole)
{
    int n = p->capture_count == 0 && whole ? 1 : p->capture_count;
    luaL_checkstack(L, n, "too many captures");
    for (int k = 0; k < n; k++)
        push_capture(L, p, m, k);
    return n;
}

static bool is_plain(const char *pattern, size_t length)
{
    for (size_t i = 0; i < length; i++)
        if (pattern[i] && strchr("^$*+?.([%-", pattern[i]))
            return false;
    return true;
}

/* Where the text occurs at `from` or later, or NULL: by its first byte, then the rest. */
static const char *find_plain(lua_State *L, const char *s, size_t length, const char *what, size_t size)
{
    const char *end = s + length;
    if (size == 0)
        return s;
    while ((size_t)(end - s) >= size) {
        const char *p = memchr(s, what[0], (size_t)(end - s) - size + 1);
        app_charge(L, (size_t)((p ? p : end) - s) / BYTES_A_UNIT + 1);
        if (!p)
            return NULL;
        if (memcmp(p, what, size) == 0)
            return p;
        app_charge(L, size / BYTES_A_UNIT);
        s = p + 1;
    }
    return NULL;
}

static int find_or_match(lua_State *L, bool find)
{
    size_t size;
    PatternMatch m = begin_match(L, 1);
    const char *pattern = luaL_checklstring(L, 2, &size);
    lua_Integer given = luaL_optinteger(L, 3, 1);
    Pattern p;
    if (given > 0 && (lua_Unsigned)given - 1 > m.length) {
        luaL_pushfail(L);
        return 1;
    }
    size_t from = start_of(given, m.length);
    if (find && (lua_toboolean(L, 4) || is_plain(pattern, size))) {
        const char *at = find_plain(L, m.text + from, m.length - from, pattern, size);
        if (!at) {
            luaL_pushfail(L);
            return 1;
        }
        lua_pushinteger(L, at - m.text + 1);
        lua_pushinteger(L, at - m.text + (lua_Integer)size);
        return 2;
    }
    push_pattern(L, 2, true, &p);
    check_pattern(L, &p);
    bool found = pattern_find(&p, &m, from);
    end_match(L, &m);
    if (!found) {
        luaL_pushfail(L);
        return 1;
    }
    if (!find)
        return push_captures(L, &p, &m, true);
    lua_pushinteger(L, (lua_Integer)m.start + 1);
    lua_pushinteger(L, (lua_Integer)m.end);
    return 2 + push_captures(L, &p, &m, false);
}

static int string_find(lua_State *L)  { return find_or_match(L, true); }
static int string_match(lua_State *L) { return find_or_match(L, false); }

typedef struct Walk {           /* of gmatch: where it is */
    Pattern p;
    size_t  from, last;         /* last: where the last match ended; SIZE_MAX = there was none */
} Walk;

/* upvalues: the text, the pattern's items, the walk */
static int next_match(lua_State *L)
{
    Walk *w = lua_touserdata(L, lua_upvalueindex(3));
    PatternMatch m = begin_match(L, lua_upvalueindex(1));
    check_pattern(L, &w->p);
    while (w->from <= m.length && pattern_find(&w->p, &m, w->from)) {
        if (m.end == w->last) {                 /* an empty match where the last one ended is none */
            w->from = m.start + 1;
            continue;
        }
        w->from = w->last = m.end;
        end_match(L, &m);
        return push_captures(L, &w->p, &m, true);
    }
    w->from = SIZE_MAX;
    end_match(L, &m);
    return 0;
}

static int string_gmatch(lua_State *L)
{
    size_t length;
    luaL_checklstring(L, 1, &length);
    luaL_checkstring(L, 2);
    lua_Integer given = luaL_optinteger(L, 3, 1);
    size_t from = given > 0 && (lua_Unsigned)given - 1 > length ? SIZE_MAX : start_of(given, length);
    Pattern p;
    lua_settop(L, 2);
    push_pattern(L, 2, false, &p);
    Walk *w = lua_newuserdatauv(L, sizeof *w, 0);
    *w = (Walk){p, from, SIZE_MAX};
    lua_remove(L, 2);
    lua_pushcclosure(L, next_match, 3);
    return 1;
}

/* ---- gsub --------------------------------------------------------------------------------- */

enum { GSUB_TEXT = 1, GSUB_PATTERN = 2, GSUB_BY = 3 };

/* Adds the replacement text: %0 to %9 are captures, %% is %. */
static void add_text(lua_State *L, luaL_Buffer *b, const Pattern *p, const PatternMatch *m)
{
    size_t length;
    const char *by = lua_tolstring(L, GSUB_BY, &length);
    for (size_t i = 0; i < length; i++) {
        if (by[i] != '%') {
            luaL_addchar(b, by[i]);
            continue;
        }
        unsigned char c = ++i < length ? (unsigned char)by[i] : 0;
        if (c == '%') {
            luaL_addchar(b, '%');
        } else if (c == '0') {
            luaL_addlstring(b, m->text + m->start, m->end - m->start);
        } else if (c >= '1' && c <= '9') {
            int k = c - '1';
            if (k >= (p->capture_count > 0 ? p->capture_count : 1))
                luaL_error(L, "invalid capture index %%%d in replacement string", k + 1);
            push_capture(L, p, m, k);
            luaL_addvalue(b);
        } else {
            luaL_error(L, "invalid use of '%%' in replacement string");
        }
    }
    app_charge(L, length);
}

/* Adds what stands for the match; false when it stays as it is. */
static bool add_replacement(lua_State *L, luaL_Buffer *b, const Pattern *p, const PatternMatch *m)
{
    int kind = lua_type(L, GSUB_BY);
    if (kind == LUA_TSTRING) {
        add_text(L, b, p, m);
        return true;
    }
    if (kind == LUA_TFUNCTION) {
        lua_pushvalue(L, GSUB_BY);
        lua_call(L, push_captures(L, p, m, true), 1);
    } else {
        push_capture(L, p, m, 0);
        lua_gettable(L, GSUB_BY);
    }
    if (!lua_toboolean(L, -1)) {
        lua_pop(L, 1);
        luaL_addlstring(b, m->text + m->start, m->end - m->start);
        return false;
    }
    if (!lua_isstring(L, -1))
        luaL_error(L, "invalid replacement value (a %s)", luaL_typename(L, -1));
    luaL_addvalue(b);
    return true;
}

static int string_gsub(lua_State *L)
{
    PatternMatch m = begin_match(L, GSUB_TEXT);
    luaL_checkstring(L, GSUB_PATTERN);
    int kind = lua_type(L, GSUB_BY);
    luaL_argexpected(L, kind == LUA_TNUMBER || kind == LUA_TSTRING || kind == LUA_TFUNCTION || kind == LUA_TTABLE, GSUB_BY,
                     "string/function/table");
    lua_Integer most = luaL_optinteger(L, 4, (lua_Integer)m.length + 1), n = 0;
    if (kind == LUA_TNUMBER)
        lua_tostring(L, GSUB_BY);
    Pattern p;
    luaL_Buffer b;
    size_t at = 0, last = SIZE_MAX;
    bool changed = false;
    lua_settop(L, GSUB_BY);
    push_pattern(L, GSUB_PATTERN, true, &p);
    check_pattern(L, &p);
    luaL_buffinit(L, &b);
    while (n < most) {
        app_charge(L, 2);
        if (pattern_match_at(&p, &m, at) && m.end != last) {
            n++;
            changed = add_replacement(L, &b, &p, &m) || changed;
            at = last = m.end;
        } else if (at < m.length) {
            luaL_addchar(&b, m.text[at++]);
        } else {
            break;
        }
        if (p.anchored)
            break;
    }
    end_match(L, &m);
    if (!changed) {
        lua_pushvalue(L, GSUB_TEXT);
    } else {
        luaL_addlstring(&b, m.text + at, m.length - at);
        luaL_pushresult(&b);
    }
    lua_pushinteger(L, n);
    return 2;
}

/* ---- format --------------------------------------------------------------------------------- */

/* upvalue: Lua's own. Values for %s become texts here, so that none shows an address. */
static int string_format(lua_State *L)
{
    size_t length, work = 0;
    const char *format = luaL_checklstring(L, 1, &length);
    int n = lua_gettop(L), argument = 1;
    for (size_t i = 0; i < length; i++) {
        if (format[i] != '%')
            continue;
        if (++i < length && format[i] == '%')
            continue;
        while (i < length && format[i] && strchr("-+ #0123456789.", format[i]))
            i++;
        if (++argument > n)
            break;                              /* Lua says so */
        if (i < length && format[i] == 'p')
            return luaL_error(L, "invalid conversion '%%p' to 'format': addresses are not available to scripts");
        if (i < length && format[i] == 's' && lua_type(L, argument) != LUA_TSTRING) {
            bind_text(L, argument);
            lua_replace(L, argument);
        }
        work += lua_type(L, argument) == LUA_TSTRING ? lua_rawlen(L, argument) / BYTES_A_UNIT : 8;
    }
    app_charge(L, work + length);
    return lib_call_first(L);
}

/* upvalue: Lua's own. What the sizes in the format ask for is looked at before it is filled byte by byte. */
static int string_pack(lua_State *L)
{
    const char *format = luaL_checkstring(L, 1);
    int n = lua_gettop(L);
    size_t work = strlen(format);
    for (const char *p = format; *p; p++) {
        if (*p != 'c')
            continue;
        double size = 0;
        while (isdigit((unsigned char)p[1]))
            size = size * 10 + (*++p - '0');
        app_need(L, size < 1e15 ? (size_t)size : (size_t)1e15);
        work += size < 1e15 ? (size_t)size : 0;
    }
    for (int i = 2; i <= n; i++)
        if (lua_type(L, i) == LUA_TSTRING)
            work += lua_rawlen(L, i) / BYTES_A_UNIT;
    app_charge(L, work);
    return lib_call_first(L);
}

const LibEntry lib_string[] = {
    {"byte", string_byte, false},   {"char", string_char, false},     {"find", string_find, false}, {"format", string_format, false},
    {"gmatch", string_gmatch, false}, {"gsub", string_gsub, false},   {"len", string_len, false},   {"lower", string_lower, false},
    {"match", string_match, false}, {"pack", string_pack, false},           {"packsize", NULL, true},     {"rep", string_rep, false},
    {"reverse", string_reverse, false}, {"sub", string_sub, false},   {"unpack", NULL, true},       {"upper", string_upper, false},
    {NULL, NULL, false},
};
