// Any text as a scene file: an error or a scene whose world runs, never a crash.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/json_reader.h"
#include "core/world/scene_reader.h"
#include "core/world/world.h"

namespace {

/// Every file a scene names: a model with one clip, "walk".
camrig::Result<camrig::world::ModelRef> any_model(const std::filesystem::path&) {
    static const camrig::world::ModelRef model = [] {
        auto made = std::make_shared<camrig::world::Model>();
        camrig::world::Animation walk;
        walk.name = "walk";
        walk.duration_ns = camrig::ns_per_s;
        walk.ground_speed_m_s = 1.2;
        made->animations.push_back(walk);
        return made;
    }();
    return model;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace camrig;
    const auto document = parse_json({reinterpret_cast<const char*>(data), size}, world::max_scene_bytes);
    if (!document) return 0;
    auto scene = world::read_scene(*document, "scenes", any_model);
    if (!scene) return 0;
    const auto shared = std::make_shared<const world::Scene>(std::move(*scene));
    auto world = world::World::create(shared, shared->seed);
    if (!world) return 0;
    (*world)->advance_to(shared->step_ns * 3);
    (void)(*world)->snapshot(shared->step_ns * 3 - 1);
    return 0;
}
