/* effect/heat.c - heat: lumped bodies, conduction where they touch, convection, radiation, heaters, and what friction, blows
 * and joints lose.
 *
 * Each body that takes part is a node of a network (solve/network.h), the air around a boundary. The list of what may touch is
 * made and planned before the step is committed, so that flow takes no memory; what does touch, and how hard, is looked up
 * afterwards. Bodies may sleep and be fixed: heat goes on.
 *
 * The books: what is stored since the bodies joined is dig_energy.heat; heaters do work; what goes to the air, and into bodies
 * that keep their temperature, is lost. Friction and blows were booked as lost: what a node takes of it is stored instead.
 */
#include "effect/heat.h"

#include "effect/effect.h"
#include "world/joint.h"
#include "world/region.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

static_assert(offsetof(Heat, swelled) == offsetof(Warmth, swelled) && offsetof(Heat, expansion_from) == offsetof(Warmth, expansion_from),
              "others read the first fields of Heat as Warmth");
static_assert(offsetof(HeatWorld, gradient) == offsetof(Surround, gradient), "others read the first options as Surround");

#define FIELD(NAME, UNIT, DOC, FALLBACK, MIN, MAX) \
    {.name = #NAME, .kind = DIG_REAL, .unit = UNIT, .doc = DOC, .fallback = FALLBACK, .min = MIN, .max = MAX, .offset = offsetof(Heat, NAME)}
#define OPTION(NAME, UNIT, DOC, FALLBACK, MIN, MAX) \
    {.name = #NAME, .kind = DIG_REAL, .unit = UNIT, .doc = DOC, .fallback = FALLBACK, .min = MIN, .max = MAX, .offset = offsetof(HeatWorld, NAME)}

static const dig_param body_rows[] = {
    FIELD(temperature, "K", "of the whole body; when it joins, default that of the air", NAN, 0, HEAT_MOST),
    FIELD(expansion, "1/K", "of its volume as it warms: what floats by it; its shape stays as it is", 0, -0.1, 0.1),
    FIELD(expansion_from, "K", "temperature at which it is as large as its shapes; default that at which it joins", NAN, 0, HEAT_MOST),
    FIELD(heat_capacity, "J/(kg*K)", "per mass; default that of the material", NAN, 1e-3, 1e9),
    FIELD(conductivity, "W/(m*K)", "where it touches; default that of the material", NAN, 0, 1e6),
    FIELD(emissivity, "1", "share of a black body's radiation that it gives off and takes up", 0, 0, 1),
    FIELD(convection, "W/(m^2*K)", "to the air, per surface", 0, 0, 1e6),
    FIELD(surface, "m^2", "that the air gets to; default that of the shapes", NAN, 0, 1e15),
    FIELD(contact_conductance, "W/K", "with each body that it touches; default by area and pressure", NAN, 0, 1e9),
    FIELD(heating, "W", "power fed in", 0, -1e12, 1e12),
    {0}
};

/* Such surfaces, at a bar: about 5 kW/(m^2 K) between pieces of steel. */
static const dig_param world_rows[] = {
    OPTION(ambient, "K", "temperature of the air, or the water, about bodies", HEAT_AMBIENT, 0, HEAT_MOST),
    OPTION(gradient, "K/m", "how much warmer it is higher up; `ambient` is that at the origin's height", 0, -1e6, 1e6),
    OPTION(asperities, "1/m", "mean slope of the surfaces over their roughness", 1e5, 0, 1e12),
    OPTION(hardness, "Pa", "of the softer surface's peaks", 1e8, 1, 1e15),
    {0}
};

static HeatWorld options_of(const EffectSlot *e)
{
    HeatWorld o = {HEAT_AMBIENT, 0, 1e5, 1e8};
    return e->world ? *(const HeatWorld *)e->world : o;
}

/* ---- kernels ---- */

real heat_contact(const HeatWorld *o, real ka, real kb, real force, real area)
{
    real both = ka + kb > 0 ? 2 * ka * kb / (ka + kb) : 0;
    if (!(force > 0 && area > 0))
        return 0;
    return 1.25 * both * o->asperities * area * pow(force / (area * o->hardness), 0.95);
}

real heat_share(real ea, real eb) { return ea + eb > 0 ? ea / (ea + eb) : 0.5; }

#define PEAK 1e-3               /* m */

real heat_area(const Manifold *m)
{
    vec3 twice = vec3_zero();
    for (int i = 2; i < m->count; i++)
        twice = vec3_add(twice, vec3_cross(vec3_sub(m->points[i - 1].a, m->points[0].a), vec3_sub(m->points[i].a, m->points[0].a)));
    real along = m->count > 1 ? vec3_distance(m->points[0].a, m->points[1].a) : 0;
    return real_max(0.5 * fabs(vec3_dot(twice, m->normal)), PEAK * real_max(along, PEAK));
}

static NetLine radiation(const NetBranch *b, real xa, real xb, real h)
{
    real ta = real_max(xa, 0), tb = real_max(xb, 0), g = 4 * b->p[0] * ta * ta * ta;
    (void)h;
    return (NetLine){g, b->p[0] * (ta * ta * ta * ta - tb * tb * tb * tb) - g * (xa - xb)};
}

/* ---- joining ---- */

static const dig_material_def *material_of(const World *w, const Body *b) { return &w->materials.data[body_make(b)->surface.material].def; }

/* m^2 */
static real surface_of(const World *w, const Body *b)
{
    real sum = 0;
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next) {
        const Shape *shape = &w->solids.data[s].form->shape;
        sum += shape->type->area ? shape->type->area(shape) : 0;
    }
    return sum;
}

/* kg  What does not obey forces has no mass: it weighs what its materials do. 0: planes and open grounds. */
static real mass_of(const World *w, const Body *b)
{
    real sum = 0;
    for (uint32_t s = b->shape_first; s != NONE && b->kind != DIG_DYNAMIC; s = w->solids.data[s].next) {
        const Solid *solid = &w->solids.data[s];
        MassProps m = {0};
        if (solid->form->shape.type->mass)
            solid->form->shape.type->mass(&solid->form->shape, &m);
        sum += w->materials.data[solid->form->surface.material].def.density * m.volume;
    }
    return b->kind == DIG_DYNAMIC ? b->mass : sum;
}

/* What a body does not say of itself is its material's, whichever that is now. was: what the material gave before, NaN: nothing. */
static real of_material(real said, real was, real now, real *given)
{
    bool own = !isnan(said) && said != was;
    *given = own ? NAN : now;
    return own ? said : now;
}

static dig_status join(const World *w, const EffectSlot *e, uint32_t body, void *member, char *why, size_t capacity)
{
    Heat *h = member;
    const Body *b = &w->bodies.data[body];
    const Heat *old = column_find(&e->members, body);
    if (old && h->temperature != old->temperature) {
        snprintf(why, capacity, "%s: temperature cannot be assigned; use body:warm{to = %g}", BODY_TEXT(w, b), h->temperature);
        return DIG_E_KIND;
    }
    h->temperature = isnan(h->temperature) ? surround_at(e->world, vec3_dot(medium_up(w), b->x)) : h->temperature;
    h->expansion_from = isnan(h->expansion_from) ? h->temperature : h->expansion_from;
    h->heat_capacity = of_material(h->heat_capacity, old ? old->material_capacity : NAN, material_of(w, b)->heat_capacity, &h->material_capacity);
    h->conductivity = of_material(h->conductivity, old ? old->material_conductivity : NAN, material_of(w, b)->conductivity,
                                  &h->material_conductivity);
    h->swelled = old ? old->swelled : real_max(h->expansion * (h->temperature - h->expansion_from), SHRUNK);
    h->surface = isnan(h->surface) ? surface_of(w, b) : h->surface;
    h->capacity = h->heat_capacity * mass_of(w, b);
    h->stored = old && h->capacity > 0 ? old->stored : 0;
    h->start = h->capacity > 0 ? h->temperature - h->stored / h->capacity : h->temperature;
    if (!isfinite(h->capacity) || !isfinite(h->surface)) {
        snprintf(why, capacity, "%s: %s is not finite", BODY_TEXT(w, b), isfinite(h->surface) ? "its heat capacity" : "its surface");
        return DIG_E_ARG;
    }
    return DIG_OK;
}

/* ---- what may touch ---- */

typedef struct Near { uint32_t pair; int a, b; int branch; } Near;       /* members; b < 0: the other body takes no part */

typedef struct Plan {
    Network net;
    Near   *near; int count;
    int    *node;               /* of each member; from net.nodes on: the air and those that keep their temperature */
    real   *given;              /* J  each member gets from its contacts */
    real   *out;                /* J  each node gives off */
    int     contacts;           /* branches [0, contacts) are between bodies, then come the air's */
} Plan;

static int member_of(const Column *c, uint32_t body) { return body != NONE && body < (uint32_t)c->rows ? (int)c->row[body] - 1 : -1; }

/* Each pair of solids once: from the member of it that comes first. near NULL: only counts. */
static int list_near(const World *w, const Column *c, Near *near)
{
    int n = 0;
    for (int i = 0; i < c->count; i++)
        for (uint32_t s = w->bodies.data[c->body[i]].shape_first; s != NONE; s = w->solids.data[s].next)
            for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
                const Pair *p = &w->pairs.data[l / 2];
                int other = member_of(c, l % 2 ? p->body_a : p->body_b);
                if (other >= 0 && other < i)
                    continue;
                if (near)
                    near[n] = (Near){l / 2, i, other, -1};
                n++;
            }
    return n;
}

