#include "core/render/gl/egl_context.h"

#include <charconv>
#include <string_view>
#include <vector>

#include <spdlog/spdlog.h>

#include "core/render/gl/egl_library.h"

namespace camrig::render::gl {
namespace {

constexpr int max_egl_devices = 64;

bool has_extension(const char* extensions, std::string_view name) {
    if (extensions == nullptr) return false;
    const std::string padded = " " + std::string(extensions) + " ";
    return padded.find(" " + std::string(name) + " ") != std::string::npos;
}

struct Device {
    EGLDeviceEXT handle = nullptr;
    bool is_software = false;
    std::string label;
};

std::vector<Device> list_devices(const EglLibrary& egl) {
    const auto query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.eglGetProcAddress("eglQueryDevicesEXT"));
    const auto query_string =
        reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(egl.eglGetProcAddress("eglQueryDeviceStringEXT"));
    if (query_devices == nullptr || query_string == nullptr) return {};

    EGLDeviceEXT handles[max_egl_devices];
    EGLint count = 0;
    if (!query_devices(max_egl_devices, handles, &count)) return {};
    std::vector<Device> devices;
    for (int i = 0; i < count; ++i) {
        const char* extensions = query_string(handles[i], EGL_EXTENSIONS);
        Device device;
        device.handle = handles[i];
        device.is_software = has_extension(extensions, "EGL_MESA_device_software");
        device.label = device.is_software ? "software" : "hardware";
        if (has_extension(extensions, "EGL_EXT_device_drm")) {
            if (const char* file = query_string(handles[i], EGL_DRM_DEVICE_FILE_EXT)) device.label = file;
        }
        devices.push_back(std::move(device));
    }
    return devices;
}

std::string describe(const std::vector<Device>& devices) {
    std::string text = "EGL devices here: ";
    for (std::size_t i = 0; i < devices.size(); ++i) {
        text += std::to_string(i) + " (" + devices[i].label + "), ";
    }
    return text + "cpu, llvmpipe";
}

EGLDisplay display_of(const EglLibrary& egl, const Device& device) {
    return egl.eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, device.handle, nullptr);
}

void APIENTRY log_gl_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei, const GLchar* text, const void*) {
    if (type == GL_DEBUG_TYPE_ERROR) spdlog::error("OpenGL: {}", text);
    if (type != GL_DEBUG_TYPE_ERROR && severity == GL_DEBUG_SEVERITY_HIGH) spdlog::warn("OpenGL: {}", text);
}

bool has_gl_extension(const GlFunctions& gl, std::string_view name) {
    GLint count = 0;
    gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; ++i) {
        if (name == reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)))) return true;
    }
    return false;
}

}  // namespace

Result<void> EglContext::open(void* display, const std::string& what) {
    if (display == EGL_NO_DISPLAY || !egl_->eglInitialize(display, nullptr, nullptr)) {
        return error(ErrorKind::unavailable, what + ": EGL does not start on it");
    }
    display_ = display;
    if (!egl_->eglBindAPI(EGL_OPENGL_API)) return error(ErrorKind::unsupported, what + ": no desktop OpenGL");
#ifdef NDEBUG
    constexpr EGLint debug = EGL_FALSE;
#else
    constexpr EGLint debug = EGL_TRUE;
#endif
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_CONTEXT_OPENGL_DEBUG,
                                 debug,
                                 EGL_NONE};
    context_ = egl_->eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (context_ == EGL_NO_CONTEXT) return error(ErrorKind::unsupported, what + ": no OpenGL 4.5 core context");
    if (!egl_->eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
        return error(ErrorKind::unsupported, what + ": no context without a surface");
    }
    if (auto loaded = gl_.load(egl_->eglGetProcAddress); !loaded) return at(what, loaded.error());

    const auto* renderer = reinterpret_cast<const char*>(gl_.GetString(GL_RENDERER));
    const auto* version = reinterpret_cast<const char*>(gl_.GetString(GL_VERSION));
    description_ = std::string(renderer) + ", OpenGL " + version;
    is_software_ = description_.starts_with("llvmpipe") || description_.starts_with("softpipe");
    has_draw_id_ = has_gl_extension(gl_, "GL_ARB_shader_draw_parameters");
    gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &max_texture_size_);
    if (debug) {
        gl_.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        gl_.DebugMessageCallback(log_gl_message, nullptr);
    }
    return {};
}

void EglContext::close() noexcept {
    if (display_ == nullptr) return;
    egl_->eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context_ != nullptr) egl_->eglDestroyContext(display_, context_);
    // The display stays initialised: EGL displays are per process and other contexts may use this one.
    display_ = nullptr;
    context_ = nullptr;
}

EglContext::~EglContext() {
    close();
}

Result<std::unique_ptr<EglContext>> EglContext::create(const std::string& wanted) {
    // The driver for CPUs is large, and would be loaded to list the devices.
    if (wanted.empty() && !has_gpu_node()) return error(ErrorKind::unavailable, "no hardware with OpenGL here");
    const auto library = EglLibrary::open();
    if (!library) return std::unexpected(library.error());
    const EglLibrary& egl = **library;
    const std::vector<Device> devices = list_devices(egl);
    const auto try_open = [&egl](EGLDisplay display, const std::string& what) -> Result<std::unique_ptr<EglContext>> {
        std::unique_ptr<EglContext> context(new EglContext(egl));
        if (auto opened = context->open(display, what); !opened) return std::unexpected(opened.error());
        return context;
    };
    if (wanted == "llvmpipe") {
        std::string why = "device llvmpipe: there is none";
        for (const Device& device : devices) {
            if (!device.is_software) continue;
            auto context = try_open(display_of(egl, device), "device llvmpipe");
            if (context) return context;
            why = context.error().message;
        }
        return error(ErrorKind::unavailable,
                     why + "; it is Mesa's software rasteriser (package libgl1-mesa-dri); " + describe(devices));
    }
    if (wanted.empty()) {
        for (const Device& device : devices) {
            if (device.is_software) continue;
            auto context = try_open(display_of(egl, device), device.label);
            if (context && !(*context)->is_software()) return context;
        }
        return error(ErrorKind::unavailable, "no hardware with OpenGL 4.5; " + describe(devices));
    }

    std::size_t index = 0;
    const char* end = wanted.data() + wanted.size();
    const auto [stop, failure] = std::from_chars(wanted.data(), end, index);
    if (failure != std::errc{} || stop != end || index >= devices.size()) {
        return error(ErrorKind::invalid_argument, "device '" + wanted + "' does not exist; " + describe(devices));
    }
    auto context = try_open(display_of(egl, devices[index]), "device " + wanted);
    if (!context) return error(context.error().kind, context.error().message + "; " + describe(devices));
    return context;
}

}  // namespace camrig::render::gl
