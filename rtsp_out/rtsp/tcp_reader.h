#pragma once

#include <functional>
#include <optional>

#include <gst/rtsp-server/rtsp-server.h>

#include "rtsp_out/rtsp/annex_b.h"

namespace camrig::rtsp {

/// What a TCP reader gets of the packets of its stream: from the first key picture after it came, and of each picture
/// all, so that the picture is let go when its last packet has been written to the last reader.
///
/// Key pictures: gst-rtsp-server gives a new reader whatever comes next, of which a decoder shows nothing and
/// complains.
///
/// Letting go: a picture on its way is kept by its packets. The appsink through which gst-rtsp-server sends to TCP
/// readers keeps what was taken from it last until the next is taken (GStreamer 1.22 to 1.26,
/// GstAppSinkPrivate.sample), so the last packet of a picture would be kept until the next picture, for which a step in
/// lockstep waits. So a buffer of no bytes, the flush buffer, goes after packets that come together, which are those of
/// a picture or of a part of it: faults may have taken its last one. It is dropped where packets are written.
///
/// gst-rtsp-server has a way of its own for lists of packets and for single ones, and only that of single ones can be
/// replaced and the other still be used. So each list travels inside a single buffer of no bytes, the carrier.

/// At the sink pad of an appsink, before anything flows: packets travel in carriers, and a flush buffer comes after
/// those of RTP while `is_flushed()`. Streaming thread.
void carry_packets(GstPad* pad, std::function<bool()> is_flushed);

/// For a TCP reader, before it plays: unpacks carriers, drops flush buffers, and leaves out packets of RTP until a key
/// picture of `codec` begins; of JPEG (none) every picture is one. Server thread.
void unpack_carriers(GstRTSPStreamTransport* transport, std::optional<NalCodec> codec);

}  // namespace camrig::rtsp
