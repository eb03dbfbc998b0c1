/* effect/buoyancy.c - water with a level surface: what is in it is borne by the weight of the water it displaces, and dragged.
 *
 * Water and bodies that say so expand as they warm (Boussinesq: rho (1 - expansion (T - T0)); V (1 + expansion (T - T0)); a body's
 * shape stays as it is for all else): the temperature of the water is that of what is about bodies, world:ambient. What a body in it
 * swells pushes water up: that work is taken from the heat that is lost.
 *
 * The force rho g V acts at the centre of the displaced volume V, upward; drag acts there, too, on the wetted share of the body,
 * with the coefficient and area that it has in air. The water stands still but for its current: it makes no waves, and gives the
 * bodies no added mass.
 */
#include "effect/effect.h"
#include "geom/wet.h"
#include "solve/medium.h"

typedef struct Water {
    real density, level;        /* kg/m^3, m along gravity's opposite                  */
    vec3 current;               /* m/s                                                 */
    real damping;               /* 1/s                                                 */
    vec3 at, size;              /* m   the basin; size 0: it has no end that way       */
    real viscosity;             /* Pa s                                                */
    real expansion, expansion_from;         /* 1/K, K at which it has its density      */
} Water;

static const dig_param world_params[] = {
    {.name = "density", .kind = DIG_REAL, .unit = "kg/m^3", .doc = "of the water", .fallback = 1000, .min = 0, .max = 1e5,
     .offset = offsetof(Water, density)},
    {.name = "level", .kind = DIG_REAL, .unit = "m", .doc = "height of the surface, against gravity from the origin", .fallback = 0, .min = -1e6,
     .max = 1e6, .offset = offsetof(Water, level)},
    {.name = "current", .kind = DIG_VEC3, .unit = "m/s", .doc = "velocity of the water", .fallback = 0, .min = -1e4, .max = 1e4,
     .offset = offsetof(Water, current)},
    {.name = "damping", .kind = DIG_REAL, .unit = "1/s", .doc = "rate at which motion in it dies away besides drag, for the waves that it makes",
     .fallback = 0, .min = 0, .max = 1e6, .offset = offsetof(Water, damping)},
    {.name = "at", .kind = DIG_VEC3, .unit = "m", .doc = "middle of the basin", .fallback = 0, .min = -1e6, .max = 1e6, .offset = offsetof(Water, at)},
    {.name = "size", .kind = DIG_VEC3, .unit = "m", .doc = "full extents of the basin; 0: no end that way", .fallback = 0, .min = 0, .max = 1e6,
     .offset = offsetof(Water, size)},
    {.name = "viscosity", .kind = DIG_REAL, .unit = "Pa*s", .doc = "Stokes' drag besides, as on a ball of the same volume; water has 1e-3",
     .fallback = 0, .min = 0, .max = 1e6, .offset = offsetof(Water, viscosity)},
    {.name = "expansion", .kind = DIG_REAL, .unit = "1/K", .doc = "of its volume as it warms", .fallback = 0, .min = -0.1, .max = 0.1,
     .offset = offsetof(Water, expansion)},
    {.name = "expansion_from", .kind = DIG_REAL, .unit = "K", .doc = "at which it has its density", .fallback = AMBIENT, .min = 0, .max = 1e7,
     .offset = offsetof(Water, expansion_from)},
    {0}
};

/* ---- what is displaced ---- */

typedef struct Displaced { real volume, whole; vec3 centre; } Displaced;       /* m^3, m^3, m from the centre of mass */

/* Within the basin is whose centre of mass is. Upward only the surface ends it: a body that is half under when its centre comes
 * to the rim was borne before. */
static bool within(const Water *water, vec3 x, vec3 up)
{
    vec3 from = vec3_sub(x, water->at), half = vec3_scale(0.5, water->size);
    vec3 off = vec3_abs(vec3_mad(from, -real_max(0, vec3_dot(from, up)), up));
    return !((half.x > 0 && off.x > half.x) || (half.y > 0 && off.y > half.y) || (half.z > 0 && off.z > half.z));
}

