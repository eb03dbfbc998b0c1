/* render/batch.c - turns the items of a view into sorted instances, and draws them. */
#include "render/batch.h"

#include <stdlib.h>

#include "render/subject.h"

static const real BEVEL = 0.055;        /* of the smallest extent */
static const real FINEST = 1.2;         /* pixels that a bevel is wide at least: highlights are lines and no dashes; but ...  */
static const real MOST_BEVEL = 0.4;     /* ... no more than this share of half the smallest extent                              */
static const real SHELLS = 16;          /* while the distance from the eye doubles */
static const real SHOWN = 1.7;          /* how much finer the meshes of round bodies are where they are seen and do not only throw shadows */
static const real DULL = 0.35;          /* roughness from which on a floor mirrors nothing */
static const real CORNER_SKY = 2;       /* bodies up to so many times the typical radius take the hidden sky at their corners */
static const float SCALE = 0.1f;        /* of its colour, that a glowing body throws back */

/* Green without load, yellow at half of what breaks it, red there; linear. */
void stress_colour(float stress, float colour[3])
{
    float s = stress < 0 ? 0 : stress > 1 ? 1 : stress;
    colour[0] = s < 0.5f ? 0.03f + 1.5f * s : 0.78f;
    colour[1] = s < 0.5f ? 0.45f : 0.9f * (1 - s);
    colour[2] = 0.03f;
}

void dig_colour(uint32_t dig, float colour[3])
{
    /* golden-ratio steps round the colour circle: neighbours in number lie far apart */
    real hue = fmod(0.08 + 0.61803398874989485 * dig, 1.0) * 6;
    for (int i = 0; i < 3; i++) {
        real d = fabs(fmod(hue + 6 - 2 * i, 6) - 3) - 1;         /* hexagon: red, green, blue 120 degrees apart */
        real full = real_clamp(d, 0, 1);
        colour[i] = (float)(0.05 + 0.75 * full * full);
    }
}

static void put4(float out[4], real a, real b, real c, real d)
{
    out[0] = (float)a;
    out[1] = (float)b;
    out[2] = (float)c;
    out[3] = (float)d;
}

/* What a form is drawn with. All lengths in scene units. */
typedef struct Solid { int mesh; ProgramForm form; vec3 size, half; real shift, radius; } Solid;

static Solid round_solid(int mesh, ProgramForm form, real radius, real length, real pixels_per_unit, bool fine)
{
    real reach = 0.5 * length + radius;
    int level = fine ? MESH_LEVELS - 1 : mesh_level(radius * pixels_per_unit);
    return (Solid){mesh + level, form, {radius, radius, radius}, {radius, reach, radius}, length, reach};
}

/* A cylinder's or a cone's wall lies between the circle and its chords: the bevel starts from the chords. */
static Solid turned_solid(int mesh, ProgramForm form, real radius, real height, real pixels_per_unit, bool fine)
{
    int level = fine ? MESH_LEVELS - 1 : mesh_level(radius * pixels_per_unit);
    real inner = 0.9999 * radius * mesh_chord(level);
    return (Solid){mesh + level, form, {radius, height, radius}, {inner, 0.5 * height, inner}, 0, hypot(radius, 0.5 * height)};
}

static Solid solid_of(const ViewMesh *m, int uploaded, bool closed, real unit, real pixels_per_unit, bool fine)
{
    real a = (real)m->size[0] / unit, b = (real)m->size[1] / unit, c = (real)m->size[2] / unit;
    switch (m->form) {
    case VIEW_SPHERE:   return round_solid(MESH_SPHERE, FORM_SPHERE, a, 0, pixels_per_unit, fine);
    case VIEW_CAPSULE:  return round_solid(MESH_CAPSULE, FORM_SMOOTH, a, b, pixels_per_unit, fine);
    case VIEW_CYLINDER: return turned_solid(MESH_CYLINDER, FORM_CYLINDER, a, b, pixels_per_unit, fine);
    case VIEW_CONE:     return turned_solid(MESH_CONE, FORM_SMOOTH, a, b, pixels_per_unit, fine);
    case VIEW_BOX:      return (Solid){MESH_BOX, FORM_BOX, {a, b, c}, {a / 2, b / 2, c / 2}, 0, 0};
    case VIEW_PLANE:    return (Solid){MESH_QUAD, FORM_SMOOTH, {1, 1, 1}, {1, 1, 1}, 0, 0};
    case VIEW_MESH:     break;
    }
    return (Solid){uploaded, closed ? FORM_MESH : FORM_TWO_SIDED, {1 / unit, 1 / unit, 1 / unit}, {1, 1, 1}, 0, 0};
}

