// The rig's side alone: rings, the tree, hostile peers.

#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <optional>
#include <random>
#include <set>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/temporary_folder.h"
#include "tests/unit/v4l2_sink/preload/test_rig.h"
#include "v4l2_sink/preload/device_host.h"
#include "v4l2_sink/preload/device_modes.h"
#include "v4l2_sink/preload/device_ring.h"
#include "v4l2_sink/preload/device_tree.h"
#include "v4l2_sink/preload/ring_pool.h"
#include "v4l2_sink/task_queue.h"

namespace camrig::device::device_server_test {
namespace {

constexpr int patience_ms = 10'000;

UniqueFd connect_to(const std::string& path) {
    UniqueFd fd(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    EXPECT_EQ(::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    return fd;
}

/// True when the other side hangs up.
bool hangs_up(int fd) {
    pollfd wait{fd, POLLIN, 0};
    char byte;
    return ::poll(&wait, 1, patience_ms) == 1 && ::recv(fd, &byte, 1, MSG_DONTWAIT) == 0;
}

camrig_request hello(std::uint32_t number) {
    camrig_request request{};
    request.type = camrig_request_hello;
    request.u.hello.protocol = CAMRIG_DEVICE_PROTOCOL;
    request.u.hello.number = number;
    return request;
}

camrig_reply ask(int fd, const camrig_request& request) {
    EXPECT_EQ(::send(fd, &request, sizeof request, MSG_NOSIGNAL), static_cast<ssize_t>(sizeof request));
    camrig_reply reply{};
    EXPECT_EQ(::recv(fd, &reply, sizeof reply, 0), static_cast<ssize_t>(sizeof reply));
    return reply;
}

TEST(DeviceServer, OneSocketHasOneRig) {
    TestRig rig;
    const auto second = DeviceServer::create(rig.bus, rig.server->socket_path(), rig.controls);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().kind, ErrorKind::already_exists);
}

TEST(DeviceServer, ASocketLeftByAKilledRigIsTakenOver) {
    const TemporaryFolder folder;
    stream::LocalFrameBus bus({1, std::make_shared<frame::FramePool>()});
    const std::string path = folder / "s";
    {
        const UniqueFd dead(::socket(AF_UNIX, SOCK_SEQPACKET, 0));
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::strcpy(address.sun_path, path.c_str());
        ASSERT_EQ(::bind(dead.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    EXPECT_TRUE(DeviceServer::create(bus, path, std::make_shared<StoredControls>()));
}

TEST(DeviceServer, AFileInTheWayIsNotRemoved) {
    const TemporaryFolder folder;
    stream::LocalFrameBus bus({1, std::make_shared<frame::FramePool>()});
    const std::string path = folder / "notes.txt";
    std::ofstream(path) << "mine";
    EXPECT_FALSE(DeviceServer::create(bus, path, std::make_shared<StoredControls>()));
    EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(DeviceServer, ASocketWithAFullBacklogIsSomebodys) {
    const TemporaryFolder folder;
    stream::LocalFrameBus bus({1, std::make_shared<frame::FramePool>()});
    const std::string path = folder / "s";
    const UniqueFd busy(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    ASSERT_EQ(::bind(busy.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(busy.get(), 0), 0);
    const UniqueFd first = connect_to(path);
    const auto second = DeviceServer::create(bus, path, std::make_shared<StoredControls>());
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().kind, ErrorKind::already_exists);
}

TEST(DeviceServer, TheSocketOfASuccessorStays) {
    TestRig rig;
    const std::string path = rig.server->socket_path();
    std::filesystem::remove(path);
    UniqueFd successor(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    ASSERT_EQ(::bind(successor.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    rig.server.reset();
    EXPECT_TRUE(std::filesystem::exists(path));
}

// A waiting connection makes the listener readable for as long as there is no descriptor for it.
TEST(DeviceServer, WithoutDescriptorsItWaitsAndThenGoesOn) {
    TestRig rig;
    const UniqueFd program(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    const int next = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    ::close(next);
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
    const rlimit none{static_cast<rlim_t>(next), before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, rig.server->socket_path().c_str());
    ASSERT_EQ(::connect(program.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const auto cpu_ns = [] {
        timespec now{};
        ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
        return now.tv_sec * ns_per_s + now.tv_nsec;
    };
    const TimeNs started_ns = cpu_ns();
    pollfd answer{program.get(), POLLIN, 0};
    EXPECT_EQ(::poll(&answer, 1, 500), 0);  // nobody is there to answer; this thread sleeps
    const TimeNs spent_ns = cpu_ns() - started_ns;
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
    EXPECT_LT(spent_ns, 50 * ns_per_ms);
    EXPECT_EQ(ask(program.get(), hello(10)).status, 0);
}

// Programs in other containers have no process number here.
TEST(DeviceServer, AProgramIsKnownByTheMarkItDraws) {
    TestRig rig;
    const auto open_as = [&](std::uint32_t low, std::uint32_t high) {
        UniqueFd fd = connect_to(rig.server->socket_path());
        camrig_request request = hello(10);
        request.u.hello.process[0] = low;
        request.u.hello.process[1] = high;
        EXPECT_EQ(ask(fd.get(), request).status, 0);
        return fd;
    };
    camrig_request acquire{};
    acquire.type = camrig_request_acquire;
    const UniqueFd one = open_as(1, 7), same = open_as(1, 7), other = open_as(1, 8), another = open_as(2, 7);
    EXPECT_EQ(ask(one.get(), acquire).status, 0);
    EXPECT_EQ(ask(same.get(), acquire).status, EBUSY);
    EXPECT_EQ(ask(other.get(), acquire).status, 0);
    EXPECT_EQ(ask(another.get(), acquire).status, 0);
}

/// A program that has begun to stream, in the format that its device tells it first; `rate`: another of its rates.
UniqueFd streaming(const TestRig& rig, camrig_request greeting, std::size_t rate = 0) {
    UniqueFd fd = connect_to(rig.server->socket_path());
    const camrig_reply told = ask(fd.get(), greeting);
    EXPECT_EQ(told.status, 0);
    camrig_request acquire{}, start{};
    acquire.type = camrig_request_acquire;
    EXPECT_EQ(ask(fd.get(), acquire).status, 0);
    start.type = camrig_request_stream_on;
    start.u.format = told.u.description.current;
    EXPECT_LT(rate, told.u.description.rate_count);
    start.u.format.rate = told.u.description.rate[rate];
    EXPECT_EQ(ask(fd.get(), start).status, 0);
    return fd;
}

// Names go into errors and books, which are read in terminals.
TEST(DeviceServer, WhatAProgramCallsItselfMovesNoTerminalsCursor) {
    TestRig rig;
    camrig_request request = hello(10);
    std::memcpy(request.u.hello.program, "\x1b[31m\n", 7);
    const UniqueFd program = streaming(rig, request);
    const std::vector<stream::ReaderReport> programs = rig.programs();
    ASSERT_EQ(programs.size(), 1u);
    EXPECT_NE(programs[0].peer.find(" read by ?[31m? "), std::string::npos) << programs[0].peer;
}

// Series of /metrics are told apart by camera, format, kind and peer.
TEST(DeviceServer, ProgramsWithOneSizeAndTwoRatesAreReadersOfTwoNames) {
    TestRig rig;
    camrig_request one = hello(10), other = hello(10);
    one.u.hello.process[0] = 1;
    one.u.hello.program[0] = 'a';
    other.u.hello.process[0] = 2;
    other.u.hello.program[0] = 'b';
    const UniqueFd full = streaming(rig, one, 0), slow = streaming(rig, other, 1);
    stream::RigReport report;
    report.cameras.emplace_back().name = "lobby";
    rig.bus.fill_report(report);
    std::set<std::string> names;
    std::size_t readers = 0;
    for (const stream::OutputReport& output : report.cameras[0].outputs) {
        for (const stream::ReaderReport& reader : output.readers) {
            names.insert(output.format + "|" + reader.kind + "|" + reader.peer);
            ++readers;
        }
    }
    EXPECT_EQ(readers, 4u);  // two rings, two programs
    EXPECT_EQ(names.size(), readers);
}

// The kernel keeps the newest value of a control for a subscriber that does not look; so does the rig.
TEST(DeviceServer, ASubscriberThatDoesNotReadKeepsItsDeviceAndGetsTheNewestValue) {
    TestRig rig;
    const UniqueFd idle = connect_to(rig.server->socket_path());
    ASSERT_EQ(ask(idle.get(), hello(10)).status, 0);
    for (const std::uint32_t id : {V4L2_CID_BRIGHTNESS, V4L2_CID_GAIN}) {
        camrig_request subscribe{};
        subscribe.type = camrig_request_subscribe;
        subscribe.u.subscribe = {id, 1, 0};
        ASSERT_EQ(ask(idle.get(), subscribe).status, 0);
    }
    const auto set = [&](std::uint32_t id, std::int32_t value) {
        rig.controls->set("lobby", std::array{DeviceControlValue{id, value}}, [](const Result<void>&) {});
        rig.server->controls_changed("lobby", {id});
    };
    set(V4L2_CID_GAIN, 99);
    for (int n = 0; n < 5000; ++n) set(V4L2_CID_BRIGHTNESS, n % 60);
    set(V4L2_CID_BRIGHTNESS, 64);
    // Who opens a device that came later shows that all of it has been told.
    CHECK(rig.server->add_device(11, "lobby", codec::ChromaSampling::yuv422).has_value());
    while (ask(connect_to(rig.server->socket_path()).get(), hello(11)).status != 0) std::this_thread::yield();

    // A request is still answered, behind what was told before.
    camrig_request ask_format{};
    ask_format.type = camrig_request_get_format;
    ASSERT_EQ(::send(idle.get(), &ask_format, sizeof ask_format, MSG_NOSIGNAL),
              static_cast<ssize_t>(sizeof ask_format));
    std::map<std::uint32_t, std::int32_t> values;
    bool is_answered = false;
    while (!is_answered || values[V4L2_CID_BRIGHTNESS] != 64) {
        pollfd wait{idle.get(), POLLIN, 0};
        ASSERT_EQ(::poll(&wait, 1, patience_ms), 1);
        camrig_reply message{};
        const ssize_t got = ::recv(idle.get(), &message, sizeof message, 0);
        ASSERT_GT(got, 0) << "unplugged";
        camrig_control_event event{};
        std::memcpy(&event, &message, sizeof event);
        if (event.type == camrig_message_control_event)
            values[event.id] = event.value;
        else
            is_answered = true;
    }
    EXPECT_EQ(values[V4L2_CID_GAIN], 99);
}

/// Keeps who asks for the list of controls until it is let go.
class HeldControls final : public ControlPort {
public:
    std::vector<DeviceControl> list(std::string_view) override {
        if (--asks_first > 0) return {};
        asked.set_value();
        go_on.get_future().wait();
        return {};
    }
    Result<std::int32_t> get(std::string_view, std::uint32_t) override {
        ++reads;
        return 0;
    }
    void set(std::string_view, std::span<const DeviceControlValue>, std::function<void(Result<void>)>) override {}

    std::promise<void> asked, go_on;
    int asks_first = 1;  ///< this call is kept
    int reads = 0;       ///< server's thread
};

TEST(TaskQueue, WhatOneNameIsPostedForAnyNumberOfTimesWaitsOnce) {
    TaskQueue queue;
    std::size_t ran = 0, last = 0;
    for (std::size_t i = 0; i < 2 * TaskQueue::max_tasks; ++i)
        queue.post("brightness", [&ran, &last, i] {
            ++ran;
            last = i;
        });
    queue.run();
    EXPECT_EQ(ran, 1u);
    EXPECT_EQ(last, 2 * TaskQueue::max_tasks - 1);
}

TEST(DeviceServer, OfChangesThatItsThreadHasNoTimeForTheNewestOfEachControlWaits) {
    const TemporaryFolder folder;
    stream::LocalFrameBus bus{{1, std::make_shared<frame::FramePool>()}};
    bus.add_camera({CameraId{1}, "lobby", {320, 240}, *Rate::create(30, 1)});
    const auto controls = std::make_shared<HeldControls>();
    auto server = DeviceServer::create(bus, folder / "devices.sock", controls).value();
    ASSERT_TRUE(server->add_device(10, "lobby", codec::ChromaSampling::yuv422));
    const UniqueFd program = connect_to(server->socket_path());
    const camrig_request greeting = hello(10);
    ASSERT_EQ(::send(program.get(), &greeting, sizeof greeting, MSG_NOSIGNAL), static_cast<ssize_t>(sizeof greeting));
    controls->asked.get_future().wait();
    for (std::size_t n = 0; n <= TaskQueue::max_tasks; ++n) {
        server->controls_changed("lobby", {V4L2_CID_GAIN, V4L2_CID_BRIGHTNESS});
        server->controls_changed("a camera without a device", {V4L2_CID_GAIN});
    }
    for (const char* camera : {"gate", "lobby"}) {
        server->remove_device(10);
        ASSERT_TRUE(server->add_device(10, camera, codec::ChromaSampling::yuv422));
    }
    controls->go_on.set_value();
    camrig_reply reply{};
    ASSERT_EQ(::recv(program.get(), &reply, sizeof reply, 0), static_cast<ssize_t>(sizeof reply));
    EXPECT_TRUE(hangs_up(program.get())) << "its device was another one in between";
    server.reset();
    EXPECT_EQ(controls->reads, 2);
}

TEST(DeviceServer, WhatAProgramAsksOfADeviceThatWasJustRemovedHarmsNobody) {
    const TemporaryFolder folder;
    stream::LocalFrameBus bus{{1, std::make_shared<frame::FramePool>()}};
    bus.add_camera({CameraId{1}, "lobby", {320, 240}, *Rate::create(30, 1)});
    const auto controls = std::make_shared<HeldControls>();
    auto server = DeviceServer::create(bus, folder / "devices.sock", controls).value();
    for (const int number : {10, 11}) ASSERT_TRUE(server->add_device(number, "lobby", codec::ChromaSampling::yuv422));
    controls->asks_first = 2;
    const UniqueFd program = connect_to(server->socket_path()), other = connect_to(server->socket_path());
    ASSERT_EQ(ask(program.get(), hello(10)).status, 0);
    const camrig_request greeting = hello(11);
    ASSERT_EQ(::send(other.get(), &greeting, sizeof greeting, MSG_NOSIGNAL), static_cast<ssize_t>(sizeof greeting));
    controls->asked.get_future().wait();
    // Both wait for the server's thread, which takes them together.
    server->remove_device(10);
    camrig_request format{};
    format.type = camrig_request_get_format;
    ASSERT_EQ(::send(program.get(), &format, sizeof format, MSG_NOSIGNAL), static_cast<ssize_t>(sizeof format));
    controls->go_on.set_value();
    EXPECT_TRUE(hangs_up(program.get()));
    EXPECT_EQ(ask(other.get(), format).status, 0);
}

TEST(DeviceServer, NumbersAreGivenOnceAndWithinRange) {
    TestRig rig;
    EXPECT_EQ(rig.server->add_device(10, "lobby", codec::ChromaSampling::yuv422).error().kind,
              ErrorKind::already_exists);
    EXPECT_EQ(rig.server->add_device(256, "lobby", codec::ChromaSampling::yuv422).error().kind,
              ErrorKind::invalid_argument);
    EXPECT_EQ(rig.server->add_device(-1, "lobby", codec::ChromaSampling::yuv422).error().kind,
              ErrorKind::invalid_argument);
    EXPECT_TRUE(rig.server->add_device(255, "lobby", codec::ChromaSampling::yuv422));
    rig.server->remove_device(10);
    EXPECT_TRUE(rig.server->add_device(10, "gate", codec::ChromaSampling::yuv422));
}

TEST(DeviceServer, TheTreeShowsWhatDevAndSysWouldShow) {
    TestRig rig;
    const std::string tree = rig.server->socket_path() + ".tree";
    std::string text;
    std::getline(std::ifstream(tree + "/sys/class/video4linux/video10/name"), text);
    EXPECT_EQ(text, "lobby");
    std::getline(std::ifstream(tree + "/sys/dev/char/81:10/dev"), text);
    EXPECT_EQ(text, "81:10");
    EXPECT_TRUE(std::filesystem::exists(tree + "/dev/v4l/by-id/camrig-lobby-video-index0"));
    EXPECT_TRUE(std::filesystem::equivalent(tree + "/sys/class/video4linux/video10/subsystem",
                                            tree + "/sys/class/video4linux"));
    EXPECT_TRUE(std::filesystem::exists(tree + "/run/udev/data/c81:10"));
    rig.server->remove_device(10);
    EXPECT_FALSE(std::filesystem::exists(tree + "/dev/video10"));
    EXPECT_FALSE(std::filesystem::exists(tree + "/run/udev/data/c81:10"));
    EXPECT_FALSE(std::filesystem::exists(tree + "/sys/class/video4linux/video10"));
    rig.server.reset();
    EXPECT_FALSE(std::filesystem::exists(tree));
}

// What a stranger prepared under the tree's name would send our writing into any file of ours.
TEST(DeviceServer, ATreeThatCannotBeRemovedIsNotWrittenInto) {
    namespace fs = std::filesystem;
    constexpr uid_t nobody = 65534;
    const TemporaryFolder folder;
    const fs::path tree = folder / "devices.tree", victim = folder / "victim";
    for (const char* place : {"dev/v4l/by-id", "sys/class/video4linux", "sys/dev/char"}) {
        fs::create_directories(tree / place);
        fs::permissions(tree / place, fs::perms(0777));
    }
    std::ofstream(victim) << "precious";
    fs::create_symlink(victim, tree / "dev/video10");
    fs::permissions(folder.path(), fs::perms(0755));
    fs::permissions(tree / "dev", fs::perms(0555));
    ASSERT_TRUE(::geteuid() != 0 || ::chown(victim.c_str(), nobody, nobody) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
        // Root may remove whatever it likes; an ordinary user may not.
        if (::geteuid() == 0 && ::setuid(nobody) != 0) ::_exit(2);
        auto made = DeviceTree::create((folder / "devices").string());
        ::_exit(made && made->add(10, "lobby") ? 1 : 0);
    }
    int ended = -1;
    ::waitpid(child, &ended, 0);
    EXPECT_EQ(ended, 0);
    EXPECT_EQ(fs::file_size(victim), 8u);
    fs::permissions(tree / "dev", fs::perms(0755));
}

TEST(DeviceServer, WhoBreaksTheProtocolIsThrownOutAndOthersGoOn) {
    TestRig rig;
    const UniqueFd honest = connect_to(rig.server->socket_path());
    ASSERT_EQ(ask(honest.get(), hello(10)).status, 0);

    const UniqueFd short_message = connect_to(rig.server->socket_path());
    ::send(short_message.get(), "x", 1, MSG_NOSIGNAL);
    EXPECT_TRUE(hangs_up(short_message.get()));

    const UniqueFd no_hello = connect_to(rig.server->socket_path());
    camrig_request request{};
    request.type = camrig_request_stream_on;
    ::send(no_hello.get(), &request, sizeof request, MSG_NOSIGNAL);
    EXPECT_TRUE(hangs_up(no_hello.get()));

    const UniqueFd twice = connect_to(rig.server->socket_path());
    EXPECT_EQ(ask(twice.get(), hello(10)).status, 0);
    const camrig_request again = hello(10);
    ::send(twice.get(), &again, sizeof again, MSG_NOSIGNAL);
    EXPECT_TRUE(hangs_up(twice.get()));

    const UniqueFd other_version = connect_to(rig.server->socket_path());
    camrig_request old = hello(10);
    old.u.hello.protocol = 99;
    EXPECT_EQ(ask(other_version.get(), old).status, EPROTO);

    camrig_request format{};
    format.type = camrig_request_get_format;
    EXPECT_EQ(ask(honest.get(), format).u.format.width, 320u);
}

TEST(DeviceServer, RandomRequestsNeverHarmTheRig) {
    TestRig rig;
    std::mt19937 random(7);
    for (int round = 0; round < 50; ++round) {
        const UniqueFd fd = connect_to(rig.server->socket_path());
        const camrig_request first = hello(10);
        ::send(fd.get(), &first, sizeof first, MSG_NOSIGNAL);
        for (int i = 0; i < 20; ++i) {
            camrig_request request{};
            auto* bytes = reinterpret_cast<unsigned char*>(&request);
            for (std::size_t k = 0; k < sizeof request; ++k) bytes[k] = static_cast<unsigned char>(random());
            request.type = 2 + static_cast<std::uint32_t>(random() % 12);
            ::send(fd.get(), &request, sizeof request, MSG_NOSIGNAL | MSG_DONTWAIT);
        }
    }
    rig.show();
    const UniqueFd honest = connect_to(rig.server->socket_path());
    EXPECT_EQ(ask(honest.get(), hello(10)).status, 0);
}

TEST(DeviceHost, WhoTakesNoAnswerThatCameLaterIsUnplugged) {
    stream::LocalFrameBus bus{{1, std::make_shared<frame::FramePool>()}};
    bus.add_camera({CameraId{1}, "lobby", {320, 240}, *Rate::create(30, 1)});
    const auto tasks = std::make_shared<TaskQueue>();
    DeviceHost host(bus, std::make_shared<StoredControls>(), tasks);
    host.add_device(10, "lobby", codec::ChromaSampling::yuv422);
    int pair[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), 0);
    const UniqueFd program(pair[0]);
    const auto session = std::make_shared<DeviceSession>(UniqueFd(pair[1]));
    const camrig_request greeting = hello(10);
    host.receive(session, std::as_bytes(std::span(&greeting, 1)));
    camrig_request question{};
    question.type = camrig_request_get_control;
    question.u.control_id = V4L2_CID_GAIN;
    host.receive(session, std::as_bytes(std::span(&question, 1)));
    const char filler[1024]{};
    while (::send(session->control_fd(), filler, sizeof filler, MSG_DONTWAIT | MSG_NOSIGNAL) > 0) {
    }
    tasks->run();  // the answer
    host.tick(monotonic_now_ns());
    EXPECT_EQ(host.take_ended(), std::vector{session});
    EXPECT_FALSE(session->event_socket);
    host.tick(monotonic_now_ns());
    EXPECT_TRUE(host.take_ended().empty());
}

/// A reader of a ring whose counters the test writes as it likes.
struct ByHand {
    explicit ByHand(DeviceRing& in) : ring(in) {
        int pair[2];
        CHECK(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, pair) == 0);
        mine.reset(pair[0]);
        theirs.reset(pair[1]);
        place = ring.attach(reader = std::make_shared<RingReader>(mine.get(), &page, stats));
    }
    int tokens() const {
        int count = 0;
        char token;
        while (::recv(theirs.get(), &token, 1, MSG_DONTWAIT) == 1) ++count;
        return count;
    }
    DeviceRing& ring;
    UniqueFd mine, theirs;
    camrig_reader_page page{};
    std::shared_ptr<stream::ReaderStats> stats = std::make_shared<stream::ReaderStats>();
    std::shared_ptr<RingReader> reader;
    camrig_ring_place place{};
};

class DeviceRingTest : public testing::Test {
protected:
    static constexpr ImageSize size{320, 240};
    void show(TimeNs world_ns, std::int64_t sequence, TimeNs instant_ns = monotonic_now_ns()) {
        stream::MediaUnit unit;
        unit.frame = maker.make(sequence, world_ns, instant_ns);
        unit.info = unit.frame->info();
        EXPECT_TRUE(ring->write(unit));
    }
    const camrig_ring_header& header() {
        if (view == nullptr)
            view = static_cast<const camrig_ring_header*>(
                ::mmap(nullptr, sizeof(camrig_ring_header), PROT_READ, MAP_SHARED, ring->memory_fd(), 0));
        return *view;
    }
    ~DeviceRingTest() override {
        if (view != nullptr) ::munmap(const_cast<camrig_ring_header*>(view), sizeof(camrig_ring_header));
    }
    const camrig_ring_slot& newest() { return header().slot[(header().published - 1) % header().slots]; }

    PictureMaker maker{{CameraId{1}, "lobby", size, *Rate::create(30, 1)}};
    std::shared_ptr<DeviceRing> ring = *DeviceRing::create(size, 320 * 240 * 4, std::nullopt);
    const camrig_ring_header* view = nullptr;
};

TEST_F(DeviceRingTest, AReaderCannotMapTheRingForWriting) {
    EXPECT_EQ(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, ring->memory_fd(), 0), MAP_FAILED);
    EXPECT_LT(::write(ring->memory_fd(), "x", 1), 0);
    EXPECT_NE(::ftruncate(ring->memory_fd(), 0), 0);
}

// Whatever a reader writes into its page, it gets a bounded number of tokens and others are served.
TEST_F(DeviceRingTest, LyingCountersHarmOnlyTheLiar) {
    ByHand liar(*ring), honest(*ring);
    for (int n = 0; n < 500; ++n) {
        liar.page.queued = n % 3 == 0 ? UINT64_MAX : static_cast<std::uint64_t>(n) * 1000;
        liar.page.taken = n % 5 == 0 ? UINT64_MAX : n % 2 == 0 ? static_cast<std::uint64_t>(n) * 999 : 0;
        honest.page.queued = static_cast<std::uint64_t>(n) + 1;
        honest.page.taken = static_cast<std::uint64_t>(n);
        show(n, n);
        EXPECT_EQ(honest.tokens(), 1);
    }
    EXPECT_EQ(liar.stats->offered, liar.stats->delivered + liar.stats->dropped);
    EXPECT_EQ(honest.stats->delivered, 500u);
}

TEST_F(DeviceRingTest, NoMorePicturesArePromisedThanAreSafe) {
    ByHand greedy(*ring);
    greedy.page.queued = 1000;
    for (int n = 0; n < 200; ++n) show(n, n);
    EXPECT_EQ(greedy.tokens(), static_cast<int>(greedy.place.slots) - camrig_slot_margin);
    // H = T + D, and the next picture to take is among the newest.
    EXPECT_EQ(greedy.page.displaced, 200u - (greedy.place.slots - camrig_slot_margin));
}

TEST_F(DeviceRingTest, ASilentCameraRepeatsItsLastPictureWithAFreshStamp) {
    show(0, 5);
    const auto stamp = newest().monotonic_ns;
    const auto sequence = newest().sequence;
    ring->repeat_if_idle(monotonic_now_ns(), ns_per_s);
    EXPECT_EQ(header().published, 1u);
    const TimeNs later = monotonic_now_ns() + 2 * ns_per_s;
    ring->repeat_if_idle(later, ns_per_s);
    EXPECT_EQ(header().published, 2u);
    EXPECT_EQ(newest().monotonic_ns, static_cast<std::uint64_t>(later - 500 * ns_per_ms));
    EXPECT_GT(newest().monotonic_ns, stamp);
    EXPECT_EQ(newest().sequence, sequence + 1);
    show(100, 6);
    EXPECT_EQ(newest().sequence, sequence + 2);
}

TEST_F(DeviceRingTest, APictureThatWasDrawnWhileOneWasRepeatedKeepsItsInstant) {
    const TimeNs now_ns = monotonic_now_ns();
    show(0, 0, now_ns - 10 * ns_per_ms);
    ring->repeat_if_idle(now_ns + 2 * ns_per_s, ns_per_s);
    show(1, 1, now_ns + 1'600 * ns_per_ms);
    EXPECT_EQ(newest().monotonic_ns, static_cast<std::uint64_t>(now_ns + 1'600 * ns_per_ms));
}

TEST_F(DeviceRingTest, ACameraWhosePicturesAreLateRepeatsThemWithAnOlderStamp) {
    const TimeNs now_ns = monotonic_now_ns();
    show(0, 0, now_ns - 1'500 * ns_per_ms);
    ring->repeat_if_idle(now_ns + 2 * ns_per_s, ns_per_s);
    EXPECT_EQ(header().published, 2u);
    show(1, 1, now_ns + 400 * ns_per_ms);
    EXPECT_EQ(newest().monotonic_ns, static_cast<std::uint64_t>(now_ns + 400 * ns_per_ms));
}

TEST_F(DeviceRingTest, LostPicturesShowAsGapsAndAReloadedWorldGoesOnRising) {
    show(0, 7);
    EXPECT_EQ(newest().sequence, 0u);
    show(1, 10);
    EXPECT_EQ(newest().sequence, 3u);
    show(0, 0);
    EXPECT_EQ(newest().sequence, 4u);
    show(1, 1);
    EXPECT_EQ(newest().sequence, 5u);
}

TEST_F(DeviceRingTest, ALowerRateThanTheCamerasCountsItsTicksUntilTheCameraIsSlowerStill) {
    const Rate ten = *Rate::create(10, 1);
    ring = *DeviceRing::create(size, 320 * 240 * 4, ten);
    std::int64_t sequence = 0;
    TimeNs world_ns = 0;
    for (std::uint32_t n = 0; n < 5; ++n, sequence += 3, world_ns += 100 * ns_per_ms) {  // three of 30 a second
        show(world_ns, sequence);
        EXPECT_EQ(newest().sequence, n);
    }
    for (std::uint32_t n = 5; n < 10; ++n, ++sequence, world_ns += 500 * ns_per_ms) {  // the camera makes 2 a second
        show(world_ns, sequence);
        EXPECT_EQ(newest().sequence, n);
    }
    ++sequence;  // this one is lost
    show(world_ns + 500 * ns_per_ms, sequence);
    EXPECT_EQ(newest().sequence, 11u);
}

class RingPoolTest : public testing::Test {
protected:
    explicit RingPoolTest(bool is_lockstep = false)
        : pool(bus, std::make_shared<TaskQueue>(), [](const auto&) {}, is_lockstep) {
        bus.add_camera(maker.camera());
        fed = *pool.take("lobby", {V4L2_PIX_FMT_YUYV, 320, 240, {30, 1}}, codec::ChromaSampling::yuv422);
        reader.emplace(*fed->ring);
        reader->page.queued = 10;
    }
    /// The camera's first picture, which the reader gets.
    void show(const std::shared_ptr<stream::DeliveryLatch>& latch = nullptr) {
        bus.publish({.world_ns = 0, .monotonic_ns = 0, .frames = {maker.make(0, 0, monotonic_now_ns())}}, latch);
        pollfd wait{reader->theirs.get(), POLLIN, 0};
        ASSERT_EQ(::poll(&wait, 1, patience_ms), 1);
        EXPECT_EQ(reader->tokens(), 1);
    }

    stream::LocalFrameBus bus{{1, std::make_shared<frame::FramePool>()}};
    PictureMaker maker{{CameraId{1}, "lobby", {320, 240}, *Rate::create(30, 1)}};
    RingPool pool;
    std::shared_ptr<FedRing> fed;
    std::optional<ByHand> reader;
};

TEST_F(RingPoolTest, ASlowCamerasPictureIsNotRepeatedBeforeTheNextIsDue) {
    stream::CameraStream slower = maker.camera();
    slower.rate = *Rate::create(1, 2);
    bus.change_camera(slower);
    show();
    const TimeNs now_ns = monotonic_now_ns();
    pool.tick(now_ns + 3 * ns_per_s);
    EXPECT_EQ(reader->tokens(), 0);
    pool.tick(now_ns + 5 * ns_per_s);
    EXPECT_EQ(reader->tokens(), 1);
}

// A step of a world that is paused in real time has a latch too.
TEST_F(RingPoolTest, APausedWorldsPictureIsRepeatedAfterAStepToo) {
    show(stream::DeliveryLatch::create());
    pool.tick(monotonic_now_ns() + 2 * ns_per_s);
    EXPECT_EQ(reader->tokens(), 1);
}

class RingPoolInLockstep : public RingPoolTest {
protected:
    RingPoolInLockstep() : RingPoolTest(true) {}
};

// What a step that was given up had drawn comes without a latch.
TEST_F(RingPoolInLockstep, APictureIsNotRepeatedWhicheverWayItCame) {
    show();
    pool.tick(monotonic_now_ns() + 60 * ns_per_s);
    EXPECT_EQ(reader->tokens(), 0);
}

TEST(DeviceModes, SizesKeepTheShapeAndAreEven) {
    const DeviceModes modes = modes_of({CameraId{1}, "x", {1281, 721}, *Rate::create(30000, 1001)});
    EXPECT_EQ(modes.sizes.front(), (ImageSize{1280, 720}));
    for (const ImageSize size : modes.sizes) {
        EXPECT_EQ(size.width % 2 + size.height % 2, 0);
        EXPECT_EQ(size.width * 720, size.height * 1280);
    }
    EXPECT_EQ(modes.rates.front().to_string(), "30000/1001");
    EXPECT_EQ(modes.rates[1].to_string(), "25");
}

TEST(DeviceModes, TheSmallestCameraHasOneSize) {
    EXPECT_EQ(modes_of({CameraId{1}, "x", {16, 16}, Rate()}).sizes.size(), 1u);
}

}  // namespace
}  // namespace camrig::device::device_server_test
