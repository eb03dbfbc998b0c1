/* render/font.c - letters from a font file, drawn once into a picture. */
#include <ft2build.h>
#include FT_FREETYPE_H
#include <stdlib.h>

#include "render/overlay.h"

static const char *const font_paths[] = {
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",      /* Debian, Ubuntu */
    "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",    /* Fedora         */
    "/usr/share/fonts/dejavu/DejaVuSans.ttf",               /* Gentoo, SUSE   */
    "/usr/share/fonts/TTF/DejaVuSans.ttf",                  /* Arch           */
    "/usr/local/share/fonts/dejavu/DejaVuSans.ttf",         /* FreeBSD        */
};

/* Fills glyph by glyph from the top left, row by row. */
static void draw_glyphs(Font *f, FT_Face face)
{
    int x = 1, y = 1, row = 0;
    for (int i = 0; i < FONT_COUNT; i++) {
        if (FT_Load_Char(face, (FT_ULong)(FONT_FIRST + i), FT_LOAD_RENDER) != 0)
            continue;
        const FT_GlyphSlot slot = face->glyph;
        int width = (int)slot->bitmap.width, height = (int)slot->bitmap.rows;
        if (x + width + 1 > FONT_SIDE) {
            x = 1;
            y += row + 1;
            row = 0;
        }
        if (y + height + 1 > FONT_SIDE)
            return;
        for (int k = 0; k < height; k++)
            memcpy(f->picture + (size_t)(y + k) * FONT_SIDE + x, slot->bitmap.buffer + k * slot->bitmap.pitch, (size_t)width);
        f->glyphs[i] = (Glyph){(short)x, (short)y, (short)width, (short)height, (short)slot->bitmap_left, (short)slot->bitmap_top,
                               (float)slot->advance.x / 64};
        x += width + 1;
        row = int_max(row, height);
    }
}

void font_make(Font *f, int size)
{
    if (f->missing || f->size == size)
        return;
    if (!f->picture)
        f->picture = malloc((size_t)FONT_SIDE * FONT_SIDE);
    FT_Library library;
    f->missing = true;
    if (!f->picture || FT_Init_FreeType(&library) != 0)
        return;
    for (size_t i = 0; f->missing && i < sizeof font_paths / sizeof *font_paths; i++) {
        FT_Face face;
        if (FT_New_Face(library, font_paths[i], 0, &face) != 0)
            continue;
        if (FT_Set_Pixel_Sizes(face, 0, (FT_UInt)size) == 0) {
            memset(f->picture, 0, (size_t)FONT_SIDE * FONT_SIDE);
            memset(f->glyphs, 0, sizeof f->glyphs);
            draw_glyphs(f, face);
            f->line = (float)face->size->metrics.height / 64;
            f->size = size;
            f->missing = false;
        }
        FT_Done_Face(face);
    }
    FT_Done_FreeType(library);
}

void font_close(Font *f)
{
    free(f->picture);
    *f = (Font){0};
}

/* One code point; malformed bytes count as one each. */
static uint32_t next_code(const char **text)
{
    const unsigned char *p = (const unsigned char *)*text;
    int extra = p[0] < 0x80 ? 0 : (p[0] & 0xe0) == 0xc0 ? 1 : (p[0] & 0xf0) == 0xe0 ? 2 : (p[0] & 0xf8) == 0xf0 ? 3 : 0;
    uint32_t code = extra == 0 ? p[0] : p[0] & (0x3fu >> extra);
    for (int i = 1; i <= extra; i++) {
        if ((p[i] & 0xc0) != 0x80) {
            *text += 1;
            return '?';
        }
        code = code << 6 | (p[i] & 0x3fu);
    }
    *text += 1 + extra;
    return extra == 0 && code >= 0x80 ? '?' : code;
}

const Glyph *font_next(const Font *f, const char **text)
{
    if (!**text)
        return NULL;
    uint32_t code = next_code(text);
    if (code < FONT_FIRST || code >= FONT_FIRST + FONT_COUNT)
        code = '?';
    return &f->glyphs[code - FONT_FIRST];
}
