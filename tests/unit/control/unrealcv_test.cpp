#include <set>

#include <gmock/gmock.h>

#include "control/unrealcv/colors.h"
#include "control/unrealcv/command.h"
#include "control/unrealcv/pictures.h"
#include "control/unrealcv/units.h"
#include "control/unrealcv/wire.h"

namespace camrig::unrealcv {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string framed(std::string_view payload) {
    return frame_head(payload.size()) + std::string(payload);
}

TEST(UnrealCvFrames, ComeWholeHoweverTheyAreCut) {
    const std::string stream = framed("0:vget /cameras") + framed("1:vget /objects") + framed("2:a");
    for (std::size_t piece = 1; piece <= stream.size(); ++piece) {
        FrameReader reader;
        std::vector<std::string> payloads;
        for (std::size_t at = 0; at < stream.size(); at += piece) {
            reader.append(std::string_view(stream).substr(at, piece));
            while (auto payload = reader.next()) payloads.push_back(*payload);
        }
        EXPECT_THAT(payloads, ElementsAre("0:vget /cameras", "1:vget /objects", "2:a"));
        EXPECT_EQ(reader.problem(), "");
    }
}

TEST(UnrealCvFrames, AreAsTheClientPacksThem) {
    // struct.pack("I", 0x9E2B83C1) + struct.pack("I", 3)
    EXPECT_EQ(frame_head(3), std::string("\xC1\x83\x2B\x9E\x03\x00\x00\x00", 8));
}

TEST(UnrealCvFrames, ThatCannotBeEndTheStreamAndHoldNoMemory) {
    const auto problem_of = [](const std::string& bytes) {
        FrameReader reader;
        reader.append(framed("0:a") + bytes);
        EXPECT_EQ(reader.next(), "0:a");
        EXPECT_EQ(reader.next(), std::nullopt);
        const std::string problem = reader.problem();
        reader.append(framed("1:b"));
        EXPECT_EQ(reader.next(), std::nullopt);
        return problem;
    };
    EXPECT_THAT(problem_of(std::string(8, 'x')), HasSubstr("magic"));
    EXPECT_THAT(problem_of(frame_head(0)), HasSubstr("empty"));
    EXPECT_THAT(problem_of(frame_head(std::size_t{256} << 20)), HasSubstr("268435456 bytes"));
    EXPECT_THAT(problem_of(frame_head(max_request_bytes + 1)), HasSubstr("at most 1048576"));
    EXPECT_EQ(problem_of(frame_head(max_request_bytes)), "");
}

TEST(UnrealCvRequests, HaveANumberAndACommand) {
    const auto parsed = parse_request("17:vget /camera/0/lit png");
    ASSERT_TRUE(parsed);
    EXPECT_EQ(parsed->id, "17");
    EXPECT_EQ(parsed->command, "vget /camera/0/lit png");
    EXPECT_EQ(parse_request("3:a:b")->command, "a:b");
    for (const char* bad : {"", ":", ":vget", "vget", "-1:vget", "1x:vget", "123456789012345678901:vget", "17"})
        EXPECT_FALSE(parse_request(bad)) << bad;
}

TEST(UnrealCvUnits, MirrorYAndTurnTheOtherWay) {
    EXPECT_EQ(text_of(location_of({1.0, 2.0, -0.000001})), "100.000 -200.000 0.000");
    EXPECT_EQ(metres_of({100.0, -200.0, 5.0}), glm::dvec3(1.0, 2.0, 0.05));
    // FRotationMatrix: a yaw of 90 turns x to y; camrig's y is the other way.
    const glm::dvec3 ahead = orientation_of({0.0, 90.0, 0.0}) * glm::dvec3(1.0, 0.0, 0.0);
    EXPECT_NEAR(glm::distance(ahead, glm::dvec3(0.0, -1.0, 0.0)), 0.0, 1e-15);
    const glm::dvec3 up = orientation_of({30.0, 0.0, 0.0}) * glm::dvec3(1.0, 0.0, 0.0);
    EXPECT_NEAR(up.z, 0.5, 1e-15);
    // A roll of 90 puts what was on the right (UE's y) below.
    const glm::dvec3 right = orientation_of({0.0, 0.0, 90.0}) * glm::dvec3(0.0, -1.0, 0.0);
    EXPECT_NEAR(right.z, -1.0, 1e-15);
}

TEST(UnrealCvUnits, RotationsGoRoundAndAreNormal) {
    for (double pitch = -85.0; pitch <= 85.0; pitch += 17.0)
        for (double yaw = -175.0; yaw <= 180.0; yaw += 35.5)
            for (double roll = -170.0; roll <= 180.0; roll += 50.0)
                EXPECT_LT(glm::distance(rotation_of(orientation_of({pitch, yaw, roll})), {pitch, yaw, roll}), 1e-10);
    EXPECT_EQ(text_of(rotation_of(orientation_of({0.0, 297.7, 360.0}))), "0.000 -62.300 0.000");
    EXPECT_EQ(text_of(rotation_of(orientation_of({0.0, -180.0, 0.0}))), "0.000 180.000 0.000");
}

TEST(UnrealCvUnits, NumbersAreThoseOfUsersPrograms) {
    EXPECT_EQ(number_of("-12.5"), -12.5);
    EXPECT_EQ(number_of("+.5"), 0.5);
    EXPECT_EQ(number_of("1e-05"), 1e-5);
    for (const char* bad : {"", "x", "1x", "nan", "inf", "1 2", "--1", "1e13", "-1e300"})
        EXPECT_FALSE(number_of(bad)) << bad;
    EXPECT_EQ(integer_of("042"), 42);
    for (const char* bad : {"", "-1", "1.0", "99999999999"}) EXPECT_FALSE(integer_of(bad)) << bad;
}

std::vector<std::string_view> arguments_of(std::string_view pattern, std::string_view line) {
    std::vector<std::string_view> arguments;
    if (!matches(pattern, line, arguments)) arguments = {"NO MATCH"};
    return arguments;
}

TEST(UnrealCvTemplates, TakeWhatStandsForTheirPlaceholders) {
    EXPECT_THAT(arguments_of("vset /camera/[uint]/fov [float]", "vset /camera/3/fov 90.0"), ElementsAre("3", "90.0"));
    EXPECT_THAT(arguments_of("vget /object/[str]/color", "vget /object/a.b-c/color"), ElementsAre("a.b-c"));
    EXPECT_THAT(arguments_of("vget /object/[str]/color", "vget /object//color"), ElementsAre(""));
    EXPECT_THAT(arguments_of("vget /camera/[uint]/lit [str]", "vget /camera/0/lit a/b.png"),
                ElementsAre("0", "a/b.png"));
    EXPECT_THAT(arguments_of("vbp [str] [rest]", "vbp cat set_move 1 2"), ElementsAre("cat", "set_move 1 2"));
    for (const auto& [pattern, line] : {std::pair{"vget /cameras", "vget /camerass"},
                                        {"vget /cameras", "vget /camera"},
                                        {"vset /camera/[uint]/fov [float]", "vset /camera/x/fov 90"},
                                        {"vset /camera/[uint]/fov [float]", "vset /camera/0/fov 90 1"},
                                        {"vset /camera/[uint]/fov [float]", "vset /camera/0/fov "},
                                        {"vget /camera/[uint]/lit [str]", "vget /camera/0/lit a b"}})
        EXPECT_THAT(arguments_of(pattern, line), ElementsAre("NO MATCH")) << line;
}

TEST(UnrealCvTemplates, EachIsOfOneCommandAndHasHelp) {
    std::set<std::string_view> patterns;
    for (const Command& one : commands()) {
        EXPECT_TRUE(patterns.insert(one.pattern).second) << one.pattern;
        EXPECT_FALSE(one.help.empty()) << one.pattern;
    }
    EXPECT_TRUE(patterns.contains("vget /unrealcv/commands"));
}

TEST(UnrealCvColors, AreFarEnoughApartAndNeverBlack) {
    constexpr std::uint32_t count = 32 * 32 * 32 - 1;
    std::set<Rgb> all;
    for (std::uint32_t id = 1; id <= count; ++id) {
        const Rgb color = Colors::own_color(ObjectId{id});
        EXPECT_NE(color, Rgb{});
        all.insert(color);
        for (const std::uint8_t level : color) EXPECT_TRUE(level == 0 || level % 8 == 7) << int{level};
    }
    EXPECT_EQ(all.size(), count);
    EXPECT_EQ(Colors::own_color(ObjectId{count + 1}), Colors::own_color(ObjectId{1}));
    EXPECT_EQ(text_of(Colors::own_color(ObjectId{1})), "(R=135,G=0,B=0,A=255)");
}

frame::Frame frame_of(frame::PixelFormat format, ImageSize size, std::span<const std::byte> bytes) {
    frame::FrameInfo info;
    info.format = format;
    info.size = size;
    return {info, {bytes.begin(), bytes.end()}};
}

std::string text_of(const codec::BytesRef& file) {
    return {reinterpret_cast<const char*>(file->data()), file->size()};
}

TEST(UnrealCvPictures, DepthIsInCentimetresAlongTheAxisOrInMetresAlongTheRay) {
    const std::vector<float> metres{1.0f, 2.0f, std::numeric_limits<float>::infinity()};
    const frame::Frame depth = frame_of(frame::PixelFormat::depth32f, {3, 1}, std::as_bytes(std::span(metres)));
    const camera::Intrinsics looks{.fx = 0.75, .fy = 1.0, .cx = 1.0, .cy = 0.0};
    PictureMemory memory;
    const auto values = [&](Depth how) {
        const std::string file = text_of(depth_array(memory, depth, how, looks, {}).value());
        EXPECT_THAT(file, HasSubstr("'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), "));
        EXPECT_EQ((file.size() - 12) % 64, 0u);
        std::vector<float> read(3);
        std::memcpy(read.data(), file.data() + file.size() - 12, 12);
        return read;
    };
    EXPECT_THAT(values(Depth::plane_cm), ElementsAre(100.0f, 200.0f, 65504.0f));
    EXPECT_THAT(values(Depth::plane_m), ElementsAre(1.0f, 2.0f, 65504.0f));
    // One focal length and a third to the left: 5/3 as long as the axis.
    EXPECT_THAT(values(Depth::ray_m), ElementsAre(static_cast<float>(5.0 / 3.0), 2.0f, 65504.0f));
}

TEST(UnrealCvPictures, BitmapsAreNeverText) {
    PictureMemory memory;
    const std::vector<std::byte> black(8, std::byte{0});
    const std::string file =
        text_of(encode_picture(memory, frame_of(frame::PixelFormat::rgba8, {2, 1}, black), FileType::bmp).value());
    // Blue, green, red and alpha 255, which no UTF-8 has.
    EXPECT_EQ(file.substr(54), std::string("\0\0\0\xff\0\0\0\xff", 8));
    EXPECT_EQ(file.size(), 62u);
}

TEST(UnrealCvPictures, OfAnySizeAndAfterAnyOtherHaveEachPixel) {
    PictureMemory memory;
    std::vector<codec::BytesRef> sent;
    for (const int width : {37, 5, 64, 9, 37}) {
        std::vector<std::byte> rgba;
        for (int i = 0; i < 4 * width; ++i) rgba.push_back(static_cast<std::byte>(i * 31 + width));
        const frame::Frame frame = frame_of(frame::PixelFormat::rgba8, {width, 1}, rgba);
        const std::string bmp = text_of(encode_picture(memory, frame, FileType::bmp).value());
        ASSERT_EQ(bmp.size(), 54u + rgba.size());
        for (std::size_t i = 0; i < rgba.size(); i += 4)
            EXPECT_EQ(bmp.substr(54 + i, 4),
                      (std::string{static_cast<char>(rgba[i + 2]), static_cast<char>(rgba[i + 1]),
                                   static_cast<char>(rgba[i]), '\xff'}));
        const std::string npy = text_of(encode_picture(memory, frame, FileType::npy).value());
        EXPECT_EQ(npy.substr(npy.size() - rgba.size()),
                  std::string(reinterpret_cast<const char*>(rgba.data()), rgba.size()));
        const std::string png = text_of(encode_picture(memory, frame, FileType::png).value());
        sent.push_back(encode_picture(memory, frame, FileType::png).value());
        EXPECT_EQ(text_of(sent.back()), png);
    }
    // What is still being sent keeps its bytes.
    EXPECT_EQ(text_of(sent.front()), text_of(sent.back()));
    EXPECT_NE(sent.front(), sent.back());
}

TEST(UnrealCvPictures, OfMasksAreOpaqueAndBlackWhereNothingIs) {
    PictureMemory memory;
    const std::vector<std::uint32_t> ids{0, 1, 1, 2, 0};
    Colors colors;
    colors.set(ObjectId{2}, {9, 8, 7});
    const frame::FrameRef mask =
        mask_of(memory, frame_of(frame::PixelFormat::id32, {5, 1}, std::as_bytes(std::span(ids))), colors);
    std::vector<int> rgba;
    for (const std::byte one : mask->bytes()) rgba.push_back(static_cast<int>(one));
    EXPECT_THAT(rgba, ElementsAre(0, 0, 0, 255, 135, 0, 0, 255, 135, 0, 0, 255, 9, 8, 7, 255, 0, 0, 0, 255));
}

TEST(UnrealCvPictures, NormalsAreOfTheWorldMirrored) {
    const std::vector<float> up_left_nothing{0.0f, -1.0f, 0.0f, -1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    const frame::Frame normals =
        frame_of(frame::PixelFormat::normal32f, {3, 1}, std::as_bytes(std::span(up_left_nothing)));
    // A camera that looks along x: its left is +y, UE's -y.
    const glm::dmat3 turn(glm::dvec3(0.0, -1.0, 0.0), glm::dvec3(0.0, 0.0, -1.0), glm::dvec3(1.0, 0.0, 0.0));
    PictureMemory memory;
    std::vector<int> rgba;
    const frame::FrameRef shown = shown_normals(memory, normals, turn);
    for (const std::byte one : shown->bytes()) rgba.push_back(static_cast<int>(one));
    EXPECT_THAT(rgba, ElementsAre(128, 128, 255, 255, 128, 0, 128, 255, 128, 128, 128, 255));
}

}  // namespace
}  // namespace camrig::unrealcv
