// What clients send to the RTSP port before the library reads it: whatever comes, in whatever pieces, the verdict is
// the same, and no message that passes is larger than its bounds.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "rtsp_out/rtsp/mount_path.h"
#include "rtsp_out/rtsp/request_bounds.h"

namespace {

void check(bool good) {
    if (!good) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace camrig;
    if (size < 2) return 0;
    rtsp::RequestLimits limits;
    limits.line_bytes = 64;
    limits.head_bytes = 256;
    limits.header_lines = 6;
    limits.body_bytes = limits.data_bytes = 300;
    rtsp::RequestBounds singly(limits), in_pieces(limits);
    if (data[0] & 1) {
        singly.allow_data();
        in_pieces.allow_data();
    }
    const std::size_t piece = 1 + data[1];
    const std::string_view bytes(reinterpret_cast<const char*>(data) + 2, size - 2);

    bool good = true;
    std::size_t of_message = 0;
    for (std::size_t i = 0; i < bytes.size() && good; ++i) {
        good = singly.take(bytes.substr(i, 1), 1).has_value();
        of_message = singly.message_began_ns() == 0 ? 0 : of_message + 1;
        check(of_message <= limits.head_bytes + limits.body_bytes);
    }
    bool good_in_pieces = true;
    for (std::size_t i = 0; i < bytes.size() && good_in_pieces; i += piece)
        good_in_pieces = in_pieces.take(bytes.substr(i, piece), 1).has_value();
    check(good == good_in_pieces);
    if (good) check(singly.message_began_ns() == in_pieces.message_began_ns());

    const std::string path = rtsp::mount_path_of(bytes);
    check(path.size() <= bytes.size() && path.find("/stream=") == std::string::npos);
    check(path.size() < 2 || path.back() != '/');
    return 0;
}
