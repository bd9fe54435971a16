#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/field_of.h"

// A camera of tomorrow: an object that may be null, with a preset, a choice, bounded numbers and an object in it.
namespace camrig::field_tests {

using nlohmann::json;
using testing::HasSubstr;

enum class Head { dome, cheap };

struct Limits {
    double low_deg = -90;
    double high_deg = 90;
};
struct Ptz {
    Head preset = Head::dome;
    double speed_deg_s = 100;
    Limits tilt;
};
struct Camera {
    std::optional<Ptz> ptz;
    std::optional<double> exposure_s;  ///< nullopt: automatic
    std::string group;
    int bits = 8;
    bool is_on = true;
};

std::span<const Named<Head>> names_of(std::type_identity<Head>) {
    static constexpr Named<Head> names[] = {{Head::dome, "dome"}, {Head::cheap, "cheap"}};
    return names;
}

FieldTable<Limits> fields_of(std::type_identity<Limits>) {
    static const std::vector<FieldOf<Limits>> table{
        field_at<&Limits::low_deg>({.name = "low_deg", .unit = "deg", .range = {-90, 90}}),
        field_at<&Limits::high_deg>({.name = "high_deg", .unit = "deg", .range = {-90, 90}})};
    return table;
}

FieldTable<Ptz> fields_of(std::type_identity<Ptz>) {
    static const std::vector<FieldOf<Ptz>> table = [] {
        // A preset sets all; what is given beside it comes after it in the table, and so wins.
        auto preset = field_at<&Ptz::preset>({.name = "preset"});
        preset.read = [field = preset.field](JsonReader& reader, Changes<Ptz>& changes) {
            if (const auto head = read_value<Head>(reader, field))
                changes.change([head = *head](Ptz& ptz) { ptz = {head, head == Head::cheap ? 20.0 : 100.0, {}}; });
        };
        return std::vector<FieldOf<Ptz>>{
            std::move(preset),
            field_at<&Ptz::speed_deg_s>({.name = "speed_deg_s",
                                         .doc = "at most",
                                         .unit = "deg/s",
                                         .range = {.low = 0, .high = 500, .is_low_out = true}}),
            field_at<&Ptz::tilt>({.name = "tilt"})};
    }();
    return table;
}

namespace {

const std::vector<FieldOf<Camera>>& camera_table() {
    static const std::vector<FieldOf<Camera>> table{
        field_at<&Camera::ptz>({.name = "ptz", .null = "it stands still"}),
        field_at<&Camera::exposure_s>({.name = "exposure_s", .unit = "s", .range = {1e-6, 10}, .word = "auto"}),
        field_at<&Camera::group>({.name = "group", .range = {.high = 4}}),
        field_at<&Camera::bits>({.name = "bits", .range = {8, 16}}), field_at<&Camera::is_on>({.name = "is_on"})};
    return table;
}

Result<Camera> changed(Camera camera, const char* text) {
    const json value = json::parse(text);
    JsonReader reader(value, "cameras[0]");
    Changes<Camera> changes;
    read_fields(camera_table(), reader, changes);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    changes.apply_to(camera);
    return camera;
}

const Field& described(const char* name) {
    for (const auto& each : camera_table())
        if (each.field.name == name) return each.field;
    ADD_FAILURE() << name;
    return camera_table().front().field;
}

TEST(FieldTable, WhatIsWrittenIsReadBack) {
    const Camera camera = changed({}, R"({"ptz": {"preset": "cheap", "tilt": {"low_deg": -30}}, "exposure_s": 0.01,
        "group": "left", "bits": 12, "is_on": false})")
                              .value();
    const json written = write_fields(camera_table(), camera);
    EXPECT_EQ(written, json::parse(R"({"ptz": {"preset": "cheap", "speed_deg_s": 20, "tilt": {"low_deg": -30,
        "high_deg": 90}}, "exposure_s": 0.01, "group": "left", "bits": 12, "is_on": false})"));
    EXPECT_EQ(write_fields(camera_table(), changed({}, written.dump().c_str()).value()), written);
}

TEST(FieldTable, AnObjectThatMayBeNullIsMadeChangedAndTakenAway) {
    const Camera made = changed({}, R"({"ptz": {}})").value();
    ASSERT_TRUE(made.ptz);
    EXPECT_EQ(made.ptz->speed_deg_s, 100);
    const Camera faster = changed(made, R"({"ptz": {"speed_deg_s": 200}})").value();
    EXPECT_EQ(faster.ptz->speed_deg_s, 200);
    EXPECT_EQ(changed(faster, R"({"ptz": {"tilt": {"high_deg": 0}}})")->ptz->speed_deg_s, 200)
        << "what is not given stays";
    EXPECT_FALSE(changed(faster, R"({"ptz": null})")->ptz);
    EXPECT_EQ(write_fields(camera_table(), Camera{})["ptz"], nullptr);
}

