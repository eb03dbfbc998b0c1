/* render/stage.c - finds the part of a view that matters. */
#include "render/stage.h"

static const real LARGE_FIXED = 8;      /* a fixed body this many times larger than all that moves counts only in part */

static box3 empty_box(void)
{
    return (box3){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static bool is_empty(box3 b) { return !(b.low.x <= b.high.x); }

static real half_diagonal(box3 b) { return is_empty(b) ? 0 : 0.5 * vec3_distance(b.low, b.high); }

bool item_sound(const View *v, const ViewItem *item)
{
    vec3 p = vec3_from(item->p);
    real n = 0;
    for (int i = 0; i < 4; i++)
        n += (real)item->q[i] * (real)item->q[i];
    if (item->mesh < 0 || item->mesh >= v->mesh_count || !vec3_finite(p) || !(n > 0 && isfinite(n)))
        return false;
    return vec3_finite(vec3_from(v->meshes[item->mesh].size));
}

static box3 vertex_bounds(const ViewMesh *m)
{
    box3 b = empty_box();
    for (int i = 0; i < m->vertex_count; i++) {
        vec3 p = vec3_from(m->vertices + 3 * i);
        b.low = vec3_min(b.low, p);
        b.high = vec3_max(b.high, p);
    }
    return b;
}

bool item_bounds(const View *v, const ViewItem *item, box3 *box)
{
    const ViewMesh *m = &v->meshes[item->mesh];
    real a = (real)m->size[0], b = (real)m->size[1], c = (real)m->size[2];
    switch (m->form) {
    case VIEW_SPHERE:   *box = (box3){{-a, -a, -a}, {a, a, a}}; return true;
    case VIEW_BOX:      *box = (box3){{-a / 2, -b / 2, -c / 2}, {a / 2, b / 2, c / 2}}; return true;
    case VIEW_CAPSULE:  *box = (box3){{-a, -a - b / 2, -a}, {a, a + b / 2, a}}; return true;
    case VIEW_CYLINDER: *box = (box3){{-a, -b / 2, -a}, {a, b / 2, a}}; return true;
    case VIEW_CONE:     *box = (box3){{-a, -b / 4, -a}, {a, 3 * b / 4, a}}; return true;
    case VIEW_PLANE:    return false;
    case VIEW_MESH:     break;
    }
    *box = vertex_bounds(m);
    return !is_empty(*box);
}

/* The box round an item in scene axes, m. */
static bool turned_bounds(const View *v, const ViewItem *item, mat3 axes, box3 *box)
{
    box3 own;
    if (!item_sound(v, item) || !item_bounds(v, item, &own))
        return false;
    mat3 turn = mat3_mul(axes, quat_matrix(quat_from(item->q)));
    vec3 middle = vec3_scale(0.5, vec3_add(own.low, own.high)), half = vec3_scale(0.5, vec3_sub(own.high, own.low));
    vec3 at = vec3_add(mat3_mul_vec(axes, vec3_from(item->p)), mat3_mul_vec(turn, middle));
    mat3 size = {vec3_abs(turn.r0), vec3_abs(turn.r1), vec3_abs(turn.r2)};
    half = mat3_mul_vec(size, half);
    *box = (box3){vec3_sub(at, half), vec3_add(at, half)};
    return vec3_finite(half);
}

/* Mean and spread of the moving bodies' places; with trim, again without those beyond four spreads. A body at
 * distance D from n - 1 others makes the spread D / sqrt(n): from n = 17 on it is found. */
typedef struct Crowd { vec3 mean; real reach; } Crowd;

static Crowd find_crowd(const View *v, mat3 axes, bool trim)
{
    Crowd crowd = {{0, 0, 0}, INFINITY};
    for (int round = 0; trim && round < 3; round++) {
        vec3 sum = {0, 0, 0};
        real square = 0;
        int count = 0;
        for (int i = 0; i < v->item_count; i++) {
            const ViewItem *item = &v->items[i];
            vec3 p = mat3_mul_vec(axes, vec3_from(item->p));
            if (item->fixed || !item_sound(v, item) || vec3_distance(p, crowd.mean) > crowd.reach)
                continue;
            sum = vec3_add(sum, p);
            square += vec3_length2(p);
            count++;
        }
        if (count < 20)
            return (Crowd){{0, 0, 0}, INFINITY};
        crowd.mean = vec3_scale(1.0 / count, sum);
        crowd.reach = 4 * sqrt(real_max(0, square / count - vec3_length2(crowd.mean)));
    }
    return crowd;
}

/* Union of the moving bodies' boxes; *typical = geometric mean of their radii, m. */
static box3 moving_box(const View *v, mat3 axes, bool trim, real *typical)
{
    Crowd crowd = find_crowd(v, axes, trim);
    box3 all = empty_box(), one;
    real logs = 0;
    int count = 0;
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        if (item->fixed || !turned_bounds(v, item, axes, &one))
            continue;
        if (vec3_distance(mat3_mul_vec(axes, vec3_from(item->p)), crowd.mean) > crowd.reach)
            continue;
        all = box3_union(all, one);
        real radius = half_diagonal(one);
        if (radius > 0) {
            logs += log(radius);
            count++;
        }
    }
    *typical = count ? exp(logs / count) : 0;
    return all;
}

static box3 with_fixed(const View *v, mat3 axes, box3 moving)
{
    real size = half_diagonal(moving);
    box3 all = moving, one, near = box3_grow(moving, 0.2 * size);
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        if (!item->fixed || !turned_bounds(v, item, axes, &one))
            continue;
        if (!is_empty(moving) && half_diagonal(one) > LARGE_FIXED * size) {
            one.low = vec3_max(one.low, near.low);
            one.high = vec3_min(one.high, near.high);
            if (!(one.low.x <= one.high.x && one.low.y <= one.high.y && one.low.z <= one.high.z))
                continue;
        }
        all = box3_union(all, one);
    }
    return all;
}

