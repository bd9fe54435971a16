// Bodies of MJPEG streams as `camrig probe` takes them apart: whatever a server sends, in pieces of any size, gives
// parts within the limits or an error, and the pieces do not change what comes out.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "tools/probe/multipart_reader.h"

namespace camrig {
namespace {

void require(bool condition) {
    if (!condition) std::abort();
}

/// The bytes of all parts, until there are no more or the stream breaks.
std::vector<std::string> parts_of(std::string_view body, std::size_t piece) {
    auto reader = probe::MultipartReader::create("multipart/x-mixed-replace; boundary=frame");
    require(reader.has_value());
    std::vector<std::string> parts;
    while (!body.empty()) {
        reader->feed(body.substr(0, piece));
        body.remove_prefix(std::min(piece, body.size()));
        for (;;) {
            auto part = reader->next();
            if (!part) return parts;
            if (!*part) break;
            require((*part)->bytes.size() <= probe::MultipartReader::max_part_bytes);
            static_cast<void>((*part)->number("x-sequence"));
            parts.push_back(std::move((*part)->bytes));
        }
    }
    return parts;
}

}  // namespace
}  // namespace camrig

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace camrig;
    // The first byte says how large the pieces are, the rest is the body; and the same text as a Content-Type.
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    static_cast<void>(probe::MultipartReader::create(text));
    if (text.empty() || size > probe::MultipartReader::max_head_bytes) return 0;
    const std::string_view body = text.substr(1);
    const auto whole = parts_of(body, body.size());
    const auto pieces = parts_of(body, data[0] % 64 + 1U);
    require(whole == pieces);
    return 0;
}
