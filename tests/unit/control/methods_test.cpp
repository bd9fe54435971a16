#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <map>
#include <set>
#include <thread>

#include <gmock/gmock.h>

#include "control/rpc/generated_files.h"
#include "core/base/base64.h"
#include "tests/unit/control/rpc_harness.h"

namespace camrig::control {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* lobby = R"({"name":"lobby","size":[64,48],"ptz":{"preset":"ideal"}})";

/// Runs the example that stands in the table, on a rig that has what it speaks of.
json run_example(RpcHarness& rpc, const Method& method) {
    json params = json::parse(method.example);
    if (method.name == "auth") params["token"] = "correct-token";
    if (method.name != "camera.create") rpc.result("camera.create", lobby);
    if (method.name == "ptz.preset_goto" || method.name == "ptz.preset_remove")
        rpc.result("ptz.preset_set", R"({"camera":"lobby","preset":"door"})");
    return rpc.call(method.name, params);
}

// A method that is never run in the unit tests cannot be in the table: its example is the test.
TEST(MethodTable, EveryMethodRunsItsExample) {
    for (const Method& method : documented_methods()) {
        RpcHarness rpc;
        const json reply = run_example(rpc, method);
        EXPECT_TRUE(reply.contains("result")) << method.name << ": " << reply.dump();
        EXPECT_GE(rpc.server.calls().at(method.name), 1u) << method.name;
        EXPECT_FALSE(method.summary.empty()) << method.name;
    }
}

TEST(MethodTable, ResultsHaveTheFieldsThatAreDocumentedAndNoOthers) {
    for (const Method& method : documented_methods()) {
        RpcHarness rpc;
        const json result = run_example(rpc, method)["result"];
        std::set<std::string> documented;
        for (const Field& field : method.result) {
            documented.insert(field.name);
            const bool is_always_there = method.name != "server.info" && field.name != "pixels";
            EXPECT_TRUE(!is_always_there || result.contains(field.name)) << method.name << " gives no " << field.name;
        }
        for (const auto& [key, value] : result.items())
            EXPECT_TRUE(documented.contains(key)) << method.name << " does not document " << key;
    }
}

TEST(MethodTable, EveryParameterIsReadAndCheckedByItsMethod) {
    for (const Method& method : documented_methods()) {
        for (const Field& field : method.params) {
            RpcHarness rpc;
            json params = json::parse(method.example);
            params[field.name] = json::parse("[[]]");
            const json reply = rpc.call(method.name, params);
            ASSERT_TRUE(reply.contains("error")) << method.name << " takes anything as " << field.name;
            EXPECT_EQ(reply["error"]["code"], -32602);
            EXPECT_THAT(reply["error"]["message"].get<std::string>(),
                        AllOf(StartsWith(field.name), testing::Not(HasSubstr("unknown key"))))
                << method.name;
        }
    }
}

TEST(MethodTable, UnknownAndMissingParametersAreNamed) {
    RpcHarness rpc;
    for (const Method& method : documented_methods()) {
        json params = json::parse(method.example);
        params["nonsense"] = 1;
        const json reply = rpc.call(method.name, params);
        ASSERT_TRUE(reply.contains("error")) << method.name;
        EXPECT_EQ(reply["error"]["code"], -32602) << method.name;
        EXPECT_THAT(reply["error"]["message"].get<std::string>(), HasSubstr("nonsense")) << method.name;
        for (const Field& field : method.params) {
            if (!field.required) continue;
            params = json::parse(method.example);
            params.erase(field.name);
            EXPECT_THAT(rpc.failure(method.name, params.dump()),
                        AllOf(StartsWith("-32602 invalid_argument"), HasSubstr("'" + field.name + "' is missing")));
        }
    }
}

std::string text_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(GeneratedFiles, AreUpToDate) {
    for (const GeneratedFile& generated : generated_files()) {
        const std::string text = text_of(generated.path);
        const auto made = generated.make(text);
        ASSERT_TRUE(made) << generated.path << ": " << made.error().message;
        EXPECT_TRUE(*made == text) << generated.path
                                   << " differs from the tables; make it anew: camrig methods --write .";
    }
}

TEST(GeneratedFiles, AFileWithoutItsMarksIsRefusedAndNotOverwritten) {
    EXPECT_FALSE(scene_format_tables("# no marks\n"));
    EXPECT_FALSE(scene_schema("{}"));
    EXPECT_FALSE(scene_schema("no JSON"));
}

/// The sources of a folder as one text.
std::string sources_in(const char* folder) {
    std::string all;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".cpp" || entry.path().extension() == ".py") all += text_of(entry.path());
    return all;
}

