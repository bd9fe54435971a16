#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libswscale/swscale.h>
}

#include "core/base/result.h"

namespace camrig::world {

// A stream's side data moved to its parameters in FFmpeg 6.1.
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
#define CAMRIG_LIBAV_SIDE_DATA(use) use(avcodec, av_packet_side_data_get)
#else
#define CAMRIG_LIBAV_SIDE_DATA(use) use(avformat, av_stream_get_side_data)
#endif

#define CAMRIG_LIBAV_FUNCTIONS(use)                                                                                    \
    use(avformat, avformat_open_input) use(avformat, avformat_close_input) use(avformat, avformat_find_stream_info)    \
        use(avformat, av_find_best_stream) use(avformat, av_read_frame) use(avformat, av_seek_frame)                   \
            use(avcodec, avcodec_alloc_context3) use(avcodec, avcodec_free_context)                                    \
                use(avcodec, avcodec_parameters_to_context) use(avcodec, avcodec_open2)                                \
                    use(avcodec, avcodec_receive_frame) use(avcodec, avcodec_send_packet)                              \
                        use(avcodec, avcodec_flush_buffers) use(avcodec, av_packet_alloc) use(avcodec, av_packet_free) \
                            use(avcodec, av_packet_unref) use(avutil, av_log_set_level) use(avutil, av_dict_set)       \
                                use(avutil, av_dict_free) use(avutil, av_strerror) use(avutil, av_frame_alloc)         \
                                    use(avutil, av_frame_free) use(avutil, av_frame_get_buffer)                        \
                                        use(avutil, av_display_rotation_get) use(swscale, sws_freeContext)             \
                                            use(swscale, sws_getCachedContext) use(swscale, sws_setColorspaceDetails)  \
                                                use(swscale, sws_getCoefficients) use(swscale, sws_scale)              \
                                                    CAMRIG_LIBAV_SIDE_DATA(use)

/// The functions of FFmpeg's libraries that films need. They are opened with the first film: with all that they use
/// they are a hundred libraries, which a rig without films does not load.
struct LibavLibrary {
#define CAMRIG_LIBAV_MEMBER(library, name) decltype(&::name) name = nullptr;
    CAMRIG_LIBAV_FUNCTIONS(CAMRIG_LIBAV_MEMBER)
#undef CAMRIG_LIBAV_MEMBER

    /// Error `unsupported`: they are not installed. Any thread.
    static Result<const LibavLibrary*> open();
};

}  // namespace camrig::world
