/* render/gl.h - the OpenGL 3.3 core entry points the renderer uses, in a table of its own.
 *
 * No loader library: one list names each function once, and the table is filled through the backend's own
 * GetProcAddress. The table lives in the Renderer, so that two renderers on different backends do not mix.
 *
 * Floor: render.
 */
#ifndef DIG_GL_H
#define DIG_GL_H

#include <GL/glcorearb.h>

#include "render/context.h"

/* X(type of the pointer, name without gl) */
#define GL_FUNCTIONS(X)                                                 \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                            \
    X(PFNGLATTACHSHADERPROC, AttachShader)                              \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                  \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                          \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                        \
    X(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer)                      \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                                \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                        \
    X(PFNGLBLENDFUNCSEPARATEPROC, BlendFuncSeparate)                    \
    X(PFNGLBLITFRAMEBUFFERPROC, BlitFramebuffer)                        \
    X(PFNGLBUFFERDATAPROC, BufferData)                                  \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)          \
    X(PFNGLCLEARPROC, Clear)                                            \
    X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv)                            \
    X(PFNGLCLEARBUFFERUIVPROC, ClearBufferuiv)                          \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                            \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                            \
    X(PFNGLCREATESHADERPROC, CreateShader)                              \
    X(PFNGLCULLFACEPROC, CullFace)                                      \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                            \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                  \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                            \
    X(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers)                \
    X(PFNGLDELETESHADERPROC, DeleteShader)                              \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                          \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                  \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                                    \
    X(PFNGLDEPTHMASKPROC, DepthMask)                                    \
    X(PFNGLDISABLEPROC, Disable)                                        \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                                  \
    X(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced)                \
    X(PFNGLDRAWBUFFERPROC, DrawBuffer)                                  \
    X(PFNGLDRAWELEMENTSINSTANCEDPROC, DrawElementsInstanced)            \
    X(PFNGLENABLEPROC, Enable)                                          \
    X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)        \
    X(PFNGLFINISHPROC, Finish)                                          \
    X(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer)        \
    X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)              \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                                  \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                        \
    X(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers)                      \
    X(PFNGLGENTEXTURESPROC, GenTextures)                                \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                        \
    X(PFNGLGETERRORPROC, GetError)                                      \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                    \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                              \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                      \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                \
    X(PFNGLGETSTRINGPROC, GetString)                                    \
    X(PFNGLGETUNIFORMBLOCKINDEXPROC, GetUniformBlockIndex)              \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                  \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                                \
    X(PFNGLREADBUFFERPROC, ReadBuffer)                                  \
    X(PFNGLREADPIXELSPROC, ReadPixels)                                  \
    X(PFNGLRENDERBUFFERSTORAGEMULTISAMPLEPROC, RenderbufferStorageMultisample) \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                              \
    X(PFNGLTEXIMAGE2DPROC, TexImage2D)                                  \
    X(PFNGLTEXPARAMETERFVPROC, TexParameterfv)                          \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri)                            \
    X(PFNGLPOLYGONOFFSETPROC, PolygonOffset)                            \
    X(PFNGLTEXSUBIMAGE2DPROC, TexSubImage2D)                            \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                    \
    X(PFNGLUNIFORM2FPROC, Uniform2f)                                    \
    X(PFNGLUNIFORMBLOCKBINDINGPROC, UniformBlockBinding)                \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                  \
    X(PFNGLVERTEXATTRIBDIVISORPROC, VertexAttribDivisor)                \
    X(PFNGLVERTEXATTRIBIPOINTERPROC, VertexAttribIPointer)              \
    X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                \
    X(PFNGLVIEWPORTPROC, Viewport)

typedef struct Gl {
#define ENTRY_MEMBER(type, name) type name;
    GL_FUNCTIONS(ENTRY_MEMBER)
#undef ENTRY_MEMBER
} Gl;

/* Fills the table from the current context. false and one sentence when it is older than 3.3 or lacks a function. */
bool gl_load(Gl *gl, const ContextBackend *backend, void *context, char *why, size_t capacity);

#endif