static const EffectSlot *other(const World *w, const char *name)
{
    for (int i = 0; i < w->effect_count; i++)
        if (strcmp(w->effects[i].type->name, name) == 0)
            return &w->effects[i];
    return NULL;
}

/* kg/m^3  at a height against gravity */
static real density_at(const World *w, const Water *water, real height)
{
    if (water->expansion == 0)
        return water->density;
    const EffectSlot *heat = other(w, "heat");
    return water->density * real_max(0, 1 - water->expansion * (surround_at(heat ? heat->world : NULL, height) - water->expansion_from));
}

/* By a body with its centre of mass at x and turned by q, in water below up . p <= level. */
static Displaced displaced(const World *w, uint32_t body, vec3 x, quat q, vec3 up, real level)
{
    const Body *b = &w->bodies.data[body];
    pose origin = {vec3_sub(x, quat_rotate(q, b->centre)), q};
    Displaced d = {0, 0, {0, 0, 0}};
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next) {
        const Solid *solid = &w->solids.data[s];
        pose at = pose_mul(origin, solid->form->at);
        Wet wet = shape_wet(&solid->form->shape, quat_unrotate(at.q, up), level - vec3_dot(up, at.p));
        MassProps mass = {.volume = 0};
        if (solid->form->shape.type->mass)
            solid->form->shape.type->mass(&solid->form->shape, &mass);
        d.whole += mass.volume;
        if (!(wet.volume > 0))
            continue;
        d.volume += wet.volume;
        d.centre = vec3_add(d.centre, vec3_add(quat_rotate(at.q, wet.moment), vec3_scale(wet.volume, vec3_sub(at.p, x))));
    }
    d.centre = d.volume > 0 ? vec3_scale(1 / d.volume, d.centre) : vec3_zero();
    const EffectSlot *heat = other(w, "heat");
    const Warmth *own = heat ? column_find(&heat->members, body) : NULL;
    if (own && own->swelled != 0) {
        d.volume *= 1 + own->swelled;
        d.whole *= 1 + own->swelled;
    }
    return d;
}

/* ---- the force ---- */

/* Coefficients in water are those in air. */
static const DragBody *own_drag(const World *w, uint32_t body)
{
    const EffectSlot *drag = other(w, "drag");
    return drag ? column_find(&drag->members, body) : NULL;
}

/* The force is that of the middle of the substep, where the body gets by its velocity and by this very force: so implicit, it keeps
 * the energy of bobbing and is stable for a cork in any step. The spring is stiffest with the whole shadow in the surface. */
static void bear(const Water *water, Group *g, int i, vec3 up, real gravity)
{
    Member *m = &g->member[i];
    real h = g->h, im = m->im;
    vec3 x = vec3_mad(g->pos[i].x, 0.5 * h, g->vel[i].v);
    quat q = quat_unit(quat_mul(quat_exp(vec3_scale(0.5 * h, g->vel[i].w)), g->pos[i].q));
    if (!within(water, x, up))
        return;
    Displaced d = displaced(g->world, m->slot, x, q, up, water->level);
    if (!(d.volume > 0))
        return;
    real density = density_at(g->world, water, vec3_dot(up, vec3_add(x, d.centre))), weight = density * gravity;
    real area = 0, drag;
    if (d.volume < d.whole)
        medium_area(g->world, m->slot, q, up, &area, &drag);
    real others = vec3_dot(up, m->force), soft = 1 + 0.25 * h * h * weight * area * im;
    real lift = (others + weight * d.volume) / soft - others;
    m->force = vec3_mad(m->force, lift, up);
    m->torque = vec3_mad(m->torque, weight * d.volume / soft, vec3_cross(d.centre, up));
    Medium medium = {density, water->current, water->damping, water->viscosity};
    if (density > 0)
        medium_drag(g, i, &medium, own_drag(g->world, m->slot), d.volume / d.whole, density * d.volume, d.centre);
}

static dig_status force(const EffectSlot *e, Group *g)
{
    const Water *water = e->world;
    real gravity = vec3_length(g->gravity);
    if (!water || !(gravity > 0))
        return DIG_OK;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves)
            bear(water, g, i, vec3_scale(-1 / gravity, g->gravity), gravity);
    g->stores = true;
    return DIG_OK;
}

