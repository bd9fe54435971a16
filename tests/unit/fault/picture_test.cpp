#include "core/fault/picture.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/fault/light.h"
#include "core/fault/mask.h"
#include "tests/unit/fault/faulty.h"

namespace camrig::fault {
namespace {

constexpr ImageSize size{64, 48};

/// Every pixel another colour, and a fine pattern.
std::vector<std::byte> picture() {
    std::vector<std::byte> rgba;
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const int fine = 15 * ((x / 2 + y / 2) % 2);
            for (const int value : {40 + 3 * x + fine, 50 + 4 * y + fine, 120 + x + y + fine, 255})
                rgba.push_back(std::byte(value));
        }
    return rgba;
}

std::vector<std::byte> changed(const FaultKind& kind, double severity, std::int64_t sequence = 10) {
    auto rgba = picture();
    change_picture(at_frame(fault_of(kind, severity), sequence), size, rgba);
    return rgba;
}

double difference(const std::vector<std::byte>& a, const std::vector<std::byte>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(std::to_integer<int>(a[i]) - std::to_integer<int>(b[i]));
    return sum;
}

std::vector<FaultKind> picture_kinds() {
    std::vector<FaultKind> kinds;
    for (const auto& kind : fault_kinds()) {
        const nlohmann::json none = nlohmann::json::object();
        JsonReader reader(none, "");
        FaultKind made = kind.read(reader);
        const bool needs_two = std::holds_alternative<Tearing>(made);  // of which one is not here
        if (!needs_two && changes_picture(at_frame(fault_of(made), 0))) kinds.push_back(std::move(made));
    }
    return kinds;
}

TEST(PictureFaults, EveryKindChangesThePictureMoreAtAHigherSeverity) {
    for (const FaultKind& kind : picture_kinds()) {
        double milder = 0.0;
        for (const double severity : {0.1, 0.25, 0.5, 0.75, 1.0}) {
            const double now = difference(changed(kind, severity), picture());
            EXPECT_GE(now, milder) << name_of(kind) << " " << severity;
            milder = now;
        }
        EXPECT_GT(milder, 0.0) << name_of(kind);
    }
}

TEST(PictureFaults, EveryKindMakesTheSameBytesAgainAndLeavesAlphaAlone) {
    for (const FaultKind& kind : picture_kinds()) {
        const auto once = changed(kind, 0.7, 123);
        EXPECT_EQ(once, changed(kind, 0.7, 123)) << name_of(kind);
        for (std::size_t i = 3; i < once.size(); i += 4) ASSERT_EQ(once[i], std::byte{255}) << name_of(kind);
    }
}

TEST(Black, AtSeverity1IsBlackAndNeedNotBeDrawn) {
    const auto rgba = changed(Black{}, 1.0);
    for (std::size_t i = 0; i < rgba.size(); ++i) ASSERT_EQ(rgba[i], std::byte(i % 4 == 3 ? 255 : 0));
    EXPECT_TRUE(hides_picture(at_frame(fault_of(Black{}), 0)));
    EXPECT_FALSE(hides_picture(at_frame(fault_of(Black{}, 0.9), 0)));
    EXPECT_EQ(changed(Black{}, 0.5)[0], std::byte{20}) << "half of 40";
}

TEST(Light, CodesComeBackFromTheirLightAndRiseWithIt) {
    for (int i = 0; i < 256; ++i) {
        EXPECT_EQ(coded(light_of(i)), i);
        EXPECT_TRUE(i == 0 || light_of(i) > light_of(i - 1));
    }
    EXPECT_NEAR(light_of(188), 0.5, 0.003) << "IEC 61966-2-1";
    EXPECT_EQ(coded(7.0), 255);
    EXPECT_EQ(coded(-1.0), 0);
}

TEST(Defocus, KeepsLightAndAFlatPictureAndSpreadsADotAsADiscDoes) {
    constexpr ImageSize square{101, 101};
    std::vector<std::byte> rgba(4 * 101 * 101, std::byte{0});
    for (int c = 0; c < 3; ++c) rgba[static_cast<std::size_t>(4 * (50 * 101 + 50) + c)] = std::byte{255};
    blur(rgba, square, 4.0);
    double light = 0.0, variance = 0.0;
    for (int y = 0; y < 101; ++y)
        for (int x = 0; x < 101; ++x) {
            const double here = light_of(std::to_integer<int>(rgba[static_cast<std::size_t>(4 * (y * 101 + x))]));
            light += here;
            variance += here * (x - 50) * (x - 50);
        }
    EXPECT_NEAR(light, 1.0, 0.1);
    EXPECT_NEAR(variance / light, 4.0 * 4.0 / 4.0, 0.4);
    std::vector<std::byte> flat(4 * 101 * 101, std::byte{97});
    const auto before = flat;
    blur(flat, square, 10.0);
    EXPECT_EQ(flat, before);
}

TEST(Dirt, CoversTheShareOfThePictureThatWasAskedForAndOnlyGrows) {
    constexpr ImageSize hd{1920, 1080};
    std::vector<float> less(1920, 0.0f), row(1920);
    for (const double coverage : {0.05, 0.2, 0.5, 0.8}) {
        const Mask mask = Mask::dirt(*fault_of(Dirt{}), hd, coverage, 0.1);
        EXPECT_NEAR(mask.covered(), coverage, 0.01);
        mask.row(333, row);
        for (std::size_t x = 0; x < row.size(); ++x) ASSERT_GE(row[x], less[x] - 1e-6f);
        less = row;
    }
    EXPECT_EQ(Mask::dirt(*fault_of(Dirt{}), hd, 0.0, 0.1).covered(), 0.0);
    EXPECT_EQ(Mask::dirt(*fault_of(Dirt{}), hd, 1.0, 0.1).covered(), 1.0);
}

TEST(WaterDrops, AreWhereTheMaskSaysAndShowTheSceneUpsideDown) {
    const FrameFaults faults = at_frame(fault_of(WaterDrops{.count = 3, .size = 0.4}), 10);
    const auto before = picture(), after = changed(WaterDrops{.count = 3, .size = 0.4}, 1.0);
    const auto mask = hidden_mask(&faults, size);
    std::int64_t hidden = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        hidden += mask[i] == 255;
        ASSERT_TRUE(mask[i] == 0 || mask[i] == 255);
        if (mask[i] == 0) {
            ASSERT_TRUE(std::equal(&before[4 * i], &before[4 * i] + 4, &after[4 * i])) << i;
        }
    }
    EXPECT_GT(hidden, size.pixels() / 20);
    EXPECT_DOUBLE_EQ(covered_fraction(faults, size), static_cast<double>(hidden) / static_cast<double>(size.pixels()));
    // Green rises downwards in the picture: in a drop it falls.
    const WaterDrop drop = drops_of(*faults.active[0], size)[0];
    const auto green = [&](double dy) {
        const auto x = static_cast<std::size_t>(drop.x), y = static_cast<std::size_t>(drop.y + dy);
        return std::to_integer<int>(after[4 * (y * static_cast<std::size_t>(size.width) + x) + 1]);
    };
    const double near = 0.3 * drop.radius;
    if (drop.y - near >= 0 && drop.y + near < size.height) {
        EXPECT_GE(green(-near), green(near));
    }
}