// What only those need who write a client of their own, or the web page; `camrig call` and Rig::call reach it.
TEST(MethodTable, EveryMethodIsInBothClientsAndOnTheCommandLine) {
    const std::set<std::string> by_call_only{"auth",         "server.info", "server.describe", "server.shutdown",
                                             "scene.check",  "world.limit", "world.digest",    "rig.identity",
                                             "plate.project"};
    const std::set<std::string> needs_no_rig{"plate.calibrate", "plate.light"};  // on the command line
    for (const char* folder : {"control/client", "control/python/camrig", "tools/camrig"}) {
        const std::string sources = sources_in(folder);
        for (const Method& method : documented_methods()) {
            if (by_call_only.contains(method.name)) continue;
            if (folder == std::string("tools/camrig") && needs_no_rig.contains(method.name)) continue;
            EXPECT_TRUE(sources.contains('"' + method.name + '"')) << method.name << " is not in " << folder;
        }
    }
}

TEST(ServerMethods, DescribeTellsEveryParameterOfACamera) {
    RpcHarness rpc;
    const json camera = rpc.result("camera.create", lobby);
    const json described = rpc.result("server.describe", "{}");
    EXPECT_EQ(described["methods"].size(), documented_methods().size());
    std::map<std::string, json> fields;
    for (const json& field : described["objects"]["camera"]) fields[field["name"]] = field;
    for (const auto& [name, value] : camera.items()) EXPECT_TRUE(fields.contains(name)) << name;
    EXPECT_EQ(fields["zoom"]["minimum"], 1);
    EXPECT_EQ(fields["zoom"]["maximum"], 10);
    EXPECT_EQ(fields["near"]["exclusive_minimum"], 0);
    EXPECT_EQ(fields["quality"]["choices"], json({"fast", "simple", "beautiful"}));
    EXPECT_EQ(fields["quality"]["null"], "the rig's");
    EXPECT_EQ(fields["antialias"]["default"], "auto");
    EXPECT_EQ(fields["controls"]["fields"][1]["name"], "exposure_ev");
    EXPECT_EQ(fields["id"]["by"], "rig");
    std::map<std::string, json> faults;
    for (const json& kind : described["kinds"]["fault"]) faults[kind["name"]] = kind["fields"];
    EXPECT_EQ(faults["packet_loss"][0]["default"], "0.1");
}

TEST(MethodTable, WithoutARigEveryMethodIsUnavailable) {
    for (const Method& method : documented_methods()) {
        if (method.name.starts_with("server.") || method.name == "auth") continue;
        if (method.name == "world.load" || method.name == "scene.check") continue;  // they read files first
        if (method.name.starts_with("plate.")) continue;                            // they ask nothing of it
        std::optional<ErrorKind> kind;
        method.handler(json::parse(method.example), [&](Result<RpcResult> result) {
            if (!result) kind = result.error().kind;
        });
        EXPECT_EQ(kind, ErrorKind::unavailable) << method.name;
    }
}

