/* export/output.c - bytes that grow: text, numbers, JSON strings. */
#include "export/output.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void output_fail(Output *o, const char *format, ...)
{
    va_list arguments;
    if (!output_good(o))
        return;
    va_start(arguments, format);
    vsnprintf(o->why, sizeof o->why, format, arguments);
    va_end(arguments);
}

static unsigned char *space(Output *o, size_t size)
{
    if (!output_good(o))
        return NULL;
    if (size > o->capacity - o->size) {
        size_t want = o->capacity < 65536 ? 65536 : o->capacity;
        while (want - o->size < size && want < SIZE_MAX / 2)
            want *= 2;
        unsigned char *data = want - o->size < size ? NULL : realloc(o->data, want);
        if (!data) {
            output_fail(o, "no memory for %zu bytes of output", o->size + size);
            return NULL;
        }
        o->data = data;
        o->capacity = want;
    }
    return o->data + o->size;
}

void output_bytes(Output *o, const void *bytes, size_t size)
{
    unsigned char *to = size ? space(o, size) : NULL;
    if (!to)
        return;
    memcpy(to, bytes, size);
    o->size += size;
}

void output_text(Output *o, const char *format, ...)
{
    va_list arguments;
    char text[1024];
    va_start(arguments, format);
    int n = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (n < 0 || n >= (int)sizeof text)
        output_fail(o, "a line of the output is too long");
    else
        output_bytes(o, text, (size_t)n);
}

void output_number(Output *o, real x)
{
    char text[40] = "null";
    x += 0.0;           /* no -0 */
    for (int digits = 15; digits <= 17 && isfinite(x); digits++) {
        snprintf(text, sizeof text, "%.*g", digits, x);
        if (strtod(text, NULL) == x)
            break;
    }
    output_bytes(o, text, strlen(text));
}

void output_json(Output *o, const char *text)
{
    output_bytes(o, "\"", 1);
    for (const char *c = text; *c; c++)
        if (*c == '"' || *c == '\\')
            output_text(o, "\\%c", *c);
        else if ((unsigned char)*c < 0x20)
            output_text(o, "\\u%04x", (unsigned)*c);
        else
            output_bytes(o, c, 1);
    output_bytes(o, "\"", 1);
}

void output_close(Output *o)
{
    free(o->data);
    *o = (Output){0};
}
