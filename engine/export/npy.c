/* export/npy.c - one NumPy array [frames][bodies] of records with named fields, NaN where a body is not there.
 *
 * Format: the NPY specification, version 1.0 (numpy.lib.format): magic, length of the header, a Python literal padded with blanks
 * to a multiple of 64, then the numbers, little-endian. Numbers are written as they stand in memory.
 */
#include "export/output.h"

#include <stdio.h>
#include <string.h>

#include "base/base.h"

typedef struct Record { real time, position[3], rotation[4], velocity[3], spin[3], temperature; } Record;

static const char fields[] =
    "[('time', '<f8'), ('position', '<f8', (3,)), ('rotation', '<f8', (4,)), ('velocity', '<f8', (3,)), ('spin', '<f8', (3,)), "
    "('temperature', '<f8')]";

static int count_frames(const Replay *r, const ExportOptions *options)
{
    int count = 0;
    for (int i = export_next_frame(r, options, -1); i >= 0; i = export_next_frame(r, options, i))
        count++;
    return count;
}

static void put_header(Output *out, int frames, int bodies)
{
    char text[512];
    int n = snprintf(text, sizeof text, "{'descr': %s, 'fortran_order': False, 'shape': (%d, %d)}", fields, frames, bodies);
    int whole = (10 + n + 1 + 63) / 64 * 64 - 10;
    const unsigned char start[10] = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, (unsigned char)(whole & 255), (unsigned char)(whole >> 8)};
    output_bytes(out, start, sizeof start);
    output_text(out, "%-*s\n", whole - 1, text);
}

static Record record_of(const ReplayFrame *f, const ReplayPose *p)
{
    if (!p)
        return (Record){f->time, {NAN, NAN, NAN}, {NAN, NAN, NAN, NAN}, {NAN, NAN, NAN}, {NAN, NAN, NAN}, NAN};
    return (Record){f->time, {p->position.x, p->position.y, p->position.z}, {p->rotation.x, p->rotation.y, p->rotation.z, p->rotation.w},
                    {p->velocity.x, p->velocity.y, p->velocity.z}, {p->spin.x, p->spin.y, p->spin.z},
                    p->temperature > 0 ? p->temperature : NAN};
}

static dig_status write_npy(Replay *r, const ExportOptions *options, Output *out)
{
    int bodies = replay_info(r)->bodies;
    put_header(out, count_frames(r, options), bodies);
    for (int i = export_next_frame(r, options, -1); i >= 0 && output_good(out); i = export_next_frame(r, options, i)) {
        const ReplayFrame *f;
        int next = 0;
        DIG_TRY(replay_frame(r, i, &f));
        for (int b = 0; b < bodies; b++) {
            bool there = next < f->pose_count && f->poses[next].body == b;
            Record record = record_of(f, there ? &f->poses[next] : NULL);
            next += there;
            output_bytes(out, &record, sizeof record);
        }
    }
    return DIG_OK;
}

const ExportFormat export_npy = {".npy", "a NumPy array [frames][bodies] with named fields", write_npy};