/* The highest horizontal plane that lies below the middle of the box. */
static int find_floor(const View *v, mat3 axes, box3 box, real *z)
{
    int found = -1;
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        if (!item_sound(v, item) || v->meshes[item->mesh].form != VIEW_PLANE || item->clear > 0)
            continue;
        vec3 normal = mat3_mul_vec(axes, quat_rotate(quat_from(item->q), (vec3){0, 1, 0}));
        real height = mat3_mul_vec(axes, vec3_from(item->p)).z;
        bool below = is_empty(box) || height <= 0.5 * (box.low.z + box.high.z);
        if (normal.z > 0.999999 && below && (found < 0 || height > *z)) {
            found = i;
            *z = height;
        }
    }
    return found;
}

static real ladder(real size) { return exp2(ceil(4 * log2(size)) / 4); }

Stage stage_of(const View *v, bool trim)
{
    Stage s = {.floor_item = -1};
    vec3 up = vec3_unit(vec3_from(v->up));
    s.axes = quat_matrix(quat_between(up, (vec3){0, 0, 1}));
    real typical;
    box3 box = with_fixed(v, s.axes, moving_box(v, s.axes, trim, &typical));
    real floor = 0;
    s.floor_item = find_floor(v, s.axes, box, &floor);
    if (is_empty(box))
        box = (box3){{-1, -1, floor}, {1, 1, floor + 1}};
    real size = real_max(half_diagonal(box), 1e-9);
    if (s.floor_item >= 0 && fabs(box.low.z - floor) < 1.5 * size)
        box.low.z = floor;
    else if (s.floor_item < 0)
        floor = box.low.z;
    size = real_max(half_diagonal(box), 1e-9);
    s.unit = ladder(size);
    vec3 middle = vec3_scale(0.5, vec3_add(box.low, box.high));
    s.centre = mat3_mul_vec(mat3_transpose(s.axes), middle);
    s.low = vec3_scale(1 / s.unit, vec3_sub(box.low, middle));
    s.high = vec3_scale(1 / s.unit, vec3_sub(box.high, middle));
    s.typical = real_clamp(typical > 0 ? typical / s.unit : 0.2, 0.02, 0.5);
    s.floor = (floor - middle.z) / s.unit;
    return s;
}

vec3 stage_point(const Stage *s, vec3 p)
{
    return vec3_scale(1 / s->unit, mat3_mul_vec(s->axes, vec3_sub(p, s->centre)));
}