TEST(CameraMethods, ErrorsCarryTheirKind) {
    RpcHarness rpc;
    EXPECT_EQ(rpc.result("camera.create", lobby)["size"], json({64, 48}));
    EXPECT_THAT(rpc.failure("camera.create", lobby), StartsWith("-32000 already_exists"));
    EXPECT_THAT(rpc.failure("camera.get", R"({"name":"hall"})"), StartsWith("-32000 not_found"));
    EXPECT_THAT(rpc.failure("camera.set", R"({"name":"hall","fps":5})"), StartsWith("-32000 not_found"));
    EXPECT_THAT(rpc.failure("camera.delete", R"({"name":"hall"})"), StartsWith("-32000 not_found"));
    EXPECT_THAT(rpc.failure("camera.create", R"({"name":"b","place":"nowhere"})"), StartsWith("-32000 not_found"));
    EXPECT_THAT(rpc.failure("camera.create", R"({"name":"No Name"})"), StartsWith("-32602 invalid_argument name"));
    EXPECT_THAT(rpc.failure("camera.create", R"({"name":"b","size":[15,16]})"),
                StartsWith("-32602 invalid_argument size"));
    EXPECT_THAT(rpc.failure("camera.create", R"({"name":"b","fps":1001})"), StartsWith("-32602 invalid_argument fps"));
    EXPECT_THAT(rpc.failure("camera.create", R"({"name":"b","vfov_deg":60,"hfov_deg":60})"), HasSubstr("only one"));
    EXPECT_THAT(rpc.failure("camera.create", R"({"name":"b","pose":{"position":[0,0,0],"look_at":[0,0,0]}})"),
                StartsWith("-32602 invalid_argument pose"));
    EXPECT_THAT(rpc.failure("camera.set", R"({"name":"lobby","outputs":[{"kind":"smoke"}]})"),
                HasSubstr("outputs[0].kind"));
}

TEST(CameraMethods, SetChangesOnlyWhatIsGiven) {
    RpcHarness rpc;
    rpc.result("camera.create", R"({"name":"lobby","size":[64,48],"fps":"30000/1001","code_strip":false})");
    const json camera = rpc.result("camera.set", R"({"name":"lobby","near":0.5})");
    EXPECT_EQ(camera["near"], 0.5);
    EXPECT_EQ(camera["fps"], "30000/1001");
    EXPECT_EQ(camera["size"], json({64, 48}));
}

TEST(CameraMethods, ListGivesEachAsGetDoes) {
    RpcHarness rpc;
    rpc.result("camera.create", lobby);
    EXPECT_EQ(rpc.result("camera.list", "{}")["cameras"],
              json::array({rpc.result("camera.get", R"({"name":"lobby"})")}));
}

