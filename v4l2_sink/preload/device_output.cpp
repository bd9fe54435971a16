#include "v4l2_sink/preload/device_output.h"

#include "v4l2_sink/media_format.h"

namespace camrig::device {

FieldTable<DeviceOutput> fields_of(std::type_identity<DeviceOutput>) {
    static const std::vector<FieldOf<DeviceOutput>> table{
        field_at<&DeviceOutput::number>(video_number_field()),
        field_at<&DeviceOutput::subsampling>(subsampling_field("subsampling")),
        field_at<&DeviceOutput::error_controls>(
            {.name = "error_controls",
             .doc = "it has V4L2 controls by which programs let it fail, with the names and numbers of the kernel's "
                    "vivid (docs/faults.md)"}),
    };
    return table;
}

OutputFamily device_family() {
    return {.kind = output_kind<DeviceOutput>(
                {.name = "device", .doc = "/dev/videoN in user space, for programs that `camrig exec` runs"}),
            .key = "number",
            .is_key_of_rig = true};
}

}  // namespace camrig::device
