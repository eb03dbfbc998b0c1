/* render/shaders.h - the GLSL text of every kind of program, in pieces.
 *
 * Pieces are short because C promises only 4095 characters a string. In front of them go the version and the
 * #defines of the key (program.h).
 */
#ifndef DIG_SHADERS_H
#define DIG_SHADERS_H

#include "render/program.h"

enum { SHADER_PIECES = 8 };

typedef struct ShaderSource { const char *vertex[SHADER_PIECES], *fragment[SHADER_PIECES]; } ShaderSource;

extern const ShaderSource shader_sources[PROGRAM_KIND_COUNT];

#endif