/* Length of one repeat of a pattern on a solid with these half extents. */
static real pattern_cell(int pattern, const ViewMesh *m, vec3 half)
{
    real small = 2 * real_min(half.x, real_min(half.y, half.z)), large = 2 * vec3_largest(half);
    switch (pattern) {
    case PATTERN_WOOD:   return real_max(small, 0.25 * large);
    case PATTERN_BRICK:  return large / ceil(real_clamp(large / (1.6 * small), 1, 40)) / 1.5;
    case PATTERN_TILE:   return small / 2;
    case PATTERN_STRIPE: return m->form == VIEW_BOX ? half.y : 2.6 * half.y;
    case PATTERN_CHECK:  return m->form == VIEW_BOX ? small / 2 : 2 * large;
    default:             return 1;
    }
}

/* Wood: the longest axis. Stripes: whether the band in the middle is the pale one, as on a ball. */
static real pattern_axis(int pattern, const ViewMesh *m, vec3 half)
{
    if (pattern == PATTERN_STRIPE)
        return m->form == VIEW_SPHERE || m->form == VIEW_BOX;
    return half.x >= half.y && half.x >= half.z ? 0 : half.y >= half.z ? 1 : 2;
}

/* Half the width of a band in repeats: balls and capsules have one slim band, boxes even stripes. */
static real pattern_band(const ViewMesh *m)
{
    return m->form == VIEW_SPHERE ? 0.125 : m->form == VIEW_CAPSULE || m->form == VIEW_CYLINDER ? 0.16 : 0.25;
}

/* An own mesh's half extents, for its patterns. */
static vec3 mesh_half(const View *v, const ViewItem *item, real unit)
{
    box3 box;
    if (!item_bounds(v, item, &box))
        return (vec3){1, 1, 1};
    return vec3_scale(1 / unit, vec3_max(vec3_abs(box.low), vec3_abs(box.high)));
}

static void set_colour(DrawItem *d, const ViewItem *item, const BatchEye *eye)
{
    vec3 c = vec3_min(vec3_max(vec3_from(item->colour), (vec3){0, 0, 0}), (vec3){1, 1, 1});
    if (eye->overlay_dig && item->dig) {
        float tint[3];
        dig_colour(item->dig, tint);
        c = vec3_lerp(c, vec3_from(tint), 0.85);
        if (item->asleep)
            c = vec3_lerp(c, (vec3){0.12, 0.12, 0.13}, 0.55);
    }
    if (eye->overlay_stress && item->stress >= 0) {
        float tint[3];
        stress_colour(item->stress, tint);
        c = vec3_from(tint);
    }
    real rough = real_clamp((real)item->roughness, 0.12, 1);
    put4(d->instance.colour, c.x, c.y, c.z, isfinite(rough) ? rough : 0.5);
}

/* What is hot shines; with a scale, what has a temperature is coloured by that alone, and the rest is grey. */
static void set_heat(DrawItem *d, const ViewItem *item, const BatchEye *eye)
{
    float colour[3], *own = d->instance.colour;
    real t = (real)item->temperature;
    if (eye->heat.on) {
        real grey = 0.25 * (real)(own[0] + own[1] + own[2]) / 3 + 0.12;
        bool has = t > 0 && isfinite(t);
        if (has)
            heat_colour((t - eye->heat.low) / (eye->heat.high - eye->heat.low), colour);
        put4(own, has ? (real)colour[0] : grey, has ? (real)colour[1] : grey, has ? (real)colour[2] : grey, 0.9);
        d->key.pattern = d->key.pattern == PATTERN_CHECK || !has ? d->key.pattern : PATTERN_PLAIN;
        d->instance.look[0] = has ? -0.35f : 0;
        return;
    }
    real strength = heat_glow(t, colour);
    if (!(strength > 0))
        return;
    /* scale glows black; what it shines with then hides what the room lights of it */
    real cover = real_min(1, 4 * sqrt(strength)), most = 0, dull = 1 - 0.7 * real_clamp((real)item->metallic, 0, 1);
    for (int i = 0; i < 3; i++) {
        own[i] = (float)((1 - cover) * dull * (real)own[i]) + (float)cover * SCALE * colour[i];
        most = real_max(most, (real)own[i]);
    }
    d->instance.look[0] = (float)(-strength / real_max(most, 0.01));
}

