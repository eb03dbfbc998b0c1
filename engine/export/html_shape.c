/* export/html_shape.c - shapes of a page, taken from pictures of the run, and what is drawn beside bodies: contacts, lines, struts, pushes. */
#include "export/html_data.h"

#include "base/hash.h"

const struct HtmlMomentKind html_moments[MOMENTS] = {
    [MOMENT_CONTACT] = {"contact_at", "contact", 6}, [MOMENT_LINE] = {"line_at", "line", 7},
    [MOMENT_STRUT] = {"strut_at", "strut", 8}, [MOMENT_PUSH] = {"push_at", "push", 6},
    [MOMENT_CAMERA] = {"camera_at", "camera", 11}, [MOMENT_SHEET] = {"sheet_at", "sheet", 5},
};

static vec3 vec_from(const float v[3]) { return (vec3){(real)v[0], (real)v[1], (real)v[2]}; }

static void write_vec(float out[3], vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/* ---- meshes ---- */

static uint64_t hash_of(const ViewMesh *m)
{
    uint64_t h = hash_u64(HASH_START, (uint64_t)m->form);
    h = hash_bytes(h, m->size, sizeof m->size);
    if (m->form == VIEW_MESH) {
        h = hash_bytes(h, m->vertices, (size_t)m->vertex_count * 3 * sizeof *m->vertices);
        h = hash_bytes(h, m->indices, (size_t)m->index_count * sizeof *m->indices);
    }
    return h;
}

/* What the browser cannot make from a form and a size is written as triangles. */
static dig_status find_mesh(HtmlData *d, const ViewMesh *m, int *index)
{
    uint64_t hash = hash_of(m);
    for (*index = 0; *index < d->meshes.count; ++*index)
        if (d->meshes.data[*index].hash == hash)
            return DIG_OK;
    HtmlMesh mesh = {.hash = hash, .form = m->form, .vertex = d->vertices.count, .index = d->indices.count};
    memcpy(mesh.size, m->size, sizeof mesh.size);
    if (m->form == VIEW_MESH || m->form == VIEW_CONE) {
        mesh.vertex_count = 3 * m->vertex_count;
        mesh.index_count = m->index_count;
        mesh.normal_count = m->normals ? mesh.vertex_count : 0;
        const float none[3] = {0, 0, 0};
        DIG_TRY(html_put(&d->vertices, m->vertices, mesh.vertex_count));
        DIG_TRY(html_put(&d->indices, m->indices, m->index_count));
        /* normals stand where their vertices stand */
        for (int i = 0; i < m->vertex_count; i++)
            DIG_TRY(html_put(&d->normals, m->normals ? m->normals + (size_t)3 * (size_t)i : none, 3));
    }
    return html_put(&d->meshes, &mesh, 1);
}

/* ---- shapes ---- */

static dig_status take_shape(HtmlData *d, const View *v, const ViewItem *item, int body, pose at)
{
    HtmlShape s = {.body = body, .pattern = item->pattern, .roughness = item->roughness, .metallic = item->metallic,
                   .opacity = 1 - item->clear};
    quat q = {(real)item->q[0], (real)item->q[1], (real)item->q[2], (real)item->q[3]};
    pose own = pose_mul(pose_inverse(at), (pose){vec3_add(vec_from(item->p), (vec3){v->origin[0], v->origin[1], v->origin[2]}), q});
    DIG_TRY(find_mesh(d, &v->meshes[item->mesh], &s.mesh));
    write_vec(s.p, own.p);
    const float turn[4] = {(float)own.q.x, (float)own.q.y, (float)own.q.z, (float)own.q.w};
    memcpy(s.q, turn, sizeof turn);
    memcpy(s.colour, item->colour, sizeof s.colour);
    return html_put(&d->shapes, &s, 1);
}

/* Shapes of bodies that are new; at the first frame those of no body too. */
static dig_status take_shapes(HtmlData *d, const ReplayFrame *f, const View *v)
{
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        if (v->meshes[item->mesh].taken)
            continue;                   /* sheets are lists of their corners */
        if (item->body == 0) {
            if (item->fixed && d->frames == 0)
                DIG_TRY(take_shape(d, v, item, -1, (pose){d->place, quat_identity()}));
            continue;
        }
        int row = (int)item->body - 1 < d->row_of.count ? d->row_of.data[item->body - 1] : -1;
        if (row < 0 || d->bodies.data[f->poses[row].body].shaped)
            continue;
        if (item->woven) {
            d->bodies.data[f->poses[row].body].woven = true;
            continue;
        }
        DIG_TRY(take_shape(d, v, item, f->poses[row].body, (pose){f->poses[row].position, f->poses[row].rotation}));
    }
    for (int i = 0; i < f->pose_count; i++) {
        HtmlBody *b = &d->bodies.data[f->poses[i].body];
        b->shaped = !b->woven;
        b->woven = false;
    }
    return DIG_OK;
}

/* ---- lists of one moment ---- */

/* Rows from `before` on belong to this frame; when they are those of the frame before they go again. */
dig_status html_end_moment(HtmlData *d, HtmlMomentName name, int before)
{
    HtmlMoment *m = &d->moments[name];
    uint32_t width = (uint32_t)html_moments[name].width;
    uint32_t rows = (uint32_t)(m->rows.count - before) / width, first = (uint32_t)before / width;
    uint32_t old = m->at.count > 0 ? m->at.data[m->at.count - 1] : 0;
    if (rows == old && rows > 0 && memcmp(m->rows.data + before, m->rows.data + (size_t)m->first * width, rows * width * sizeof(float)) == 0) {
        m->rows.count = before;
        first = m->first;
    }
    m->first = first;
    const uint32_t at[2] = {first, rows};
    return html_put(&m->at, at, 2);
}

