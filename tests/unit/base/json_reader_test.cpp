#include "core/base/json_reader.h"

#include <gtest/gtest.h>

#include "core/base/error_list.h"

namespace camrig {
namespace {

TEST(ParseJson, ALongArrayOfObjectsTakesLinearTime) {
    // With a parser callback this took minutes.
    std::string text = "[";
    for (int i = 0; i < 300000; ++i) text += "{},";
    text += "{}]";
    EXPECT_EQ(parse_json(text, text.size()).value().size(), 300001u);
}

TEST(ParseJson, AnErrorDoesNotTellWhatSomebodysFileSays) {
    for (const char* const text :
         {"\"top secret of somebody", "[1, 2, \"top secret of somebody\n", "{\"a\": top secret}"}) {
        const auto read = parse_json(text, 1000);
        ASSERT_FALSE(read.has_value()) << text;
        EXPECT_EQ(read.error().message.find("secret"), std::string::npos) << read.error().message;
        EXPECT_NE(read.error().message.find("parse error at line"), std::string::npos) << read.error().message;
    }
}

TEST(ParseJson, AnErrorTellsWhatWasReadAndWhatWouldBeRight) {
    const std::string said = parse_json("{\"a\" to}", 1000).error().message;
    EXPECT_NE(said.find("last read: '\"a\" to'; expected ':'"), std::string::npos) << said;
    const std::string longer = parse_json("{\"a long name of something\" to}", 1000).error().message;
    EXPECT_NE(longer.find("last read: a long text; expected ':'"), std::string::npos) << longer;
}

TEST(JsonReader, ErrorsCarryThePathOfThePlace) {
    const auto json = parse_json(R"({"near": "a"})", 1000).value();
    JsonReader reader(json, "cameras[2]");
    double near = 1;
    reader.optional("near", near);
    const auto done = reader.finish();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message, "cameras[2].near: expected a number, got string");
}

TEST(JsonReader, UnknownKeysAreErrorsThatNameTheKnownOnes) {
    const auto json = parse_json(R"({"name": "a", "colour": 1})", 1000).value();
    JsonReader reader(json, "");
    std::string name;
    reader.required("name", name);
    bool lit = false;
    reader.optional("lit", lit);
    const auto done = reader.finish();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message, "colour: unknown key; known here: lit, name");
}

TEST(JsonReader, WithAListEveryErrorIsToldOnce) {
    const auto json = parse_json(R"({"a": 1, "b": "x", "in": {"c": []}, "z": 0, "zz": 0})", 1000).value();
    ErrorList list;
    JsonReader reader(json, "top");
    std::string a;
    double b = 0.0, d = 0.0;
    reader.required("a", a);
    reader.required("a", a);
    reader.required("b", b);
    reader.required("d", d);
    JsonReader nested(*reader.find("in"), "top.in");
    nested.required("c", b);
    reader.fail(nested.finish().error());
    EXPECT_EQ(reader.finish().error().message, "top.a: expected a string, got number");
    std::vector<std::string> paths;
    for (const PlacedError& each : list.all()) paths.push_back(each.path);
    EXPECT_EQ(paths, (std::vector<std::string>{"top.a", "top.b", "top.d", "top.in.c", "top.z", "top.zz"}));
}

TEST(JsonReader, TheFirstErrorWinsAndTheRestDoesNothing) {
    const auto json = parse_json(R"({"a": [1, 2], "b": 5})", 1000).value();
    JsonReader reader(json, "x");
    std::array<double, 3> three{};
    reader.required("a", std::span<double>(three));
    std::string b = "untouched";
    reader.required("b", b);
    EXPECT_EQ(b, "untouched");
    EXPECT_EQ(reader.finish().error().message, "x.a: expected an array of 3 numbers");
}

TEST(JsonReader, SomethingElseThanAnObjectIsAnError) {
    const auto json = parse_json("[1]", 1000).value();
    EXPECT_EQ(JsonReader(json, "pose").finish().error().message, "pose: expected an object, got array");
}

TEST(ParseJson, HostileTextIsRefused) {
    EXPECT_EQ(parse_json(std::string(2000, '['), 1000).error().kind, ErrorKind::resource_exhausted);
    EXPECT_NE(parse_json(std::string(100, '[') + std::string(100, ']'), 1000).error().message.find("deeper"),
              std::string::npos);
    EXPECT_NE(parse_json(R"({"a":1,"a":2})", 1000).error().message.find("twice"), std::string::npos);
    for (const char* text : {"", "{", "nul", "{\"a\":NaN}", "1e999", "{} x", "\"\xff\""})
        EXPECT_FALSE(parse_json(text, 1000)) << text;
}

}  // namespace
}  // namespace camrig
