// A network camera's reader made of ffmpeg's own libraries: what any program on them knows of a stream.
//
//     rtsp_libav_reader URL > frames
//
// For each decoded picture, in the machine's byte order: time stamp in ticks of the stream and wall-clock time in us since
// 1970 as 8 bytes each (INT64_MIN: not known yet), width and height as 4 bytes each, then the luma plane. Ends with the
// stream, exit status 0.
//
// It puts H.264 pictures together by itself. libavformat would do so too, but a packet of its making ends where the next
// picture begins, and it gives it the side data of that one: its wall-clock time is the next picture's (ffmpeg 4.4 to 7,
// parse_packet in libavformat/demux.c). Its time stamp is its own.
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

// What the decoder makes of a whole picture.
static int decode(AVCodecContext* decoder, AVFrame* frame, const AVPacket* picture) {
    avcodec_send_packet(decoder, picture);
    while (avcodec_receive_frame(decoder, frame) >= 0)
        if (write_frame(frame) != 0) return -1;  // nobody reads any more
    return 0;
}

// The same for a piece of H.264, which may end the picture before it.
static int decode_piece(AVCodecParserContext* parser, AVCodecContext* decoder, AVFrame* frame, AVPacket* picture, const AVPacket* piece) {
    const uint8_t* data = piece->data;
    int left = piece->size;
    int64_t pts = piece->pts;
    while (left > 0) {
        const int used = av_parser_parse2(parser, decoder, &picture->data, &picture->size, data, left, pts, AV_NOPTS_VALUE, -1);
        data += used;
        left -= used;
        pts = AV_NOPTS_VALUE;
        picture->pts = parser->pts;
        if (picture->size > 0 && decode(decoder, frame, picture) != 0) return -1;
    }
    return 0;
}

int main(int argc, char** argv) {
    if (argc != 2) return fail("usage: rtsp_libav_reader URL", AVERROR(EINVAL));
    for (int i = 0; i < remembered; ++i) known_pts[i] = known_wall[i] = INT64_MIN;
    AVDictionary* options = NULL;
    av_dict_set(&options, "rtsp_transport", "tcp", 0);
    AVFormatContext* input = avformat_alloc_context();
    input->flags |= AVFMT_FLAG_NOPARSE;
    int code = avformat_open_input(&input, argv[1], NULL, &options);
    if (code < 0) return fail("open", code);
    const AVCodec* codec = avcodec_find_decoder(input->streams[0]->codecpar->codec_id);
    AVCodecContext* decoder = avcodec_alloc_context3(codec);
    avcodec_parameters_to_context(decoder, input->streams[0]->codecpar);
    decoder->thread_count = 1;
    if ((code = avcodec_open2(decoder, codec, NULL)) < 0) return fail("decoder", code);
    AVCodecParserContext* parser = codec->id == AV_CODEC_ID_H264 ? av_parser_init(codec->id) : NULL;
    AVPacket *packet = av_packet_alloc(), *picture = av_packet_alloc();
    AVFrame* frame = av_frame_alloc();
    for (unsigned number = 0; (code = av_read_frame(input, packet)) >= 0; ++number) {
        known_pts[number % remembered] = packet->pts;
        known_wall[number % remembered] = wall_of(packet);
        const int stops = parser ? decode_piece(parser, decoder, frame, picture, packet) : decode(decoder, frame, packet);
        av_packet_unref(packet);
        if (stops) return 0;
    }
    if (code != AVERROR_EOF) return fail("read", code);
    av_frame_free(&frame);
    av_packet_free(&packet);
    av_packet_free(&picture);
    if (parser) av_parser_close(parser);
    avcodec_free_context(&decoder);
    avformat_close_input(&input);
    return 0;
}
