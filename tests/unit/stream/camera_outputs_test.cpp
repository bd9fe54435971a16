#include "core/stream/camera_outputs.h"

#include <gtest/gtest.h>

#include "core/base/output_family.h"

namespace camrig::stream {
namespace {

struct Lamp {
    int pin = 0;
    std::string color = "red";
};
FieldTable<Lamp> fields_of(std::type_identity<Lamp>) {
    static const std::vector<FieldOf<Lamp>> table{field_at<&Lamp::pin>({.name = "pin", .required = true}),
                                                  field_at<&Lamp::color>({.name = "color"})};
    return table;
}

class CameraOutputsTest : public testing::Test {
protected:
    CameraOutputsTest() {
        set_output_families({{.kind = output_kind<Lamp>({.name = "lamp", .doc = "shines"}), .key = "pin"}});
    }
    ~CameraOutputsTest() override { set_output_families({}); }

    static OutputSpec lamp(int pin, const std::string& color = "red") {
        return {.kind = "lamp", .options = {{"pin", pin}, {"color", color}}};
    }
    static CameraStream camera(const std::string& name, std::vector<OutputSpec> outputs) {
        return {CameraId{1}, name, {64, 48}, {}, std::move(outputs)};
    }
    using Outputs = std::vector<OutputSpec>;
    CameraOutputs outputs{"lamp"};
};

TEST_F(CameraOutputsTest, AChangeOfACameraSaysWhatBeganEndedAndStayed) {
    auto change = outputs.update(camera("lobby", {lamp(1), lamp(2), lamp(3), {.kind = "other"}}), true);
    EXPECT_EQ(change.added, (Outputs{lamp(1), lamp(2), lamp(3)}));
    change = outputs.update(camera("lobby", {lamp(2, "green"), lamp(3), lamp(4)}), true);
    EXPECT_EQ(change.gone, Outputs{lamp(1)});
    EXPECT_EQ(change.changed, Outputs{lamp(2, "green")});
    EXPECT_EQ(change.kept, Outputs{lamp(3)});
    EXPECT_EQ(change.added, Outputs{lamp(4)});
}

TEST_F(CameraOutputsTest, AnOptionLeftOutIsItsDefault) {
    const OutputSpec bare{.kind = "lamp", .options = {{"pin", 1}}};
    outputs.update(camera("lobby", {bare}), true);
    EXPECT_EQ(outputs.update(camera("lobby", {lamp(1)}), true).kept, Outputs{lamp(1)});
    EXPECT_EQ(outputs.update(camera("lobby", {lamp(1, "green")}), true).changed, Outputs{lamp(1, "green")});
    EXPECT_EQ(outputs.update(camera("lobby", {bare}), true).changed, Outputs{bare});
}

TEST_F(CameraOutputsTest, ACameraThatGoesEndsItsOutputsAndNoOthers) {
    outputs.update(camera("lobby", {lamp(1)}), true);
    outputs.update(camera("gate", {lamp(2)}), true);
    const auto change = outputs.update(camera("lobby", {lamp(1)}), false);
    EXPECT_EQ(change.gone, Outputs{lamp(1)});
    EXPECT_TRUE(change.added.empty() && change.changed.empty() && change.kept.empty());
    EXPECT_EQ(outputs.update(camera("gate", {lamp(2)}), true).kept, Outputs{lamp(2)});
}

}  // namespace
}  // namespace camrig::stream
