/* world/material.c - the everyday materials, and what two surfaces make of each other.
 *
 * Densities, heat capacities, conductivities, resistivities: CRC Handbook of
 * Chemistry and Physics, 97th ed.; strengths and friction pairs: Oberg et al.,
 * Machinery's Handbook, 29th ed. Young's moduli: CRC; woods (along the grain, bent): Forest Products Laboratory, Wood
 * Handbook, 2010, ch. 5; cork, felt, foam, leather, paper: Ashby, Materials Selection in Mechanical Design,
 * 2011, app. A (middle of the range). Friction of a material alone is meant against
 * itself or the like; restitutions and rolling frictions are typical values.
 */
#include "world/world.h"

#define TEXT(t) {t}

static const Material standard[] = {
    /* name      density frict dyn  rolling  rest   c      k       resistivity strength Young colour          rough metal pattern sound */
    {"default",  {1000, 0.5,  0.5,  0,      0,     1500,  0.5,    1e12,   20e6, 1e9,   {0.55, 0.55, 0.58},    0.6,  0, TEXT("plain"),  TEXT("dull")}},
    {"oak",      {720,  0.5,  0.4,  0.01,   0.4,   2000,  0.16,   1e14,   50e6, 12e9,  {0.42, 0.24, 0.10},    0.55, 0, TEXT("wood"),   TEXT("wood")}},
    {"pine",     {500,  0.5,  0.4,  0.012,  0.4,   2300,  0.12,   1e14,   35e6, 9e9,   {0.62, 0.42, 0.20},    0.6,  0, TEXT("wood"),   TEXT("wood")}},
    {"wood",     {650,  0.5,  0.4,  0.01,   0.4,   2100,  0.15,   1e14,   40e6, 10e9,  {0.50, 0.30, 0.14},    0.55, 0, TEXT("wood"),   TEXT("wood")}},
    {"steel",    {7850, 0.6,  0.45, 0.002,  0.6,   490,   45,     1.6e-7, 400e6, 210e9, {0.56, 0.57, 0.58},   0.3,  1, TEXT("plain"),  TEXT("metal")}},
    {"iron",     {7870, 0.6,  0.5,  0.002,  0.5,   449,   80,     9.6e-8, 250e6, 211e9, {0.42, 0.40, 0.39},   0.45, 1, TEXT("plain"),  TEXT("metal")}},
    {"tin",      {7290, 0.35, 0.3,  0.003,  0.3,   227,   67,     1.1e-7, 15e6, 50e9,  {0.62, 0.64, 0.66},    0.35, 1, TEXT("plain"),  TEXT("tin")}},
    {"aluminium", {2700, 0.6, 0.5,  0.003,  0.5,   897,   237,    2.7e-8, 200e6, 70e9,  {0.77, 0.78, 0.79},   0.35, 1, TEXT("plain"),  TEXT("metal")}},
    {"copper",   {8960, 0.6,  0.5,  0.003,  0.4,   385,   401,    1.7e-8, 210e6, 120e9, {0.72, 0.36, 0.20},   0.35, 1, TEXT("plain"),  TEXT("metal")}},
    {"brass",    {8500, 0.5,  0.4,  0.003,  0.5,   380,   120,    6.5e-8, 300e6, 100e9, {0.70, 0.52, 0.20},   0.3,  1, TEXT("plain"),  TEXT("metal")}},
    {"lead",     {11340, 0.9, 0.8,  0.01,   0.1,   129,   35,     2.1e-7, 12e6, 16e9,  {0.25, 0.26, 0.29},    0.6,  1, TEXT("plain"),  TEXT("dull")}},
    {"rubber",   {1100, 0.9,  0.8,  0.015,  0.75,  2010,  0.16,   1e13,   15e6, 5e6,   {0.30, 0.05, 0.04},    0.8,  0, TEXT("stripe"), TEXT("rubber")}},
    {"plastic",  {950,  0.35, 0.3,  0.005,  0.5,   1900,  0.4,    1e15,   30e6, 1e9,   {0.05, 0.22, 0.50},    0.35, 0, TEXT("plain"),  TEXT("plastic")}},
    {"glass",    {2500, 0.5,  0.4,  0.002,  0.6,   840,   1.0,    1e12,   40e6, 70e9,  {0.45, 0.60, 0.62},    0.1,  0, TEXT("plain"),  TEXT("glass")}},
    {"ice",      {917,  0.05, 0.03, 0.002,  0.3,   2090,  2.2,    1e6,    1e6, 9e9,   {0.60, 0.74, 0.82},    0.15, 0, TEXT("plain"),  TEXT("glass")}},
    {"stone",    {2600, 0.65, 0.55, 0.005,  0.3,   800,   2.5,    1e9,    10e6, 50e9,  {0.36, 0.34, 0.32},    0.8,  0, TEXT("plain"),  TEXT("stone")}},
    {"concrete", {2400, 0.7,  0.6,  0.006,  0.2,   880,   1.4,    1e5,    4e6, 30e9,  {0.42, 0.41, 0.39},    0.85, 0, TEXT("plain"),  TEXT("stone")}},
    {"brick",    {1900, 0.65, 0.6,  0.008,  0.2,   840,   0.7,    1e8,    3e6, 15e9,  {0.48, 0.16, 0.10},    0.85, 0, TEXT("brick"),  TEXT("stone")}},
    {"tile",     {2300, 0.5,  0.4,  0.003,  0.4,   850,   1.2,    1e12,   30e6, 60e9,  {0.62, 0.60, 0.56},    0.4,  0, TEXT("tile"),   TEXT("stone")}},
    {"cardboard", {690, 0.5,  0.45, 0.02,   0.2,   1400,  0.06,   1e11,   5e6, 3e9,   {0.46, 0.31, 0.17},    0.9,  0, TEXT("plain"),  TEXT("paper")}},
    {"paper",    {800,  0.4,  0.35, 0.02,   0.1,   1400,  0.05,   1e11,   30e6, 4e9,   {0.80, 0.78, 0.72},    0.9,  0, TEXT("plain"),  TEXT("paper")}},
    {"leather",  {860,  0.6,  0.5,  0.03,   0.3,   1500,  0.14,   1e10,   20e6, 0.2e9, {0.25, 0.10, 0.05},    0.7,  0, TEXT("plain"),  TEXT("dull")}},
    {"cork",     {200,  0.7,  0.6,  0.03,   0.5,   1900,  0.045,  1e12,   1e6, 20e6,  {0.55, 0.36, 0.20},    0.9,  0, TEXT("plain"),  TEXT("dull")}},
    {"foam",     {30,   0.7,  0.6,  0.05,   0.3,   1400,  0.035,  1e13,   0.2e6, 1e6,   {0.80, 0.70, 0.35},   0.95, 0, TEXT("plain"),  TEXT("dull")}},
    {"ivory",    {1850, 0.2,  0.15, 0.002,  0.93,  1200,  0.5,    1e8,    100e6, 10e9,  {0.84, 0.80, 0.66},   0.2,  0, TEXT("stripe"), TEXT("click")}},
    {"felt",     {180,  0.4,  0.35, 0.01,   0.3,   1400,  0.05,   1e12,   1e6, 5e6,   {0.03, 0.25, 0.10},    0.95, 0, TEXT("plain"),  TEXT("dull")}},
    {"teflon",   {2200, 0.04, 0.04, 0.002,  0.3,   1000,  0.25,   1e18,   25e6, 0.5e9, {0.82, 0.82, 0.82},    0.4,  0, TEXT("plain"),  TEXT("plastic")}},
};

