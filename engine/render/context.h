/* render/context.h - an off-screen OpenGL context, whichever library makes it.
 *
 * A backend is one file that ends in one const table. The renderer draws into framebuffers of its own and never
 * touches a default one, so a backend needs neither window nor surface.
 *
 * The program (not this library, which leaves the environment alone) may set, before the first context:
 *   MESA_SHADER_CACHE_DISABLE=true  Mesa then does not write ~/.cache/mesa_shader_cache. Tests want that; but the first
 *                                   picture of a process takes about 0.1 s for each kind of surface without the cache.
 *   MESA_SHADER_CACHE_DIR           the cache elsewhere.
 *   LP_NUM_THREADS=0                one thread a process: for frame ranges in parallel processes.
 * It must not fork after opening a context unless LP_NUM_THREADS is 0, nor set LP_NATIVE_VECTOR_WIDTH=512 (crashes with
 * multisampling).
 *
 * Floor: render.
 */
#ifndef DIG_CONTEXT_H
#define DIG_CONTEXT_H

#include "base/base.h"

typedef void (*GlProc)(void);

typedef struct ContextBackend {
    const char *name;
    dig_status (*open)(void **context, char *why, size_t capacity);     /* makes a 3.3 core context, not yet bound */
    void       (*close)(void *context);                                 /* unbound before                          */
    bool       (*bind)(void *context);                                  /* makes it current on this thread         */
    void       (*unbind)(void *context);
    GlProc     (*proc)(void *context, const char *name);
} ContextBackend;

extern const ContextBackend context_osmesa, context_egl;

#endif
