#include <array>
#include <cmath>

#include "core/world/backdrop/backdrop_spec.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

auto at_px_of_detail() {
    constexpr const char* schema =
        R"({"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 2, "maxItems": 2})";
    auto entry = entry_by<&PanoramaDetail::at_px>(
        {.name = "at_px",
         .type = "[x, y]",
         .doc = "its upper left pixel in that larger panorama",
         .required = true,
         .unit = "px",
         .schema = schema},
        [](JsonReader& reader, std::string_view key, glm::ivec2& out) {
            std::array<double, 2> given{};
            reader.required(key, std::span<double>(given));
            for (int i = 0; i < 2; ++i) {
                const double number = given[static_cast<std::size_t>(i)];
                if (reader.ok(key) && !(number >= 0.0 && number < 1e6 && number == std::floor(number)))
                    reader.fail(key, "must be whole numbers from 0 to 999999");
                else
                    out[i] = static_cast<int>(number);
            }
        });
    entry.write = [](const PanoramaDetail& detail) { return nlohmann::json{detail.at_px.x, detail.at_px.y}; };
    return entry;
}

}  // namespace

FieldTable<PanoramaDetail> fields_of(std::type_identity<PanoramaDetail>) {
    static const std::vector<FieldOf<PanoramaDetail>> table{
        field_at<&PanoramaDetail::file>(
            {.name = "file",
             .doc = "PNG or JPEG, beside `file` of the panorama; what is not wholly opaque is left out",
             .required = true}),
        field_at<&PanoramaDetail::scale>({.name = "scale",
                                          .doc = "2, 4, 8, 16, 32 or 64: its pixels are those of a panorama with so "
                                                 "many times the columns, 524288 of them at most",
                                          .required = true,
                                          .range = {2, 64},
                                          .schema = R"({"enum": [2, 4, 8, 16, 32, 64]})"}),
        at_px_of_detail()};
    return table;
}

}  // namespace camrig::world
