#pragma once

#include <filesystem>
#include <fstream>
#include <future>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "control/rpc/rpc_server.h"
#include "tests/temporary_folder.h"
#include "tests/unit/control/fake_rig.h"

namespace camrig::control {

/// An RPC server on a fake rig, asked and answered in this thread.
struct RpcHarness {
    explicit RpcHarness(ControlLimits chosen = {}) : limits(chosen) {}

    ControlLimits limits;
    FakeRig rig;
    int shutdowns = 0;
    const TemporaryFolder folder;  ///< of the log of commands, which is empty
    RpcServer server{context()};

    std::string handle(std::string_view text, Authority authority = Authority::own) {
        auto answered = std::make_shared<std::promise<std::string>>();
        auto answer = answered->get_future();
        const auto done = [answered](RpcAnswer reply) {
            std::string line = reply.joined();
            reply = {};  // what it claimed is free before anybody looks
            answered->set_value(std::move(line));
        };
        server.handle(text, done, authority);
        return answer.get();
    }
    RpcContext context() {
        RpcContext made{rig,
                        rig,
                        [] { return nlohmann::json{{"version", "1.2.3"}, {"pid", 1}}; },
                        [this] { ++shutdowns; },
                        "correct-token",
                        limits,
                        "this is how to command"};
        const std::filesystem::path log = folder / "log";
        std::ofstream{log};
        made.log = [log] { return LogPlace{log, 0}; };
        return made;
    }
    nlohmann::json call(std::string_view method, const nlohmann::json& params) {
        const nlohmann::json request{{"jsonrpc", "2.0"}, {"id", 1}, {"method", method}, {"params", params}};
        return nlohmann::json::parse(handle(request.dump()));
    }
    nlohmann::json result(std::string_view method, std::string_view params) {
        const nlohmann::json reply = call(method, nlohmann::json::parse(params));
        return reply.contains("result") ? reply["result"] : reply;
    }
    /// "-32602 invalid_argument near: must be ..."
    std::string failure(std::string_view method, std::string_view params) {
        const nlohmann::json reply = call(method, nlohmann::json::parse(params));
        if (!reply.contains("error")) return "no error: " + reply.dump();
        const nlohmann::json& error = reply["error"];
        return std::to_string(error["code"].get<int>()) + " " + error["data"]["kind"].get<std::string>() + " " +
               error["message"].get<std::string>();
    }
};

}  // namespace camrig::control
