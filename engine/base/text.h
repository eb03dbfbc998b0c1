/* base/text.h - what names and messages may hold: UTF-8 without control characters, which a terminal would act upon.
 *
 * Floor: base.
 */
#ifndef DIG_TEXT_H
#define DIG_TEXT_H

#include "base/base.h"

typedef enum TextKind {
    TEXT_PLAIN,
    TEXT_CONTROL,       /* U+0000 to U+001F, U+007F to U+009F */
    TEXT_BROKEN         /* a byte that begins no character of UTF-8 */
} TextKind;

/* Kind of the character at `text`, of which `size` > 0 bytes are there, and its length in bytes (1 of a broken one). */
TextKind text_next(const char *text, size_t size, size_t *length);

/* What is wrong with a text as a name, as in "name %s"; NULL when nothing is. */
const char *text_fault(const char *text);

/* Puts '?' in place of every byte that is not of a plain character. */
void text_clean(char *text);

#endif