static real tile_size(real unit)
{
    /* 1, 2 or 5 times a power of ten metres, about an eighth of the scene */
    real want = 0.30 * unit, power = pow(10, floor(log10(want)));
    real step = want / power;
    return (step < 1.5 ? 1 : step < 3.5 ? 2 : step < 7.5 ? 5 : 10) * power;
}

real plane_sheen(const ViewItem *item)
{
    real smooth = real_clamp(1 - (real)item->roughness / DULL, 0, 1);
    return item->clear > 0 || !isfinite(smooth) ? 0 : smooth * smooth;
}

/* A plane is a quad under the eye that ends in the fog; its tiles stay where they are in the world. */
static void set_plane(DrawItem *d, const ViewItem *item, const Stage *s, const BatchEye *eye)
{
    quat q = quat_mul(quat_from_matrix(s->axes), quat_from(item->q));
    vec3 normal = quat_rotate(q, (vec3){0, 1, 0});
    vec3 point = stage_point(s, vec3_from(item->p));
    real height = vec3_dot(vec3_sub(eye->at, point), normal);
    vec3 foot = vec3_mad(eye->at, -height, normal);
    real cell = tile_size(s->unit) / s->unit;
    vec3 slide = vec3_scale(1 / cell, quat_unrotate(q, vec3_sub(foot, point)));
    vec3 place = vec3_sub(foot, eye->at);
    put4(d->instance.place, place.x, place.y, place.z, 0);
    put4(d->instance.size, eye->reach, 1, eye->reach, 0);
    put4(d->instance.look, 0, 0, 1 / cell, 0);
    if (eye->mirrors && d->index == s->floor_item) {
        put4(d->instance.look, 0, plane_sheen(item), 1 / cell, real_clamp((real)item->metallic, 0, 1));
        d->key.mirror = !eye->numbers;
    }
    /* whole hundreds dropped: few digits before the point, and the pattern's even and odd cells stay */
    put4(d->instance.half, fmod(slide.x, 100), fmod(slide.z, 100), 1, 0);
    d->distance = INFINITY;     /* after all bodies: it lies behind most of them */
    d->key.plane = true;
    d->key.floor = d->index == s->floor_item;
}

/* Fills in everything but the order; false when the item cannot be drawn. */
static bool describe(DrawItem *d, const Batches *b, const Meshes *meshes, const View *v, const Stage *s, const BatchEye *eye, int index)
{
    const ViewItem *item = &v->items[index];
    if (!item_sound(v, item) || b->meshes[item->mesh] < 0)
        return false;
    const ViewMesh *m = &v->meshes[item->mesh];
    int pattern = item->pattern >= PATTERN_PLAIN && item->pattern <= PATTERN_CHECK ? item->pattern : PATTERN_PLAIN;
    if (eye->overlay_stress && item->stress >= 0)
        pattern = PATTERN_PLAIN;
    *d = (DrawItem){.index = index, .mesh = b->meshes[item->mesh], .closed = true};
    d->key = (ProgramKey){.pattern = pattern, .lamps = eye->lamps, .shadows = eye->shadows};
    quat q = quat_mul(quat_from_matrix(s->axes), quat_from(item->q));
    put4(d->instance.turn, q.x, q.y, q.z, q.w);
    d->instance.clear = item->clear > 0 ? fminf(item->clear, 1) : 0;        /* 0 when it is no number */
    d->key.clear = d->instance.clear > 0;
    d->instance.number[0] = item->body;
    d->instance.number[1] = (uint32_t)index;
    set_colour(d, item, eye);
    if (m->form == VIEW_PLANE) {
        d->mesh = MESH_QUAD;
        set_plane(d, item, s, eye);
        set_heat(d, item, eye);
        return true;
    }
    vec3 place = vec3_sub(stage_point(s, vec3_from(item->p)), eye->at);
    real distance = vec3_length(place);
    bool closed = meshes->entry[d->mesh].closed;
    real pixels = (eye->numbers ? 1 : SHOWN) * eye->pixels / real_max(distance, 1e-6);
    Solid solid = solid_of(m, d->mesh, closed, s->unit, pixels, eye->fine);
    vec3 half = m->form == VIEW_MESH ? mesh_half(v, item, s->unit) : solid.half;
    real small = real_min(solid.half.x, real_min(solid.half.y, solid.half.z));
    real bevel = real_max(2 * BEVEL * small, real_min(FINEST * distance / eye->pixels, MOST_BEVEL * small));
    put4(d->instance.place, place.x, place.y, place.z, fmod(0.6180339887 * item->body, 1));
    put4(d->instance.size, solid.size.x, solid.size.y, solid.size.z, solid.shift);
    put4(d->instance.look, real_clamp((real)item->metallic, 0, 1), bevel, 1 / real_max(pattern_cell(pattern, m, half), 1e-9),
         pattern_axis(pattern, m, half));
    put4(d->instance.half, half.x, half.y, half.z, pattern_band(m));
    set_heat(d, item, eye);
    d->mesh = solid.mesh;
    d->closed = solid.form != FORM_TWO_SIDED;
    d->caster = !d->key.clear && !item->room;       /* light goes through */
    d->key.form = solid.form;
    d->key.corner_sky = d->closed && vec3_length(half) < CORNER_SKY * s->typical;
    d->distance = (float)distance;
    return true;
}

