/* render/osmesa.c - a context from OSMesa: software only, needs nothing of the system.
 *
 * The library is loaded for the first picture: it brings LLVM, whose 400,000 relocations are most of the time that digbox takes to start,
 * and worlds without pictures run where it is not installed.
 */
#include <GL/osmesa.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/context.h"

#define OSMESA_FUNCTIONS(X) X(CreateContextAttribs) X(DestroyContext) X(MakeCurrent) X(GetProcAddress)

typedef struct OsmesaContext {
    void         *library;
    OSMesaContext handle;
    unsigned char pixel[4];     /* OSMesa wants a buffer even from those who draw elsewhere */
#define OSMESA_MEMBER(name) __typeof__(&OSMesa##name) name;
    OSMESA_FUNCTIONS(OSMESA_MEMBER)
#undef OSMESA_MEMBER
} OsmesaContext;

static bool load(OsmesaContext *c)
{
    static const char *const names[] = {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
    for (size_t i = 0; i < sizeof names / sizeof *names && !c->library; i++)
        c->library = dlopen(names[i], RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);       /* never unloaded: it leaves thread destructors behind */
    if (!c->library)
        return false;
    void *symbol;
    /* A copy of the bits: ISO C has no conversion from dlsym's void * to a function. */
#define OSMESA_FILL(name)                           \
    symbol = dlsym(c->library, "OSMesa" #name);     \
    if (!symbol)                                    \
        return false;                               \
    memcpy(&c->name, &symbol, sizeof symbol);
    OSMESA_FUNCTIONS(OSMESA_FILL)
#undef OSMESA_FILL
    return true;
}

static void drop(OsmesaContext *c)
{
    if (c->library)
        dlclose(c->library);
    free(c);
}

static dig_status osmesa_open(void **context, char *why, size_t capacity)
{
    static const int wanted[] = {OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 0, OSMESA_PROFILE, OSMESA_CORE_PROFILE,
                                 OSMESA_CONTEXT_MAJOR_VERSION, 3, OSMESA_CONTEXT_MINOR_VERSION, 3, 0};
    OsmesaContext *c = calloc(1, sizeof *c);
    if (!c) {
        snprintf(why, capacity, "osmesa: no memory");
        return DIG_E_MEMORY;
    }
    const char *fault = load(c) ? NULL : "libOSMesa.so.8 cannot be loaded";
    if (!fault && !(c->handle = c->CreateContextAttribs(wanted, NULL)))
        fault = "no OpenGL 3.3 core context (OSMesaCreateContextAttribs)";
    if (fault) {
        snprintf(why, capacity, "osmesa: %s", fault);
        drop(c);
        return DIG_E_FULL;
    }
    *context = c;
    return DIG_OK;
}

static void osmesa_close(void *context)
{
    OsmesaContext *c = context;
    c->DestroyContext(c->handle);
    drop(c);
}

static bool osmesa_bind(void *context)
{
    OsmesaContext *c = context;
    return c->MakeCurrent(c->handle, c->pixel, GL_UNSIGNED_BYTE, 1, 1);
}

static void osmesa_unbind(void *context)
{
    OsmesaContext *c = context;
    c->MakeCurrent(NULL, NULL, GL_UNSIGNED_BYTE, 0, 0);
}

static GlProc osmesa_proc(void *context, const char *name)
{
    OsmesaContext *c = context;
    return (GlProc)c->GetProcAddress(name);
}

const ContextBackend context_osmesa = {
    .name = "osmesa", .open = osmesa_open, .close = osmesa_close, .bind = osmesa_bind, .unbind = osmesa_unbind, .proc = osmesa_proc,
};
