/* export/dot.c - the graphs of one moment in the language of Graphviz: a box for each DIG, static bodies outside, links by kind. */
#include "export/output.h"

#include "math/vec.h"

static const char *const colours[] = {"#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377"};   /* P. Tol's bright scheme */
enum { COLOURS = sizeof colours / sizeof *colours };

static int nearest_frame(const Replay *r, const ExportOptions *options)
{
    if (isnan(options->at))
        return options->last;
    real frame = options->at / replay_info(r)->step - (real)replay_info(r)->first_step;
    return (int)real_clamp(round(frame), options->first, options->last);
}

static void put_node(Replay *r, Output *out, const ReplayPose *p)
{
    char buffer[32];
    const ReplayBody *b = replay_body(r, p->body);
    output_text(out, "    b%d [label=", p->body);
    output_json(out, export_name(b, p->body, buffer));
    if (b->kind == DIG_STATIC)
        output_text(out, ", shape=box, style=filled, fillcolor=\"#dddddd\"");
    else if (b->kind == DIG_KINEMATIC)
        output_text(out, ", shape=box, style=\"rounded,filled\", fillcolor=\"#ffffff\"");
    else if (!p->awake)
        output_text(out, ", style=filled, fillcolor=\"#eeeeee\"");
    output_text(out, "];\n");
}

/* Members of a graph, once: those before this one that share it have written it. */
static void put_graph(Replay *r, Output *out, const ReplayFrame *f, int first)
{
    uint32_t dig = f->poses[first].dig;
    for (int i = 0; i < first; i++)
        if (f->poses[i].dig == dig)
            return;
    output_text(out, "  subgraph cluster_%u {\n    label=\"DIG %u\"; color=\"%s\"; style=rounded;\n", dig, dig, colours[dig % COLOURS]);
    for (int i = first; i < f->pose_count; i++)
        if (f->poses[i].dig == dig)
            put_node(r, out, &f->poses[i]);
    output_text(out, "  }\n");
}

static void put_link(const Replay *r, Output *out, const dig_link *l)
{
    static const char *const styles[] = {[DIG_LINK_CONTACT] = "solid", [DIG_LINK_JOINT] = "bold", [DIG_LINK_PORT] = "dashed", [DIG_LINK_RANGE] = "dotted"};
    int a = replay_body_of(r, l->a), b = replay_body_of(r, l->b);
    bool mechanical = l->layer == 0;
    if (a < 0)
        return;
    if (b < 0)      /* the world itself: a wall, an anchor, the outside of a layer */
        output_text(out, "  b%d -- outside", a);
    else
        output_text(out, "  b%d -- b%d", a, b);
    output_text(out, " [style=%s", styles[l->kind]);
    if (mechanical)
        output_text(out, ", label=\"%.3g N\"];\n", vec3_length(l->effort));
    else
        output_text(out, ", label=\"%s %.3g W\", color=\"%s\"];\n", dig_layer_name(l->layer), l->power, colours[l->layer % COLOURS]);
}

static dig_status write_dot(Replay *r, const ExportOptions *options, Output *out)
{
    const ReplayFrame *f;
    bool outside = false;
    DIG_TRY(replay_frame(r, nearest_frame(r, options), &f));
    output_text(out, "// t = %.9g s, frame %d\ngraph digs {\n  label=\"t = %.4g s\"; labelloc=t; fontname=\"DejaVu Sans\";\n"
                     "  node [fontname=\"DejaVu Sans\"]; edge [fontname=\"DejaVu Sans\", fontsize=10];\n", f->time, f->frame, f->time);
    for (int i = 0; i < f->pose_count && output_good(out); i++)
        if (f->poses[i].dig != 0)
            put_graph(r, out, f, i);
        else
            put_node(r, out, &f->poses[i]);
    for (int i = 0; i < f->link_count; i++)
        outside = outside || replay_body_of(r, f->links[i].b) < 0;
    if (outside)
        output_text(out, "    outside [shape=plaintext, label=\"the world\"];\n");
    for (int i = 0; i < f->link_count; i++)
        put_link(r, out, &f->links[i]);
    output_text(out, "}\n");
    return DIG_OK;
}

const ExportFormat export_dot = {".dot", "the graphs of one moment for Graphviz", write_dot};
