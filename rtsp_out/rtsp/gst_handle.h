#pragma once

#include <memory>

#include <gst/gst.h>

namespace camrig::rtsp {

/// Owns one reference of a GObject.
struct GObjectUnref {
    void operator()(void* object) const { g_object_unref(object); }
};
template <typename T>
using GObjectHandle = std::unique_ptr<T, GObjectUnref>;

struct GstCapsUnref {
    void operator()(GstCaps* caps) const { gst_caps_unref(caps); }
};
using GstCapsHandle = std::unique_ptr<GstCaps, GstCapsUnref>;

struct GstBufferUnref {
    void operator()(GstBuffer* buffer) const { gst_buffer_unref(buffer); }
};
using GstBufferHandle = std::unique_ptr<GstBuffer, GstBufferUnref>;

/// A weak reference to a GObject; lock() gives null once it is gone. Any thread.
class GObjectWeak {
public:
    explicit GObjectWeak(void* object) { g_weak_ref_init(&reference_, object); }
    ~GObjectWeak() { g_weak_ref_clear(&reference_); }
    GObjectWeak(const GObjectWeak&) = delete;
    GObjectWeak& operator=(const GObjectWeak&) = delete;
    template <typename T>
    GObjectHandle<T> lock() {
        return GObjectHandle<T>(static_cast<T*>(g_weak_ref_get(&reference_)));
    }

private:
    GWeakRef reference_;
};

/// A child of a bin by its name, or null. The handle holds a reference.
inline GObjectHandle<GstElement> child_of(GstElement* bin, const char* name) {
    return GObjectHandle<GstElement>(gst_bin_get_by_name(GST_BIN(bin), name));
}

}  // namespace camrig::rtsp