static int compare_near(const void *a, const void *b)
{
    const Near *x = a, *y = b;
    if (x->a != y->a)
        return x->a < y->a ? -1 : 1;
    if (x->b != y->b)
        return x->b < y->b ? -1 : 1;
    return (x->pair > y->pair) - (x->pair < y->pair);
}

static bool advanced(const World *w, uint32_t body)
{
    return body != NONE && w->bodies.data[body].kind == DIG_DYNAMIC && w->bodies.data[body].awake;
}

static real capacity_of(const Column *c, int member) { return ((const Heat *)column_at(c, member))->capacity; }

/* Might heat flow from one to the other in this step? Sleepers do not begin to touch. */
static bool may_conduct(const World *w, const Column *c, const Near *n)
{
    const Pair *p = &w->pairs.data[n->pair];
    return n->b >= 0 && (capacity_of(c, n->a) > 0 || capacity_of(c, n->b) > 0) &&
           (p->touching || advanced(w, p->body_a) || advanced(w, p->body_b));
}

/* Pairs of solids of the same two bodies share a branch. */
static int number_branches(const World *w, const Column *c, Near *near, int count)
{
    int n = 0, shared = -1;
    for (int i = 0; i < count; i++) {
        bool same = i > 0 && near[i].a == near[i - 1].a && near[i].b == near[i - 1].b;
        shared = same ? shared : -1;
        if (!may_conduct(w, c, &near[i]))
            continue;
        shared = shared < 0 ? n++ : shared;
        near[i].branch = shared;
    }
    return n;
}

