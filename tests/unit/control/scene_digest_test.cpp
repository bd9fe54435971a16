#include "control/rpc/scene_digest.h"

#include <cstdlib>
#include <fstream>
#include <optional>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace camrig::control {
namespace {

/// A folder of shipped scenes that the test writes, and another one of its own scenes.
class DigestOfScene : public testing::Test {
protected:
    DigestOfScene() {
        if (const char* const given = std::getenv("CAMRIG_SCENES")) before_ = given;
        ::setenv("CAMRIG_SCENES", (folder_.path() / "shipped").c_str(), 1);
    }
    ~DigestOfScene() override {
        if (before_)
            ::setenv("CAMRIG_SCENES", before_->c_str(), 1);
        else
            ::unsetenv("CAMRIG_SCENES");
    }
    void write(const std::string& name, const std::string& text) {
        std::filesystem::create_directories((folder_.path() / name).parent_path());
        std::ofstream(folder_.path() / name) << text;
    }
    SceneDigest digest(const std::string& name) const { return digest_of_scene(folder_.path() / name).value(); }

private:
    std::optional<std::string> before_;
    const TemporaryFolder folder_;
};

TEST_F(DigestOfScene, IsOfShippedBasesAndModelsToo) {
    write("shipped/hall.json", R"({"models": {"wall": {"file": "hall/wall.glb"}}})");
    write("shipped/hall/wall.glb", "wall");
    write("shipped/people/anna.glb", "anna");
    write("own/scene.json", R"({"base": "camrig:hall", "models": {"anna": {"file": "camrig:people/anna"}}})");
    SceneDigest before = digest("own/scene.json");
    EXPECT_EQ(before.files, 4u);
    for (const char* file : {"shipped/hall.json", "shipped/hall/wall.glb", "shipped/people/anna.glb"}) {
        write(file, file == std::string("shipped/hall.json")
                        ? R"({"models": {"wall": {"file": "hall/wall.glb"}}, "seed": 2})"
                        : "another one");
        const SceneDigest after = digest("own/scene.json");
        EXPECT_NE(after.value, before.value) << file;
        EXPECT_EQ(after.files, 4u);
        before = after;
    }
    write("elsewhere/deeper/scene.json",
          R"({"base": "camrig:hall", "models": {"anna": {"file": "camrig:people/anna"}}})");
    EXPECT_EQ(digest("elsewhere/deeper/scene.json").value, before.value);
}

TEST_F(DigestOfScene, IsOfFilesWhoseUriIsEncoded) {
    write("own/scene.json", R"({"models": {"box": {"file": "box.gltf"}}})");
    write("own/box.gltf", R"({"images": [{"uri": "old%20wood.png"}, {"uri": "100%.png"}]})");
    write("own/old wood.png", "wood");
    const SceneDigest before = digest("own/scene.json");
    EXPECT_EQ(before.files, 3u);
    write("own/old wood.png", "oak");
    EXPECT_NE(digest("own/scene.json").value, before.value);
}

}  // namespace
}  // namespace camrig::control