/* Numbers cost the same everywhere: by mesh, planes last. The rest before the planes, shell by shell from the eye, so that what is hidden
 * is seldom shaded, in a shell by program and mesh; two-sided meshes apart from closed ones is part of the form. Then what is seen
 * through. */
static uint64_t order_of(const DrawItem *d)
{
    if (d->key.clear) {         /* from far to near, each on its own */
        uint32_t bits;
        memcpy(&bits, &d->distance, sizeof bits);       /* not negative: as bits, in the same order */
        return (uint64_t)1 << 63 | (uint64_t)(INT32_MAX - bits) << 32 | (uint32_t)d->index;
    }
    if (d->numbered)
        return (uint64_t)d->key.plane << 62 | (uint64_t)d->mesh;
    real shell = d->key.plane ? 0 : real_clamp(1000 + SHELLS * log2((real)d->distance), 0, 2000);
    return (uint64_t)d->key.plane << 62 | (uint64_t)1 << 61 | (uint64_t)shell << 44 | (uint64_t)program_key_bits(d->key) << 16 | (uint64_t)d->mesh;
}

static int compare_items(const void *a, const void *b)
{
    const DrawItem *x = a, *y = b;
    if (x->order != y->order)
        return x->order < y->order ? -1 : 1;
    if (x->distance != y->distance)
        return x->distance < y->distance ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

static dig_status reserve(Batches *b, const View *v)
{
    if (v->item_count + 1 > b->capacity) {      /* the floor may be drawn in two pieces */
        size_t n = (size_t)v->item_count + (size_t)v->item_count / 2 + 1;
        DrawItem *items = realloc(b->items, n * sizeof *items);
        if (!items)
            return DIG_E_MEMORY;
        b->items = items;
        Instance *packed = realloc(b->packed, n * sizeof *packed);
        if (!packed)
            return DIG_E_MEMORY;
        b->packed = packed;
        b->capacity = (int)n;
    }
    if (v->mesh_count > b->mesh_capacity) {
        int *meshes = realloc(b->meshes, 2 * (size_t)v->mesh_count * sizeof *meshes);
        if (!meshes)
            return DIG_E_MEMORY;
        b->meshes = meshes;
        b->mesh_capacity = 2 * v->mesh_count;
    }
    return DIG_OK;
}

/* Cuts the floor's map out of the floor as a piece of its own, drawn first; the rest, a trifle deeper, needs no map (3 % of the drawing
 * time of 200 bodies). */
static void split_floor(Batches *b, Meshes *meshes, const Gl *gl, const BatchEye *eye)
{
    DrawItem *all = &b->items[b->count - 1], *patch = &b->items[b->count++];
    const Instance *k = &all->instance;
    quat q = quat_from(k->turn);
    float corners[4][2];
    for (int i = 0; i < 4; i++) {       /* seen from above, z of the quad points down */
        real x = eye->patch_x + (i & 1 ? eye->patch_half : -eye->patch_half), y = eye->patch_y - (i & 2 ? eye->patch_half : -eye->patch_half);
        vec3 at = quat_unrotate(q, vec3_sub((vec3){x - eye->at.x, y - eye->at.y, 0}, vec3_from(k->place)));
        corners[i][0] = (float)(at.x / (real)k->size[0]);
        corners[i][1] = (float)(at.z / (real)k->size[2]);
    }
    meshes_patch(meshes, gl, corners);
    b->solid++;
    b->drawn++;
    *patch = *all;
    patch->mesh = MESH_PATCH;
    all->key.open = true;
    patch->order = order_of(patch);
    all->order = order_of(all);
}

dig_status batches_build(Batches *b, Meshes *meshes, const Gl *gl, const View *v, const Stage *s, const BatchEye *eye, uint64_t draw)
{
    DIG_TRY(reserve(b, v));
    if (!b->buffer)
        gl->GenBuffers(1, &b->buffer);
    for (int i = 0; i < v->mesh_count; i++) {
        const ViewMesh *m = &v->meshes[i];
        b->meshes[i] = m->form == VIEW_MESH ? meshes_find(meshes, gl, m, mesh_hash(m), draw) : MESH_BOX;
    }
    b->count = b->solid = b->drawn = 0;
    for (int i = 0; i < v->item_count; i++) {
        DrawItem *d = &b->items[b->count];
        if (!describe(d, b, meshes, v, s, eye, i))
            continue;
        d->numbered = eye->numbers && subject_can(d);
        d->order = order_of(d);
        b->solid += !d->key.clear;
        b->drawn += !d->numbered;
        b->count++;
        if (eye->patch && !d->numbered && d->key.floor && !d->key.clear)
            split_floor(b, meshes, gl, eye);
    }
    if (b->count == 0)
        return DIG_OK;
    qsort(b->items, (size_t)b->count, sizeof *b->items, compare_items);
    for (int i = 0; i < b->count; i++)
        b->packed[i] = b->items[i].instance;
    gl->BindBuffer(GL_ARRAY_BUFFER, b->buffer);
    gl->BufferData(GL_ARRAY_BUFFER, b->count * (GLsizeiptr)sizeof *b->packed, b->packed, GL_STREAM_DRAW);
    return DIG_OK;
}

void batches_close(Batches *b, const Gl *gl)
{
    if (b->buffer)
        gl->DeleteBuffers(1, &b->buffer);
    free(b->items);
    free(b->packed);
    free(b->meshes);
    *b = (Batches){0};
}

/* Points the instance attributes at entry `first`: OpenGL 3.3 cannot start at an instance by itself. */
static void aim(const Gl *gl, GLuint buffer, int first)
{
    gl->BindBuffer(GL_ARRAY_BUFFER, buffer);
    uintptr_t base = (uintptr_t)first * sizeof(Instance);
    for (GLuint k = 0; k < 8; k++) {
        GLuint slot = 2 + k;
        gl->EnableVertexAttribArray(slot);
        if (k == 7)
            gl->VertexAttribPointer(slot, 1, GL_FLOAT, GL_FALSE, sizeof(Instance), (const void *)(base + offsetof(Instance, clear)));
        else if (k < 6)
            gl->VertexAttribPointer(slot, 4, GL_FLOAT, GL_FALSE, sizeof(Instance), (const void *)(base + k * sizeof(float[4])));
        else
            gl->VertexAttribIPointer(slot, 2, GL_UNSIGNED_INT, sizeof(Instance), (const void *)(base + offsetof(Instance, number)));
        gl->VertexAttribDivisor(slot, 1);
    }
}

static ProgramKey key_for(const DrawItem *d, ProgramKind kind)
{
    if (kind == PROGRAM_SURFACE) {
        ProgramKey key = d->key;
        key.kind = kind;
        if (key.form == FORM_SPHERE)
            key.form = FORM_SMOOTH;     /* the mesh's normals are the sphere's */
        return key;
    }
    if (kind == PROGRAM_NUMBER)
        return (ProgramKey){.kind = kind};
    /* data layers need the form only */
    return (ProgramKey){.kind = kind, .form = d->key.form};
}

dig_status batches_draw(const Batches *b, const Meshes *meshes, Programs *programs, const Gl *gl, ProgramKind kind, int first, int last,
                        char *why, size_t capacity)
{
    int end;
    for (int i = first; i < last; i = end) {
        const DrawItem *d = &b->items[i];
        for (end = i + 1; end < last && b->items[end].order == d->order; end++) {
        }
        const Program *program = programs_get(programs, gl, key_for(d, d->numbered && kind == PROGRAM_SURFACE ? PROGRAM_NUMBER : kind), why, capacity);
        if (!program)
            return DIG_E_FORMAT;
        gl->UseProgram(program->name);
        (d->closed ? gl->Enable : gl->Disable)(GL_CULL_FACE);
        (d->key.open ? gl->Enable : gl->Disable)(GL_POLYGON_OFFSET_FILL);
        const GpuMesh *mesh = &meshes->entry[d->mesh];
        gl->BindVertexArray(mesh->array);
        aim(gl, b->buffer, i);
        gl->DrawElementsInstanced(GL_TRIANGLES, mesh->index_count, GL_UNSIGNED_INT, NULL, end - i);
    }
    return DIG_OK;
}
