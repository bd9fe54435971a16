#pragma once

#include <string>

#include "core/base/output_family.h"
#include "core/codec/encoder.h"

namespace camrig::device {

/// The options of an output {kind: "v4l2"}: /dev/video<number> of the kernel module v4l2loopback.
struct LoopbackOutput {
    int number = 0;
    std::string format = "YUYV";  ///< YUYV, YU12, MJPG or BGR3
    codec::ChromaSampling subsampling = codec::ChromaSampling::yuv422;
};
FieldTable<LoopbackOutput> fields_of(std::type_identity<LoopbackOutput>);

OutputFamily loopback_family();

}  // namespace camrig::device