TEST(WorldMethods, SecondsBecomeTheNanosecondsThatTheyRead) {
    RpcHarness rpc;
    const std::pair<const char*, TimeNs> cases[] = {{"0.2", 200'000'000},
                                                    {"0.1", 100'000'000},
                                                    {"0.3", 300'000'000},
                                                    {"1e-9", 1},
                                                    {"0.000000001", 1},
                                                    {"1.1", 1'100'000'000},
                                                    {"0", 0},
                                                    {"-0.0", 0},
                                                    {"86400", 86'400'000'000'000},
                                                    {"4e-10", 0},
                                                    {"6e-10", 1},
                                                    {"12345.678901234", 12'345'678'901'234},
                                                    {"0.033333333", 33'333'333},
                                                    {"86399.999999999", 86'399'999'999'999}};
    for (const auto& [seconds, expected] : cases) {
        rpc.result("world.step", "{\"seconds\":" + std::string(seconds) + "}");
        EXPECT_EQ(rpc.rig.last_step_ns(), expected) << seconds;
    }
}

TEST(WorldMethods, StepsBackwardsTooFarOrUnclearAreRefused) {
    RpcHarness rpc;
    for (const char* params :
         {"{}", R"({"seconds":1,"nanoseconds":1})", R"({"seconds":-1e-9})", R"({"seconds":86400.1})",
          R"({"seconds":"1"})", R"({"seconds":null})", R"({"nanoseconds":-1})", R"({"nanoseconds":1.5})",
          R"({"nanoseconds":86400000000001})", R"({"nanoseconds":18446744073709551615})",
          R"({"seconds":1,"timeout_s":0})", R"({"seconds":1,"timeout_s":3601})"})
        EXPECT_THAT(rpc.failure("world.step", params), StartsWith("-32602 invalid_argument")) << params;
    EXPECT_EQ(rpc.rig.last_step_ns(), -1);
}

TEST(WorldMethods, LoadErrorsNameTheFile) {
    RpcHarness rpc;
    EXPECT_THAT(rpc.failure("world.load", R"({"scene":"scenes/none.json"})"), HasSubstr("scenes/none.json"));
    EXPECT_THAT(rpc.failure("world.load", R"({"scene":"a\u0000b"})"), HasSubstr("zero byte"));
    EXPECT_EQ(rpc.result("world.load", R"({"scene":"scenes/minimal.json"})")["scene"], "minimal");
}

TEST(WorldMethods, LoadingWhileTheRigEndsIsAnswered) {
    RpcHarness rpc;
    rpc.server.stop();
    EXPECT_TRUE(rpc.call("world.load", {{"scene", "scenes/minimal.json"}}).contains("error"));
}

TEST(FrameMethods, PicturesComeInBase64WithTheirInstant) {
    RpcHarness rpc;
    rpc.result("camera.create", lobby);
    const json frame = rpc.result("frame.get", R"({"camera":"lobby"})");
    EXPECT_EQ(frame["data"], "q6ur");
    EXPECT_EQ(frame["encoding"], "base64");
    EXPECT_EQ(frame["format"], "jpeg");
    EXPECT_EQ(frame["kind"], "color");
    EXPECT_EQ(frame["sequence"], 4);
    EXPECT_EQ(frame["time_ns"], 160'000'000);
    EXPECT_EQ(frame["size"], json({64, 48}));
    EXPECT_EQ(rpc.rig.last_fetch().format.quality, codec::default_jpeg_quality);
    EXPECT_FALSE(frame.contains("pixels"));
    EXPECT_EQ(rpc.result("frame.get", R"({"camera":"lobby","format":"raw"})")["pixels"], "rgba8");
}

TEST(FrameMethods, QualityTimeAndLayoutReachTheRig) {
    RpcHarness rpc;
    rpc.result("camera.create", lobby);
    rpc.result("frame.get", R"({"camera":"lobby","format":"raw","pixels":"bgr24"})");
    EXPECT_EQ(rpc.rig.last_fetch().format.pixels, frame::PixelFormat::bgr24);
    rpc.result("frame.get", R"({"camera":"lobby","quality":55,"min_ns":123})");
    EXPECT_EQ(rpc.rig.last_fetch().format.quality, 55);
    EXPECT_EQ(rpc.rig.last_fetch().min_ns, 123);
}

TEST(FrameMethods, WrongRequestsAreRefused) {
    RpcHarness rpc;
    rpc.result("camera.create", lobby);
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","kind":"smell"})"),
                StartsWith("-32602 invalid_argument kind"));
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","format":"gif"})"),
                StartsWith("-32602 invalid_argument format"));
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","quality":0})"),
                StartsWith("-32602 invalid_argument quality"));
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","format":"png","quality":9})"), HasSubstr("only jpeg"));
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","kind":"depth"})"), StartsWith("-32000 unsupported"));
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","format":"raw","pixels":"nv12"})"),
                StartsWith("-32602 invalid_argument pixels"));
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","pixels":"bgr24"})"), HasSubstr("raw"));
    // Here by HTTP, as it were.
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","encoding":"bytes"})"), HasSubstr("control socket"));
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"hall"})"), StartsWith("-32000 not_found"));
}

