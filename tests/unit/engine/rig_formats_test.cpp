#include <algorithm>
#include <future>

#include <gtest/gtest.h>

#include "core/base/clock.h"
#include "core/engine/rig.h"
#include "core/frame/convert.h"
#include "core/render/null_renderer.h"
#include "tests/unit/engine/inline_lane.h"
#include "tests/unit/stream/fake_sink.h"

// A renderer that converts colours is asked for what readers take, and for nothing twice.
namespace camrig::engine::rig_formats_test {
namespace {

/// A null renderer that gives planes, but not of pictures with image controls, and notes what it was asked for.
class PlanesRenderer final : public render::Renderer {
public:
    PlanesRenderer(std::shared_ptr<frame::FramePool> pool, std::vector<frame::PixelFormats>& asked)
        : pool_(std::move(pool)), null_(pool_), asked_(asked) {}

    Result<Finished> draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                          std::span<const render::View> views) override {
        for (const render::View& view : views) asked_.push_back(view.color_formats);
        Finished finished = null_.draw(snapshot, monotonic_ns, views).value();
        std::vector<frame::FrameRef> drawn;
        drawn.swap(finished.set.frames);
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            for (const frame::PixelFormat format : frame::color_formats) {
                if (!views[i].color_formats.contains(format)) continue;
                EXPECT_TRUE(makes(format, views[i]));
                finished.set.frames.push_back(converted(*pool_, drawn[i], format, {}).value());
            }
        }
        return finished;
    }
    bool makes(frame::PixelFormat format, const render::View& view) const override {
        const bool is_planes = format == frame::PixelFormat::i420 || format == frame::PixelFormat::jpeg_i420;
        return format == frame::PixelFormat::rgba8 || (is_planes && view.spec->controls.brightness == 0.0);
    }
    void forget(CameraId) override {}
    std::string description() const override { return null_.description(); }

private:
    std::shared_ptr<frame::FramePool> pool_;
    render::NullRenderer null_;
    std::vector<frame::PixelFormats>& asked_;
};

constexpr stream::MediaFormat jpeg{codec::Codec::jpeg, frame::PixelFormat::rgba8, 90, {}};
constexpr stream::MediaFormat png{codec::Codec::png, frame::PixelFormat::rgba8, 0, {}};
constexpr stream::MediaFormat raw(frame::PixelFormat pixels) {
    return {codec::Codec::raw, pixels, 0, {}};
}

class RigFormats : public testing::Test {
protected:
    void SetUp() override {
        auto made = make_rig(std::make_shared<world::Scene>(), {}, std::make_unique<PlanesRenderer>(pool, asked), bus);
        ASSERT_TRUE(made) << made.error().message;
        rig = std::move(*made);
        CreateCamera command{.name = "lobby", .place = {}, .patch = {}};
        command.patch.size = ImageSize{32, 16};
        command.patch.rate = Rate::parse("100").value();
        call(command);
    }
    template <typename C>
    typename C::Reply call(C command) {
        std::optional<Result<typename C::Reply>> reply;
        Command request = Request<C>{std::move(command), [&](auto result) { reply = std::move(result); }};
        rig->apply(request);
        return reply->value();
    }
    std::shared_ptr<stream::FakeSink> subscribe(const stream::MediaFormat& format) {
        auto sink = std::make_shared<stream::FakeSink>();
        subscriptions.push_back(bus.subscribe("lobby", format, {"test", "", {}}, sink, {}).value());
        return sink;
    }
    void next_instant() {
        asked.clear();
        while (asked.empty()) rig->tick(monotonic_now_ns());
        rig->tick(0);  // hears of it
    }
    stream::MediaUnit fetch(const stream::MediaFormat& format) {
        std::promise<Result<stream::MediaUnit>> answer;
        rig->fetch({"lobby", frame::FrameKind::color, 0, format},
                   [&](Result<stream::MediaUnit> unit) { answer.set_value(unit); });
        for (int turn = 0; turn < 2; ++turn) rig->tick(0);  // in which nothing is due: it is drawn, and heard of
        return answer.get_future().get().value();
    }

