/* render/gl.c - fills the table of OpenGL entry points. */
#include "render/gl.h"

#include <stdio.h>

bool gl_load(Gl *gl, const ContextBackend *backend, void *context, char *why, size_t capacity)
{
    /* Mesa answers any name with some function, so NULL catches a missing function only on other drivers; the version
     * below is the test that counts. */
#define ENTRY_FILL(type, entry)                                             \
    gl->entry = (type)backend->proc(context, "gl" #entry);                \
    if (!gl->entry) {                                                    \
        snprintf(why, capacity, "%s: the driver lacks gl" #entry, backend->name); \
        return false;                                                   \
    }
    GL_FUNCTIONS(ENTRY_FILL)
#undef ENTRY_FILL

    GLint major = 0, minor = 0;
    gl->GetIntegerv(GL_MAJOR_VERSION, &major);
    gl->GetIntegerv(GL_MINOR_VERSION, &minor);
    if (major * 10 + minor < 33) {
        snprintf(why, capacity, "%s: OpenGL %d.%d, needs 3.3", backend->name, (int)major, (int)minor);
        return false;
    }
    return true;
}
