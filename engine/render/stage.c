/* render/stage.c - finds the part of a view that matters. */
#include "render/stage.h"

static const real LARGE_FIXED = 8;      /* a fixed body this many times larger than all that moves counts only in part */
static const real FAINT = 0.05;         /* of half the picture's height: what moves is hardly seen, and from three times that on it decides */
static const real LEAST_SEEN = 0.2;     /* of half the picture's height, that the scene fills at least */
static const real USUAL = 0.2;          /* scene units: typical radius where nothing moves */

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
    if (item->woven || item->mesh < 0 || item->mesh >= v->mesh_count || !vec3_finite(p) || !(n > 0 && isfinite(n)))
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

/* ---- who counts --------------------------------------------------------
 *
 * All of this is smooth in where bodies and the eye are, so that a film shows no jumps: a body that stops counting is let go little by
 * little, and where two boxes are in question, what lies between them is taken. */

/* 1 up to `from`, 0 from `to` on. */
static real fade(real x, real from, real to)
{
    real t = real_clamp((to - x) / (to - from), 0, 1);
    return t * t * (3 - 2 * t);
}

static box3 box3_lerp(box3 a, box3 b, real t)
{
    return t <= 0 ? a : t >= 1 ? b : (box3){vec3_lerp(a.low, b.low, t), vec3_lerp(a.high, b.high, t)};
}

/* The box grown towards one that counts in part. */
static box3 include(box3 all, box3 one, real share)
{
    return is_empty(all) ? one : box3_lerp(all, box3_union(all, one), share);
}

/* m, scene axes. */
static vec3 place_of(const ViewItem *item, mat3 axes) { return mat3_mul_vec(axes, vec3_from(item->p)); }

static real radius_of(const View *v, const ViewItem *item)
{
    box3 own;
    return item_bounds(v, item, &own) ? half_diagonal(own) : 0;
}

/* Where the moving bodies are: mean and spread of their places, and their mean radius, m. They are weighted by their area, and from the
 * second round on also by how near the eye they are, and who lies beyond three to nine spreads is let go. */
typedef struct Crowd { vec3 mean; real spread, radius; } Crowd;

static Crowd find_crowd(const View *v, mat3 axes, const StageEye *eye)
{
    Crowd crowd = {{0, 0, 0}, INFINITY, 0};
    real middle = 0;                    /* m, from the eye to the mean */
    vec3 at = eye ? mat3_mul_vec(axes, eye->at) : crowd.mean;
    for (int round = 0; eye && round < 4; round++) {
        vec3 sum = {0, 0, 0};
        real square = 0, radii = 0, weight = 0;
        for (int i = 0; i < v->item_count; i++) {
            const ViewItem *item = &v->items[i];
            if (item->fixed || !item_sound(v, item))
                continue;
            vec3 p = place_of(item, axes);
            real r = radius_of(v, item), w = r * r, far = middle + vec3_distance(p, at);
            if (round > 0)
                w *= fade(vec3_distance(p, crowd.mean), 3 * crowd.spread, 9 * crowd.spread) / real_max(far * far, 1e-12);
            sum = vec3_mad(sum, w, p);
            square += w * (vec3_length2(p) + r * r);
            radii += w * r;
            weight += w;
        }
        if (!(weight > 0 && isfinite(square)))
            return (Crowd){{0, 0, 0}, INFINITY, 0};
        crowd = (Crowd){vec3_scale(1 / weight, sum), 0, radii / weight};
        crowd.spread = sqrt(real_max(crowd.radius * crowd.radius, square / weight - vec3_length2(crowd.mean)));
        middle = vec3_distance(crowd.mean, at);
    }
    return crowd;
}

/* What is small beside the others is let go from two spreads on, what is not from four. */
static real share_of(const Crowd *crowd, vec3 p, real radius)
{
    if (!isfinite(crowd->spread))
        return 1;
    real limit = crowd->spread * (2 + 2 * real_min(1, 4 * radius / crowd->radius));
    return fade(vec3_distance(p, crowd->mean) - radius, limit, 2 * limit);
}

/* Union of the moving bodies' boxes; *typical = geometric mean of their radii, weighted by these, m. */
static box3 moving_box(const View *v, mat3 axes, const StageEye *eye, real *typical)
{
    Crowd crowd = find_crowd(v, axes, eye);
    box3 all = empty_box(), one;
    real logs = 0, weight = 0;
    for (int whole = 1; whole >= 0; whole--)            /* who counts in part comes after those who count */
        for (int i = 0; i < v->item_count; i++) {
            const ViewItem *item = &v->items[i];
            if (item->fixed || !turned_bounds(v, item, axes, &one))
                continue;
            real radius = half_diagonal(one), share = share_of(&crowd, place_of(item, axes), radius_of(v, item));
            if ((share >= 1) != whole || share <= 0)
                continue;
            all = include(all, one, share);
            if (radius > 0) {
                logs += share * radius * log(radius);
                weight += share * radius;
            }
        }
    *typical = weight > 0 ? exp(logs / weight) : 0;
    return all;
}