TEST(Masks, SayWhatTheCompositeIsMadeOf) {
    // picture = scene * (1 - alpha) + veil * alpha in linear light, within a code.
    const FrameFaults faults = at_frame(fault_of(Dirt{.red = 0.5, .green = 0.5, .blue = 0.5}, 0.8), 10);
    const auto before = picture(), after = changed(Dirt{.red = 0.5, .green = 0.5, .blue = 0.5}, 0.8);
    const auto mask = hidden_mask(&faults, size);
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const double alpha = mask[i] / 255.0;
        const int expected = coded((1.0 - alpha) * light_of(std::to_integer<int>(before[4 * i + 1])) + alpha * 0.5);
        ASSERT_NEAR(std::to_integer<int>(after[4 * i + 1]), expected, 2) << i;
    }
    EXPECT_EQ(std::ranges::count(hidden_mask(nullptr, size), 0), size.pixels());
}

TEST(Condensation, BlursAndGreysAllOfThePicture) {
    const auto after = changed(Condensation{}, 1.0);
    int low = 255, high = 0;
    for (std::size_t i = 1; i < after.size(); i += 4) {
        low = std::min(low, std::to_integer<int>(after[i]));
        high = std::max(high, std::to_integer<int>(after[i]));
    }
    EXPECT_LT(high - low, 120);
    const FrameFaults faults = at_frame(fault_of(Condensation{.veil = 0.6}), 1);
    EXPECT_EQ(hidden_mask(&faults, size)[0], 153);
}