static bool cools(const Heat *h, bool radiates)
{
    return h->capacity > 0 && h->surface > 0 && (radiates ? h->emissivity : h->convection) > 0;
}

static void set_ends(Plan *p, const Column *c)
{
    int n = p->contacts;
    for (int i = 0; i < p->count; i++)
        if (p->near[i].branch >= 0)
            p->net.branch[p->near[i].branch] = (NetBranch){.a = p->node[p->near[i].a], .b = p->node[p->near[i].b]};
    for (int i = 0; i < c->count; i++) {
        const Heat *h = column_at(c, i);
        if (cools(h, false))
            p->net.branch[n++] = (NetBranch){.a = p->node[i], .b = p->net.nodes, .line = {h->convection * h->surface, 0}};
        if (cools(h, true))
            p->net.branch[n++] = (NetBranch){.a = p->node[i], .b = p->net.nodes, .law = radiation,
                                             .p = {HEAT_SIGMA * h->emissivity * h->surface}};
    }
}

#define DIRECT 64               /* bodies that hang together: with more, planning costs more than solving */

static dig_status reserve(World *w, EffectSlot *e, real dt)
{
    (void)dt;
    const Column *c = &e->members;
    Plan *p = arena_zero(&w->scratch, sizeof *p);
    e->plan = NULL;
    if (c->count == 0)
        return DIG_OK;
    int count = list_near(w, c, NULL), nodes = 0, air = 0, kept = 1;
    Near *near = arena_alloc(&w->scratch, ((size_t)count + 1) * sizeof *near);
    int *node = arena_alloc(&w->scratch, (size_t)c->count * sizeof *node);
    real *given = arena_alloc(&w->scratch, 2 * (size_t)c->count * sizeof *given);
    if (!p || !near || !node || !given)
        return world_fail(w, DIG_E_MEMORY, "effect 'heat': not enough memory");
    list_near(w, c, near);
    qsort(near, (size_t)count, sizeof *near, compare_near);
    *p = (Plan){.near = near, .count = count, .node = node, .given = given, .out = given + c->count, .contacts = number_branches(w, c, near, count)};
    for (int i = 0; i < c->count; i++) {
        const Heat *h = column_at(c, i);
        nodes += h->capacity > 0;
        air += cools(h, false) + cools(h, true);
    }
    for (int i = 0, n = 0; i < c->count; i++)
        node[i] = ((const Heat *)column_at(c, i))->capacity > 0 ? n++ : nodes + kept++;
    dig_status s = network_open(&p->net, &w->scratch, nodes, kept, p->contacts + air);
    if (s == DIG_OK) {
        p->net.direct = DIRECT;
        set_ends(p, c);
        s = network_plan(&p->net, &w->scratch);
    }
    if (s != DIG_OK)
        return world_fail(w, s, "effect 'heat': not enough memory for %d bodies and %d contacts", c->count, count);
    e->plan = p;
    return DIG_OK;
}

