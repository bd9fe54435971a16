// Request targets: whatever arrives, parse_target() and what follows it answer or refuse, and what is let through is
// plain: the rest of the server compares and logs it as it is.
#include <cstdint>
#include <string_view>

#include "rtsp_out/http/access.h"
#include "rtsp_out/http/asking_page.h"
#include "rtsp_out/http/route.h"
#include "rtsp_out/http/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace camrig;
    const std::string_view text(reinterpret_cast<const char*>(data), size);

    static_cast<void>(http::is_loopback_host(text));
    static_cast<void>(http::token_of(text, nullptr, text));
    static_cast<void>(http::check_origin({"POST", text, text, {}}, "localhost", false));

    const http::AskingPage page{.host = "localhost", .origin = {}, .referer = text, .sec_fetch_site = {}};
    if (check_page(page)) CHECK(text.starts_with("http://localhost") || text.starts_with("https://localhost"));
    if (http::is_host_field(text)) CHECK(text.find_first_of(" @/\r\n") == std::string_view::npos);
    static_cast<void>(http::check_page_origin(text));

    const auto target = http::parse_target(text);
    if (!target) return 0;
    CHECK(text.size() <= http::max_target_length);
    CHECK(target->query.size() <= http::max_query_parameters);
    for (const char c : target->path) CHECK(c >= 0x20 && c <= 0x7e);
    for (const auto segment : http::segments_of(target->path)) CHECK(segment != ".." && segment != ".");
    if (target->path == "*") return 0;
    CHECK(target->path.front() == '/');

    const auto route = http::route_of(target->path);
    if (!route) return 0;
    const bool of_camera = !route->camera.empty();
    CHECK(of_camera == (route->kind == http::RouteKind::stream || route->kind == http::RouteKind::picture ||
                        route->kind == http::RouteKind::floats || route->kind == http::RouteKind::truth));
    if (const auto params = stream_params(*target)) {
        const int quality = params->quality.value_or(1);
        CHECK(quality >= 1 && quality <= 100);
    }
    if (const auto request = fetch_request(*route, *target)) CHECK(request->min_ns >= 0);
    static_cast<void>(no_params(*target));
    return 0;
}
