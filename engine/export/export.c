/* export/export.c - which format a file name asks for, and its file written whole. */
#include "export/output.h"

#include <stdio.h>
#include <string.h>

#include "base/file.h"

static const ExportFormat *const formats[] = {&export_glb, &export_csv, &export_jsonl, &export_npy, &export_dot};
enum { FORMAT_COUNT = sizeof formats / sizeof *formats };

ExportOptions export_defaults(const Replay *r)
{
    return (ExportOptions){.last = replay_info(r)->frames - 1, .at = NAN};
}

const ExportFormat *export_format(int index)
{
    return index >= 0 && index < FORMAT_COUNT ? formats[index] : NULL;
}

const ExportFormat *export_find(const char *path)
{
    size_t length = strlen(path);
    for (int i = 0; i < FORMAT_COUNT; i++) {
        size_t n = strlen(formats[i]->suffix);
        if (length > n && strcmp(path + length - n, formats[i]->suffix) == 0)
            return formats[i];
    }
    return NULL;
}

int export_next_frame(const Replay *r, const ExportOptions *options, int frame)
{
    real step = replay_info(r)->step, rate = options->fps > 0 ? options->fps : 1 / step;
    int from = options->first;
    /* The frame nearest to each multiple of 1/fps, none twice. */
    int count = frame < from ? 0 : (int)llround((frame - from) * step * rate) + 1;
    int next = frame < from ? from : from + (int)llround(count / (rate * step));
    if (next <= frame)
        next = frame + 1;
    return next <= options->last ? next : -1;
}

const char *export_name(const ReplayBody *b, int index, char buffer[32])
{
    if (b->name && b->name[0])
        return b->name;
    snprintf(buffer, 32, "body %d", index);
    return buffer;
}

dig_status export_write(Replay *r, const ExportFormat *format, const ExportOptions *options, const char *path, char *why, size_t capacity)
{
    Output out = {0};
    dig_status status = format->write(r, options, &out);
    if (status == DIG_OK && !output_good(&out))
        status = DIG_E_MEMORY;
    if (status != DIG_OK)
        snprintf(why, capacity, "%s", out.why[0] ? out.why : replay_error(r));
    else
        status = file_replace(path, out.data, out.size, FILE_DURABLE, why, capacity);
    output_close(&out);
    return status;
}
