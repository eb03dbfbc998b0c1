/* base/block.h - memory whose owner knows its size: small blocks from malloc, large ones straight from the system, page by page.
 *
 * Large worlds grow while things land in them. From malloc, what grew out of its place leaves a hole that little else fits: a fifth of
 * the memory of a pile of 8000 balls. Pages are given back at once, go along when a block grows (nothing is copied), and take no memory
 * until they are written to: room that is kept ready costs nothing, but for the rest of a wide page (two megabytes, where the system has them).
 *
 * Invariant: a block stays where it was obtained from as long as its size is on the same side of BLOCK_LARGE: hand in the size it has.
 * Floor:     base.
 */
#ifndef DIG_BLOCK_H
#define DIG_BLOCK_H

#include "base/base.h"

#define BLOCK_LARGE ((size_t)256 << 10)         /* bytes */

/* From `old` bytes to `bytes`, either may be 0 (data is NULL then); what is new is 0. NULL: no memory, or bytes = 0; without memory
 * the old block is as it was. */
void *block_resize(void *data, size_t old, size_t bytes);
void *block_open(size_t bytes);         /* of more than 0, the same but for its contents, which are not set */
void  block_free(void *data, size_t bytes);
/* A part of a large block that is not needed for now: what pages lie wholly within it take no memory until they are written to again. Its
 * contents are lost. */
void  block_forget(void *part, size_t bytes);
/* Fills a record of some hundred bytes with 0. Where it sees how many, the compiler writes an instruction that takes longer than the
 * library's wide ones. */
void  block_clear(void *record, size_t bytes);

#endif