TEST(ChromaLost, AtSeverity1IsGrey) {
    const auto grey = changed(ChromaLost{}, 1.0);
    for (std::size_t i = 0; i < grey.size(); i += 4) ASSERT_TRUE(grey[i] == grey[i + 1] && grey[i] == grey[i + 2]);
}

TEST(Tearing, TakesItsShareOfTheRowsFromBelow) {
    EXPECT_EQ(torn_rows(at_frame(fault_of(Tearing{.share = 0.5}), 1), 480), 240);
    EXPECT_EQ(torn_rows(at_frame(fault_of(Tearing{.share = 0.5}, 0.5), 1), 480), 120);
    EXPECT_EQ(torn_rows(at_frame(fault_of(Black{}), 1), 480), 0);
}

TEST(Covered, AtSeverity1NothingOfTheSceneIsLeft) {
    const auto rgba = changed(Covered{}, 1.0);
    for (std::size_t i = 4; i < rgba.size(); ++i) ASSERT_EQ(rgba[i], rgba[i - 4]);
    const auto half = changed(Covered{.softness = 0.0}, 0.5), whole = picture();
    EXPECT_EQ(half[half.size() - 2], whole[whole.size() - 2]) << "the lower edge is free";
    EXPECT_NE(half[0], whole[0]);
}

TEST(Exposure, MultipliesLight) {
    const auto rgba = changed(Exposure{.factor = 2.0}, 1.0);
    for (std::size_t i : {0, 1, 2, 400}) {
        const double before = light_of(std::to_integer<int>(picture()[i]));
        EXPECT_NEAR(light_of(std::to_integer<int>(rgba[i])), std::min(1.0, 2.0 * before), 0.005);
    }
}

TEST(WhiteBalance, ChangesRedAndBlueAndLeavesGreen) {
    const auto rgba = changed(WhiteBalance{.red = 1.5, .blue = 0.5}, 1.0), before = picture();
    for (std::size_t i = 0; i < 400; i += 4) {
        EXPECT_GT(rgba[i], before[i]);
        EXPECT_EQ(rgba[i + 1], before[i + 1]);
        EXPECT_LT(rgba[i + 2], before[i + 2]);
    }
}

TEST(Noise, HasTheDeviationThatWasAskedForAndIsAnotherInEveryFrame) {
    constexpr ImageSize large{200, 200};
    std::vector<std::byte> rgba(4 * 200 * 200, std::byte{128});
    change_picture(at_frame(fault_of(Noise{.deviation = 0.1}, 0.5), 9), large, rgba);
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (std::size_t i = 0; i < rgba.size(); ++i) {
        if (i % 4 == 3) continue;
        const double off = std::to_integer<int>(rgba[i]) - 128.0;
        sum += off;
        squares += off * off;
        ++count;
    }
    EXPECT_NEAR(sum / count, 0.0, 0.1);
    EXPECT_NEAR(std::sqrt(squares / count), 0.05 * 255, 0.15);
    EXPECT_NE(changed(Noise{}, 1.0, 1), changed(Noise{}, 1.0, 2));
}

