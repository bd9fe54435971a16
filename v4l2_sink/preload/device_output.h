#pragma once

#include "core/base/output_family.h"
#include "core/codec/encoder.h"

namespace camrig::device {

/// The options of an output {kind: "device"}: /dev/video<number> in user space.
struct DeviceOutput {
    int number = 0;
    codec::ChromaSampling subsampling = codec::ChromaSampling::yuv422;  ///< of MJPG
    bool error_controls = false;                                        ///< V4L2 controls that let it fail
};
FieldTable<DeviceOutput> fields_of(std::type_identity<DeviceOutput>);

OutputFamily device_family();

}  // namespace camrig::device
