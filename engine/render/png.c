/* render/png.c - images in and out through libpng, their data compressed by Intel's ISA-L.
 *
 * A picture under its final name is whole (base/file.h). Failures name the path and the system's reason, which libpng by itself
 * does not.
 */
#include <errno.h>
#include <isa-l/igzip_lib.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/base.h"
#include "base/file.h"
#include "render/render.h"

enum { MOST_IN_CHUNK = 1 << 30, TABLES = ISAL_DEF_LVL1_DEFAULT };

typedef struct PngSink {        /* where libpng's callbacks read, write and report */
    FILE     *file;
    PngBytes *bytes;
    int       error;            /* errno of the first failure */
    char      text[160];        /* libpng's own words         */
} PngSink;

static void png_failed(png_structp png, png_const_charp text)
{
    PngSink *sink = png_get_error_ptr(png);
    snprintf(sink->text, sizeof sink->text, "%s", text);
    longjmp(png_jmpbuf(png), 1);
}

static void png_warned(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text;
}

/* Room for so many bytes; what was there is kept. */
static bool grow(unsigned char **data, size_t *capacity, size_t wanted)
{
    if (wanted <= *capacity)
        return true;
    unsigned char *larger = realloc(*data, wanted + wanted / 4);
    if (!larger)
        return false;
    *data = larger;
    *capacity = wanted + wanted / 4;
    return true;
}