static const struct { const char *a, *b; real friction, friction_dynamic, restitution; } standard_pairs[] = {
    /* thin sheet metal swallows most of a blow */
    {"rubber", "tin", 0.6, 0.5, 0.4}, {"steel", "tin", 0.35, 0.3, 0.3},
    {"steel", "steel", 0.74, 0.57, 0},  {"steel", "ice", 0.03, 0.02, 0},     {"steel", "teflon", 0.04, 0.04, 0},  {"steel", "copper", 0.53, 0.36, 0},
    {"oak", "oak", 0.54, 0.48, 0},      {"wood", "stone", 0.6, 0.5, 0},      {"rubber", "concrete", 1.0, 0.8, 0}, {"rubber", "ice", 0.15, 0.1, 0},
    {"glass", "glass", 0.94, 0.4, 0},   {"aluminium", "steel", 0.61, 0.47, 0}, {"brass", "steel", 0.51, 0.44, 0}, {"leather", "oak", 0.6, 0.5, 0},
};

int material_find(const World *w, const char *name)
{
    for (int i = 0; i < w->materials.count; i++)
        if (strcmp(w->materials.data[i].name, name) == 0)
            return i;
    return -1;
}

static uint64_t material_bit(int material) { return (uint64_t)1 << (uint32_t)material % 64; }