/* ---- what does touch ---- */

static Manifold manifold_of(const World *w, const Contact *c)
{
    Manifold m = {.normal = c->normal, .count = c->count};
    for (int k = 0; k < c->count; k++)
        m.points[k] = contact_point_seen(w, c, k)->at;
    return m;
}

/* W/K */
static real conductance(const World *w, const HeatWorld *o, const Pair *pair, const Heat *a, const Heat *b)
{
    real sum = 0;
    for (uint32_t k = pair->contact; k != NONE; k = w->contacts.data[k].next) {
        const Contact *c = &w->contacts.data[k];
        if (!c->touching || c->count == 0)
            continue;
        Manifold m = manifold_of(w, c);
        sum += heat_contact(o, a->conductivity, b->conductivity, vec3_dot(c->force, c->normal), heat_area(&m));
    }
    return sum;
}

/* J  that the solids of a pair lost in this step */
static real loss_of(const World *w, const Pair *p)
{
    real sum = 0;
    if (!advanced(w, p->body_a) && !advanced(w, p->body_b))
        return 0;
    for (uint32_t k = p->contact; k != NONE; k = w->contacts.data[k].next)
        sum += contact_rest(w, k).lost;
    return sum;
}

/* J/(m^2 K s^0.5) */
static real effusivity(const World *w, const EffectSlot *e, uint32_t body, uint32_t solid)
{
    const Heat *h = column_find(&e->members, body);
    const dig_material_def *m = &w->materials.data[w->solids.data[solid].form->surface.material].def;
    real density = body != NONE && w->bodies.data[body].density > 0 ? w->bodies.data[body].density : m->density;
    return sqrt((h ? h->conductivity * h->heat_capacity : m->conductivity * m->heat_capacity) * density);
}

static void share_loss(const World *w, const EffectSlot *e, Plan *p, const Near *n, real lost)
{
    const Pair *pair = &w->pairs.data[n->pair];
    real into_a = heat_share(effusivity(w, e, pair->body_a, pair->solid_a), effusivity(w, e, pair->body_b, pair->solid_b));
    int a = member_of(&e->members, pair->body_a), b = member_of(&e->members, pair->body_b);
    if (a >= 0)
        p->given[a] += into_a * lost;
    if (b >= 0)
        p->given[b] += (1 - into_a) * lost;
}