static void put_bytes(png_structp png, png_bytep data, size_t size)
{
    PngSink *sink = png_get_io_ptr(png);
    PngBytes *b = sink->bytes;
    if (!grow(&b->data, &b->capacity, b->size + size)) {
        sink->error = ENOMEM;
        png_error(png, "no memory");
    }
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void flush_bytes(png_structp png) { (void)png; }

static void get_bytes(png_structp png, png_bytep data, size_t size)
{
    PngSink *sink = png_get_io_ptr(png);
    if (fread(data, 1, size, sink->file) != size) {
        sink->error = ferror(sink->file) ? errno : 0;
        png_error(png, "the file ends too early");
    }
}

/* out = a - b, byte by byte, eight at a time: the top bit of each byte keeps borrows from reaching its neighbour. */
static void subtract_bytes(unsigned char *out, const unsigned char *a, const unsigned char *b, size_t size)
{
    const uint64_t top = UINT64_C(0x8080808080808080);
    size_t i = 0;
    for (; i + 8 <= size; i += 8) {
        uint64_t x, y;
        memcpy(&x, a + i, 8);
        memcpy(&y, b + i, 8);
        x = ((x | top) - (y & ~top)) ^ ((x ^ ~y) & top);
        memcpy(out + i, &x, 8);
    }
    for (; i < size; i++)
        out[i] = (unsigned char)(a[i] - b[i]);
}

/* One row as it goes into the file, behind the number of its filter. Shaded rows are differences to the pixel on the left: they
 * compress best and fastest so. Depth: 16-bit grey, big-endian millimetres, 65535 for the sky and beyond. */
static void pack_row(RenderLayer layer, int width, const void *pixels, int y, unsigned char *row)
{
    size_t first = (size_t)y * (size_t)width;
    *row++ = layer == RENDER_DEPTH || layer == RENDER_ID ? PNG_FILTER_VALUE_NONE : PNG_FILTER_VALUE_SUB;
    if (layer == RENDER_DEPTH) {
        const float *depth = (const float *)pixels + first;
        for (int x = 0; x < width; x++) {
            double mm = (double)depth[x] * 1000;
            unsigned grey = !(mm > 0) ? 0 : mm >= 65535 ? 65535 : (unsigned)(mm + 0.5);
            row[2 * x] = (unsigned char)(grey >> 8);
            row[2 * x + 1] = (unsigned char)(grey & 255);
        }
    } else if (layer == RENDER_ID) {
        const uint32_t *id = (const uint32_t *)pixels + first;
        for (int x = 0; x < width; x++) {
            row[3 * x] = (unsigned char)(id[x] & 255);
            row[3 * x + 1] = (unsigned char)(id[x] >> 8 & 255);
            row[3 * x + 2] = (unsigned char)(id[x] >> 16 & 255);
        }
    } else {
        const unsigned char *p = (const unsigned char *)pixels + 3 * first;
        memcpy(row, p, 3);
        subtract_bytes(row + 3, p + 3, p, 3 * (size_t)width - 3);
    }
}

static void put_texts(png_structp png, png_infop info, const PngText *texts, int text_count)
{
    for (int i = 0; i < text_count; i++) {
        char key[80];       /* at most 79 bytes by the format; longer keys are cut */
        snprintf(key, sizeof key, "%s", texts[i].key);
        png_text text = {.compression = PNG_TEXT_COMPRESSION_NONE, .key = key};
        /* libpng takes a plain char *, but only reads it */
        size_t size = strlen(texts[i].value) + 1;
        text.text = malloc(size);
        if (!text.text)
            png_error(png, "no memory");
        memcpy(text.text, texts[i].value, size);
        png_set_text(png, info, &text, 1);      /* copies */
        free(text.text);
    }
}

typedef struct PngJob {
    RenderLayer    layer;
    int            width, height, text_count;
    const void    *pixels;
    const PngText *texts;
} PngJob;

/* The image data as one zlib stream at the end of out->rows. Measured on a textured picture of 1280x720 pixels: ISA-L's level 1 takes
 * 5 ms for 690 KB, libdeflate's level 1 13 ms for 660 KB, libpng at its fastest (runs only) 20 ms for 690 KB. */
static bool compress_rows(const PngJob *job, PngBytes *out, const unsigned char **stream, size_t *size)
{
    size_t stride = 1 + (job->layer == RENDER_DEPTH ? 2 : 3) * (size_t)job->width, total = stride * (size_t)job->height;
    size_t room = total + total / 8 + 4096;     /* more than stored blocks need */
    if (total > UINT32_MAX / 2 || !grow(&out->rows, &out->row_capacity, TABLES + total + room))
        return false;
    unsigned char *rows = out->rows + TABLES;
    for (int y = 0; y < job->height; y++)
        pack_row(job->layer, job->width, job->pixels, y, rows + stride * (size_t)y);
    struct isal_zstream z;
    isal_deflate_init(&z);
    z.gzip_flag = IGZIP_ZLIB;
    z.level = 1;
    z.level_buf = out->rows;
    z.level_buf_size = TABLES;
    z.end_of_stream = 1;
    z.next_in = rows;
    z.avail_in = (uint32_t)total;
    z.next_out = rows + total;
    z.avail_out = (uint32_t)room;
    int error = isal_deflate(&z);
    *stream = rows + total;
    *size = z.total_out;
    return error == COMP_OK && z.avail_in == 0 && z.internal_state.state == ZSTATE_END;
}

/* Everything between two setjmps; false when libpng jumped out. */
static bool encode(png_structp png, png_infop info, const PngJob *job, const unsigned char *stream, size_t size)
{
    if (setjmp(png_jmpbuf(png)))
        return false;
    bool grey = job->layer == RENDER_DEPTH;
    png_set_user_limits(png, 16384, 16384);
    png_set_IHDR(png, info, (png_uint_32)job->width, (png_uint_32)job->height, grey ? 16 : 8,
                 grey ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    put_texts(png, info, job->texts, job->text_count);
    png_write_info(png, info);
    for (size_t done = 0; done < size; done += MOST_IN_CHUNK)
        png_write_chunk(png, (png_const_bytep) "IDAT", stream + done, size - done < MOST_IN_CHUNK ? size - done : MOST_IN_CHUNK);
    png_write_chunk(png, (png_const_bytep) "IEND", NULL, 0);
    return true;
}

static bool encode_to(PngSink *sink, const PngJob *job)
{
    const unsigned char *stream = NULL;
    size_t size = 0;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, sink, png_failed, png_warned);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    bool done = false;
    if (info && compress_rows(job, sink->bytes, &stream, &size)) {
        png_set_write_fn(png, sink, put_bytes, flush_bytes);
        done = encode(png, info, job, stream, size);
    } else {
        sink->error = ENOMEM;
    }
    png_destroy_write_struct(png ? &png : NULL, info ? &info : NULL);
    return done;
}

dig_status png_encode(RenderLayer layer, int width, int height, const void *pixels, const PngText *texts, int text_count, PngBytes *out,
                      char *why, size_t capacity)
{
    if (width < 1 || width > 16384 || height < 1 || height > 16384 || !pixels) {
        snprintf(why, capacity, "%d x %d pixels, must be 1 to 16384 each way", width, height);
        return DIG_E_ARG;
    }
    PngSink sink = {.bytes = out};
    PngJob job = {layer, width, height, text_count, pixels, texts};
    out->size = 0;
    if (encode_to(&sink, &job))
        return DIG_OK;
    out->size = 0;
    snprintf(why, capacity, "no PNG image: %s", sink.text[0] ? sink.text : strerror(sink.error ? sink.error : EIO));
    return sink.error == ENOMEM ? DIG_E_MEMORY : DIG_E_FORMAT;
}

void png_release(PngBytes *bytes)
{
    free(bytes->data);
    free(bytes->rows);
    *bytes = (PngBytes){0};
}

/* ---- files ------------------------------------------------------------ */

dig_status png_save(const char *path, const PngBytes *bytes, bool flush, char *why, size_t capacity)
{
    return file_replace(path, bytes->data, bytes->size, flush ? FILE_FLUSHED : FILE_QUICK, why, capacity);
}

dig_status png_write(const char *path, RenderLayer layer, int width, int height, const void *pixels, const PngText *texts,
                     int text_count, char *why, size_t capacity)
{
    PngBytes bytes = {0};
    char words[200] = "";
    dig_status status = png_encode(layer, width, height, pixels, texts, text_count, &bytes, words, sizeof words);
    if (status == DIG_OK)
        status = png_save(path, &bytes, true, why, capacity);
    else
        snprintf(why, capacity, "%s: %s", path, words);
    png_release(&bytes);
    return status;
}

/* ---- reading ---------------------------------------------------------- */

typedef struct PngImage { int width, height; unsigned char *pixels; } PngImage;

static bool decode(png_structp png, png_infop info, PngImage *image)
{
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_set_user_limits(png, 16384, 16384);
    png_read_info(png, info);
    if (png_get_bit_depth(png, info) != 8 || png_get_color_type(png, info) != PNG_COLOR_TYPE_RGB)
        png_error(png, "not an 8-bit RGB image");
    if (png_get_interlace_type(png, info) != PNG_INTERLACE_NONE)
        png_error(png, "interlaced");
    image->width = (int)png_get_image_width(png, info);
    image->height = (int)png_get_image_height(png, info);
    size_t stride = 3 * (size_t)image->width;
    image->pixels = malloc(stride * (size_t)image->height);
    if (!image->pixels)
        png_error(png, "no memory");
    for (int y = 0; y < image->height; y++)
        png_read_row(png, image->pixels + stride * (size_t)y, NULL);
    png_read_end(png, NULL);
    return true;
}

/* Reads all rows, of whatever kind. The caller frees *row, which a damaged file would leave behind. */
static bool unpack(png_structp png, png_infop info, png_bytep *row)
{
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_set_user_limits(png, 16384, 16384);
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);        /* texts, too */
    png_read_info(png, info);
    *row = malloc(png_get_rowbytes(png, info));
    if (!*row)
        png_error(png, "no memory");
    for (png_uint_32 y = 0; y < png_get_image_height(png, info); y++)
        png_read_row(png, *row, NULL);
    png_read_end(png, NULL);
    return true;
}

