#include "control/rpc/json_rpc.h"

#include <gmock/gmock.h>

#include "tests/unit/control/rpc_harness.h"

namespace camrig::control {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

json error_of(const std::string& text) {
    return json::parse(text).at("error");
}

TEST(JsonRpc, TextThatIsNoJsonIsAParseErrorWithNullId) {
    RpcHarness rpc;
    for (const char* text : {"{", "hello", "{\"a\":NaN}", "\xff\xfe{}", "{} {}", "{\"a\":1,\"a\":2}", "[1e999]"}) {
        const json reply = json::parse(rpc.handle(text));
        EXPECT_EQ(reply["error"]["code"], -32700) << text;
        EXPECT_TRUE(reply["id"].is_null()) << text;
        EXPECT_EQ(reply["error"]["data"]["kind"], "invalid_argument") << text;
    }
}

TEST(JsonRpc, WhatIsNoRequestIsAnInvalidRequestThatSaysWhatIsWrong) {
    RpcHarness rpc;
    const std::pair<const char*, const char*> cases[] = {
        {"1", "a request is an object"},
        {"[]", "the batch is empty"},
        {R"({"id":1,"method":"x"})", "jsonrpc: must be \"2.0\""},
        {R"({"jsonrpc":"1.0","id":1,"method":"x"})", "jsonrpc: must be \"2.0\""},
        {R"({"jsonrpc":"2.0","id":1})", "method: must be"},
        {R"({"jsonrpc":"2.0","id":1,"method":7})", "method: must be"},
        {R"({"jsonrpc":"2.0","id":{},"method":"x"})", "id: must be"},
        {R"({"jsonrpc":"2.0","id":[1],"method":"x"})", "id: must be"},
        {R"({"jsonrpc":"2.0","id":true,"method":"x"})", "id: must be"},
        {R"({"jsonrpc":"2.0","id":1,"method":"x","parmas":{}})", "parmas"},
    };
    for (const auto& [text, words] : cases) {
        const json error = error_of(rpc.handle(text));
        EXPECT_EQ(error["code"], -32600) << text;
        EXPECT_THAT(error["message"].get<std::string>(), HasSubstr(words)) << text;
    }
}

TEST(JsonRpc, ParametersByPositionAreRefusedWithAHint) {
    RpcHarness rpc;
    for (const char* params : {"[\"lobby\"]", "[]", "7", "null"}) {
        const json error = error_of(
            rpc.handle(R"({"jsonrpc":"2.0","id":1,"method":"camera.get","params":)" + std::string(params) + "}"));
        EXPECT_EQ(error["code"], -32602) << params;
        EXPECT_THAT(error["message"].get<std::string>(), HasSubstr("parameters go by name")) << params;
    }
}

// In a batch too: each request of it is looked at by itself.
TEST(JsonRpc, WhoMayOnlyLookIsToldHowToCommandAndChangesNothing) {
    RpcHarness rpc;
    for (const Method& method : rpc.server.methods()) {
        const json request{
            {"jsonrpc", "2.0"}, {"id", 1}, {"method", method.name}, {"params", json::parse(method.example)}};
        const json reply = json::parse(rpc.handle("[" + request.dump() + "]", Authority::look)).at(0);
        const bool is_refused =
            reply.contains("error") && reply["error"]["data"]["kind"] == "unauthorized" && method.name != "auth";
        const auto verb = method.name.substr(method.name.find('.') + 1);
        const bool only_asks = verb == "get" || verb == "list" || verb == "status" || verb == "info" ||
                               verb == "describe" || verb == "network" || verb == "log" ||
                               method.name == "event.wait" || method.name == "auth";
        EXPECT_EQ(is_refused, !only_asks) << method.name << ": " << reply.dump();
        if (is_refused) {
            EXPECT_EQ(reply["error"]["message"], method.name + ": this is how to command");
        }
    }
    EXPECT_EQ(rpc.shutdowns, 0);
}

TEST(JsonRpc, UnknownMethodsAreNotFound) {
    RpcHarness rpc;
    const json error = error_of(rpc.handle(R"({"jsonrpc":"2.0","id":1,"method":"camera.fly"})"));
    EXPECT_EQ(error["code"], -32601);
    EXPECT_EQ(error["data"]["kind"], "not_found");
    EXPECT_THAT(error["message"].get<std::string>(), HasSubstr("camera.fly"));
}

TEST(JsonRpc, IdsComeBackAsTheyWere) {
    RpcHarness rpc;
    for (const char* id : {"1", "-3", "0.5", "\"a\\nb\"", "null", "18446744073709551615"}) {
        const std::string request = R"({"jsonrpc":"2.0","method":"world.status","id":)" + std::string(id) + "}";
        EXPECT_THAT(rpc.handle(request), StartsWith(R"({"jsonrpc":"2.0","id":)" + std::string(id) + R"(,"result")"));
    }
}

TEST(JsonRpc, NotificationsAreExecutedAndNeverAnswered) {
    RpcHarness rpc;
    EXPECT_EQ(rpc.handle(R"({"jsonrpc":"2.0","method":"world.pause"})"), "");
    EXPECT_EQ(rpc.result("world.status", "{}")["paused"], true);
    EXPECT_EQ(rpc.handle(R"({"jsonrpc":"2.0","method":"no.such"})"), "");
    EXPECT_EQ(rpc.handle(R"({"jsonrpc":"2.0","method":"camera.get","params":{}})"), "");
    // Nor is one with parameters by position, also of a batch; what is no request is.
    EXPECT_EQ(rpc.handle(R"({"jsonrpc":"2.0","method":"world.resume","params":[1]})"), "");
    EXPECT_EQ(rpc.handle(R"([{"jsonrpc":"2.0","method":"world.resume","params":[]}])"), "");
    EXPECT_EQ(rpc.result("world.status", "{}")["paused"], true);
    EXPECT_EQ(error_of(rpc.handle(R"({"jsonrpc":"2.0","method":7})"))["code"], -32600);
    EXPECT_EQ(error_of(rpc.handle(R"({"jsonrpc":"2.0","id":1,"method":"world.resume","params":[1]})"))["code"], -32602);
}

TEST(JsonRpc, BatchesAreAnsweredInOneArrayInTheirOrder) {
    RpcHarness rpc;
    const json reply = json::parse(rpc.handle(
        R"([{"jsonrpc":"2.0","id":"a","method":"world.status"}, 1, {"jsonrpc":"2.0","method":"world.pause"},
            {"jsonrpc":"2.0","id":"b","method":"no.such"}])"));
    ASSERT_EQ(reply.size(), 3u);
    EXPECT_EQ(reply[0]["id"], "a");
    EXPECT_EQ(reply[1]["error"]["code"], -32600);
    EXPECT_EQ(reply[2]["id"], "b");
    EXPECT_EQ(reply[2]["error"]["code"], -32601);
    EXPECT_EQ(rpc.handle(R"([{"jsonrpc":"2.0","method":"world.pause"}])"), "");
}

TEST(JsonRpc, ABatchHasABound) {
    RpcHarness rpc;
    json batch = json::array();
    for (std::size_t i = 0; i <= max_batch; ++i)
        batch.push_back({{"jsonrpc", "2.0"}, {"id", i}, {"method", "world.status"}});
    EXPECT_EQ(error_of(rpc.handle(batch.dump()))["code"], -32600);
    batch.erase(batch.begin());
    EXPECT_EQ(json::parse(rpc.handle(batch.dump())).size(), max_batch);
}

TEST(JsonRpc, MessagesHaveABound) {
    RpcHarness rpc;
    const json error = error_of(rpc.handle(std::string(max_request_bytes + 1, ' ')));
    EXPECT_EQ(error["data"]["kind"], "resource_exhausted");
}

TEST(JsonRpc, BytesThatAreNoUtf8InAMessageDoNotStopTheAnswer) {
    const std::string text = rpc_error({rpc_code::application, {ErrorKind::internal, "half \xc3"}, nullptr});
    EXPECT_TRUE(json::accept(text));
}

TEST(JsonRpc, LargeDataIsTheLastMemberOfTheResult) {
    EXPECT_EQ(rpc_result(1, RpcResult(json{{"a", 1}}, "QUJD")).joined(),
              R"({"jsonrpc":"2.0","id":1,"result":{"a":1,"data":"QUJD"}})");
    EXPECT_EQ(rpc_result("x", RpcResult(json{{"a", 1}})).joined(), R"({"jsonrpc":"2.0","id":"x","result":{"a":1}})");
}

}  // namespace
}  // namespace camrig::control
