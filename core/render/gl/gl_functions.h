#pragma once

#include <GL/glcorearb.h>

#include "core/base/result.h"

/// The OpenGL 4.5 core entry points this renderer uses, and no others: NAME is called as `gl.NAME(...)`.
#define CAMRIG_GL_FUNCTIONS(X)                                    \
    X(AttachShader, ATTACHSHADER)                                 \
    X(BindBufferBase, BINDBUFFERBASE)                             \
    X(BindBufferRange, BINDBUFFERRANGE)                           \
    X(BindBuffer, BINDBUFFER)                                     \
    X(BindFramebuffer, BINDFRAMEBUFFER)                           \
    X(BindSampler, BINDSAMPLER)                                   \
    X(BindTextureUnit, BINDTEXTUREUNIT)                           \
    X(BindVertexArray, BINDVERTEXARRAY)                           \
    X(BlendFuncSeparate, BLENDFUNCSEPARATE)                       \
    X(CheckNamedFramebufferStatus, CHECKNAMEDFRAMEBUFFERSTATUS)   \
    X(ClearNamedFramebufferfv, CLEARNAMEDFRAMEBUFFERFV)           \
    X(ClearNamedFramebufferuiv, CLEARNAMEDFRAMEBUFFERUIV)         \
    X(ClientWaitSync, CLIENTWAITSYNC)                             \
    X(ClipControl, CLIPCONTROL)                                   \
    X(CompileShader, COMPILESHADER)                               \
    X(CopyImageSubData, COPYIMAGESUBDATA)                         \
    X(CreateBuffers, CREATEBUFFERS)                               \
    X(CreateFramebuffers, CREATEFRAMEBUFFERS)                     \
    X(CreateProgram, CREATEPROGRAM)                               \
    X(CreateSamplers, CREATESAMPLERS)                             \
    X(CreateShader, CREATESHADER)                                 \
    X(CreateTextures, CREATETEXTURES)                             \
    X(CreateVertexArrays, CREATEVERTEXARRAYS)                     \
    X(CullFace, CULLFACE)                                         \
    X(DebugMessageCallback, DEBUGMESSAGECALLBACK)                 \
    X(DeleteBuffers, DELETEBUFFERS)                               \
    X(DeleteFramebuffers, DELETEFRAMEBUFFERS)                     \
    X(DeleteProgram, DELETEPROGRAM)                               \
    X(DeleteSamplers, DELETESAMPLERS)                             \
    X(DeleteShader, DELETESHADER)                                 \
    X(DeleteSync, DELETESYNC)                                     \
    X(DeleteTextures, DELETETEXTURES)                             \
    X(DeleteVertexArrays, DELETEVERTEXARRAYS)                     \
    X(DepthFunc, DEPTHFUNC)                                       \
    X(DepthMask, DEPTHMASK)                                       \
    X(Disable, DISABLE)                                           \
    X(DispatchCompute, DISPATCHCOMPUTE)                           \
    X(DrawArrays, DRAWARRAYS)                                     \
    X(DrawElementsBaseVertex, DRAWELEMENTSBASEVERTEX)             \
    X(Enable, ENABLE)                                             \
    X(EnableVertexArrayAttrib, ENABLEVERTEXARRAYATTRIB)           \
    X(FenceSync, FENCESYNC)                                       \
    X(Finish, FINISH)                                             \
    X(Flush, FLUSH)                                               \
    X(FrontFace, FRONTFACE)                                       \
    X(GenTextures, GENTEXTURES)                                   \
    X(GenerateTextureMipmap, GENERATETEXTUREMIPMAP)               \
    X(GetError, GETERROR)                                         \
    X(GetInteger64v, GETINTEGER64V)                               \
    X(GetIntegerv, GETINTEGERV)                                   \
    X(GetProgramInfoLog, GETPROGRAMINFOLOG)                       \
    X(GetProgramiv, GETPROGRAMIV)                                 \
    X(GetShaderInfoLog, GETSHADERINFOLOG)                         \
    X(GetShaderiv, GETSHADERIV)                                   \
    X(GetString, GETSTRING)                                       \
    X(GetStringi, GETSTRINGI)                                     \
    X(LinkProgram, LINKPROGRAM)                                   \
    X(MapNamedBufferRange, MAPNAMEDBUFFERRANGE)                   \
    X(MemoryBarrier, MEMORYBARRIER)                               \
    X(MultiDrawElementsBaseVertex, MULTIDRAWELEMENTSBASEVERTEX)   \
    X(NamedBufferStorage, NAMEDBUFFERSTORAGE)                     \
    X(NamedFramebufferDrawBuffers, NAMEDFRAMEBUFFERDRAWBUFFERS)   \
    X(NamedFramebufferReadBuffer, NAMEDFRAMEBUFFERREADBUFFER)     \
    X(NamedFramebufferTexture, NAMEDFRAMEBUFFERTEXTURE)           \
    X(NamedFramebufferTextureLayer, NAMEDFRAMEBUFFERTEXTURELAYER) \
    X(PixelStorei, PIXELSTOREI)                                   \
    X(ReadPixels, READPIXELS)                                     \
    X(Scissor, SCISSOR)                                           \
    X(SamplerParameterfv, SAMPLERPARAMETERFV)                     \
    X(SamplerParameteri, SAMPLERPARAMETERI)                       \
    X(ShaderSource, SHADERSOURCE)                                 \
    X(TextureStorage2D, TEXTURESTORAGE2D)                         \
    X(TextureStorage3D, TEXTURESTORAGE3D)                         \
    X(TextureStorage2DMultisample, TEXTURESTORAGE2DMULTISAMPLE)   \
    X(TextureSubImage2D, TEXTURESUBIMAGE2D)                       \
    X(TextureView, TEXTUREVIEW)                                   \
    X(UseProgram, USEPROGRAM)                                     \
    X(VertexArrayAttribBinding, VERTEXARRAYATTRIBBINDING)         \
    X(VertexArrayAttribFormat, VERTEXARRAYATTRIBFORMAT)           \
    X(VertexArrayElementBuffer, VERTEXARRAYELEMENTBUFFER)         \
    X(VertexArrayVertexBuffer, VERTEXARRAYVERTEXBUFFER)           \
    X(Viewport, VIEWPORT)

namespace camrig::render::gl {

/// Function pointers of the current context. Plain data; one per context, owned by it, never null after load().
struct GlFunctions {
#define CAMRIG_GL_DECLARE(name, NAME) PFNGL##NAME##PROC name = nullptr;
    CAMRIG_GL_FUNCTIONS(CAMRIG_GL_DECLARE)
#undef CAMRIG_GL_DECLARE

    /// Fills all pointers from the context that is current on this thread; names the first function that is missing.
    /// address_of: eglGetProcAddress.
    Result<void> load(void (*(*address_of)(const char* name))());
};

/// Whether a call since the last question failed for want of memory; takes all errors that are noted.
bool is_out_of_memory(const GlFunctions& gl);

}  // namespace camrig::render::gl