static dig_status take_contacts(HtmlData *d, const View *v, vec3 shift)
{
    HtmlMoment *m = &d->moments[MOMENT_CONTACT];
    int before = m->rows.count;
    for (int i = 0; i < v->contact_count; i++) {
        float row[6];
        write_vec(row, vec3_add(vec_from(v->contacts[i].p), shift));
        memcpy(row + 3, v->contacts[i].force, 3 * sizeof *row);
        DIG_TRY(html_put(&m->rows, row, 6));
    }
    return html_end_moment(d, MOMENT_CONTACT, before);
}

static uint32_t packed_colour(const float c[3])
{
    uint32_t out = 0;
    for (int i = 0; i < 3; i++)
        out = out << 8 | (uint32_t)lround(255 * pow(real_clamp((real)c[i], 0, 1), 1 / 2.2));
    return out;
}

static dig_status take_lines(HtmlData *d, const View *v, vec3 shift)
{
    HtmlMoment *m = &d->moments[MOMENT_LINE];
    int before = m->rows.count;
    for (int i = 0; i < v->line_count; i++) {
        float row[7];
        if (v->lines[i].woven)
            continue;
        uint32_t colour = packed_colour(v->lines[i].colour);
        write_vec(row, vec3_add(vec_from(v->lines[i].a), shift));
        write_vec(row + 3, vec3_add(vec_from(v->lines[i].b), shift));
        memcpy(row + 6, &colour, sizeof colour);
        DIG_TRY(html_put(&m->rows, row, 7));
    }
    return html_end_moment(d, MOMENT_LINE, before);
}

/* Struts are the items that belong to no body and move. */
static dig_status take_struts(HtmlData *d, const View *v, vec3 shift)
{
    HtmlMoment *m = &d->moments[MOMENT_STRUT];
    int before = m->rows.count;
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        const ViewMesh *mesh = &v->meshes[item->mesh];
        if (item->body != 0 || item->fixed || item->woven || mesh->form != VIEW_CYLINDER)
            continue;
        quat q = {(real)item->q[0], (real)item->q[1], (real)item->q[2], (real)item->q[3]};
        vec3 middle = vec3_add(vec_from(item->p), shift), half = quat_rotate(q, (vec3){0, 0.5 * (real)mesh->size[1], 0});
        float row[8] = {[6] = mesh->size[0], [7] = item->stress};
        write_vec(row, vec3_sub(middle, half));
        write_vec(row + 3, vec3_add(middle, half));
        DIG_TRY(html_put(&m->rows, row, 8));
    }
    return html_end_moment(d, MOMENT_STRUT, before);
}

/* The bodies at the corners of the quads of sheets: the page knows where these are. */
static dig_status take_sheets(HtmlData *d, const ReplayFrame *f, const View *v)
{
    HtmlMoment *m = &d->moments[MOMENT_SHEET];
    int before = m->rows.count;
    for (int i = 0; i < v->quad_count; i++) {
        float row[5];
        uint32_t colour = packed_colour(v->quads[i].colour);
        bool known = true;
        for (int k = 0; k < 4; k++) {
            int slot = (int)v->quads[i].corner[k], at = slot < d->row_of.count ? d->row_of.data[slot] : -1;
            known = known && at >= 0;
            row[k] = at >= 0 ? (float)f->poses[at].body : 0;
        }
        memcpy(row + 4, &colour, sizeof colour);
        if (known)
            DIG_TRY(html_put(&m->rows, row, 5));
    }
    return html_end_moment(d, MOMENT_SHEET, before);
}

static dig_status take_pushes(HtmlData *d, const View *v, vec3 shift)
{
    HtmlMoment *m = &d->moments[MOMENT_PUSH];
    int before = m->rows.count;
    for (int i = 0; i < v->arrow_count; i++) {
        float row[6];
        write_vec(row, vec3_add(vec_from(v->arrows[i].p), shift));
        memcpy(row + 3, v->arrows[i].v, 3 * sizeof *row);
        DIG_TRY(html_put(&m->rows, row, 6));
    }
    return html_end_moment(d, MOMENT_PUSH, before);
}

/* Bounds for the camera: those at the start, and the way of what does not fly far off. */
static void take_bounds(HtmlData *d, const ReplayFrame *f, const View *v, vec3 shift)
{
    if (d->frames == 0) {
        write_vec(d->low, vec3_add(vec_from(v->low), shift));
        write_vec(d->high, vec3_add(vec_from(v->high), shift));
        memcpy(d->up, v->up, sizeof d->up);
        d->reach = 0.75 * vec3_distance(vec_from(v->low), vec_from(v->high));
        d->middle = vec3_scale(0.5, vec3_add(vec_from(d->low), vec_from(d->high)));
    }
    for (int i = 0; i < f->pose_count; i++) {
        vec3 p = vec3_sub(f->poses[i].position, d->place);
        if (f->poses[i].mode == DIG_FIXED || !(vec3_distance(p, d->middle) < d->reach))
            continue;
        write_vec(d->low, vec3_min(vec_from(d->low), p));
        write_vec(d->high, vec3_max(vec_from(d->high), p));
    }
}

dig_status html_take_view(HtmlData *d, const ReplayFrame *f, const View *v)
{
    vec3 shift = vec3_sub((vec3){v->origin[0], v->origin[1], v->origin[2]}, d->place);
    take_bounds(d, f, v, shift);
    DIG_TRY(take_shapes(d, f, v));
    DIG_TRY(take_contacts(d, v, shift));
    DIG_TRY(take_lines(d, v, shift));
    DIG_TRY(take_struts(d, v, shift));
    DIG_TRY(take_sheets(d, f, v));
    return take_pushes(d, v, shift);
}
