#include "control/onvif/video_stream.h"

#include <algorithm>
#include <cmath>

#include "core/base/output_family.h"
#include "core/base/picture_fields.h"
#include "core/base/rtp_jpeg.h"

namespace camrig::onvif {
namespace {

using nlohmann::json;
using world::CameraSpec;

/// Rates of clients are floats with few decimals.
constexpr double same_rate = 1e-3;
constexpr int slowest_share = 10;  ///< of the camera's rate that is offered
constexpr double key_interval_range_s[] = {0.01, 60.0};

std::unexpected<Error> refused(std::string why) {
    return std::unexpected(Error{ErrorKind::invalid_argument, std::move(why)});
}

/// Of the camera, as it is given; with what tells the stream from others when it has none yet.
json options_of_stream(const CameraSpec& camera, const VideoStream& stream) {
    OutputSpec output{.kind = "rtsp"};
    if (stream.ending == "sub") output.options["stream"] = "sub";
    if (stream.ending == "mjpeg") output.options["codec"] = "mjpeg";
    const auto given =
        std::ranges::find_if(camera.outputs, [&](const OutputSpec& one) { return is_same_output(one, output); });
    return given == camera.outputs.end() ? output.options : given->options;
}

/// Options that the codec does not have go.
void choose_codec(json& options, const std::string& codec) {
    options["codec"] = codec;
    if (codec != "mjpeg") options.erase("quality");
    if (codec != "h264") options.erase("profile");
    if (codec != "mjpeg") return;
    for (const char* key : {"bitrate_kbps", "key_interval_s", "preset"}) options.erase(key);
}

Result<Rate> rate_of(const CameraSpec& camera, double wanted) {
    if (!(wanted <= camera.rate.hertz() + same_rate))
        return refused("the frame rate is at most " + camera.rate.to_string());
    for (const Rate& rate : rates_for(camera))
        if (std::abs(rate.hertz() - wanted) < same_rate) return rate;
    return Rate::from_number(wanted);
}

bool is_whole(double value, IntRange range) {
    return value == std::floor(value) && value >= range.low && value <= range.high;
}

std::string words(IntRange range) {
    return std::to_string(range.low) + " to " + std::to_string(range.high);
}

}  // namespace

std::string token_of(const CameraSpec& camera, const VideoStream& stream) {
    return stream.ending.empty() ? camera.name : camera.name + "-" + stream.ending;
}

std::string_view stream_of_token(std::string_view token) {
    const std::size_t at = token.rfind('-');
    if (at == std::string_view::npos) return "";
    const auto known = std::ranges::find(stream_endings, token.substr(at + 1));
    return known == std::end(stream_endings) ? "" : *known;
}

std::string_view camera_of_token(std::string_view token) {
    const std::string_view ending = stream_of_token(token);
    return ending.empty() ? token : token.substr(0, token.size() - ending.size() - 1);
}

int gov_length(const VideoStream& stream) {
    return std::max(1, static_cast<int>(std::lround(stream.key_interval_s * stream.rate.hertz())));
}

std::vector<std::string> codecs_for(const CameraSpec& camera, const VideoStream& stream, bool has_h265) {
    if (stream.ending == "mjpeg") return {"mjpeg"};
    std::vector<std::string> codecs{"h264"};
    if (has_h265) codecs.emplace_back("h265");
    if (stream.ending == "sub" && !sizes_for(camera, stream, "mjpeg").empty()) codecs.emplace_back("mjpeg");
    return codecs;
}

std::vector<ImageSize> sizes_for(const CameraSpec& camera, const VideoStream& stream, const std::string& codec) {
    if (stream.ending != "sub") return {camera.size};
    const bool is_jpeg = codec == "mjpeg";
    const int step = is_jpeg ? rtp_jpeg_step : 2;
    std::vector<ImageSize> sizes;
    const auto add = [&](ImageSize size) {
        const bool fits = size.width >= min_image_size.width && size.height >= min_image_size.height &&
                          (is_jpeg ? fits_rtp_jpeg(size) : size.width % step == 0 && size.height % step == 0);
        if (fits && std::ranges::find(sizes, size) == sizes.end()) sizes.push_back(size);
    };
    for (const auto& [part, whole] : {std::pair{1, 1}, {3, 4}, {2, 3}, {1, 2}, {1, 3}, {1, 4}})
        add({camera.size.width * part / whole / step * step, camera.size.height * part / whole / step * step});
    add(stream.size);
    if (sizes.empty() && codec == stream.codec) sizes.push_back(stream.size);
    std::ranges::sort(sizes, std::greater{});
    return sizes;
}

std::vector<Rate> rates_for(const CameraSpec& camera) {
    std::vector<Rate> rates;
    for (int share = 1; share <= slowest_share; ++share)
        if (auto rate = Rate::create(camera.rate.num(), share * camera.rate.den())) rates.push_back(*rate);
    return rates;
}

IntRange gov_range(const Rate& rate) {
    return {std::max(1, static_cast<int>(std::ceil(key_interval_range_s[0] * rate.hertz()))),
            std::max(1, static_cast<int>(std::floor(key_interval_range_s[1] * rate.hertz())))};
}

Result<OutputSpec> output_for(const CameraSpec& camera, const VideoStream& stream, const StreamWish& wish,
                              bool has_h265) {
    json options = options_of_stream(camera, stream);
    const std::string codec = wish.codec.value_or(stream.codec);
    const auto codecs = codecs_for(camera, stream, has_h265);
    if (std::ranges::find(codecs, codec) == codecs.end()) return refused("this stream has no such encoding");
    if (codec != stream.codec) choose_codec(options, codec);

    const ImageSize size = wish.size.value_or(stream.size);
    const auto sizes = sizes_for(camera, stream, codec);
    if (std::ranges::find(sizes, size) == sizes.end())
        return refused("this stream has no pictures of " + size.to_string() + " in that encoding");
    if (size != stream.size || (codec != stream.codec && stream.ending == "sub")) options["size"] = size_to_json(size);

    Rate rate = stream.rate;
    if (wish.frame_rate && std::abs(*wish.frame_rate - wish.told_rate) >= same_rate) {
        const auto wanted = rate_of(camera, *wish.frame_rate);
        if (!wanted) return std::unexpected(wanted.error());
        rate = *wanted;
    }
    if (rate != stream.rate) options["fps"] = rate_to_json(rate);

    if (codec == "mjpeg") {
        if (wish.quality) {
            if (!is_whole(std::round(*wish.quality), quality_range))
                return refused("quality is " + words(quality_range));
            const int quality = static_cast<int>(std::round(*wish.quality));
            if (quality != stream.quality || codec != stream.codec) options["quality"] = quality;
        }
    } else {
        const double kbps =
            std::clamp(wish.bitrate_kbps.value_or(stream.bitrate_kbps), static_cast<double>(bitrate_range_kbps.low),
                       static_cast<double>(bitrate_range_kbps.high));
        // What it is by default depends on the rest: it stays what was asked for.
        const bool is_else = rate != stream.rate || size != stream.size || codec != stream.codec;
        if (static_cast<int>(kbps) != stream.bitrate_kbps || (wish.bitrate_kbps && is_else))
            options["bitrate_kbps"] = static_cast<int>(kbps);
        const double gov = wish.gov_length.value_or(gov_length(stream));
        const bool is_other = gov != gov_length(stream) || (wish.gov_length && rate != stream.rate);
        if (is_other && !is_whole(gov, gov_range(rate))) return refused("GovLength is " + words(gov_range(rate)));
        if (is_other) options["key_interval_s"] = gov / rate.hertz();
        if (codec == "h264" && wish.profile && *wish.profile != stream.profile) options["profile"] = *wish.profile;
    }
    options["kind"] = "rtsp";
    JsonReader reader(options, "output");
    OutputSpec output = read_output(reader);
    if (auto good = reader.finish(); !good) return std::unexpected(good.error());
    return output;
}

}  // namespace camrig::onvif
