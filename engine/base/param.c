/* base/param.c - parameter rows: finding, defaults, checks, suggestions. */

#include "base/param.h"

#include <stdio.h>

#include "base/text.h"

enum { NAME_LIMIT = 64 };       /* longer names are compared by their first 64 bytes */

int param_count(const dig_param *rows)
{
    int n = 0;
    while (rows && rows[n].name)
        n++;
    return n;
}

const dig_param *param_find(const dig_param *rows, const char *name)
{
    for (const dig_param *row = rows; row && row->name; row++)
        if (strcmp(row->name, name) == 0)
            return row;
    return NULL;
}

const dig_param *param_find_path(const dig_param *rows, const char *path, size_t *offset)
{
    *offset = 0;
    while (rows) {
        size_t length = strcspn(path, ".");
        const dig_param *row = rows;
        while (row->name && !(strlen(row->name) == length && memcmp(row->name, path, length) == 0))
            row++;
        if (!row->name)
            return NULL;
        *offset += row->offset;
        if (path[length] == '\0')
            return row;
        rows = row->kind == DIG_TABLE ? row->rows : NULL;
        path += length + 1;
    }
    return NULL;
}

size_t param_size(const dig_param *row)
{
    switch (row->kind) {
    case DIG_REAL: return sizeof(real);
    case DIG_INT: case DIG_CHOICE: return sizeof(int64_t);
    case DIG_BOOL: return sizeof(bool);
    case DIG_VEC3: case DIG_DIR: case DIG_SIZE3: case DIG_COLOUR: return sizeof(vec3);
    case DIG_QUAT: return sizeof(quat);
    case DIG_RANGE: case DIG_PAIR: return 2 * sizeof(real);
    case DIG_TEXT: case DIG_MATERIAL: return sizeof(dig_text);
    case DIG_BODY: return sizeof(dig_body);
    case DIG_JOINT: return sizeof(dig_joint);
    case DIG_POINTS: return sizeof(dig_points);
    case DIG_INDICES: return sizeof(dig_indices);
    case DIG_TABLE: return 0;
    }
    return 0;
}

/* ---- defaults ------------------------------------------------------------ */

static void default_field(const dig_param *row, char *field)
{
    real x = row->fallback;
    switch (row->kind) {
    case DIG_REAL:
        memcpy(field, &x, sizeof x);
        break;
    case DIG_INT: case DIG_CHOICE: {
        int64_t i = isfinite(x) ? (int64_t)x : 0;
        memcpy(field, &i, sizeof i);
        break;
    }
    case DIG_BOOL: {
        bool b = isfinite(x) && x > 0;
        memcpy(field, &b, sizeof b);
        break;
    }
    case DIG_VEC3: case DIG_DIR: case DIG_SIZE3: case DIG_COLOUR: {
        vec3 v = {x, x, x};
        memcpy(field, &v, sizeof v);
        break;
    }
    case DIG_QUAT: {
        quat q = {0, 0, 0, 1};
        memcpy(field, &q, sizeof q);
        break;
    }
    case DIG_RANGE: case DIG_PAIR: {
        real r[2] = {x, x};
        memcpy(field, r, sizeof r);
        break;
    }
    case DIG_TABLE:
        param_defaults(row->rows, field);
        break;
    case DIG_TEXT: case DIG_MATERIAL: case DIG_BODY: case DIG_JOINT: case DIG_POINTS: case DIG_INDICES:
        memset(field, 0, param_size(row));
        break;
    }
}

void param_defaults(const dig_param *rows, void *def)
{
    for (const dig_param *row = rows; row && row->name; row++)
        default_field(row, (char *)def + row->offset);
}

void dig_schema_defaults(const dig_schema *s, void *def)
{
    memset(def, 0, s->size);
    param_defaults(s->rows, def);
}

/* ---- specks -------------------------------------------------------------- */

bool param_has_reals(const dig_param *row)
{
    switch (row->kind) {
    case DIG_REAL: case DIG_RANGE: case DIG_PAIR: case DIG_VEC3: case DIG_DIR: case DIG_SIZE3: case DIG_COLOUR: case DIG_QUAT: return true;
    default: return false;
    }
}

void param_settle(const dig_param *rows, void *def)
{
    for (const dig_param *row = rows; row && row->name; row++) {
        char *field = (char *)def + row->offset;
        if (row->kind == DIG_TABLE)
            param_settle(row->rows, field);
        for (size_t at = 0; param_has_reals(row) && at < param_size(row); at += sizeof(real)) {
            real x;
            memcpy(&x, field + at, sizeof x);
            if (fabs(x) > 0 && fabs(x) < PARAM_SPECK)
                memset(field + at, 0, sizeof x);
        }
    }
}

/* ---- checks ---------------------------------------------------------------- */

static bool has_range(const dig_param *row)
{
    return row->max > row->min || row->min > row->max;
}

static bool may_be_missing(const dig_param *row)
{
    return isnan(row->fallback) && !row->required;
}