TEST(FrameMethods, PicturesTooLargeForALineSayWhereToGetThem) {
    RpcHarness rpc;
    rpc.result("camera.create", lobby);
    rpc.rig.set_picture_bytes(max_frame_bytes + 1);
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby"})"),
                AllOf(StartsWith("-32000 resource_exhausted"), HasSubstr("snapshot.png")));
}

std::string batch_of(int size, const std::string& params) {
    json batch = json::array();
    for (int id = 0; id < size; ++id)
        batch.push_back({{"jsonrpc", "2.0"}, {"id", id}, {"method", "frame.get"}, {"params", json::parse(params)}});
    return batch.dump();
}

// 64 raw pictures of 48 MiB in one request must not cost 4 GiB.
TEST(FrameMethods, WhatABatchCannotHoldIsRefusedBeforeItIsDrawn) {
    ControlLimits limits;
    limits.reply_bytes = 3 * base64_size(64 * 48 * 4);
    RpcHarness rpc(limits);
    rpc.result("camera.create", R"({"name":"lobby","size":[64,48]})");
    const json answers = json::parse(rpc.handle(batch_of(6, R"({"camera":"lobby","format":"raw"})")));
    ASSERT_EQ(answers.size(), 6u);
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(answers[i]["id"], i);
        ASSERT_EQ(answers[i].contains("result"), i < 3) << answers[i].dump();
        if (i < 3) continue;
        EXPECT_EQ(answers[i]["error"]["data"]["kind"], "resource_exhausted");
        EXPECT_THAT(answers[i]["error"]["message"].get<std::string>(), HasSubstr("one at a time"));
    }
    EXPECT_EQ(rpc.rig.pictures(), 3);
    // The next request begins anew, and nothing is counted for answers that are gone.
    EXPECT_EQ(json::parse(rpc.handle(batch_of(3, R"({"camera":"lobby","format":"raw"})")))[2].contains("result"), true);
    EXPECT_EQ(rpc.server.budget()->used(), 0u);
}

TEST(FrameMethods, EncodedPicturesOfABatchCountWithTheBytesTheyHave) {
    ControlLimits limits;
    limits.reply_bytes = 3 * base64_size(1000);
    RpcHarness rpc(limits);
    rpc.result("camera.create", R"({"name":"lobby","size":[64,48]})");
    rpc.rig.set_picture_bytes(1000);
    const json answers = json::parse(rpc.handle(batch_of(6, R"({"camera":"lobby","format":"jpeg"})")));
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(answers[i].contains("result"), i < 3) << i;
    EXPECT_EQ(rpc.server.budget()->used(), 0u);
}

TEST(FrameMethods, PicturesUnderWayHaveABoundForAllClientsTogether) {
    ControlLimits limits;
    limits.total_reply_bytes = 64 * 48 * 4 - 1;
    RpcHarness rpc(limits);
    rpc.result("camera.create", R"({"name":"lobby","size":[64,48]})");
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby"})"),
                AllOf(StartsWith("-32000 resource_exhausted"), HasSubstr("under way")));
    EXPECT_EQ(rpc.rig.pictures(), 0);
}

TEST(FrameMethods, ARawPictureThatIsTooLargeIsRefusedBeforeItIsDrawn) {
    RpcHarness rpc;
    rpc.result("camera.create", R"({"name":"lobby","size":[8192,8192]})");
    EXPECT_THAT(rpc.failure("frame.get", R"({"camera":"lobby","format":"raw"})"),
                AllOf(StartsWith("-32000 resource_exhausted"), HasSubstr("snapshot.png")));
    EXPECT_EQ(rpc.rig.pictures(), 0);
}

TEST(RpcServer, AnAnswerOfAnyMethodHasABound) {
    ControlLimits limits;
    limits.reply_bytes = 200;
    RpcHarness rpc(limits);
    EXPECT_THAT(rpc.failure("server.info", "{}"), StartsWith("-32000 resource_exhausted"));
    EXPECT_EQ(rpc.result("world.pause", "{}").contains("error"), true);
}