TEST(DeadPixels, AreAsManyAsWereAskedForAndStayWhereTheyAre) {
    const auto rgba = changed(DeadPixels{.share = 0.1}, 1.0, 1);
    EXPECT_EQ(rgba, changed(DeadPixels{.share = 0.1}, 1.0, 500));
    int dead = 0;
    for (std::size_t i = 0; i < rgba.size(); i += 4) dead += rgba[i] == rgba[i + 1] && rgba[i] == rgba[i + 2];
    EXPECT_NEAR(dead, 0.1 * size.pixels(), 3.0 * std::sqrt(0.09 * size.pixels()));
}

TEST(DeadPixels, AreOthersOfEachFault) {
    const auto dead_of = [](std::uint64_t id) {
        Fault fault = *fault_of(DeadPixels{.share = 0.1}, 1.0);
        fault.id = id;
        auto rgba = picture();
        change_picture(at_frame(std::make_shared<const Fault>(fault), 1), size, rgba);
        std::vector<bool> dead;
        for (std::size_t i = 0; i < rgba.size(); i += 4)
            dead.push_back(rgba[i] == rgba[i + 1] && rgba[i] == rgba[i + 2]);
        return dead;
    };
    const auto one = dead_of(1), other = dead_of(2);
    double both = 0;
    for (std::size_t i = 0; i < one.size(); ++i) both += one[i] && other[i];
    EXPECT_NEAR(both, 0.01 * size.pixels(), 3.0 * std::sqrt(0.01 * size.pixels()));
}

TEST(DeadRows, AreWholeRowsOrColumns) {
    for (const bool columns : {false, true}) {
        const auto rgba = changed(DeadRows{.share = 0.3, .columns = columns}, 1.0), before = picture();
        const int lines = columns ? size.width : size.height, across = columns ? size.height : size.width;
        int dead = 0;
        for (int line = 0; line < lines; ++line) {
            int differ = 0;
            for (int i = 0; i < across; ++i) {
                const int x = columns ? line : i, y = columns ? i : line;
                const auto at = static_cast<std::size_t>(4 * (y * size.width + x));
                differ += !std::equal(&rgba[at], &rgba[at] + 4, &before[at]);
            }
            EXPECT_TRUE(differ == 0 || differ == across) << line;
            dead += differ > 0;
        }
        EXPECT_GT(dead, lines / 8);
        EXPECT_LT(dead, lines / 2);
    }
}

TEST(MirroredAndUpsideDown, ShowEachPixelSomewhereElse) {
    const auto before = picture(), mirrored = changed(Mirrored{}, 0.1), turned = changed(UpsideDown{}, 1.0);
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const auto at = [](int px, int py) { return static_cast<std::size_t>(4 * (py * size.width + px)); };
            ASSERT_EQ(mirrored[at(x, y)], before[at(size.width - 1 - x, y)]);
            ASSERT_EQ(turned[at(x, y) + 1], before[at(size.width - 1 - x, size.height - 1 - y) + 1]);
        }
}

TEST(Banding, DarkensRowsAndMovesWithTime) {
    const auto rgba = changed(Banding{}, 1.0, 0), before = picture();
    bool is_dark = false, is_bright = false;
    for (int y = 0; y < size.height; ++y) {
        const auto at = static_cast<std::size_t>(4 * y * size.width);
        EXPECT_LE(rgba[at], before[at]);
        is_dark |= std::to_integer<int>(rgba[at]) < std::to_integer<int>(before[at]) - 8;
        is_bright |= std::to_integer<int>(rgba[at]) >= std::to_integer<int>(before[at]) - 2;
    }
    EXPECT_TRUE(is_dark && is_bright);
    EXPECT_NE(rgba, changed(Banding{}, 1.0, 20));
}

}  // namespace
}  // namespace camrig::fault