static const char *shown_unit(const dig_param *row)
{
    return row->unit && strcmp(row->unit, "1") != 0 ? row->unit : "";
}

/* part: "", ".x", ".y", ".z", "[1]", "[2]" */
static dig_status fail_bound(const dig_param *row, const char *part, real x, const char *subject, char *why, size_t capacity)
{
    const char *unit = shown_unit(row);
    const char *gap = *unit ? " " : "";
    char value[64];
    snprintf(value, sizeof value, "%s = %.6g%s%s", part, isnan(x) ? (real)NAN : x, gap, unit);
    if (isnan(x) || (isinf(x) && !has_range(row)))
        snprintf(why, capacity, "%s: %s%s, must be a finite number", subject, row->name, value);
    else if (row->min > 0 && !(x > 0))
        snprintf(why, capacity, "%s: %s%s, must be > 0", subject, row->name, value);
    else if (x < row->min && !(row->min < 0) && !(row->min > 0))
        snprintf(why, capacity, "%s: %s%s, must be >= 0", subject, row->name, value);
    else if (x < row->min)
        snprintf(why, capacity, "%s: %s%s, must be at least %.6g%s%s", subject, row->name, value, row->min, gap, unit);
    else if (isinf(row->max))
        snprintf(why, capacity, "%s: %s%s, must be a finite number", subject, row->name, value);
    else
        snprintf(why, capacity, "%s: %s%s, must be at most %.6g%s%s", subject, row->name, value, row->max, gap, unit);
    return DIG_E_ARG;
}

static bool inside(const dig_param *row, real x, bool infinite_is_fine)
{
    if (isnan(x) || (isinf(x) && !(infinite_is_fine && has_range(row))))
        return false;
    return !has_range(row) || (x >= row->min && x <= row->max);
}

static dig_status check_vector(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity)
{
    static const char *const part[3] = {".x", ".y", ".z"};
    real v[3];
    memcpy(v, field, sizeof v);
    if (isnan(v[0]) && may_be_missing(row))
        return DIG_OK;
    if (row->kind == DIG_COLOUR && v[0] < 0)
        return DIG_OK;
    for (int i = 0; i < 3; i++)
        if (!inside(row, v[i], false))
            return fail_bound(row, part[i], v[i], subject, why, capacity);
    if (row->kind == DIG_DIR && !(fabs(v[0]) + fabs(v[1]) + fabs(v[2]) > 0)) {
        snprintf(why, capacity, "%s: %s = {0, 0, 0}, must not be zero: it is a direction", subject, row->name);
        return DIG_E_ARG;
    }
    for (int i = 0; i < 3 && row->kind == DIG_SIZE3; i++)
        if (!(v[i] > 0)) {
            snprintf(why, capacity, "%s: %s%s = %.6g %s, must be > 0", subject, row->name, part[i], v[i], shown_unit(row));
            return DIG_E_ARG;
        }
    return DIG_OK;
}

static dig_status check_quat(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity)
{
    quat q;
    memcpy(&q, field, sizeof q);
    real n = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    if (isfinite(n) && n > 0)
        return DIG_OK;
    snprintf(why, capacity, "%s: %s = {%g, %g, %g, %g}, must be finite and not zero: it is a rotation", subject, row->name,
             q.x, q.y, q.z, q.w);
    return DIG_E_ARG;
}

static dig_status check_range(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity)
{
    real r[2];
    memcpy(r, field, sizeof r);
    if (isnan(r[0]) && isnan(r[1]) && may_be_missing(row))
        return DIG_OK;
    for (int i = 0; i < 2; i++)
        if (isnan(r[i]) || (has_range(row) && !(r[i] >= row->min && r[i] <= row->max)))
            return fail_bound(row, i == 0 ? "[1]" : "[2]", r[i], subject, why, capacity);
    if (row->kind == DIG_PAIR || r[0] <= r[1])
        return DIG_OK;
    snprintf(why, capacity, "%s: %s = {%g, %g} %s, must have the lower bound first", subject, row->name, r[0], r[1],
             shown_unit(row));
    return DIG_E_ARG;
}

static dig_status check_whole(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity)
{
    int64_t i;
    memcpy(&i, field, sizeof i);
    if (row->kind == DIG_INT)
        return inside(row, (real)i, false) ? DIG_OK : fail_bound(row, "", (real)i, subject, why, capacity);
    int64_t count = 0;
    while (row->choices && row->choices[count])
        count++;
    if (i >= 0 && i < count)
        return DIG_OK;
    snprintf(why, capacity, "%s: %s = %lld is not one of its %lld choices", subject, row->name, (long long)i, (long long)count);
    return DIG_E_ARG;
}

static dig_status check_text(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity)
{
    const char *text = field;
    size_t room = sizeof((dig_text *)0)->s;
    if (!memchr(text, '\0', room)) {
        snprintf(why, capacity, "%s: %s is longer than %zu bytes", subject, row->name, room - 1);
        return DIG_E_ARG;
    }
    if (row->required && !*text) {
        snprintf(why, capacity, "%s: %s is missing", subject, row->name);
        return DIG_E_ARG;
    }
    const char *fault = text_fault(text);
    if (fault)
        snprintf(why, capacity, "%s: %s %s", subject, row->name, fault);
    return fault ? DIG_E_ARG : DIG_OK;
}

