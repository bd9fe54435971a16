// A rig without a world: cameras with test pictures as user-space devices, for trying real programs against them.
//
//   device_generator SOCKET SECONDS DEVICE...      DEVICE = NUMBER:NAME:WIDTHxHEIGHT:FPS[:lockstep]
//
// Prints "ready" and then, at the end, one line per reader.

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <semaphore>
#include <thread>

#include <unistd.h>

#include "tests/unit/v4l2_sink/preload/test_rig.h"

using namespace camrig;

namespace {
std::atomic<bool> stop{false};
}

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fprintf(stderr, "use: %s SOCKET SECONDS NUMBER:NAME:WIDTHxHEIGHT:FPS[:lockstep]...\n", argv[0]);
        return 2;
    }
    std::signal(SIGTERM, [](int) { stop = true; });
    std::signal(SIGINT, [](int) { stop = true; });
    LocalFrameBus bus({2, std::make_shared<FramePool>()});
    auto server = DeviceServer::create(bus, argv[1], std::make_shared<StoredControls>());
    if (!server) {
        std::fprintf(stderr, "%s\n", server.error().message.c_str());
        return 1;
    }
    std::vector<std::unique_ptr<PictureMaker>> makers;
    bool lockstep = false;
    for (int i = 3; i < argc; ++i) {
        int number = 0, width = 0, height = 0;
        char name[32] = "";
        char rate[32] = "", rest[64] = "";
        if (std::sscanf(argv[i], "%d:%31[^:]:%dx%d:%31[^:]%63s", &number, name, &width, &height, rate, rest) < 5)
            return 2;
        CameraStream camera{static_cast<CameraId>(i), name, {width, height}, *Rate::parse(rate)};
        bus.add_camera(camera);
        lockstep = lockstep || std::strstr(rest, "lockstep") != nullptr;
        if (auto added = (*server)->add_device(number, name, ChromaSampling::yuv422); !added) {
            std::fprintf(stderr, "%s\n", added.error().message.c_str());
            return 1;
        }
        makers.push_back(std::make_unique<PictureMaker>(camera));
    }
    std::puts("ready");
    std::fflush(stdout);

    const TimeNs start = monotonic_now_ns(), end = start + std::atoll(argv[2]) * ns_per_s;
    std::vector<std::int64_t> next(makers.size(), 0);
    TimeNs world = 0;
    while (!stop && monotonic_now_ns() < end) {
        TimeNs due = INT64_MAX;
        for (std::size_t i = 0; i < makers.size(); ++i)
            due = std::min(due, makers[i]->camera().rate.time_of_frame(next[i]));
        world = due;
        if (!lockstep) {
            const TimeNs wake = start + due;
            timespec until{wake / ns_per_s, wake % ns_per_s};
            ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
        }
        FrameSet set;
        set.world_ns = world;
        set.monotonic_ns = lockstep ? monotonic_now_ns() : start + due;
        bool watched = false;
        for (std::size_t i = 0; i < makers.size(); ++i) {
            if (makers[i]->camera().rate.time_of_frame(next[i]) != due) continue;
            const std::int64_t n = next[i]++;
            if (bus.wanted(makers[i]->camera().id, world).empty()) continue;
            watched = true;
            set.frames.push_back(makers[i]->make(n, world, set.monotonic_ns));
        }
        if (!lockstep) {
            bus.publish(set, nullptr);
        } else if (!set.frames.empty()) {
            auto open = std::make_shared<std::counting_semaphore<>>(0);
            const auto latch = DeliveryLatch::create([open] { open->release(); });
            auto hold = latch->hold("the generator");
            bus.publish(set, latch);
            set.frames.clear();
            hold.release();
            while (!latch->is_open() && !stop)
                if (!open->try_acquire_for(std::chrono::seconds(2)))
                    for (const auto& who : latch->holders()) std::fprintf(stderr, "late: %s\n", who.c_str());
        }
        if (lockstep && !watched) ::usleep(1000);
    }
    for (const auto& reader : (*server)->report())
        std::printf("%s: offered %lu delivered %lu dropped %lu latency %.3f ms\n", reader.peer.c_str(), reader.offered,
                    reader.delivered, reader.dropped, reader.latency_ms);
}
