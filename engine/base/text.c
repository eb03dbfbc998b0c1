/* base/text.c - UTF-8 (RFC 3629) and control characters. */

#include "base/text.h"

/* Bytes of the character that begins there; 0 when it is none, or has a longer form than it needs. */
static size_t read_character(const unsigned char *b, size_t size, uint32_t *code)
{
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};       /* [bytes] */
    size_t n = b[0] < 0x80 ? 1 : b[0] >= 0xc2 && b[0] < 0xe0 ? 2 : b[0] >= 0xe0 && b[0] < 0xf0 ? 3 : b[0] >= 0xf0 && b[0] < 0xf5 ? 4 : 0;
    if (n == 0 || n > size)
        return 0;
    *code = n == 1 ? b[0] : b[0] & (0x7fu >> n);
    for (size_t i = 1; i < n; i++) {
        if ((b[i] & 0xc0) != 0x80)
            return 0;
        *code = *code << 6 | (b[i] & 0x3f);
    }
    bool surrogate = *code >= 0xd800 && *code < 0xe000;
    return *code < least[n] || *code > 0x10ffff || surrogate ? 0 : n;
}

TextKind text_next(const char *text, size_t size, size_t *length)
{
    uint32_t code = 0;
    *length = read_character((const unsigned char *)text, size, &code);
    if (*length == 0) {
        *length = 1;
        return TEXT_BROKEN;
    }
    return code < 0x20 || (code >= 0x7f && code < 0xa0) ? TEXT_CONTROL : TEXT_PLAIN;
}

const char *text_fault(const char *text)
{
    size_t size = strlen(text), n;
    for (; size > 0; text += n, size -= n)
        switch (text_next(text, size, &n)) {
        case TEXT_CONTROL: return "holds a control character";
        case TEXT_BROKEN: return "is not UTF-8";
        default: break;
        }
    return NULL;
}

void text_clean(char *text)
{
    size_t size = strlen(text), n;
    for (; size > 0; text += n, size -= n)
        if (text_next(text, size, &n) != TEXT_PLAIN)
            memset(text, '?', n);
}
