/* render/egl.c - a context from EGL without a surface, for machines whose Mesa no longer has OSMesa.
 *
 * libEGL is loaded when asked for, so that digbox starts where it is not installed. The display stays initialised
 * until the process ends: EGL does not count its users, and terminating it would take other renderers' contexts along.
 */
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "render/context.h"

#define EGL_FUNCTIONS(X)                                                                                             \
    X(PFNEGLGETPROCADDRESSPROC, GetProcAddress) X(PFNEGLINITIALIZEPROC, Initialize) X(PFNEGLBINDAPIPROC, BindAPI)     \
    X(PFNEGLCREATECONTEXTPROC, CreateContext) X(PFNEGLDESTROYCONTEXTPROC, DestroyContext)                            \
    X(PFNEGLMAKECURRENTPROC, MakeCurrent) X(PFNEGLRELEASETHREADPROC, ReleaseThread)

typedef struct EglContext {
    void      *library;
    EGLDisplay display;
    EGLContext handle;
#define EGL_MEMBER(type, name) type name;
    EGL_FUNCTIONS(EGL_MEMBER)
#undef EGL_MEMBER
} EglContext;

static bool load(EglContext *c)
{
    /* Never unloaded from memory: the driver leaves thread destructors behind. */
    c->library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!c->library)
        return false;
    void *symbol;
    /* A copy of the bits: ISO C has no conversion from dlsym's void * to a function. */
#define EGL_FILL(type, name)                        \
    symbol = dlsym(c->library, "egl" #name);        \
    if (!symbol)                                    \
        return false;                               \
    memcpy(&c->name, &symbol, sizeof symbol);
    EGL_FUNCTIONS(EGL_FILL)
#undef EGL_FILL
    return true;
}

static const char *start(EglContext *c)
{
    static const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display = (PFNEGLGETPLATFORMDISPLAYEXTPROC)c->GetProcAddress("eglGetPlatformDisplayEXT");
    if (!get_display)
        return "eglGetPlatformDisplayEXT is missing";
    c->display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (c->display == EGL_NO_DISPLAY)
        return "no surfaceless display";
    if (!c->Initialize(c->display, NULL, NULL))
        return "eglInitialize failed";
    if (!c->BindAPI(EGL_OPENGL_API))
        return "no OpenGL API";
    c->handle = c->CreateContext(c->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
    return c->handle == EGL_NO_CONTEXT ? "no OpenGL 3.3 core context" : NULL;
}

static dig_status egl_open(void **context, char *why, size_t capacity)
{
    EglContext *c = calloc(1, sizeof *c);
    if (!c) {
        snprintf(why, capacity, "egl: no memory");
        return DIG_E_MEMORY;
    }
    const char *fault = load(c) ? start(c) : "libEGL.so.1 cannot be loaded";
    if (fault) {
        snprintf(why, capacity, "egl: %s", fault);
        if (c->library)
            dlclose(c->library);
        free(c);
        return DIG_E_FULL;
    }
    *context = c;
    return DIG_OK;
}

static void egl_close(void *context)
{
    EglContext *c = context;
    c->DestroyContext(c->display, c->handle);
    c->ReleaseThread();
    dlclose(c->library);
    free(c);
}

static bool egl_bind(void *context)
{
    EglContext *c = context;
    return c->BindAPI(EGL_OPENGL_API) && c->MakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, c->handle);
}

static void egl_unbind(void *context)
{
    EglContext *c = context;
    c->MakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

static GlProc egl_proc(void *context, const char *name)
{
    EglContext *c = context;
    return (GlProc)c->GetProcAddress(name);
}

const ContextBackend context_egl = {
    .name = "egl", .open = egl_open, .close = egl_close, .bind = egl_bind, .unbind = egl_unbind, .proc = egl_proc,
};
