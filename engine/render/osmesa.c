/* render/osmesa.c - a context from OSMesa: software only, needs nothing of the system. */
#include <GL/osmesa.h>

#include <stdio.h>
#include <stdlib.h>

#include "render/context.h"

typedef struct OsmesaContext {
    OSMesaContext handle;
    unsigned char pixel[4];     /* OSMesa wants a buffer even from those who draw elsewhere */
} OsmesaContext;

static dig_status osmesa_open(void **context, char *why, size_t capacity)
{
    static const int wanted[] = {OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 0, OSMESA_PROFILE, OSMESA_CORE_PROFILE,
                                 OSMESA_CONTEXT_MAJOR_VERSION, 3, OSMESA_CONTEXT_MINOR_VERSION, 3, 0};
    OsmesaContext *c = calloc(1, sizeof *c);
    if (!c) {
        snprintf(why, capacity, "osmesa: no memory");
        return DIG_E_MEMORY;
    }
    c->handle = OSMesaCreateContextAttribs(wanted, NULL);
    if (!c->handle) {
        snprintf(why, capacity, "osmesa: no OpenGL 3.3 core context (OSMesaCreateContextAttribs)");
        free(c);
        return DIG_E_FULL;
    }
    *context = c;
    return DIG_OK;
}

static void osmesa_close(void *context)
{
    OsmesaContext *c = context;
    OSMesaDestroyContext(c->handle);
    free(c);
}

static bool osmesa_bind(void *context)
{
    OsmesaContext *c = context;
    return OSMesaMakeCurrent(c->handle, c->pixel, GL_UNSIGNED_BYTE, 1, 1);
}

static void osmesa_unbind(void *context)
{
    (void)context;
    OSMesaMakeCurrent(NULL, NULL, GL_UNSIGNED_BYTE, 0, 0);
}

static GlProc osmesa_proc(void *context, const char *name)
{
    (void)context;
    return (GlProc)OSMesaGetProcAddress(name);
}

const ContextBackend context_osmesa = {
    .name = "osmesa", .open = osmesa_open, .close = osmesa_close, .bind = osmesa_bind, .unbind = osmesa_unbind, .proc = osmesa_proc,
};