    std::vector<frame::PixelFormats> asked;
    std::shared_ptr<frame::FramePool> pool = std::make_shared<frame::FramePool>();
    stream::LocalFrameBus bus{{1, pool}};
    std::unique_ptr<Rig> rig;
    std::vector<stream::Subscription> subscriptions;
};

TEST_F(RigFormats, EachReaderGetsItsOwnAndThePictureIsCountedOnce) {
    const auto stream = subscribe(jpeg), planes = subscribe(raw(frame::PixelFormat::i420)),
               packed = subscribe(raw(frame::PixelFormat::yuyv));
    next_instant();
    ASSERT_EQ(asked.size(), 1u);
    EXPECT_EQ(asked[0], (frame::PixelFormats{frame::PixelFormat::jpeg_i420, frame::PixelFormat::i420,
                                             frame::PixelFormat::rgba8}));
    for (const auto& sink : {stream, planes, packed}) {
        ASSERT_TRUE(sink->wait_for_units(1));
        EXPECT_EQ(sink->units().size(), 1u);
    }
    EXPECT_EQ(planes->units()[0].frame->info().format, frame::PixelFormat::i420);
    EXPECT_EQ(packed->units()[0].frame->info().format, frame::PixelFormat::yuyv);
    const stream::CameraReport report = call(GetStats{}).cameras.at(0);
    EXPECT_EQ(report.rendered, 1u);
    EXPECT_EQ(report.due, report.rendered + report.dropped);
}

TEST_F(RigFormats, APictureOnDemandIsMadeOfWhatIsThere) {
    const auto planes = subscribe(raw(frame::PixelFormat::i420));
    next_instant();
    ASSERT_TRUE(planes->wait_for_units(1));
    asked.clear();
    EXPECT_EQ(fetch(raw(frame::PixelFormat::i420)).frame, planes->units()[0].frame);
    EXPECT_TRUE(asked.empty());
    fetch(png);
    EXPECT_EQ(asked, std::vector{frame::PixelFormats{frame::PixelFormat::rgba8}});
    fetch(raw(frame::PixelFormat::yuyv));
    EXPECT_EQ(asked.size(), 1u) << "made of the same";
    // A JPEG is of planes like those of streams.
    fetch(jpeg);
    EXPECT_EQ(asked.back(), frame::PixelFormats{frame::PixelFormat::jpeg_i420});
    fetch(jpeg);
    EXPECT_EQ(asked.size(), 2u);
}

TEST_F(RigFormats, WhatTheRendererDoesNotMakeComesAsRgba) {
    const auto stream = subscribe(jpeg), planes = subscribe(raw(frame::PixelFormat::i420));
    SetCamera command{.name = "lobby", .patch = {}};
    command.patch.change([](world::CameraSpec& spec) { spec.controls.brightness = 0.2; });
    call(command);
    next_instant();
    EXPECT_EQ(asked, std::vector{frame::PixelFormats{frame::PixelFormat::rgba8}});
    ASSERT_TRUE(stream->wait_for_units(1) && planes->wait_for_units(1));
    EXPECT_EQ(planes->units()[0].frame->info().format, frame::PixelFormat::i420);
}

TEST_F(RigFormats, AWorldThatStandsStillShowsAChangeToEachReader) {
    const auto planes = subscribe(raw(frame::PixelFormat::i420));
    next_instant();
    ASSERT_TRUE(planes->wait_for_units(1));
    call(PauseWorld{});
    asked.clear();
    SetCamera command{.name = "lobby", .patch = {}};
    command.patch.zoom = 2.0;
    call(command);
    for (int turn = 0; turn < 2; ++turn) rig->tick(monotonic_now_ns());
    EXPECT_EQ(asked, std::vector{frame::PixelFormats{frame::PixelFormat::i420}});
    EXPECT_TRUE(planes->wait_for_units(2));
}

}  // namespace
}  // namespace camrig::engine::rig_formats_test