TEST(FieldTable, AWordStandsForAValueThatNobodyGave) {
    const Camera manual = changed({}, R"({"exposure_s": 0.02})").value();
    EXPECT_EQ(manual.exposure_s, 0.02);
    EXPECT_EQ(write_fields(camera_table(), manual)["exposure_s"], 0.02);
    const Camera automatic = changed(manual, R"({"exposure_s": "auto"})").value();
    EXPECT_EQ(automatic.exposure_s, std::nullopt);
    EXPECT_EQ(write_fields(camera_table(), automatic)["exposure_s"], "auto");
    EXPECT_TRUE(check_fields(camera_table(), automatic));
}

TEST(FieldTable, APresetComesBeforeWhatIsGivenBesideIt) {
    EXPECT_EQ(changed({}, R"({"ptz": {"speed_deg_s": 50, "preset": "cheap"}})")->ptz->speed_deg_s, 50);
    EXPECT_EQ(changed({}, R"({"ptz": {"preset": "cheap"}})")->ptz->speed_deg_s, 20);
}

TEST(FieldTable, WrongValuesAreErrorsThatSayWhere) {
    const std::pair<const char*, const char*> cases[] = {
        {R"({"ptz": {"speed_deg_s": 0}})", "cameras[0].ptz.speed_deg_s: must be over 0 and at most 500 deg/s"},
        {R"({"ptz": {"tilt": {"low_deg": -91}}})", "cameras[0].ptz.tilt.low_deg: must be -90 to 90 deg"},
        {R"({"ptz": {"preset": "best"}})", "cameras[0].ptz.preset: 'best' is none of dome, cheap"},
        {R"({"ptz": {"speed": 1}})", "cameras[0].ptz.speed: unknown key; known here: preset, speed_deg_s, tilt"},
        {R"({"ptz": 1})", "cameras[0].ptz: expected an object"},
        {R"({"exposure_s": "manual"})", "cameras[0].exposure_s: expected a number, got string"},
        {R"({"exposure_s": 11})", "cameras[0].exposure_s: must be 1e-6 to 10 s"},
        {R"({"exposure_s": null})", "cameras[0].exposure_s: expected a number, got null"},
        {R"({"group": "right"})", "cameras[0].group: must have at most 4 characters"},
        {R"({"group": "a\u001b["})", "cameras[0].group: must have no control characters"},
        {R"({"bits": 8.5})", "cameras[0].bits: expected an integer"},
        {R"({"bits": null})", "cameras[0].bits: expected an integer"},
        {R"({"is_on": 1})", "cameras[0].is_on: expected true or false"}};
    for (const auto& [text, expected] : cases) {
        const auto camera = changed({}, text);
        ASSERT_FALSE(camera) << text;
        EXPECT_THAT(camera.error().message, HasSubstr(expected)) << text;
    }
    EXPECT_TRUE(changed({}, "{\"group\": \"\u00e4\u00f6\u00fc\u00df\"}")) << "characters, not bytes";
}

TEST(FieldTable, RangesHoldForValuesThatCameNotThroughJson) {
    Camera camera;
    camera.ptz.emplace().tilt.low_deg = -100;
    EXPECT_EQ(check_fields(camera_table(), camera).error().message, "ptz.tilt.low_deg: must be -90 to 90 deg");
    camera.ptz.reset();
    camera.bits = 17;
    EXPECT_EQ(check_fields(camera_table(), camera).error().message, "bits: must be 8 to 16");
    camera.bits = 16;
    EXPECT_TRUE(check_fields(camera_table(), camera));
}

TEST(FieldTable, TypeChoicesPartsAndDefaultFollowFromTheMember) {
    EXPECT_EQ(described("ptz").type, "object or null");
    EXPECT_EQ(described("ptz").fallback, "null");
    EXPECT_EQ(described("ptz").parts.at(0).choices, (std::vector<std::string>{"dome", "cheap"}));
    EXPECT_EQ(described("ptz").parts.at(0).fallback, "dome");
    EXPECT_EQ(described("exposure_s").type, "number or \"auto\"");
    EXPECT_EQ(described("exposure_s").fallback, "auto");
    EXPECT_EQ(described("group").type, "string");
    EXPECT_EQ(described("bits").type + " " + described("bits").fallback, "integer 8");
    EXPECT_EQ(described("is_on").fallback, "true");
}

TEST(Field, TellsItsRangeInWords) {
    EXPECT_EQ((Range{1, 10}.words()), "1 to 10");
    EXPECT_EQ((Range{.low = 0, .high = 1e6, .is_low_out = true}.words()), "over 0 and at most 1e6");
    EXPECT_EQ((Range{.low = 0}.words()), "at least 0");
    EXPECT_EQ((Range{.high = 5, .is_high_out = true}.words()), "below 5");
    EXPECT_EQ(Range{}.words(), "");
    EXPECT_FALSE((Range{0, 1}.contains(std::nan(""))));
}

}  // namespace
}  // namespace camrig::field_tests
