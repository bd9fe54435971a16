#pragma once

#include <functional>
#include <optional>

#include <gst/rtsp-server/rtsp-server.h>

#include "rtsp_out/rtsp/annex_b.h"

namespace camrig::rtsp {

/// Two changes to how gst-rtsp-server sends a stream to clients over TCP (interleaved): a client gets packets from the
/// first key frame after it began to play, and a picture's memory is released as soon as its last packet has been
/// written to the last client.
///
/// Key frames: gst-rtsp-server gives a new client whatever packet comes next, which a decoder cannot show and complains
/// of.
///
/// Release: packets refer to the memory of their picture. The appsink through which gst-rtsp-server sends to TCP
/// clients keeps the last sample pulled from it until the next is pulled (GStreamer 1.22 to 1.26,
/// GstAppSinkPrivate.sample), so the last packet of a picture would be kept until the next picture, for which a step in
/// lockstep waits. So an empty buffer, the flush buffer, follows each group of packets that arrive together, which are
/// a picture's or a part of them: faults may have removed its last one. It is dropped where packets are written.
///
/// gst-rtsp-server has separate callbacks for buffer lists and for single buffers, and only the one for single buffers
/// can be replaced while the other is still used. So each list travels inside a single empty buffer, the carrier.

/// Installed at the sink pad of an appsink before data flows: puts packets into carriers, and adds a flush buffer after
/// RTP packets while `is_flushed()`. The probe runs on the streaming thread.
void carry_packets(GstPad* pad, std::function<bool()> is_flushed);

/// For a TCP client, before it plays: unpacks carriers, drops flush buffers, and leaves out RTP packets until a key
/// frame of `codec` begins; nullopt is JPEG, where every picture is one. Server thread.
void unpack_carriers(GstRTSPStreamTransport* transport, std::optional<NalCodec> codec);

}  // namespace camrig::rtsp
