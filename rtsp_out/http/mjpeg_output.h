#pragma once

#include "core/base/output_family.h"
#include "core/codec/encoder.h"

namespace camrig::http {

/// The options of an output {kind: "mjpeg"}: defaults of the camera's MJPEG stream over HTTP. Every camera has that
/// stream, with or without such an output, and a reader may ask for another quality.
struct MjpegOutput {
    int quality = codec::default_jpeg_quality;
};
FieldTable<MjpegOutput> fields_of(std::type_identity<MjpegOutput>);

OutputFamily mjpeg_family();

/// The options of the mjpeg output among a camera's outputs; the defaults if there is none.
MjpegOutput mjpeg_options_of(const std::vector<OutputSpec>& outputs);

}  // namespace camrig::http
