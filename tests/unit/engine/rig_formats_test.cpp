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
namespace camrig::rig_formats_test {
namespace {

/// A null renderer that gives planes, but not of pictures with image controls, and notes what it was asked for.
class PlanesRenderer final : public Renderer {
public:
    PlanesRenderer(std::shared_ptr<FramePool> pool, std::vector<PixelFormats>& asked)
        : pool_(std::move(pool)), null_(pool_), asked_(asked) {}

    Result<Finished> draw(const SnapshotRef& snapshot, TimeNs monotonic_ns, std::span<const View> views) override {
        for (const View& view : views) asked_.push_back(view.color_formats);
        Finished finished = null_.draw(snapshot, monotonic_ns, views).value();
        std::vector<FrameRef> drawn;
        drawn.swap(finished.set.frames);
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            for (const PixelFormat format : color_formats) {
                if (!views[i].color_formats.contains(format)) continue;
                EXPECT_TRUE(makes(format, views[i]));
                finished.set.frames.push_back(converted(*pool_, drawn[i], format, {}).value());
            }
        }
        return finished;
    }
    bool makes(PixelFormat format, const View& view) const override {
        const bool is_planes = format == PixelFormat::i420 || format == PixelFormat::jpeg_i420;
        return format == PixelFormat::rgba8 || (is_planes && view.spec->controls.brightness == 0.0);
    }
    void forget(CameraId) override {}
    std::string description() const override { return null_.description(); }

private:
    std::shared_ptr<FramePool> pool_;
    NullRenderer null_;
    std::vector<PixelFormats>& asked_;
};

constexpr MediaFormat jpeg{Codec::jpeg, PixelFormat::rgba8, 90, {}};
constexpr MediaFormat png{Codec::png, PixelFormat::rgba8, 0, {}};
constexpr MediaFormat raw(PixelFormat pixels) {
    return {Codec::raw, pixels, 0, {}};
}

class RigFormats : public testing::Test {
protected:
    void SetUp() override {
        auto made = make_rig(std::make_shared<Scene>(), {}, std::make_unique<PlanesRenderer>(pool, asked), bus);
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
    std::shared_ptr<FakeSink> subscribe(const MediaFormat& format) {
        auto sink = std::make_shared<FakeSink>();
        subscriptions.push_back(bus.subscribe("lobby", format, {"test", "", {}}, sink, {}).value());
        return sink;
    }
    void next_instant() {
        asked.clear();
        while (asked.empty()) rig->tick(monotonic_now_ns());
        rig->tick(0);  // hears of it
    }
    MediaUnit fetch(const MediaFormat& format) {
        std::promise<Result<MediaUnit>> answer;
        rig->fetch({"lobby", FrameKind::color, 0, format}, [&](Result<MediaUnit> unit) { answer.set_value(unit); });
        for (int turn = 0; turn < 2; ++turn) rig->tick(0);  // in which nothing is due: it is drawn, and heard of
        return answer.get_future().get().value();
    }

    std::vector<PixelFormats> asked;
    std::shared_ptr<FramePool> pool = std::make_shared<FramePool>();
    LocalFrameBus bus{{1, pool}};
    std::unique_ptr<Rig> rig;
    std::vector<Subscription> subscriptions;
};

TEST_F(RigFormats, EachReaderGetsItsOwnAndThePictureIsCountedOnce) {
    const auto stream = subscribe(jpeg), planes = subscribe(raw(PixelFormat::i420)),
               packed = subscribe(raw(PixelFormat::yuyv));
    next_instant();
    ASSERT_EQ(asked.size(), 1u);
    EXPECT_EQ(asked[0], (PixelFormats{PixelFormat::jpeg_i420, PixelFormat::i420, PixelFormat::rgba8}));
    for (const auto& sink : {stream, planes, packed}) {
        ASSERT_TRUE(sink->wait_for_units(1));
        EXPECT_EQ(sink->units().size(), 1u);
    }
    EXPECT_EQ(planes->units()[0].frame->info().format, PixelFormat::i420);
    EXPECT_EQ(packed->units()[0].frame->info().format, PixelFormat::yuyv);
    const CameraReport report = call(GetStats{}).cameras.at(0);
    EXPECT_EQ(report.rendered, 1u);
    EXPECT_EQ(report.due, report.rendered + report.dropped);
}

TEST_F(RigFormats, APictureOnDemandIsMadeOfWhatIsThere) {
    const auto planes = subscribe(raw(PixelFormat::i420));
    next_instant();
    ASSERT_TRUE(planes->wait_for_units(1));
    asked.clear();
    EXPECT_EQ(fetch(raw(PixelFormat::i420)).frame, planes->units()[0].frame);
    EXPECT_TRUE(asked.empty());
    fetch(png);
    EXPECT_EQ(asked, std::vector{PixelFormats{PixelFormat::rgba8}});
    fetch(raw(PixelFormat::yuyv));
    EXPECT_EQ(asked.size(), 1u) << "made of the same";
    // A JPEG is of planes like those of streams.
    fetch(jpeg);
    EXPECT_EQ(asked.back(), PixelFormats{PixelFormat::jpeg_i420});
    fetch(jpeg);
    EXPECT_EQ(asked.size(), 2u);
}

TEST_F(RigFormats, WhatTheRendererDoesNotMakeComesAsRgba) {
    const auto stream = subscribe(jpeg), planes = subscribe(raw(PixelFormat::i420));
    SetCamera command{.name = "lobby", .patch = {}};
    command.patch.change([](CameraSpec& spec) { spec.controls.brightness = 0.2; });
    call(command);
    next_instant();
    EXPECT_EQ(asked, std::vector{PixelFormats{PixelFormat::rgba8}});
    ASSERT_TRUE(stream->wait_for_units(1) && planes->wait_for_units(1));
    EXPECT_EQ(planes->units()[0].frame->info().format, PixelFormat::i420);
}

TEST_F(RigFormats, AWorldThatStandsStillShowsAChangeToEachReader) {
    const auto planes = subscribe(raw(PixelFormat::i420));
    next_instant();
    ASSERT_TRUE(planes->wait_for_units(1));
    call(PauseWorld{});
    asked.clear();
    SetCamera command{.name = "lobby", .patch = {}};
    command.patch.zoom = 2.0;
    call(command);
    for (int turn = 0; turn < 2; ++turn) rig->tick(monotonic_now_ns());
    EXPECT_EQ(asked, std::vector{PixelFormats{PixelFormat::i420}});
    EXPECT_TRUE(planes->wait_for_units(2));
}

}  // namespace
}  // namespace camrig::rig_formats_test
