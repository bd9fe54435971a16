#include "rtsp_out/http/mjpeg_output.h"

namespace camrig::http {

FieldTable<MjpegOutput> fields_of(std::type_identity<MjpegOutput>) {
    static const std::vector<FieldOf<MjpegOutput>> table{
        field_at<&MjpegOutput::quality>({.name = "quality", .doc = "JPEG quality", .range = {1, 100}})};
    return table;
}

OutputFamily mjpeg_family() {
    return {.kind = output_kind<MjpegOutput>(
                {.name = "mjpeg", .doc = "how the MJPEG stream over HTTP, which every camera has, is encoded"})};
}

MjpegOutput mjpeg_options_of(const std::vector<OutputSpec>& outputs) {
    for (const OutputSpec& output : outputs)
        if (output.kind == "mjpeg") return options_of<MjpegOutput>(output);
    return {};
}

}  // namespace camrig::http
