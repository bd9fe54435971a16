// Every due picture reaches a real program whole and in order, a hundred thousand times: in lockstep, through the
// library (LD_PRELOAD), checked by the client's own eyes (every pixel and the code strip of every picture).

#include <array>
#include <semaphore>
#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/v4l2_sink/preload/test_rig.h"

namespace camrig::device {
namespace {

using std::chrono_literals::operator""ms;

/// Shows a picture, waits until it was delivered, shows the next.
void run_in_lockstep(TestRig& rig, const std::atomic<bool>& stop) {
    while (!stop) {
        auto opened = std::make_shared<std::counting_semaphore<>>(0);
        const auto latch = stream::DeliveryLatch::create([opened] { opened->release(); });
        auto hold = latch->hold("the test");
        rig.show(latch);
        hold.release();
        while (!stop && !latch->is_open()) (void)opened->try_acquire_for(100ms);
    }
}

TEST(DeviceSoak, AHundredThousandPicturesAreWholeAndInOrder) {
    TestRig rig;
    std::atomic<bool> stop{false};
    std::thread camera([&] { run_in_lockstep(rig, stop); });
    const std::string command = "CAMRIG_DEVICE_SOCKET='" + rig.server->socket_path() + "' LD_PRELOAD='" +
                                CAMRIG_TEST_PRELOAD "' exec timeout 550 " CAMRIG_TEST_CLIENT
                                                    " /dev/video10 100000 YUYV 320x240 2>&1";
    FILE* const pipe = ::popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::array<char, 1024> part;
    std::string output;
    while (const std::size_t got = std::fread(part.data(), 1, part.size(), pipe)) output.append(part.data(), got);
    EXPECT_EQ(::pclose(pipe), 0);
    stop = true;
    camera.join();
    EXPECT_NE(output.find("frames 100000 lost 0 spurious 0"), std::string::npos) << output;
}

}  // namespace
}  // namespace camrig::device
