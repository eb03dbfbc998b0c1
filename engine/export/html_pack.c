/* export/html_pack.c - the numbers of a page made small: columns of integers on a grid, their differences, bytes of like meaning together,
 * deflate, base64. data.js reads it.
 *
 * A part is some columns of a list of rows. Columns stand one after the other; of each stand the lowest bytes of all rows, then the next ones.
 * order -1: the bytes are those of the numbers. Otherwise the numbers are whole multiples of `step` (1 for integers) modulo 2^32, from which
 * the number before was taken away `order` times, going down the column; 0, -1, 1, -2 ... are 0, 1, 2, 3.
 */
#include "export/html_data.h"

#include <libdeflate.h>
#include <stdlib.h>

enum { LEVEL = 6 };                 /* of deflate: 9 is smaller by 1 % and takes three times as long */

/* ---- numbers to integers ---- */

static float float_of(uint32_t word)
{
    float x;
    memcpy(&x, &word, sizeof x);
    return x;
}

/* Whether all numbers of the columns are on the grid with room for differences. */
static bool fits(const HtmlRows *r, const HtmlPart *p, int from)
{
    for (size_t i = 0; p->step > 0 && i < r->count; i++)
        for (int k = 0; k < p->width; k++)
            if (!(fabs((real)float_of(r->words[i * r->stride + (size_t)(from + k)])) < p->step * 0x1p30))
                return false;
    return true;
}

/* A float of which the lowest bits are rounded away. */
static uint32_t round_bits(uint32_t word, int drop)
{
    uint32_t low = (1u << drop) - 1;
    if (drop == 0 || (word & 0x7f800000) == 0x7f800000)
        return word;
    return (word + (low >> 1) + 1) & ~low;
}

static uint32_t integer_of(uint32_t word, const HtmlPart *p)
{
    return p->step > 0 ? (uint32_t)(int32_t)lround((real)float_of(word) / p->step) : word;
}

/* One column as integers that are small where it changes evenly. */
static void take_column(uint64_t *out, const HtmlRows *r, const HtmlPart *p, size_t column, bool grid)
{
    uint32_t before = 0, slope = 0;
    for (size_t i = 0; i < r->count; i++) {
        uint32_t word = r->words[i * r->stride + column];
        if (!grid) {
            out[i] = round_bits(word, p->drop);
            continue;
        }
        uint32_t x = integer_of(word, p), difference = x - (p->order > 0 ? before : 0);
        uint32_t d = difference - (p->order > 1 ? slope : 0);
        before = x;
        slope = difference;
        out[i] = d << 1 ^ (d >> 31 ? 0xffffffffu : 0);
    }
}

/* ---- sections ---- */

/* All lowest bytes of the numbers, then all second ones, ... */
static void put_planes(Output *out, const uint64_t *numbers, size_t count, int size)
{
    unsigned char bytes[1024];
    for (int byte = 0; byte < size; byte++)
        for (size_t i = 0, n = 0; i < count; i++) {
            bytes[n++] = (unsigned char)(numbers[i] >> (8 * byte));
            if (n == sizeof bytes || i + 1 == count) {
                output_bytes(out, bytes, n);
                n = 0;
            }
        }
}

static uint64_t *new_column(HtmlSections *s, size_t rows)
{
    uint64_t *column = malloc((rows + 1) * sizeof *column);
    if (!column)
        output_fail(&s->bytes, "no memory for the page");
    return column;
}

static void begin_section(HtmlSections *s, const char *name, const char *type, size_t rows)
{
    output_text(&s->list, "%s\"%s\":[\"%s\",%zu,%zu,[", s->list.size ? "," : "", name, type, s->bytes.size, rows);
}

void html_section_words(HtmlSections *s, const char *name, const char *type, const HtmlRows *r, const HtmlPart *parts, int count)
{
    uint64_t *column = new_column(s, r->count);
    int at = 0;
    begin_section(s, name, type, r->count);
    for (int i = 0; i < count; i++) {
        const HtmlPart *p = &parts[i];
        bool grid = p->order >= 0 && fits(r, p, at);
        output_text(&s->list, "%s[%d,%d,%.17g]", i ? "," : "", p->width, grid ? p->order : -1, p->step > 0 ? p->step : 1);
        for (int k = 0; column && k < p->width; k++) {
            take_column(column, r, p, (size_t)(at + k), grid);
            put_planes(&s->bytes, column, r->count, 4);
        }
        at += p->width;
    }
    output_text(&s->list, "]]");
    free(column);
}

void html_section_reals(HtmlSections *s, const char *name, const real *x, size_t rows, int width)
{
    begin_section(s, name, "f64", rows);
    uint64_t *column = new_column(s, rows);
    for (size_t k = 0; column && k < (size_t)width; k++) {
        for (size_t i = 0; i < rows; i++)
            memcpy(&column[i], &x[i * (size_t)width + k], sizeof *column);
        put_planes(&s->bytes, column, rows, 8);
    }
    output_text(&s->list, "[%d,-1,1]]]", width);
    free(column);
}

/* ---- the block as text ---- */

static void put_base64(Output *out, const unsigned char *in, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char text[4 * 256];
    size_t n = 0;
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        uint32_t x = (uint32_t)in[i] << 16 | (left > 1 ? (uint32_t)in[i + 1] << 8 : 0) | (left > 2 ? in[i + 2] : 0);
        text[n++] = digit[x >> 18];
        text[n++] = digit[x >> 12 & 63];
        text[n++] = left > 1 ? digit[x >> 6 & 63] : '=';
        text[n++] = left > 2 ? digit[x & 63] : '=';
        if (n == sizeof text || left <= 3) {
            output_bytes(out, text, n);
            n = 0;
        }
    }
}

void html_put_packed(Output *out, const Output *block)
{
    struct libdeflate_compressor *c = libdeflate_alloc_compressor(LEVEL);
    size_t most = c ? libdeflate_deflate_compress_bound(c, block->size) : 0;
    unsigned char *packed = most ? malloc(most) : NULL;
    size_t size = packed ? libdeflate_deflate_compress(c, block->data, block->size, packed, most) : 0;
    if (size)
        put_base64(out, packed, size);
    else
        output_fail(out, "no memory for the page");
    free(packed);
    libdeflate_free_compressor(c);
}