/* Where a body says how well it conducts, the one that conducts worse counts. */
static real said(const Heat *a, const Heat *b)
{
    real x = a->contact_conductance, y = b->contact_conductance;
    return isnan(x) ? y : isnan(y) ? x : real_min(x, y);
}

/* 1  where they touch */
static real law_of_place(const World *w, const Pair *pair)
{
    return w->region_count > 0 && pair->contact != NONE ? region_conduct(w, w->contacts.data[pair->contact].point) : 1;
}

static void look_at_contacts(const World *w, const EffectSlot *e, Plan *p)
{
    HeatWorld o = options_of(e);
    for (int i = 0; i < p->count; i++) {
        const Near *n = &p->near[i];
        const Pair *pair = &w->pairs.data[n->pair];
        if (!pair->alive)
            continue;
        real lost = loss_of(w, pair);
        if (lost != 0 && isfinite(lost))
            share_loss(w, e, p, n, lost);
        if (n->branch < 0 || !pair->touching)
            continue;
        const Heat *a = column_at(&e->members, n->a), *b = column_at(&e->members, n->b);
        NetLine *line = &p->net.branch[n->branch].line;
        real given = said(a, b);
        real place = law_of_place(w, pair);
        line->g = isnan(given) ? line->g + place * conductance(w, &o, pair, a, b) : place * given;
    }
}

/* What a joint's friction and dampers lose warms both its bodies, half each; the world's half, and that of a body that takes no part,
 * stays lost. */
static void look_at_joints(const World *w, const EffectSlot *e, Plan *p)
{
    for (int i = 0; i < e->members.count; i++) {
        uint32_t body = e->members.body[i];
        for (uint32_t j = w->bodies.data[body].joint_first; j != NONE; j = joint_next(w, j, body)) {
            const JointRec *r = &w->joints.data[j];
            if ((advanced(w, r->a) || advanced(w, r->b)) && isfinite(r->lost))
                p->given[i] += 0.5 * r->lost;
        }
    }
}

/* ---- the step ---- */

/* What is about a body may be warmer or colder than at the origin's height: its branch gives or takes the difference. */
static void lift_air(const World *w, const EffectSlot *e, Plan *p)
{
    const HeatWorld *o = e->world;
    vec3 up = medium_up(w);
    int n = p->contacts;
    for (int i = 0; o && o->gradient != 0 && i < e->members.count; i++) {
        const Heat *h = column_at(&e->members, i);
        real warmer = surround_at(e->world, vec3_dot(up, w->bodies.data[e->members.body[i]].x)) - o->ambient;
        if (cools(h, false)) {
            NetLine *line = &p->net.branch[n++].line;
            line->i0 = -line->g * warmer;
        }
        n += cools(h, true);
    }
}

static void load(const EffectSlot *e, Plan *p, real dt)
{
    p->net.effort[p->net.nodes] = options_of(e).ambient;
    for (int i = 0; i < e->members.count; i++) {
        const Heat *h = column_at(&e->members, i);
        p->net.effort[p->node[i]] = h->temperature;
        if (p->node[i] >= p->net.nodes)
            continue;
        p->net.capacity[p->node[i]] = h->capacity;
        p->net.source[p->node[i]] = h->heating + p->given[i] / dt;
    }
}

/* s  that each node went on */
static real passed(const Plan *p, int node)
{
    for (int i = 0; i < p->net.parts; i++)
        for (int k = 0; k < p->net.part[i].nodes; k++)
            if (p->net.member[p->net.part[i].node + k] == node)
                return p->net.part[i].passed;
    return 0;
}

/* A cooler takes no more than there is, and a heater gives no more than a body can hold; what else would do so is lost. */
static void keep_possible(World *w, Heat *h)
{
    real least = -h->start * h->capacity, most = (HEAT_MOST - h->start) * h->capacity;
    real possible = real_min(real_max(h->stored, least), most), change = possible - h->stored;
    if (change * h->heating < 0)
        w->ledger.work_in += change;
    else
        w->ledger.lost -= change;
    h->stored = possible;
}

