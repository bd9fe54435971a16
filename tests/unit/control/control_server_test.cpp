#include "control/server/control_server.h"

#include <fstream>

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "tests/unit/control/server_harness.h"

namespace camrig::control {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr std::size_t large = std::size_t{1} << 26;

std::string request(int id, const std::string& method, const std::string& params = "{}") {
    return R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"method":")" + method + R"(","params":)" + params +
           "}";
}

json answer(client::LineSocket& socket) {
    auto line = socket.receive(large, soon());
    EXPECT_TRUE(line) << (line ? "" : line.error().message);
    return line ? json::parse(*line) : json();
}

bool is_closed(client::LineSocket& socket) {
    return !socket.receive(large, soon());
}

TEST(ControlServer, AnswersALineWithALine) {
    ServerHarness harness;
    auto socket = harness.connect();
    ASSERT_TRUE(socket.send(request(7, "world.status"), soon()));
    EXPECT_EQ(answer(socket)["id"], 7);
    ASSERT_TRUE(socket.send("\r\n \n" + request(8, "world.status") + "\r", soon()));
    EXPECT_EQ(answer(socket)["id"], 8);
}

TEST(ControlServer, AnswersComeInTheOrderOfTheRequestsThoughOneTakesLonger) {
    ServerHarness harness;
    harness.rig.hold_steps();
    auto socket = harness.connect();
    ASSERT_TRUE(socket.send(request(1, "world.step", R"({"seconds":1})") + "\n" + request(2, "world.status"), soon()));
    ASSERT_TRUE(eventually([&] { return harness.rpc.calls()["world.status"] == 1; }));
    harness.rig.release();
    EXPECT_EQ(answer(socket)["id"], 1);
    EXPECT_EQ(answer(socket)["id"], 2);
}

TEST(ControlServer, AConnectionThatSendsTooFarAheadIsNotRead) {
    ControlLimits limits;
    limits.in_flight = 4;
    ServerHarness harness(limits);
    harness.rig.hold_steps();
    auto socket = harness.connect();
    std::string lines;
    for (int id = 0; id < 20; ++id) lines += request(id, "world.step", R"({"seconds":1})") + "\n";
    ASSERT_TRUE(socket.send(lines, soon()));
    ASSERT_TRUE(eventually([&] { return harness.rig.held() == 4; }));
    // Another client is served meanwhile, and nothing more was taken of the first.
    EXPECT_TRUE(harness.client().call("world.status"));
    EXPECT_EQ(harness.rig.held(), 4u);
    harness.rig.release();
    for (int id = 0; id < 20; ++id) EXPECT_EQ(answer(socket)["id"], id);
}

TEST(ControlServer, TheLastLineNeedsNoEndWhenTheClientStopsSending) {
    ServerHarness harness;
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    harness.path.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const std::string text = request(3, "world.status");
    ASSERT_EQ(::send(fd, text.data(), text.size(), 0), static_cast<ssize_t>(text.size()));
    ::shutdown(fd, SHUT_WR);
    std::string reply(4096, '\0');
    std::size_t size = 0;
    for (ssize_t count = 1; count > 0; size += static_cast<std::size_t>(std::max<ssize_t>(count, 0)))
        count = ::recv(fd, reply.data() + size, reply.size() - size, 0);
    ::close(fd);
    EXPECT_EQ(json::parse(reply.substr(0, size))["id"], 3);
}

