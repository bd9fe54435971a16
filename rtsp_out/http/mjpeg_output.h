#pragma once

#include "core/base/output_family.h"
#include "core/codec/encoder.h"

namespace camrig::http {

/// The options of an output {kind: "mjpeg"}: of the camera's MJPEG stream over HTTP, which every camera has, where
/// its reader asks for nothing else.
struct MjpegOutput {
    int quality = codec::default_jpeg_quality;
};
FieldTable<MjpegOutput> fields_of(std::type_identity<MjpegOutput>);

OutputFamily mjpeg_family();

/// What these outputs of a camera say.
MjpegOutput mjpeg_options_of(const std::vector<OutputSpec>& outputs);

}  // namespace camrig::http