static void book(World *w, EffectSlot *e, Plan *p, real dt)
{
    for (int i = 0; i < e->members.count; i++) {
        Heat *h = column_at(&e->members, i);
        bool node = p->node[i] < p->net.nodes;
        real time = node && p->net.failed ? passed(p, p->node[i]) : dt;
        real heated = h->heating * time, given = p->given[i] * (time / dt);
        w->ledger.work_in += heated;
        w->ledger.lost += node ? -given : heated;
        if (!node)
            continue;
        h->stored += heated + given - p->out[p->node[i]];
        keep_possible(w, h);
        h->temperature = real_min(real_max(h->start + h->stored / h->capacity, 0), HEAT_MOST);
    }
}

/* What went out of each node, and into what keeps its temperature. */
static void sum_flows(World *w, Plan *p)
{
    memset(p->out, 0, (size_t)p->net.nodes * sizeof *p->out);
    for (int i = 0; i < p->net.branches; i++) {
        const NetBranch *b = &p->net.branch[i];
        if (b->a < p->net.nodes)
            p->out[b->a] += b->through;
        else
            w->ledger.lost -= b->through;
        if (b->b < p->net.nodes)
            p->out[b->b] -= b->through;
        else
            w->ledger.lost += b->through;
    }
}

/* Who warms whom is a link of the thermal layer: effort K, flow W/K, their product W. What keeps its temperature is a boundary.
 * Without memory a link is not there in this step. */
static void mark_links(World *w, const Column *c, const Plan *p)
{
    for (int i = 0; i < p->count; i++) {
        const Near *n = &p->near[i];
        const NetLine *line = n->branch >= 0 ? &p->net.branch[n->branch].line : NULL;
        if (!line || !(line->g > 0) || !w->pairs.data[n->pair].alive)
            continue;
        const Heat *a = column_at(c, n->a), *b = column_at(c, n->b);
        uint32_t one = c->body[n->a], other = c->body[n->b], link;
        bool bound = !(a->capacity > 0 && b->capacity > 0), turn = bound ? !(a->capacity > 0) : one > other;
        if (layer_mark(w, DIG_LAYER_THERMAL, turn ? other : one, turn ? one : other, bound, &link) != DIG_OK)
            continue;
        LayerLink *k = &w->layers[DIG_LAYER_THERMAL].links.data[link];
        k->effort = turn ? b->temperature - a->temperature : a->temperature - b->temperature;
        k->flow = line->g;
    }
}

/* Where motion is no better than at play, so is heat: one backward Euler step. */
#define COARSE 5e-5             /* m */
#define KELVIN 10               /* K per m of the tolerance, in a step */

static void flow(World *w, EffectSlot *e, real dt)
{
    Plan *p = e->plan;
    if (!p)
        return;
    e->plan = NULL;
    for (int i = 0; i < e->members.count; i++)
        p->given[i] = 0;
    look_at_contacts(w, e, p);
    look_at_joints(w, e, p);
    lift_air(w, e, p);
    load(e, p, dt);
    real tolerance = accuracy_plan(w->accuracy)->tolerance;
    p->net.tolerance = tolerance < COARSE ? KELVIN * tolerance : 0;
    network_advance(&p->net, dt);
    sum_flows(w, p);
    book(w, e, p, dt);
    mark_links(w, &e->members, p);
}

static void energy(const World *w, const EffectSlot *e, dig_energy *sum)
{
    (void)w;
    for (int i = 0; i < e->members.count; i++) {
        const Heat *h = column_at(&e->members, i);
        sum->heat += h->stored;
    }
}

/* Nothing of it is done in groups. */
static bool wanted(const World *w, const Group *g)
{
    (void)w;
    (void)g;
    return false;
}

const EffectType effect_heat = {
    .name = "heat",
    .law = "m c dT/dt = P + sum G (T' - T) + h A (Ta - T) + eps sigma A (Ta^4 - T^4)",
    .central = true,
    .cite = "incropera2007",
    .world_params = world_rows,
    .world_size = sizeof(HeatWorld),
    .body_params = body_rows,
    .body_size = sizeof(Heat),
    .wanted = wanted,
    .losses = true,
    .layer = DIG_LAYER_THERMAL,
    .join = join,
    .reserve = reserve,
    .flow = flow,
    .energy = energy,
};
