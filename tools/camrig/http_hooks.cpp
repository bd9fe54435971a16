#include "tools/camrig/http_hooks.h"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "control/web/page_files.h"
#include "core/truth/truth_json.h"

namespace camrig::cli {

http::HttpHooks http_hooks(control::RpcServer& rpc, control::Authority granted, engine::Engine& engine,
                           stream::WorkerPool& truth_text) {
    http::HttpHooks hooks;
    hooks.rpc = [&rpc, granted](std::string body, bool may_command, std::function<void(http::RpcText)> reply) {
        const auto done = [reply = std::move(reply)](control::RpcAnswer answer) {
            auto claims = std::make_shared<std::vector<ByteBudget::Claim>>(std::move(answer.claims));
            reply({std::move(answer.pieces), std::move(claims)});
        };
        rpc.handle(body, done, may_command ? granted : control::Authority::look);
    };
    hooks.stats = [&engine](std::function<void(stream::RigReport)> reply) {
        engine.post(engine::Request<engine::GetStats>{{}, [reply = std::move(reply)](Result<stream::RigReport> report) {
                                                          reply(report ? std::move(*report) : stream::RigReport{});
                                                      }});
    };
    hooks.truth = [&engine, &truth_text](std::string camera, TimeNs min_ns,
                                         std::function<void(Result<std::string>)> reply) {
        engine.post(engine::Request<engine::GetTruth>{
            {std::move(camera), min_ns}, [&truth_text, reply = std::move(reply)](Result<truth::TruthRef> truth) {
                if (!truth) return reply(std::unexpected(truth.error()));
                std::function<void()> job = [reply, truth = std::move(*truth)] {
                    reply(truth_to_json(*truth).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
                };
                if (!truth_text.post(std::move(job))) job();
            }});
    };
    hooks.files = [](std::string_view path) -> std::optional<http::StaticFile> {
        const auto file = control::page_file(path);
        if (!file) return std::nullopt;
        return http::StaticFile{std::string(file->content_type), std::make_shared<const std::string>(file->text)};
    };
    return hooks;
}

}  // namespace camrig::cli
