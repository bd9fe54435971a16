#include "core/base/output_family.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace camrig {
namespace {

using nlohmann::json;
using testing::HasSubstr;

struct Lamp {
    int pin = 0;
    std::string color = "red";
    std::optional<double> volts = {};
};
FieldTable<Lamp> fields_of(std::type_identity<Lamp>) {
    static const std::vector<FieldOf<Lamp>> table{
        field_at<&Lamp::pin>({.name = "pin", .doc = "of the board", .required = true, .range = {0, 9}}),
        field_at<&Lamp::color>({.name = "color", .choices = {"red", "green"}}),
        field_at<&Lamp::volts>({.name = "volts", .range = {1, 12}}),
    };
    return table;
}

struct Bell {
    std::string tone = "low";
};
FieldTable<Bell> fields_of(std::type_identity<Bell>) {
    static const std::vector<FieldOf<Bell>> table{
        field_at<&Bell::tone>({.name = "tone", .choices = {"low", "high"}}),
    };
    return table;
}

void check_lamp(const Lamp& lamp, JsonReader& reader) {
    if (lamp.color == "green" && reader.has("volts")) reader.fail("volts", "green lamps have none");
}

class OutputFamilies : public testing::Test {
protected:
    OutputFamilies() {
        set_output_families({{.kind = output_kind<Lamp>({.name = "lamp", .doc = "shines"}, check_lamp),
                              .key = "pin",
                              .is_key_of_rig = true,
                              .fits = [](const OutputSpec&, ImageSize size) -> Result<void> {
                                  if (size.width <= 640) return {};
                                  return error(ErrorKind::invalid_argument, "too wide for a lamp");
                              }},
                             {.kind = output_kind<Bell>({.name = "bell", .doc = "rings"}), .key = "tone"}});
    }
    ~OutputFamilies() override { set_output_families({}); }

    static Result<OutputSpec> read(const std::string& text) {
        const json value = json::parse(text);
        JsonReader reader(value, "outputs[0]");
        OutputSpec output = read_output(reader);
        if (auto done = reader.finish(); !done) return std::unexpected(done.error());
        return output;
    }
    static std::string problem_of(const std::string& text) {
        const auto output = read(text);
        return output ? "" : output.error().message;
    }
};

TEST_F(OutputFamilies, AnOutputIsToldAsItWasGivenAndHasTheDefaultsOfTheRest) {
    const auto output = read(R"({"kind": "lamp", "pin": 4})");
    ASSERT_TRUE(output) << output.error().message;
    EXPECT_EQ(output_to_json(*output), json::parse(R"({"kind": "lamp", "pin": 4})"));
    const auto lamp = options_of<Lamp>(*output);
    EXPECT_EQ(lamp.pin, 4);
    EXPECT_EQ(lamp.color, "red");
    EXPECT_FALSE(lamp.volts);
}

TEST_F(OutputFamilies, EachKindHasItsOwnKeysAndErrorsNameThePlace) {
    EXPECT_THAT(problem_of(R"({"kind": "hdmi"})"), HasSubstr("outputs[0].kind: 'hdmi' is none of lamp, bell"));
    EXPECT_THAT(problem_of(R"({"pin": 1})"), HasSubstr("outputs[0].kind: is missing"));
    EXPECT_THAT(problem_of(R"({"kind": "lamp"})"), HasSubstr("outputs[0].pin: is missing"));
    EXPECT_THAT(problem_of(R"({"kind": "lamp", "pin": 10})"), HasSubstr("outputs[0].pin: must be 0 to 9"));
    EXPECT_THAT(problem_of(R"({"kind": "bell", "pin": 1})"), HasSubstr("outputs[0].pin: unknown key"));
    EXPECT_THAT(problem_of(R"({"kind": "lamp", "pin": 1, "color": "green", "volts": 5})"),
                HasSubstr("outputs[0].volts: green lamps have none"));
}

TEST_F(OutputFamilies, TwoOfOneKeyAreTheSameOutputAlsoWhenOneSaysTheDefault) {
    const OutputSpec low = *read(R"({"kind": "bell"})"), same = *read(R"({"kind": "bell", "tone": "low"})"),
                     high = *read(R"({"kind": "bell", "tone": "high"})");
    EXPECT_TRUE(check_outputs({low, high}, {640, 480}));
    const auto twice = check_outputs({low, high, same}, {640, 480});
    ASSERT_FALSE(twice);
    EXPECT_EQ(twice.error().message, "outputs[2]: is the same output as outputs[0]");
    EXPECT_TRUE(
        check_outputs({*read(R"({"kind": "lamp", "pin": 1})"), *read(R"({"kind": "lamp", "pin": 2})")}, {64, 48}));
}

TEST_F(OutputFamilies, AFamilyMaySayWhichCamerasItFits) {
    const OutputSpec lamp = *read(R"({"kind": "lamp", "pin": 1})");
    EXPECT_TRUE(check_outputs({lamp}, {640, 480}));
    EXPECT_EQ(check_outputs({lamp}, {642, 480}).error().message, "outputs[0]: too wide for a lamp");
}

TEST_F(OutputFamilies, NoCameraHasMoreThanItsBound) {
    const std::vector<OutputSpec> many(max_outputs_per_camera + 1, *read(R"({"kind": "bell"})"));
    EXPECT_EQ(check_outputs(many, {640, 480}).error().kind, ErrorKind::resource_exhausted);
}

TEST_F(OutputFamilies, OneListOfFieldsSaysOfWhichKindsEachIs) {
    const std::vector<Field> fields = output_fields();
    ASSERT_EQ(fields.size(), 5u);
    EXPECT_EQ(fields[0].choices, (std::vector<std::string>{"lamp", "bell"}));
    EXPECT_EQ(fields[1].doc, "of lamp: of the board");
    EXPECT_FALSE(fields[1].required);
    EXPECT_EQ(fields[4].doc, "of bell");
}

}  // namespace
}  // namespace camrig