TEST(ServerMethods, InfoListsMethodsCallsAndLimits) {
    RpcHarness rpc;
    rpc.result("world.status", "{}");
    const json info = rpc.result("server.info", "{}");
    EXPECT_EQ(info["methods"].size(), documented_methods().size());
    EXPECT_EQ(info["calls"]["world.status"], 1);
    EXPECT_EQ(info["calls"]["camera.get"], 0);
    EXPECT_EQ(info["limits"]["line_bytes"], 1 << 20);
    EXPECT_EQ(info["version"], "1.2.3");
}

TEST(ServerMethods, ShutdownIsAskedForAfterTheAnswer) {
    RpcHarness rpc;
    EXPECT_EQ(rpc.result("server.shutdown", "{}")["stopping"], true);
    EXPECT_EQ(rpc.shutdowns, 1);
}

TEST(ServerMethods, AuthTellsRightFromWrong) {
    RpcHarness rpc;
    EXPECT_EQ(rpc.result("auth", R"({"token":"correct-token"})")["authorized"], true);
    EXPECT_THAT(rpc.failure("auth", R"({"token":"wrong-token"})"), StartsWith("-32000 unauthorized"));
}

// An engine that goes down with requests in its queue must not leave clients waiting.
TEST(RpcServer, ARequestThatNobodyAnswersIsAnsweredUnavailable) {
    RpcHarness rpc;
    rpc.rig.drop_commands();
    EXPECT_THAT(rpc.failure("world.status", "{}"), StartsWith("-32000 unavailable"));
}

// All of its message, in order, by the thread that reads the files.
TEST(RpcServer, AMessageWithABackdropIsStartedByAnotherThread) {
    RpcHarness rpc;
    rpc.result("camera.create", lobby);
    const std::string batch =
        R"([{"jsonrpc":"2.0","id":1,"method":"camera.set","params":{"name":"lobby","backdrop":{"file":"/none.png"}}},)"
        R"({"jsonrpc":"2.0","id":2,"method":"camera.delete","params":{"name":"lobby"}}])";
    std::thread::id by;
    std::promise<std::string> answered;
    std::promise<void> started;
    const auto done = [&](const RpcAnswer& answer) {
        by = std::this_thread::get_id();
        answered.set_value(answer.joined());
    };
    EXPECT_FALSE(rpc.server.handle(batch, done, Authority::own, {}, false, [&] { started.set_value(); }));
    started.get_future().wait();
    const json answers = json::parse(answered.get_future().get());
    EXPECT_THAT(answers[0]["error"]["message"].get<std::string>(), HasSubstr("/none.png"));
    EXPECT_TRUE(answers[1].contains("result")) << answers.dump();
    EXPECT_NE(by, std::this_thread::get_id());
}

TEST(RpcServer, AMessageWithABackdropIsAnsweredUnavailableOnceTheServerHasStopped) {
    RpcHarness rpc;
    rpc.server.stop();
    EXPECT_THAT(rpc.failure("camera.set", R"({"name":"lobby","backdrop":{"file":"/none.png"}})"),
                StartsWith("-32000 unavailable"));
}

TEST(RpcServer, AnswersMayComeAfterTheServerIsGone) {
    FakeRig rig;
    rig.hold_steps();
    std::string reply;
    {
        RpcServer server(RpcContext{rig, rig});
        server.handle(R"({"jsonrpc":"2.0","id":1,"method":"world.step","params":{"seconds":1}})",
                      [&](const RpcAnswer& answer) { reply = answer.joined(); });
    }
    rig.release();
    EXPECT_THAT(reply, HasSubstr("\"world_ns\":1000000000"));
}

}  // namespace
}  // namespace camrig::control