bool png_whole(const char *path)
{
    PngSink sink = {.file = fopen(path, "rb")};
    if (!sink.file)
        return false;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &sink, png_failed, png_warned);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (info)
        png_set_read_fn(png, &sink, get_bytes);
    png_bytep row = NULL;
    bool whole = info && unpack(png, info, &row);
    free(row);
    png_destroy_read_struct(png ? &png : NULL, info ? &info : NULL, NULL);
    fclose(sink.file);
    return whole;
}

dig_status png_read(const char *path, int *width, int *height, unsigned char **pixels, char *why, size_t capacity)
{
    PngSink sink = {0};
    *pixels = NULL;
    sink.file = fopen(path, "rb");
    if (!sink.file) {
        snprintf(why, capacity, "%s: %s", path, strerror(errno));
        return DIG_E_FILE;
    }
    PngImage image = {0};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &sink, png_failed, png_warned);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    bool done = false;
    if (info) {
        png_set_read_fn(png, &sink, get_bytes);
        done = decode(png, info, &image);
    } else {
        sink.error = ENOMEM;
    }
    png_destroy_read_struct(png ? &png : NULL, info ? &info : NULL, NULL);
    fclose(sink.file);
    if (!done) {
        free(image.pixels);
        snprintf(why, capacity, "%s: %s", path, sink.error ? strerror(sink.error) : sink.text);
        return sink.error ? DIG_E_FILE : DIG_E_FORMAT;
    }
    *width = image.width;
    *height = image.height;
    *pixels = image.pixels;
    return DIG_OK;
}
