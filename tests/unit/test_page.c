/* The packed arrays of a page (export/html_pack.c): what a reader written from its head comment gets back, and how far off that is. */
#include "check.h"
#include "export/html_data.h"

#include <string.h>

enum { ROWS = 500 };

/* Column k of a part that begins at byte `from`. */
static void unpack(const HtmlSections *s, size_t from, int k, int order, uint32_t *out)
{
    const unsigned char *b = s->bytes.data + from + (size_t)k * 4 * ROWS;
    for (int i = 0; i < ROWS; i++) {
        uint32_t z = b[i] | (uint32_t)b[ROWS + i] << 8 | (uint32_t)b[2 * ROWS + i] << 16 | (uint32_t)b[3 * ROWS + i] << 24;
        out[i] = order < 0 ? z : z % 2 ? ~(z / 2) : z / 2;
    }
    for (int o = 0; o < order; o++)
        for (int i = 1; i < ROWS; i++)
            out[i] += out[i - 1];
}

static real float_at(uint32_t word)
{
    float x;
    memcpy(&x, &word, sizeof x);
    return (real)x;
}

static void fill(float *rows, real far)
{
    for (int i = 0; i < ROWS; i++) {
        rows[3 * i] = (float)(-3 + 0.01 * i + 0.5 * sin(0.3 * i));
        rows[3 * i + 1] = (float)(i % 2 ? -1e-3 : 1.75 * far);
        rows[3 * i + 2] = (float)(1000 * cos(1.7 * i));
    }
}

TEST(places_come_back_within_half_a_step)
{
    for (int order = 0; order <= 2; order++) {
        const HtmlPart parts[] = {{2, order, 0x1p-20, 0}, {1, -1, 0, 12}};
        float rows[3 * ROWS];
        fill(rows, 1);
        HtmlRows r = {(const uint32_t *)(const void *)rows, ROWS, 3};
        HtmlSections s = {0};
        uint32_t words[ROWS];
        html_section_words(&s, "a", "f32", &r, parts, 2);
        CHECK(output_good(&s.bytes) && s.bytes.size == 3 * 4 * ROWS);
        for (int k = 0; k < 2; k++) {
            unpack(&s, 0, k, order, words);
            for (int i = 0; i < ROWS; i++)
                CHECK_NEAR((real)(int32_t)words[i] * 0x1p-20, (real)rows[3 * i + k], 0x1p-21);
        }
        unpack(&s, 2 * 4 * ROWS, 0, -1, words);
        for (int i = 0; i < ROWS; i++) {
            CHECK_NEAR(float_at(words[i]), (real)rows[3 * i + 2], 0x1p-12 * fabs((real)rows[3 * i + 2]));
            CHECK((words[i] & 0xfff) == 0);
        }
        output_close(&s.bytes);
        output_close(&s.list);
    }
}

/* Too far for the grid, or no number: the part keeps all its bits, and its head says so. */
TEST(what_does_not_fit_keeps_its_bits)
{
    const real odd[] = {2000, 1e30, INFINITY, NAN};
    const HtmlPart part = {3, 2, 0x1p-20, 0};
    for (int n = 0; n < 4; n++) {
        float rows[3 * ROWS];
        fill(rows, odd[n]);
        HtmlRows r = {(const uint32_t *)(const void *)rows, ROWS, 3};
        HtmlSections s = {0};
        uint32_t words[ROWS];
        html_section_words(&s, "a", "f32", &r, &part, 1);
        output_bytes(&s.list, "", 1);
        CHECK(strstr((const char *)s.list.data, "[[3,-1,") != NULL);
        for (int k = 0; k < 3; k++) {
            unpack(&s, 0, k, -1, words);
            for (int i = 0; i < ROWS; i++)
                CHECK(memcmp(&words[i], &rows[3 * i + k], 4) == 0);
        }
        output_close(&s.bytes);
        output_close(&s.list);
    }
}

/* Differences wrap round, so integers of any size come back. */
TEST(integers_come_back_as_they_were)
{
    uint32_t rows[ROWS], words[ROWS], seed = 7;
    for (int i = 0; i < ROWS; i++)
        rows[i] = seed = seed * 1664525u + 1013904223u;
    HtmlRows r = {rows, ROWS, 1};
    for (int order = -1; order <= 2; order++) {
        HtmlSections s = {0};
        html_section_words(&s, "a", "u32", &r, &(HtmlPart){1, order, 0, 0}, 1);
        unpack(&s, 0, 0, order, words);
        CHECK(memcmp(words, rows, sizeof rows) == 0);
        output_close(&s.bytes);
        output_close(&s.list);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(places_come_back_within_half_a_step), unit_test(what_does_not_fit_keeps_its_bits),
              unit_test(integers_come_back_as_they_were));
}
