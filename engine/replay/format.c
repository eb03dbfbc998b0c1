/* replay/format.c - headers, meshes and bodies of a replay as bytes. */
#include "replay/format.h"

#include "math/vec.h"

#include <stdlib.h>

#define FAR 1e16        /* m; nothing is farther */

const unsigned char replay_magic[8] = {0x89, 'D', 'I', 'G', 'R', 'U', 'N', '\n'};
const unsigned char replay_end_magic[8] = {0x89, 'D', 'I', 'G', 'E', 'N', 'D', '\n'};

void replay_header(Pack *p, ReplayHeader *h)
{
    unsigned char magic[8];
    uint32_t bytes = REPLAY_HEADER, reserved = 0;
    memcpy(magic, replay_magic, sizeof magic);
    pack_bytes(p, magic, sizeof magic);
    pack_check(p, memcmp(magic, replay_magic, sizeof magic) == 0, "this is not a replay of digbox");
    pack_u32(p, &h->format);
    pack_u32(p, &bytes);
    pack_bytes(p, h->version, REPLAY_VERSION);
    pack_u64(p, &h->first_step);
    pack_u64(p, &h->seed);
    pack_real_in(p, &h->step, 1e-12, 1e12, "step");
    pack_u32(p, &reserved);
}

void section_header(Pack *p, Section *s)
{
    size_t start = p->reading ? p->at : p->size;
    pack_bytes(p, s->tag, sizeof s->tag);
    pack_u32(p, &s->packed);
    pack_u32(p, &s->first);
    pack_u32(p, &s->count);
    pack_u64(p, &s->raw);
    pack_u64(p, &s->size);
    pack_u32(p, &s->crc);
    if (!pack_good(p))
        return;
    uint32_t want = libdeflate_crc32(0, (p->reading ? p->from : p->data) + start, SECTION_HEADER - 4), crc = want;
    pack_u32(p, &crc);
    pack_check(p, crc == want, "the header of a section is damaged (checksum)");
}

/* ---- meshes ---- */

/* Numbers of four bytes each, little-endian in memory as in the file. */
static void pack_array(Pack *p, void **data, int count)
{
    size_t size = (size_t)count * 4;
    if (!p->reading) {
        pack_bytes(p, *data, size);
        return;
    }
    const unsigned char *from = pack_take(p, size);
    *data = from ? malloc(size + 1) : NULL;
    if (*data)
        memcpy(*data, from, size);
    else if (from)
        pack_fail_memory(p);
}

static bool all_finite(const float *x, int count)
{
    for (int i = 0; x && i < count; i++)
        if (!isfinite(x[i]))
            return false;
    return true;
}

static void check_mesh(Pack *p, const LookMesh *m)
{
    const ViewMesh *v = &m->mesh;
    pack_check(p, all_finite(v->size, 3) && all_finite(v->vertices, 3 * v->vertex_count) && (!v->normals || all_finite(v->normals, 3 * v->vertex_count)),
               "a mesh has numbers that are not finite");
    pack_check(p, v->index_count % 3 == 0, "a mesh ends within a triangle");
    for (int i = 0; pack_good(p) && i < v->index_count; i++)
        pack_check(p, v->indices[i] < (uint32_t)v->vertex_count, "a triangle has a corner that is not there");
}

void replay_mesh(Pack *p, LookMesh *m)
{
    ViewMesh *v = &m->mesh;
    uint8_t form = (uint8_t)v->form;
    bool smooth = v->normals != NULL;
    pack_small(p, &form, VIEW_PLANE + 1, "form of a mesh");
    v->form = form;
    pack_bytes(p, v->size, sizeof v->size);
    pack_vec3(p, &m->normal, 2, "normal");
    pack_real_in(p, &m->offset, -FAR, FAR, "offset");
    pack_bool(p, &smooth);
    v->vertex_count = (int)pack_count(p, (uint32_t)v->vertex_count, 12, "vertices");
    v->index_count = (int)pack_count(p, (uint32_t)v->index_count, 4, "indices");
    pack_check(p, form == VIEW_PLANE || v->vertex_count > 0, "a mesh has no vertices");
    if (v->vertex_count > 0)
        pack_array(p, (void **)&v->vertices, 3 * v->vertex_count);
    if (v->vertex_count > 0 && smooth)
        pack_array(p, (void **)&v->normals, 3 * v->vertex_count);
    if (v->index_count > 0)
        pack_array(p, (void **)&v->indices, v->index_count);
    if (p->reading && pack_good(p))
        check_mesh(p, m);
}

/* ---- bodies ---- */

void replay_kept_body(Pack *p, KeptBody *b)
{
    pack_u32(p, &b->index);
    pack_u32(p, &b->slot);
    pack_u32(p, &b->gen);
    pack_u32(p, &b->born);
    pack_enum(p, &b->kind, 3, "kind of a body");
    pack_real_in(p, &b->mass, 0, INFINITY, "mass");
    pack_vec3(p, &b->centre, FAR, "centre");
    pack_text(p, b->name, sizeof b->name);
    pack_text(p, b->material, sizeof b->material);
    pack_text(p, b->shape, sizeof b->shape);
}