TEST(ControlServer, ALineThatIsTooLongIsAnsweredAndTheConnectionClosed) {
    ControlLimits limits;
    limits.line_bytes = 1000;
    ServerHarness harness(limits);
    auto socket = harness.connect();
    // The rig reads on for a moment only; sending may fail once it has closed.
    static_cast<void>(socket.send(std::string(100'000, '['), soon()));
    const json error = answer(socket)["error"];
    EXPECT_EQ(error["code"], -32600);
    EXPECT_EQ(error["data"]["kind"], "resource_exhausted");
    EXPECT_TRUE(is_closed(socket));
    EXPECT_TRUE(harness.client().call("world.status"));
}

TEST(ControlServer, SendingWithoutEndEndsSoonAndCostsNoMemory) {
    ServerHarness harness;
    auto socket = harness.connect();
    const std::string chunk(2 << 20, '1');
    std::size_t sent = 0;
    while (sent < (std::size_t{1} << 40) && socket.send(chunk, soon())) sent += chunk.size();
    EXPECT_LT(sent, std::size_t{16} << 20);
    EXPECT_TRUE(eventually([&] { return harness.server->counts().open == 0; }));
    EXPECT_TRUE(harness.client().call("world.status"));
}

TEST(ControlServer, AClientThatNeverReadsIsClosed) {
    ControlLimits limits;
    limits.stalled_after = std::chrono::milliseconds(50);
    ServerHarness harness(limits);
    harness.rig.set_picture_bytes(4 << 20);
    ASSERT_TRUE(harness.client().call("camera.create", {{"name", "lobby"}}));
    auto socket = harness.connect();
    for (int id = 0; id < 3; ++id) ASSERT_TRUE(socket.send(request(id, "frame.get", R"({"camera":"lobby"})"), soon()));
    EXPECT_TRUE(eventually([&] { return harness.rpc.calls()["frame.get"] >= 1; }));
    EXPECT_TRUE(eventually([&] { return harness.server->counts().open == 0; }));
}

TEST(ControlServer, WhatAClientCannotHaveAtOnceIsAnErrorAndTheConnectionStays) {
    ControlLimits limits;
    limits.queued_reply_bytes = 1500;
    ServerHarness harness(limits);
    harness.rig.set_picture_bytes(2000);
    ASSERT_TRUE(harness.client().call("camera.create", {{"name", "lobby"}}));
    auto socket = harness.connect();
    ASSERT_TRUE(socket.send(request(1, "frame.get", R"({"camera":"lobby"})"), soon()));
    EXPECT_EQ(answer(socket)["error"]["data"]["kind"], "resource_exhausted");
    harness.rig.set_picture_bytes(200);
    ASSERT_TRUE(socket.send(request(2, "frame.get", R"({"camera":"lobby"})"), soon()));
    EXPECT_TRUE(answer(socket).contains("result"));
}

TEST(ControlServer, LargeAnswersOfABatchArriveWhole) {
    ServerHarness harness;
    harness.rig.set_picture_bytes(3'000'000);
    ASSERT_TRUE(harness.client().call("camera.create", {{"name", "lobby"}}));
    auto socket = harness.connect();
    const std::string one = request(1, "frame.get", R"({"camera":"lobby"})");
    ASSERT_TRUE(socket.send("[" + one + "," + request(2, "world.status") + "," + one + "]", soon()));
    const json answers = answer(socket);
    ASSERT_EQ(answers.size(), 3u);
    EXPECT_EQ(answers[2]["result"]["data"].get<std::string>().size(), 4'000'000u);
    ASSERT_TRUE(eventually([&] { return harness.rpc.budget()->used() == 0; }));
}

TEST(ControlServer, BytesOfAPictureFollowTheLineOfTheirAnswerAndNothingElse) {
    ServerHarness harness;
    harness.rig.set_picture_bytes(100'000);
    ASSERT_TRUE(harness.client().call("camera.create", {{"name", "lobby"}}));
    auto socket = harness.connect();
    ASSERT_TRUE(socket.send(request(1, "frame.get", R"({"camera":"lobby","encoding":"bytes"})"), soon()));
    ASSERT_TRUE(socket.send(request(2, "world.status"), soon()));
    const json result = answer(socket)["result"];
    EXPECT_EQ(result["encoding"], "bytes");
    EXPECT_EQ(result["bytes"], 100'000);
    EXPECT_FALSE(result.contains("data"));
    const auto rest = socket.receive(1 << 20, soon());
    ASSERT_TRUE(rest);
    EXPECT_EQ(rest->substr(0, 100'000), std::string(100'000, '\xab'));
    EXPECT_EQ(json::parse(rest->substr(100'000))["id"], 2);
    ASSERT_TRUE(eventually([&] { return harness.rpc.budget()->used() == 0; }));
}

TEST(ControlServer, ClientsThatVanishLeaveNothing) {
    ServerHarness harness;
    harness.rig.hold_steps();
    for (int i = 0; i < 20; ++i) {
        auto socket = harness.connect();
        ASSERT_TRUE(socket.send(request(1, "world.step", R"({"seconds":1})"), soon()));
        ASSERT_TRUE(socket.send(R"({"jsonrpc":"2.0","id":1,"method":"world.st)", soon()));
    }
    ASSERT_TRUE(eventually([&] { return harness.rig.held() == 20; }));
    harness.rig.release();
    EXPECT_TRUE(eventually([&] { return harness.server->counts().open == 0; }));
    EXPECT_EQ(harness.server->counts().total, 20u);
}

TEST(ControlServer, OneConnectionTooManyIsToldSoWhenAllAreInUse) {
    ControlLimits limits;
    limits.connections = 2;
    ServerHarness harness(limits);
    harness.rig.hold_steps();
    auto first = harness.connect(), second = harness.connect();
    for (client::LineSocket* socket : {&first, &second})
        ASSERT_TRUE(socket->send(request(1, "world.step", R"({"seconds":1})"), soon()));
    ASSERT_TRUE(eventually([&] { return harness.rig.held() == 2; }));
    auto third = harness.connect();
    EXPECT_EQ(answer(third)["error"]["data"]["kind"], "resource_exhausted");
    EXPECT_TRUE(is_closed(third));
    EXPECT_EQ(harness.server->counts().refused, 1u);
    harness.rig.release();
    EXPECT_EQ(answer(first)["id"], 1);
    EXPECT_TRUE(harness.client().call("world.status"));
}

TEST(ControlServer, ANewClientTakesThePlaceOfTheOneThatHasBeenIdleLongest) {
    ControlLimits limits;
    limits.connections = 2;
    ServerHarness harness(limits);
    auto oldest = harness.client();
    ASSERT_TRUE(oldest.call("world.status"));
    auto used = harness.connect();
    ASSERT_TRUE(used.send(request(1, "world.status"), soon()));
    EXPECT_EQ(answer(used)["id"], 1);
    EXPECT_TRUE(harness.client().call("world.status"));
    EXPECT_EQ(harness.server->counts().displaced, 1u);
    EXPECT_FALSE(oldest.is_usable());
    ASSERT_TRUE(used.send(request(2, "world.status"), soon()));
    EXPECT_EQ(answer(used)["id"], 2);
}

TEST(ControlServer, ConnectionsOverTcpTakeNoPlaceOfTheOwnersSocket) {
    ControlLimits limits;
    limits.connections = 2;
    limits.unauthorized_connections = 2;
    ServerHarness harness(limits, true, "correct-token");
    harness.rig.hold_steps();
    std::vector<client::LineSocket> remote;
    for (int i = 0; i < 2; ++i) {
        remote.push_back(harness.connect_tcp());
        ASSERT_TRUE(remote.back().send(
            request(1, "auth", R"({"token":"correct-token"})") + "\n" + request(2, "world.step", R"({"seconds":1})"),
            soon()));
    }
    ASSERT_TRUE(eventually([&] { return harness.rig.held() == 2; }));
    EXPECT_TRUE(harness.client().call("world.status"));
    // Nor is there one more for who has the token, while all are in use.
    const client::Endpoint endpoint{.unix_path = {}, .host = "127.0.0.1", .port = harness.server->tcp_port()};
    EXPECT_EQ(client::RpcClient::connect({.endpoint = endpoint, .token = "correct-token"}).error().kind,
              ErrorKind::resource_exhausted);
    harness.rig.release();
}

TEST(ControlServer, StrangersCannotKeepOutWhoHasTheToken) {
    ControlLimits limits;
    limits.unauthorized_connections = 2;
    ServerHarness harness(limits, true, "correct-token");
    std::vector<client::LineSocket> silent;
    for (int i = 0; i < 5; ++i) silent.push_back(harness.connect_tcp());
    const client::Endpoint endpoint{.unix_path = {}, .host = "127.0.0.1", .port = harness.server->tcp_port()};
    EXPECT_TRUE(client::RpcClient::connect({.endpoint = endpoint, .token = "correct-token"})->call("world.status"));
    EXPECT_TRUE(is_closed(silent.front()));
    EXPECT_EQ(harness.server->counts().refused, 0u);
}

TEST(ControlServer, AWrongTokenIsCountedAndAnsweredLate) {
    ControlLimits limits;
    limits.wrong_token = std::chrono::milliseconds(60);
    ServerHarness harness(limits, true, "correct-token");
    auto guesser = harness.connect_tcp();
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_TRUE(guesser.send(request(1, "auth", R"({"token":"wrong-token!!"})"), soon()));
    EXPECT_EQ(answer(guesser)["error"]["data"]["kind"], "unauthorized");
    EXPECT_GE(std::chrono::steady_clock::now() - begin, limits.wrong_token);
    EXPECT_EQ(harness.server->counts().wrong_tokens, 1u);
}

TEST(ControlServer, WhoGuessesKeepsNobodyOutWhileTheAnswerIsHeldBack) {
    ControlLimits limits;
    limits.unauthorized_connections = 2;
    limits.wrong_token = limits.authorize_time = std::chrono::hours(1);
    ServerHarness harness(limits, true, "correct-token");
    std::vector<client::LineSocket> guessers;
    for (std::uint64_t i = 0; i < 5; ++i) {
        guessers.push_back(harness.connect_tcp());
        ASSERT_TRUE(guessers.back().send(request(1, "auth", R"({"token":"wrong-token!!"})"), soon()));
        ASSERT_TRUE(eventually([&] { return harness.server->counts().wrong_tokens == i + 1; }));
    }
    const client::Endpoint endpoint{.unix_path = {}, .host = "127.0.0.1", .port = harness.server->tcp_port()};
    EXPECT_TRUE(client::RpcClient::connect({.endpoint = endpoint, .token = "correct-token"})->call("world.status"));
    EXPECT_EQ(harness.server->counts().refused, 0u);
}

// A web page can make a browser post to any port; what follows the header must not be taken for requests.
TEST(ControlServer, HttpIsRefusedBeforeItsBodyIsRead) {
    ServerHarness harness({}, true);
    auto socket = harness.connect_tcp();
    ASSERT_TRUE(socket.send("POST / HTTP/1.1\r\nHost: x\r\n\r\n" + request(1, "server.shutdown"), soon()));
    EXPECT_THAT(answer(socket)["error"]["message"].get<std::string>(), HasSubstr("not HTTP"));
    EXPECT_TRUE(is_closed(socket));
    EXPECT_EQ(harness.rpc.calls()["server.shutdown"], 0u);
}

TEST(ControlServer, TcpAsksForTheTokenAndTheUnixSocketDoesNot) {
    ServerHarness harness({}, true, "correct-token");
    EXPECT_TRUE(harness.client().call("world.status"));
    for (const std::string& first : {request(1, "world.status"), request(1, "auth", R"({"token":"wrong-token!!"})"),
                                     request(1, "auth", R"({"token":7})"), request(1, "auth"), std::string("hello"),
                                     "[" + request(1, "auth", R"({"token":"correct-token"})") + "]"}) {
        auto socket = harness.connect_tcp();
        ASSERT_TRUE(socket.send(first + "\n" + request(2, "world.pause"), soon()));
        EXPECT_EQ(answer(socket)["error"]["data"]["kind"], "unauthorized") << first;
        EXPECT_TRUE(is_closed(socket));
    }
    EXPECT_EQ(harness.rpc.calls()["world.pause"], 0u);
    auto socket = harness.connect_tcp();
    ASSERT_TRUE(
        socket.send(request(1, "auth", R"({"token":"correct-token"})") + "\n" + request(2, "world.status"), soon()));
    EXPECT_EQ(answer(socket)["result"]["authorized"], true);
    EXPECT_EQ(answer(socket)["id"], 2);
    const client::Endpoint endpoint{.unix_path = {}, .host = "127.0.0.1", .port = harness.server->tcp_port()};
    EXPECT_TRUE(client::RpcClient::connect({.endpoint = endpoint, .token = "correct-token"})->call("world.status"));
    EXPECT_EQ(client::RpcClient::connect({.endpoint = endpoint, .token = "wrong-token!!"}).error().kind,
              ErrorKind::unauthorized);
}

TEST(ControlServer, WithoutATokenAConnectionDoesNotStayAndSendsLittle) {
    ControlLimits limits;
    limits.authorize_time = std::chrono::milliseconds(50);
    limits.unauthorized_line_bytes = 100;
    ServerHarness harness(limits, true, "correct-token");
    auto silent = harness.connect_tcp();
    EXPECT_TRUE(is_closed(silent));
    auto loud = harness.connect_tcp();
    static_cast<void>(loud.send(std::string(10'000, '{'), soon()));
    EXPECT_TRUE(eventually([&] { return harness.server->counts().open == 0; }));
}

TEST(ControlServer, BeyondLoopbackATokenIsNeeded) {
    FakeRig rig;
    RpcServer rpc(RpcContext{rig, rig});
    ControlServerOptions options;
    options.host = "0.0.0.0";
    options.tcp_port = std::uint16_t{0};
    options.rpc = &rpc;
    const auto server = ControlServer::create(options);
    ASSERT_FALSE(server);
    EXPECT_THAT(server.error().message, HasSubstr("--token-file"));
    options.host = "no.such.host.invalid";
    EXPECT_FALSE(ControlServer::create(options));
}

TEST(ControlServer, TheSocketFileIsItsOwnersOnlyAndGoesAtTheEnd) {
    ServerHarness harness;
    struct stat facts{};
    ASSERT_EQ(::stat(harness.path.c_str(), &facts), 0);
    EXPECT_EQ(facts.st_mode & 0777, 0600u);
    harness.server->stop();
    EXPECT_FALSE(std::filesystem::exists(harness.path));
}

TEST(ControlServer, AnotherRigAtTheSamePathIsAnError) {
    ServerHarness harness;
    ControlServerOptions options;
    options.unix_path = harness.path;
    options.rpc = &harness.rpc;
    const auto second = ControlServer::create(options);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().kind, ErrorKind::already_exists);
    EXPECT_THAT(second.error().message, HasSubstr("another rig"));
    EXPECT_TRUE(harness.client().call("world.status"));
}

TEST(ControlServer, ASocketOfAnotherTypeThatLivesIsNotTakenAway) {
    const TemporaryFolder folder;
    const std::string path = (folder / "log").string();
    const UniqueFd living(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(living.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    FakeRig rig;
    RpcServer rpc(RpcContext{rig, rig});
    ControlServerOptions options;
    options.rpc = &rpc;
    options.unix_path = path;
    EXPECT_FALSE(ControlServer::create(options));
    EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(ControlServer, TheFileOfARigThatIsGoneIsReplacedAndOtherFilesAreNot) {
    TemporaryFolder folder;
    FakeRig rig;
    RpcServer rpc(RpcContext{rig, rig});
    ControlServerOptions options;
    options.rpc = &rpc;
    options.unix_path = (folder / "stale").string();
    {
        const UniqueFd dead(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        options.unix_path.copy(address.sun_path, sizeof address.sun_path - 1);
        ASSERT_EQ(::bind(dead.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    EXPECT_TRUE(ControlServer::create(options));
    options.unix_path = (folder / "file").string();
    std::ofstream(options.unix_path) << "precious";
    EXPECT_THAT(ControlServer::create(options).error().message, HasSubstr("no socket"));
    EXPECT_TRUE(std::filesystem::exists(options.unix_path));
    options.unix_path = (folder / "no/such/folder").string();
    EXPECT_THAT(ControlServer::create(options).error().message, HasSubstr("cannot be made"));
    options.unix_path = (folder / std::string(200, 'x')).string();
    EXPECT_EQ(ControlServer::create(options).error().kind, ErrorKind::invalid_argument);
}

TEST(ControlServer, StoppingSendsTheAnswersInWork) {
    ServerHarness harness;
    auto socket = harness.connect();
    harness.rig.hold_steps();
    ASSERT_TRUE(socket.send(request(1, "world.step", R"({"seconds":1})"), soon()));
    ASSERT_TRUE(eventually([&] { return harness.rig.held() == 1; }));
    std::thread stopper([&] { harness.server->stop(); });
    harness.rig.release();
    EXPECT_EQ(answer(socket)["id"], 1);
    EXPECT_TRUE(is_closed(socket));
    stopper.join();
}

TEST(ControlServer, StoppingDoesNotWaitForWhatNeverComes) {
    ControlLimits limits;
    limits.linger = std::chrono::milliseconds(20);
    ServerHarness harness(limits);
    harness.rig.hold_steps();
    auto socket = harness.connect();
    ASSERT_TRUE(socket.send(request(1, "world.step", R"({"seconds":1})"), soon()));
    ASSERT_TRUE(eventually([&] { return harness.rig.held() == 1; }));
    harness.server->stop();
    EXPECT_TRUE(is_closed(socket));
    harness.rig.release();
}

TEST(RpcClient, ErrorsKeepTheirKindAndTheConnectionGoesOn) {
    ServerHarness harness;
    auto client = harness.client();
    EXPECT_EQ(client.call("camera.get", {{"name", "hall"}}).error().kind, ErrorKind::not_found);
    EXPECT_EQ(client.call("camera.get", {{"nam", "hall"}}).error().kind, ErrorKind::invalid_argument);
    EXPECT_TRUE(client.call("world.status"));
}

TEST(RpcClient, AnAnswerThatDoesNotComeInTimeIsAnErrorAndEndsTheConnection) {
    ServerHarness harness;
    harness.rig.hold_steps();
    auto client = harness.client();
    const auto late = client.call("world.step", {{"seconds", 1}}, std::chrono::milliseconds(20));
    ASSERT_FALSE(late);
    EXPECT_THAT(late.error().message, HasSubstr("no answer in time"));
    EXPECT_EQ(client.call("world.status").error().kind, ErrorKind::unavailable);
    harness.rig.release();
}

TEST(RpcClient, NobodyThereIsOneClearError) {
    TemporaryFolder folder;
    const auto client = client::RpcClient::connect({.endpoint = {.unix_path = (folder / "none").string()}});
    ASSERT_FALSE(client);
    EXPECT_THAT(client.error().message, HasSubstr("camrig serve"));
}

}  // namespace
}  // namespace camrig::control
