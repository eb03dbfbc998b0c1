/* tests/unit/test_png.c - images written and read back: pixels, texts, and what happens when a file cannot be written. */
#ifndef _XOPEN_SOURCE
#define _XOPEN_SOURCE 700       /* mkdtemp, P_tmpdir */
#endif

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "check.h"
#include "scratch.h"
#include "render/render.h"

static char folder[256];

static int open_folder(void **state)
{
    (void)state;
    return mkdtemp(scratch_path(folder, sizeof folder, "png-XXXXXX")) ? 0 : -1;
}

static int close_folder(void **state)
{
    (void)state;
    return rmdir(folder);       /* fails when a test left a file behind */
}

static void path_of(char *out, size_t capacity, const char *name) { snprintf(out, capacity, "%s/%s", folder, name); }

static int files_in_folder(void)
{
    int count = 0;
    DIR *d = opendir(folder);
    if (!d)
        fail_msg("%s: %s", folder, strerror(errno));
    for (const struct dirent *e; (e = readdir(d));)
        count += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(d);
    return count;
}

/* An image without any pattern, so that it does not compress. */
static unsigned char *make_noise(size_t size)
{
    unsigned char *data = malloc(size);
    uint32_t h = 1;
    for (size_t i = 0; data && i < size; i++) {
        h = h * 1664525u + 1013904223u;
        data[i] = (unsigned char)(h >> 24);
    }
    return data;
}

static bool file_contains(const char *path, const char *bytes, size_t size)
{
    static char all[200000];
    FILE *f = fopen(path, "rb");
    size_t got = f ? fread(all, 1, sizeof all, f) : 0;
    if (f)
        fclose(f);
    for (size_t i = 0; i + size <= got; i++)
        if (memcmp(all + i, bytes, size) == 0)
            return true;
    return false;
}

TEST(a_png_comes_back_pixel_by_pixel_with_its_texts)
{
    char path[300], why[400] = "";
    path_of(path, sizeof path, "round.png");
    unsigned char *data = make_noise(3 * 37 * 21), *back = NULL;
    const PngText texts[] = {{"Software", "digbox"}, {"digbox:step", "1200"}};
    int width = 0, height = 0;
    CHECK_INT(png_write(path, RENDER_COLOUR, 37, 21, data, texts, 2, why, sizeof why), DIG_OK);
    CHECK_INT(files_in_folder(), 1);        /* no temporary beside it */
    CHECK_INT(png_read(path, &width, &height, &back, why, sizeof why), DIG_OK);
    CHECK_INT(width, 37);
    CHECK_INT(height, 21);
    CHECK(memcmp(data, back, 3 * 37 * 21) == 0);
    CHECK(file_contains(path, "tEXtSoftware\0digbox", 19));
    CHECK(file_contains(path, "tEXtdigbox:step\0001200", 20));
    free(data);
    free(back);
    CHECK_INT(unlink(path), 0);
}

TEST(an_id_png_holds_the_number_in_three_bytes)
{
    char path[300], why[400] = "";
    path_of(path, sizeof path, "id.png");
    const uint32_t ids[2] = {0, 0x030201};
    unsigned char *back = NULL;
    int width, height;
    CHECK_INT(png_write(path, RENDER_ID, 2, 1, ids, NULL, 0, why, sizeof why), DIG_OK);
    CHECK_INT(png_read(path, &width, &height, &back, why, sizeof why), DIG_OK);
    CHECK_INT(back[0] + back[1] + back[2], 0);
    CHECK_INT(back[3], 1);
    CHECK_INT(back[4], 2);
    CHECK_INT(back[5], 3);
    free(back);
    CHECK_INT(unlink(path), 0);
}

TEST(a_depth_png_is_16_bit_grey_and_not_read_as_colour)
{
    char path[300], why[400] = "";
    path_of(path, sizeof path, "depth.png");
    const float metres[2] = {1.5f, INFINITY};
    unsigned char *back = NULL;
    int width, height;
    CHECK_INT(png_write(path, RENDER_DEPTH, 2, 1, metres, NULL, 0, why, sizeof why), DIG_OK);
    CHECK(file_contains(path, "IHDR\0\0\0\2\0\0\0\1\20\0", 14));      /* 2 x 1, 16 bits, grey */
    CHECK_INT(png_read(path, &width, &height, &back, why, sizeof why), DIG_E_FORMAT);
    CHECK(back == NULL);
    CHECK(strstr(why, "8-bit RGB") != NULL);
    CHECK_INT(unlink(path), 0);
}

static void check_file_error(const char *path, int error)
{
    const unsigned char grey[3] = {9, 9, 9};
    char why[400] = "";
    CHECK_INT(png_write(path, RENDER_COLOUR, 1, 1, grey, NULL, 0, why, sizeof why), DIG_E_FILE);
    if (!strstr(why, path) || (error && !strstr(why, strerror(error))))
        fail_msg("\"%s\" lacks the path or \"%s\"", why, strerror(error));
}

TEST(an_unwritable_path_is_reported_with_the_systems_reason)
{
    char path[300];
    path_of(path, sizeof path, "no-such-folder/a.png");
    check_file_error(path, ENOENT);
    check_file_error(folder, 0);            /* a folder */
    check_file_error("/dev/full", 0);       /* a device: must not be replaced by a file */
    CHECK_INT(access("/dev/full", F_OK), 0);
    unsigned char *back = NULL;
    int width, height;
    char why[400] = "";
    CHECK_INT(png_read(path, &width, &height, &back, why, sizeof why), DIG_E_FILE);
    CHECK(strstr(why, strerror(ENOENT)) != NULL);
}

TEST(a_full_disk_leaves_the_old_picture_and_no_temporary)
{
    char path[300], why[400] = "";
    path_of(path, sizeof path, "full.png");
    const unsigned char grey[3] = {9, 9, 9};
    CHECK_INT(png_write(path, RENDER_COLOUR, 1, 1, grey, NULL, 0, why, sizeof why), DIG_OK);
    unsigned char *data = make_noise(3 * 200 * 200), *back = NULL;
    struct rlimit before, tight;
    getrlimit(RLIMIT_FSIZE, &before);
    tight = before;
    tight.rlim_cur = 20000;
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &tight);
    dig_status status = png_write(path, RENDER_COLOUR, 200, 200, data, NULL, 0, why, sizeof why);
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_DFL);
    free(data);
    CHECK_INT(status, DIG_E_FILE);
    if (!strstr(why, strerror(EFBIG)))
        fail_msg("\"%s\" lacks \"%s\"", why, strerror(EFBIG));
    CHECK_INT(files_in_folder(), 1);
    int width, height;
    CHECK_INT(png_read(path, &width, &height, &back, why, sizeof why), DIG_OK);
    CHECK_INT(width, 1);
    free(back);
    CHECK_INT(unlink(path), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        unit_test(a_png_comes_back_pixel_by_pixel_with_its_texts),
        unit_test(an_id_png_holds_the_number_in_three_bytes),
        unit_test(a_depth_png_is_16_bit_grey_and_not_read_as_colour),
        unit_test(an_unwritable_path_is_reported_with_the_systems_reason),
        unit_test(a_full_disk_leaves_the_old_picture_and_no_temporary),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
