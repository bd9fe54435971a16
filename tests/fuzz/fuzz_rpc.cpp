#include <cstdint>
#include <cstdlib>
#include <future>
#include <string_view>

#include "control/rpc/rpc_server.h"

// The JSON-RPC decoder and every method's reading of its parameters, against a rig that refuses all commands.
// What must hold: no crash, exactly one answer, and an answer that is JSON.
namespace camrig {
namespace {

class RefusingRig final : public engine::CommandPort, public stream::FrameFetcher {
public:
    void post(engine::Command command) override {
        std::visit([](auto& request) { request.done(error(ErrorKind::unavailable, "no")); }, command);
    }
    void fetch(stream::FetchRequest, std::function<void(Result<stream::MediaUnit>)> done) override {
        done(error(ErrorKind::unavailable, "no"));
    }
};

void require(bool condition) {
    if (!condition) std::abort();
}

void run(std::string_view text) {
    static RefusingRig rig;
    static control::RpcServer server(control::RpcContext{rig, rig});
    // Loading reads files named by the input, on another thread: not this target's business, and slow. Asked of the
    // decoded message, because escapes can write the name in many ways.
    for (const auto& item : control::parse_rpc(text).items)
        if (const auto* request = std::get_if<control::RpcRequest>(&item); request && request->method == "world.load")
            return;
    int answers = 0;
    const auto done = [&](const control::RpcAnswer& answer) {
        ++answers;
        const std::string reply = answer.joined();
        if (reply.empty()) return;
        require(reply.find('\n') == std::string::npos);
        require(nlohmann::json::accept(reply));
    };
    std::promise<void> started;
    if (!server.handle(text, done, control::Authority::own, {}, false, [&] { started.set_value(); }))
        started.get_future().wait();
    require(answers == 1);
}

}  // namespace
}  // namespace camrig

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    camrig::run({reinterpret_cast<const char*>(data), size});
    return 0;
}
