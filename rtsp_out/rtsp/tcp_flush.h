#pragma once

#include <functional>

#include <gst/rtsp-server/rtsp-server.h>

namespace camrig::rtsp {

/// Lets a picture go when its last packet has been written to the last TCP reader.
///
/// A picture on its way is kept by its packets. The appsink through which gst-rtsp-server sends to TCP readers keeps
/// what was taken from it last until the next is taken (GStreamer 1.22 to 1.26, GstAppSinkPrivate.sample), so the last
/// packet of a picture would be kept until the next picture, for which a step in lockstep waits. So a buffer of no
/// bytes, the flush buffer, goes after each picture; it is dropped where packets are written.
///
/// Packets go as lists, also single ones, and flush buffers as single ones: gst-rtsp-server has a way of its own for
/// each, and that of single buffers is replaced.

/// At the sink pad of an appsink, before anything flows: packets become lists, and a flush buffer comes after each
/// picture while `wanted()`. Streaming thread.
void send_flush_buffers(GstPad* pad, std::function<bool()> wanted);

/// For a TCP reader, before it plays: flush buffers end here. Server thread.
void drop_flush_buffers(GstRTSPStreamTransport* transport);

}  // namespace camrig::rtsp
