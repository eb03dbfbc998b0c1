/* export/csv.c - one row for each body and frame, as RFC 4180 has it: for spreadsheets, gnuplot, data frames. */
#include "export/output.h"

#include <string.h>

static const char heading[] =
    "frame,time,body,name,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz,fx,fy,fz,dig,mode,awake,temperature\r\n";

static void put_field(Output *out, const char *text)
{
    if (!strpbrk(text, ",\"\r\n")) {
        output_bytes(out, text, strlen(text));
        return;
    }
    output_bytes(out, "\"", 1);
    for (const char *c = text; *c; c++)
        output_bytes(out, *c == '"' ? "\"\"" : c, *c == '"' ? 2 : 1);
    output_bytes(out, "\"", 1);
}

static void put_numbers(Output *out, const real *x, int count)
{
    for (int i = 0; i < count; i++) {
        output_bytes(out, ",", 1);
        output_number(out, x[i]);
    }
}

static void put_pose(Replay *r, Output *out, const ReplayFrame *f, const ReplayPose *p)
{
    static const char *const modes[] = {[DIG_MOVING] = "moving", [DIG_RESTING] = "resting", [DIG_FIXED] = "fixed"};
    char buffer[32];
    output_text(out, "%d,", f->frame);
    output_number(out, f->time);
    output_text(out, ",%d,", p->body);
    put_field(out, export_name(replay_body(r, p->body), p->body, buffer));
    put_numbers(out, (const real[]){p->position.x, p->position.y, p->position.z, p->rotation.x, p->rotation.y, p->rotation.z, p->rotation.w,
                                    p->velocity.x, p->velocity.y, p->velocity.z, p->spin.x, p->spin.y, p->spin.z,
                                    p->force.x, p->force.y, p->force.z}, 16);
    output_text(out, ",%u,%s,%d,", p->dig, modes[p->mode], p->awake);
    if (p->temperature > 0)
        output_number(out, p->temperature);
    output_bytes(out, "\r\n", 2);
}

static dig_status write_csv(Replay *r, const ExportOptions *options, Output *out)
{
    output_bytes(out, heading, sizeof heading - 1);
    for (int i = export_next_frame(r, options, -1); i >= 0 && output_good(out); i = export_next_frame(r, options, i)) {
        const ReplayFrame *f;
        DIG_TRY(replay_frame(r, i, &f));
        for (int k = 0; k < f->pose_count; k++)
            put_pose(r, out, f, &f->poses[k]);
    }
    return DIG_OK;
}

const ExportFormat export_csv = {".csv", "a table, one row for each body and frame", write_csv};