static dig_status check_list(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity)
{
    int count;
    const vec3 *v = NULL;
    if (row->kind == DIG_POINTS) {
        dig_points points;
        memcpy(&points, field, sizeof points);
        count = points.count;
        v = points.v;
    } else {
        dig_indices indices;
        memcpy(&indices, field, sizeof indices);
        count = indices.count;
    }
    if (row->required && count <= 0) {
        snprintf(why, capacity, "%s: %s is missing", subject, row->name);
        return DIG_E_ARG;
    }
    for (int i = 0; v && i < count; i++)
        if (!isfinite(v[i].x) || !isfinite(v[i].y) || !isfinite(v[i].z)) {
            snprintf(why, capacity, "%s: %s[%d] = {%g, %g, %g} %s, must be finite", subject, row->name, i + 1,
                     v[i].x, v[i].y, v[i].z, shown_unit(row));
            return DIG_E_ARG;
        }
    return DIG_OK;
}

static dig_status check_handle(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity)
{
    uint32_t slot_gen[2];
    memcpy(slot_gen, field, sizeof slot_gen);
    if (!row->required || slot_gen[0] || slot_gen[1])
        return DIG_OK;
    snprintf(why, capacity, "%s: %s is missing", subject, row->name);
    return DIG_E_ARG;
}

dig_status param_check_field(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity)
{
    switch (row->kind) {
    case DIG_REAL: {
        real x;
        memcpy(&x, field, sizeof x);
        if (isnan(x) && may_be_missing(row))
            return DIG_OK;
        if (isnan(x) && row->required) {
            snprintf(why, capacity, "%s: %s is missing", subject, row->name);
            return DIG_E_ARG;
        }
        return inside(row, x, true) ? DIG_OK : fail_bound(row, "", x, subject, why, capacity);
    }
    case DIG_INT: case DIG_CHOICE: return check_whole(row, field, subject, why, capacity);
    case DIG_BOOL: return DIG_OK;
    case DIG_VEC3: case DIG_DIR: case DIG_SIZE3: case DIG_COLOUR: return check_vector(row, field, subject, why, capacity);
    case DIG_QUAT: return check_quat(row, field, subject, why, capacity);
    case DIG_RANGE: case DIG_PAIR: return check_range(row, field, subject, why, capacity);
    case DIG_TEXT: case DIG_MATERIAL: return check_text(row, field, subject, why, capacity);
    case DIG_POINTS: case DIG_INDICES: return check_list(row, field, subject, why, capacity);
    case DIG_BODY: case DIG_JOINT: return check_handle(row, field, subject, why, capacity);
    case DIG_TABLE: {
        char inner[128];
        snprintf(inner, sizeof inner, "%s: %s", subject, row->name);
        return param_check(row->rows, field, inner, why, capacity);
    }
    }
    return DIG_OK;
}

dig_status param_check(const dig_param *rows, const void *def, const char *subject, char *why, size_t capacity)
{
    for (const dig_param *row = rows; row && row->name; row++)
        DIG_TRY(param_check_field(row, (const char *)def + row->offset, subject, why, capacity));
    return DIG_OK;
}

/* ---- suggestions -------------------------------------------------------------- */

static int short_length(const char *s)
{
    const char *end = memchr(s, '\0', NAME_LIMIT);
    return end ? (int)(end - s) : NAME_LIMIT;
}

/* Optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours, each 1. Three rows of the
 * dynamic programme (Damerau 1964; Wagner & Fischer 1974). Written for names: at most NAME_LIMIT bytes count. */
static int edit_distance(const char *a, const char *b)
{
    int row[3][NAME_LIMIT + 1];
    int m = short_length(a), n = short_length(b);
    for (int j = 0; j <= n; j++)
        row[0][j] = j;
    for (int i = 1; i <= m; i++) {
        int *now = row[i % 3];
        const int *before = row[(i + 2) % 3], *earlier = row[(i + 1) % 3];
        now[0] = i;
        for (int j = 1; j <= n; j++) {
            now[j] = int_min(int_min(before[j], now[j - 1]) + 1, before[j - 1] + (a[i - 1] != b[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                now[j] = int_min(now[j], earlier[j - 2] + 1);
        }
    }
    return row[m % 3][n];
}

const char *dig_suggest(const char *name, const char *const *candidates, int count)
{
    const char *best = NULL;
    int limit = int_max(1, short_length(name) / 3);
    int least = limit + 1;
    for (int i = 0; i < count; i++) {
        int distance = edit_distance(name, candidates[i]);
        if (distance < least) {     /* the first of equally near ones */
            least = distance;
            best = candidates[i];
        }
    }
    return best;
}