/* Might some of the body get wet in this step? */
static bool comes_near(const World *w, const Water *water, const Body *b, vec3 up)
{
    real dt = w->def.step, r = b->outer + dt * (vec3_length(b->v) + dt * b->pull);
    box3 at = box3_grow((box3){b->x, b->x}, r);
    real x[3][3] = {{water->at.x - at.high.x, at.low.x - water->at.x, water->size.x},
                    {water->at.y - at.high.y, at.low.y - water->at.y, water->size.y},
                    {water->at.z - at.high.z, at.low.z - water->at.z, water->size.z}};
    real rise[3] = {up.x, up.y, up.z};
    for (int k = 0; k < 3; k++)             /* below its low end, or past its high one; what is above counts as within */
        if (x[k][2] > 0 && ((rise[k] >= 0 && x[k][0] > 0.5 * x[k][2]) || (rise[k] <= 0 && x[k][1] > 0.5 * x[k][2])))
            return false;
    return vec3_dot(up, b->x) - r <= water->level;
}

static bool wanted(const World *w, const Group *g)
{
    const EffectSlot *e = other(w, "buoyancy");
    for (int i = 0; e && e->world && i < g->moving_count; i++)
        if (comes_near(w, e->world, &w->bodies.data[g->member[i].slot], medium_up(w)))
            return true;
    return false;
}

/* J/m^3  What it takes to push something under: the weight of the water displaced, times how far it was lifted. Its density is linear
 * in height. */
static real pushed(const World *w, const Water *water, real height)
{
    real mean = 0.5 * (density_at(w, water, height) + density_at(w, water, water->level));
    return mean * vec3_length(w->def.gravity) * (water->level - height);
}

#define NOTICED 1e-5            /* of its volume: who sleeps in the water hears of so much */

/* Bodies are as large as their temperature has made them. */
static void flow(World *w, EffectSlot *e, real dt)
{
    const Water *water = e->world;
    const EffectSlot *heat = other(w, "heat");
    const Column *c = heat ? &heat->members : NULL;
    vec3 up = medium_up(w);
    (void)dt;
    for (int i = 0; water && c && i < c->count; i++) {
        Warmth *h = column_at(c, i);
        const Body *b = &w->bodies.data[c->body[i]];
        real swelled = real_max(h->expansion * (h->temperature - h->expansion_from), SHRUNK);
        bool sleeps = b->kind == DIG_DYNAMIC && !b->awake;
        if (swelled == h->swelled || (sleeps && fabs(swelled - h->swelled) < NOTICED))
            continue;
        Displaced d = {0};
        if (e->on && b->kind == DIG_DYNAMIC && within(water, b->x, up))
            d = displaced(w, c->body[i], b->x, b->q, up, water->level);
        real more = (swelled - h->swelled) / (1 + h->swelled) * d.volume;
        w->ledger.lost -= more * pushed(w, water, vec3_dot(up, vec3_add(b->x, d.centre)));
        h->swelled = swelled;
        if (sleeps && d.volume > 0)
            body_wake(w, c->body[i]);
    }
}

static void energy(const World *w, const EffectSlot *e, dig_energy *sum)
{
    const Water *water = e->world;
    real gravity = vec3_length(w->def.gravity);
    if (!e->on || !water || !(gravity > 0))
        return;
    vec3 up = vec3_scale(-1 / gravity, w->def.gravity);
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (!b->alive || b->kind != DIG_DYNAMIC || !within(water, b->x, up))
            continue;
        Displaced d = displaced(w, (uint32_t)i, b->x, b->q, up, water->level);
        sum->potential += d.volume * pushed(w, water, vec3_dot(up, vec3_add(b->x, d.centre)));
    }
}

const EffectType effect_buoyancy = {
    .name = "buoyancy",
    .law = "F = -rho g V, at the centre of the displaced volume V",
    .cite = "archimedes1897",
    .world_params = world_params,
    .world_size = sizeof(Water),
    .wanted = wanted,
    .varies = true,
    .energy = energy,
    .flow = flow,
    .run = {[STAGE_FORCE] = force},
};
