#pragma once

#include <utility>

#include "core/base/rate.h"
#include "core/stream/sink.h"
#include "rtsp_out/rtsp/gst_handle.h"

/// Pictures as GStreamer's buffers, whose memory they stay.
namespace camrig::rtsp {

/// Memory of ours as a buffer, which keeps `keeper` for as long as anybody has a reference to it.
template <typename T>
GstBufferHandle wrapped(const void* data, std::size_t size, T keeper) {
    auto* const kept = new T(std::move(keeper));
    return GstBufferHandle(gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_READONLY, const_cast<void*>(data), size, 0, size,
                                                       kept, [](void* pointer) { delete static_cast<T*>(pointer); }));
}

/// What an appsrc is to know of the pictures of a stream.
GstCapsHandle caps_of(const stream::MediaFormat& format, ImageSize size, const Rate& rate);

/// A picture of this format as it goes into the pipeline: JPEG, or the first `shown` columns and rows of YUV planes.
GstBufferHandle buffer_of(const stream::MediaUnit& unit, const stream::MediaFormat& format, ImageSize shown);

}  // namespace camrig::rtsp
