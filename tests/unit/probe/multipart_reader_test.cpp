#include "tools/probe/multipart_reader.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace camrig::probe {
namespace {

MultipartReader reader_of(std::string_view content_type = "multipart/x-mixed-replace; boundary=frame") {
    auto reader = MultipartReader::create(content_type);
    EXPECT_TRUE(reader) << reader.error().message;
    return std::move(*reader);
}

/// All parts of the body, fed in pieces of this size.
std::vector<BodyPart> parts_of(MultipartReader reader, std::string_view body, std::size_t piece) {
    std::vector<BodyPart> parts;
    for (; !body.empty(); body.remove_prefix(std::min(piece, body.size()))) {
        reader.feed(body.substr(0, piece));
        for (auto part = reader.next(); part && *part; part = reader.next()) parts.push_back(std::move(**part));
    }
    return parts;
}

TEST(MultipartReader, PartsComeOutWholeHoweverTheBytesArrive) {
    constexpr std::string_view body =
        "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 5\r\nX-Sequence: 17\r\n\r\nab\r\nc\r\n"
        "--frame\r\nCONTENT-LENGTH: 3\r\n\r\nxyz\r\n--frame\r\n";
    for (std::size_t piece = 1; piece <= body.size(); ++piece) {
        const auto parts = parts_of(reader_of(), body, piece);
        ASSERT_EQ(parts.size(), 2u) << piece;
        EXPECT_EQ(parts[0].bytes, "ab\r\nc");
        EXPECT_EQ(parts[0].number("x-sequence"), 17);
        EXPECT_EQ(parts[0].fields.at("content-type"), "image/jpeg");
        EXPECT_EQ(parts[1].bytes, "xyz");
        EXPECT_FALSE(parts[1].number("x-sequence"));
    }
}

TEST(MultipartReader, WithoutALengthTheNextBoundaryEndsAPart) {
    constexpr std::string_view body = "--frame\r\nA: 1\r\n\r\none\r\n--frame\r\nA: 2\r\n\r\ntwo\r\n--frame\r\n";
    for (const std::size_t piece : {1u, 7u, 100u}) {
        const auto parts = parts_of(reader_of(), body, piece);
        ASSERT_EQ(parts.size(), 2u);
        EXPECT_EQ(parts[0].bytes, "one");
        EXPECT_EQ(parts[1].bytes, "two");
    }
}

TEST(MultipartReader, TheBoundaryMayBeQuotedOrHaveItsDashesInTheHeader) {
    for (const char* type :
         {"multipart/x-mixed-replace;boundary=\"frame\"", "multipart/x-mixed-replace; boundary=--frame",
          "Multipart/X-Mixed-Replace; Boundary=frame; charset=x"})
        EXPECT_EQ(parts_of(reader_of(type), "--frame\r\nContent-Length: 1\r\n\r\nx\r\n", 64).size(), 1u) << type;
}

TEST(MultipartReader, WhatIsNoStreamIsRefused) {
    for (const char* type : {"image/jpeg", "", "multipart/x-mixed-replace", "multipart/mixed; boundary="})
        EXPECT_FALSE(MultipartReader::create(type)) << type;
}

TEST(MultipartReader, AHostileServerCannotFillTheMemory) {
    MultipartReader reader = reader_of();
    reader.feed("--frame\r\nContent-Length: 99999999999\r\n\r\n");
    EXPECT_FALSE(reader.next());
    MultipartReader endless = reader_of();
    endless.feed(std::string(2 * MultipartReader::max_head_bytes, 'x'));
    EXPECT_FALSE(endless.next());
    MultipartReader negative = reader_of();
    negative.feed("--frame\r\nContent-Length: -1\r\n\r\n");
    EXPECT_FALSE(negative.next());
}

}  // namespace
}  // namespace camrig::probe
