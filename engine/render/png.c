/* render/png.c - images in and out through libpng.
 *
 * A picture under its final name is whole: it is written beside it under a temporary name, flushed to the disk and
 * renamed. Failures name the path and the system's reason, which libpng by itself does not.
 */
#define _POSIX_C_SOURCE 200809L     /* open, fsync, lstat */

#include <errno.h>
#include <fcntl.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>        /* Z_RLE */

#include "base/base.h"
#include "render/render.h"

enum { PATH_CAPACITY = 4096 };

typedef struct PngSink {        /* where libpng's callbacks read, write and report */
    FILE *file;
    int   error;                /* errno of the first failure */
    char  text[160];            /* libpng's own words         */
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

static void put_bytes(png_structp png, png_bytep data, size_t size)
{
    PngSink *sink = png_get_io_ptr(png);
    if (fwrite(data, 1, size, sink->file) != size) {
        sink->error = errno;
        png_error(png, "write error");
    }
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

/* One row as it goes into the file. Depth: 16-bit grey, big-endian millimetres, 65535 for the sky and beyond. */
static void pack_row(RenderLayer layer, int width, const void *pixels, int y, unsigned char *row)
{
    size_t first = (size_t)y * (size_t)width;
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
        memcpy(row, (const unsigned char *)pixels + 3 * first, 3 * (size_t)width);
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

/* Everything between two setjmps; false when libpng jumped out. */
static bool encode(png_structp png, png_infop info, const PngJob *job, unsigned char *row)
{
    if (setjmp(png_jmpbuf(png)))
        return false;
    bool grey = job->layer == RENDER_DEPTH;
    png_set_user_limits(png, 16384, 16384);
    png_set_IHDR(png, info, (png_uint_32)job->width, (png_uint_32)job->height, grey ? 16 : 8,
                 grey ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    /* Measured on 1280x720 pictures: shaded ones take 15 ms and 350 KB as runs of differences, 18 ms and 390 KB
     * unfiltered at level 3, 26 ms or more by libpng's own choice. Flat layers (ids, depth) are best left unfiltered. */
    bool shaded = job->layer == RENDER_COLOUR || job->layer == RENDER_NORMAL;
    png_set_filter(png, PNG_FILTER_TYPE_BASE, shaded ? PNG_FILTER_SUB : PNG_FILTER_NONE);
    png_set_compression_level(png, shaded ? 1 : 3);
    if (shaded)
        png_set_compression_strategy(png, Z_RLE);
    put_texts(png, info, job->texts, job->text_count);
    png_write_info(png, info);
    for (int y = 0; y < job->height; y++) {
        pack_row(job->layer, job->width, job->pixels, y, row);
        png_write_row(png, row);
    }
    png_write_end(png, info);
    return true;
}

static bool encode_to(PngSink *sink, const PngJob *job)
{
    unsigned char *row = malloc(3 * (size_t)job->width);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, sink, png_failed, png_warned);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    bool done = false;
    if (row && info) {
        png_set_write_fn(png, sink, put_bytes, flush_bytes);
        done = encode(png, info, job, row);
    } else {
        sink->error = ENOMEM;
    }
    png_destroy_write_struct(png ? &png : NULL, info ? &info : NULL);
    free(row);
    return done;
}

/* path's folder + .name.pid.tmp; false when it does not fit */
static bool temporary_name(const char *path, char *name, size_t capacity)
{
    const char *slash = strrchr(path, '/');
    int folder = slash ? (int)(slash - path) + 1 : 0;
    int length = snprintf(name, capacity, "%.*s.%s.%ld.tmp", folder, path, path + folder, (long)getpid());
    return length > 0 && (size_t)length < capacity;
}

/* A rename would replace a device, a pipe or a link by a file. */
static bool replaceable(const char *path)
{
    struct stat info;
    return lstat(path, &info) != 0 || S_ISREG(info.st_mode);
}

/* Writes and closes; the errno of the first failure, 0 for none. */
static int write_whole(const char *name, PngSink *sink, const PngJob *job)
{
    int handle = open(name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (handle < 0)
        return errno;
    sink->file = fdopen(handle, "wb");
    if (!sink->file) {
        int error = errno;
        close(handle);
        return error;
    }
    int error = 0;
    if (!encode_to(sink, job))
        error = sink->error ? sink->error : EIO;
    if (!error && (fflush(sink->file) != 0 || fsync(handle) != 0))
        error = errno;
    if (fclose(sink->file) != 0 && !error)
        error = errno;
    return error;
}

dig_status png_write(const char *path, RenderLayer layer, int width, int height, const void *pixels, const PngText *texts,
                     int text_count, char *why, size_t capacity)
{
    if (width < 1 || width > 16384 || height < 1 || height > 16384 || !pixels) {
        snprintf(why, capacity, "%s: %d x %d pixels, must be 1 to 16384 each way", path, width, height);
        return DIG_E_ARG;
    }
    char name[PATH_CAPACITY];
    if (!temporary_name(path, name, sizeof name)) {
        snprintf(why, capacity, "%.200s...: %s", path, strerror(ENAMETOOLONG));
        return DIG_E_FILE;
    }
    if (!replaceable(path)) {
        snprintf(why, capacity, "%s: exists and is not an ordinary file", path);
        return DIG_E_FILE;
    }
    PngSink sink = {0};
    PngJob job = {layer, width, height, text_count, pixels, texts};
    int error = write_whole(name, &sink, &job);
    bool ours = error != EEXIST;
    if (!error && rename(name, path) != 0)
        error = errno;
    if (!error)
        return DIG_OK;
    if (ours)
        unlink(name);
    /* libpng's words add something only where the system had none to say */
    snprintf(why, capacity, "%s: %s", path, error == EIO && sink.text[0] ? sink.text : strerror(error));
    return DIG_E_FILE;
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