/* How much of a fixed body counts by how large it is seen: what is hardly a pixel does not. */
static real seen_share(box3 one, mat3 axes, const StageEye *eye)
{
    if (!eye)
        return 1;
    real distance = vec3_distance(vec3_scale(0.5, vec3_add(one.low, one.high)), mat3_mul_vec(axes, eye->at));
    return 1 - fade(half_diagonal(one), 0.005 * eye->half * distance, 0.010 * eye->half * distance + 1e-12);
}

/* How far a fixed body is too large to count as a whole beside things of that size. */
static real excess(box3 one, real size) { return 1 - fade(half_diagonal(one), LARGE_FIXED * size, 1.5 * LARGE_FIXED * size); }

/* The part of a fixed body near what moves; far from it, nothing more than that. */
static box3 part_near(box3 one, box3 moving, box3 near)
{
    box3 part = {vec3_max(one.low, near.low), vec3_min(one.high, near.high)};
    if (part.low.x <= part.high.x && part.low.y <= part.high.y && part.low.z <= part.high.z)
        return part;
    return (box3){vec3_min(vec3_max(one.low, moving.low), moving.high), vec3_min(vec3_max(one.high, moving.low), moving.high)};
}

/* What moves and the fixed bodies; huge ones only near what moves. */
static box3 with_fixed(const View *v, mat3 axes, box3 moving, const StageEye *eye)
{
    real size = half_diagonal(moving);
    box3 all = moving, one, near = box3_grow(moving, 0.2 * size);
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        if (!item->fixed || !turned_bounds(v, item, axes, &one))
            continue;
        real share = seen_share(one, axes, eye);
        if (!is_empty(moving))
            one = box3_lerp(one, part_near(one, moving, near), excess(one, size));
        all = include(all, one, share);
    }
    return all;
}

/* The same where what moves is hardly seen: the fixed bodies, in size up to a few pictures, decide, and what moves counts near them. */
static box3 mostly_fixed(const View *v, mat3 axes, box3 moving, const StageEye *eye, real seen)
{
    box3 both = moving, fixed = empty_box(), one;
    real most = 0;
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        if (!item->fixed || !turned_bounds(v, item, axes, &one))
            continue;
        real share = seen_share(one, axes, eye) * (1 - excess(one, seen));
        if (share <= 0)
            continue;
        both = include(both, one, share);
        fixed = include(fixed, one, share);
        most = real_max(most, share);
    }
    if (is_empty(fixed))
        return moving;
    vec3 beyond = vec3_max(vec3_sub(fixed.low, moving.low), vec3_sub(moving.high, fixed.high));
    real limit = 0.25 * half_diagonal(fixed) + 10 * half_diagonal(moving);
    return box3_lerp(both, fixed, most * (1 - fade(vec3_largest(beyond), limit, 2 * limit)));
}

static real seen_at(box3 box, mat3 axes, const StageEye *eye)
{
    return eye->half * vec3_distance(vec3_scale(0.5, vec3_add(box.low, box.high)), mat3_mul_vec(axes, eye->at));
}

/* The box round what matters, m; *near: how much the moving bodies make its scale, 0..1. */
static box3 find_box(const View *v, mat3 axes, const StageEye *eye, real *typical, real *near)
{
    box3 moving = moving_box(v, axes, eye, typical);
    *near = 1;
    if (!eye || is_empty(moving))
        return with_fixed(v, axes, moving, eye);
    real seen = seen_at(moving, axes, eye);
    *near = 1 - fade(half_diagonal(moving), FAINT * seen, 3 * FAINT * seen + 1e-12);
    box3 close = *near > 0 ? with_fixed(v, axes, moving, eye) : moving;
    if (*near >= 1)
        return close;
    box3 wide = mostly_fixed(v, axes, moving, eye, seen);
    wide = box3_grow(wide, real_max(0, LEAST_SEEN * seen_at(wide, axes, eye) - half_diagonal(wide)));
    return box3_lerp(wide, close, *near);
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

Stage stage_of(const View *v, const StageEye *eye)
{
    Stage s = {.floor_item = -1};
    vec3 up = vec3_unit(vec3_from(v->up));
    s.axes = quat_matrix(quat_between(up, (vec3){0, 0, 1}));
    real typical, near;
    box3 box = find_box(v, s.axes, eye, &typical, &near);
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
    typical = typical > 0 ? USUAL * pow(typical / s.unit / USUAL, near) : USUAL;
    s.typical = real_clamp(typical, 0.02, 0.5);
    s.floor = (floor - middle.z) / s.unit;
    return s;
}

vec3 stage_point(const Stage *s, vec3 p)
{
    return vec3_scale(1 / s->unit, mat3_mul_vec(s->axes, vec3_sub(p, s->centre)));
}