void material_pairs_look(World *w)
{
    w->paired = 0;
    for (int i = 0; i < w->material_pairs.count; i++)
        w->paired |= material_bit(w->material_pairs.data[i].a) | material_bit(w->material_pairs.data[i].b);
}

dig_status materials_open(World *w)
{
    int count = (int)(sizeof standard / sizeof standard[0]), pairs = (int)(sizeof standard_pairs / sizeof standard_pairs[0]);
    DIG_TRY(list_reserve(&w->materials, count, &w->allocations));
    DIG_TRY(list_reserve(&w->material_pairs, pairs, &w->allocations));
    memcpy(w->materials.data, standard, sizeof standard);
    w->materials.count = count;
    for (int i = 0; i < pairs; i++)
        w->material_pairs.data[i] = (MaterialPair){material_find(w, standard_pairs[i].a), material_find(w, standard_pairs[i].b),
                                                   standard_pairs[i].friction, standard_pairs[i].friction_dynamic, NAN,
                                                   standard_pairs[i].restitution > 0 ? standard_pairs[i].restitution : NAN};
    w->material_pairs.count = pairs;
    material_pairs_look(w);
    return DIG_OK;
}

/* Fills what the body did not say from its material. */
Surface surface_resolve(const World *w, const Surface *s)
{
    const dig_material_def *m = &w->materials.data[s->material].def;
    Surface r = *s;
    if (isnan(r.friction_dynamic))
        r.friction_dynamic = !isnan(r.friction) ? r.friction : isnan(m->friction_dynamic) ? m->friction : m->friction_dynamic;
    if (isnan(r.friction))
        r.friction = m->friction;
    if (isnan(r.rolling))
        r.rolling = m->rolling_friction;
    if (isnan(r.restitution))
        r.restitution = m->restitution;
    return r;
}

static real pick(real special, real general) { return isnan(special) ? general : special; }

/* Its own row in the table, the last one; NULL: it has none, as most pairs, of which mostly one material has no row at all. */
static const MaterialPair *row_of(const World *w, int a, int b)
{
    if (!(w->paired & material_bit(a) && w->paired & material_bit(b)))
        return NULL;
    for (int i = w->material_pairs.count - 1; i >= 0; i--) {
        const MaterialPair *m = &w->material_pairs.data[i];
        if (m->a + m->b == a + b && (m->a == a || m->a == b))
            return m;
    }
    return NULL;
}

/* Friction and restitution of two surfaces: a row of the material table of their own, else the geometric mean of the frictions
 * and the larger restitution. A body that gives its own number overrides the table. */
Rub surface_pair(const World *w, const Surface *a, const Surface *b)
{
    Surface ra = surface_resolve(w, a), rb = surface_resolve(w, b);
    Rub r = {.friction = sqrt(ra.friction * rb.friction), .rolling = real_max(ra.rolling, rb.rolling),
             .restitution = real_max(ra.restitution, rb.restitution)};
    r.friction_dynamic = real_min(r.friction, sqrt(ra.friction_dynamic * rb.friction_dynamic));
    bool own_friction = !isnan(a->friction) || !isnan(b->friction);
    bool own_restitution = !isnan(a->restitution) || !isnan(b->restitution);
    const MaterialPair *m = row_of(w, a->material, b->material);
    if (!m)
        return r;
    if (!own_friction) {
        r.friction_dynamic = pick(m->friction_dynamic, pick(m->friction, r.friction_dynamic));
        r.friction = pick(m->friction, r.friction);
    }
    r.rolling = isnan(a->rolling) && isnan(b->rolling) ? pick(m->rolling, r.rolling) : r.rolling;
    if (!own_restitution)
        r.restitution = pick(m->restitution, r.restitution);
    return r;
}
