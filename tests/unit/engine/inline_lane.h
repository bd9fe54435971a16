#pragma once

#include "core/base/clock.h"
#include "core/engine/rig.h"

namespace camrig::engine {

/// A lane whose tasks are drawn within post(), on the test's thread.
class InlineLane : public DrawLane {
public:
    InlineLane(std::unique_ptr<render::Renderer> renderer, std::shared_ptr<DrawnTasks> drawn)
        : renderer_(std::move(renderer)), drawn_(std::move(drawn)), description_(renderer_->description()) {}

    void post(DrawTask task) override {
        const TimeNs start_ns = monotonic_now_ns();
        task.draw(*renderer_);
        drawn_->put([done = std::move(task.done), spent_ns = monotonic_now_ns() - start_ns] { done(spent_ns); });
    }
    render::RenderCounters counters() const override { return renderer_->counters(); }
    bool makes(frame::PixelFormat format, const render::View& view) const override {
        return renderer_->makes(format, view);
    }
    bool is_plain(const render::View& view) const override { return renderer_->is_plain(view); }
    TimeNs expected_cost_ns(const render::View& view) const override { return renderer_->expected_cost_ns(view); }
    bool wants_second() const override { return renderer_->is_on_cpu(); }
    const std::string& description() const override { return description_; }

private:
    const std::unique_ptr<render::Renderer> renderer_;
    const std::shared_ptr<DrawnTasks> drawn_;
    const std::string description_;
};

/// A rig whose one lane draws on the test's thread.
inline Result<std::unique_ptr<Rig>> make_rig(world::SceneRef scene, const EngineOptions& options,
                                             std::unique_ptr<render::Renderer> renderer, stream::LocalFrameBus& bus) {
    const auto drawn = std::make_shared<DrawnTasks>(max_draw_tasks);
    std::vector<std::unique_ptr<DrawLane>> lanes;
    lanes.push_back(std::make_unique<InlineLane>(std::move(renderer), drawn));
    return Rig::create(std::move(scene), options, std::move(lanes), drawn, bus, [] {});
}

}  // namespace camrig::engine
