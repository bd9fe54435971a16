#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/camera/calibration_file.h"

// Calibrations of real cameras (YAML and JSON of ROS, OpenCV and Kalibr), which are files of strangers. What must hold:
// no crash, bounded work, and what is accepted is a camera that comes back from camrig's own file as it was.
namespace camrig {
namespace {

void require(bool condition) {
    if (!condition) std::abort();
}

void run(std::string_view text) {
    Result<camera::Calibration> read = camera::parse_calibration(text, "fuzz.yaml");
    if (!read) {
        require(!read.error().message.empty());
        return;
    }
    read->camera_name = "camera";
    const Result<std::string> written = write_camera_info(*read);
    if (!written) return;  // a size or a lens that ROS has no name for
    const Result<camera::Calibration> again = camera::parse_calibration(*written, "written.yaml");
    require(again.has_value());
    require(again->size == read->size && again->intrinsics == read->intrinsics);
}

}  // namespace
}  // namespace camrig

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    camrig::run({reinterpret_cast<const char*>(data), size});
    return 0;
}
