#pragma once

#include <utility>

#include "core/base/rate.h"
#include "core/stream/sink.h"
#include "rtsp_out/rtsp/gst_handle.h"

/// Pictures as GStreamer buffers, without a copy.
namespace camrig::rtsp {

/// A read-only buffer around this memory; it owns `keeper`, which keeps the memory alive.
template <typename T>
GstBufferHandle wrapped(const void* data, std::size_t size, T keeper) {
    auto* const kept = new T(std::move(keeper));
    return GstBufferHandle(gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_READONLY, const_cast<void*>(data), size, 0, size,
                                                       kept, [](void* pointer) { delete static_cast<T*>(pointer); }));
}

/// The caps of an appsrc for pictures of this format: image/jpeg, or video/x-raw.
GstCapsHandle caps_of(const stream::MediaFormat& format, ImageSize size, const Rate& rate);

/// A picture of this format as it goes into the pipeline: JPEG, or the first `shown` columns and rows of YUV planes.
GstBufferHandle buffer_of(const stream::MediaUnit& unit, const stream::MediaFormat& format, ImageSize shown);

}  // namespace camrig::rtsp
