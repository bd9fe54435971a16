// A network camera's reader made of ffmpeg's own libraries: what any program on them knows of a stream.
//
//     rtsp_libav_reader URL > frames
//
// For each decoded picture, in the machine's byte order: time stamp in ticks of the stream and wall-clock time in us since
// 1970 as 8 bytes each (INT64_MIN: not known yet), width and height as 4 bytes each, then the luma plane. Ends with the
// stream, exit status 0.
#include <inttypes.h>
#include <stdio.h>

#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>

enum { remembered = 64 };  // packets that may be in the decoder

static int64_t known_pts[remembered], known_wall[remembered];

// What the demuxer made of the sender reports: AVProducerReferenceTime of the packet.
static int64_t wall_of(const AVPacket* packet) {
    size_t size = 0;
    const uint8_t* data = av_packet_get_side_data(packet, AV_PKT_DATA_PRFT, &size);
    return data && size >= sizeof(int64_t) ? ((const AVProducerReferenceTime*)data)->wallclock : INT64_MIN;
}

static int write_frame(const AVFrame* frame) {
    int64_t wall = INT64_MIN;
    for (int i = 0; i < remembered; ++i)
        if (known_pts[i] == frame->pts) wall = known_wall[i];
    const int64_t times[2] = {frame->pts, wall};
    const int32_t size[2] = {frame->width, frame->height};
    fwrite(times, sizeof times, 1, stdout);
    fwrite(size, sizeof size, 1, stdout);
    for (int y = 0; y < frame->height; ++y)
        fwrite(frame->data[0] + (ptrdiff_t)y * frame->linesize[0], 1, (size_t)frame->width, stdout);
    return fflush(stdout);
}

static int fail(const char* what, int code) {
    char text[AV_ERROR_MAX_STRING_SIZE] = "";
    av_strerror(code, text, sizeof text);
    fprintf(stderr, "%s: %s\n", what, text);
    return 1;
}

int main(int argc, char** argv) {
    if (argc != 2) return fail("usage: rtsp_libav_reader URL", AVERROR(EINVAL));
    for (int i = 0; i < remembered; ++i) known_pts[i] = known_wall[i] = INT64_MIN;
    AVDictionary* options = NULL;
    av_dict_set(&options, "rtsp_transport", "tcp", 0);
    AVFormatContext* input = NULL;
    int code = avformat_open_input(&input, argv[1], NULL, &options);
    if (code < 0) return fail("open", code);
    const AVCodec* codec = avcodec_find_decoder(input->streams[0]->codecpar->codec_id);
    AVCodecContext* decoder = avcodec_alloc_context3(codec);
    avcodec_parameters_to_context(decoder, input->streams[0]->codecpar);
    decoder->thread_count = 1;
    if ((code = avcodec_open2(decoder, codec, NULL)) < 0) return fail("decoder", code);
    AVPacket* packet = av_packet_alloc();
    AVFrame* frame = av_frame_alloc();
    for (unsigned number = 0; (code = av_read_frame(input, packet)) >= 0; ++number) {
        known_pts[number % remembered] = packet->pts;
        known_wall[number % remembered] = wall_of(packet);
        avcodec_send_packet(decoder, packet);
        av_packet_unref(packet);
        while (avcodec_receive_frame(decoder, frame) >= 0)
            if (write_frame(frame) != 0) return 0;  // nobody reads any more
    }
    if (code != AVERROR_EOF) return fail("read", code);
    av_frame_free(&frame);
    av_packet_free(&packet);
    avcodec_free_context(&decoder);
    avformat_close_input(&input);
    return 0;
}
