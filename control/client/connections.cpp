#include "control/client/connections.h"

namespace camrig::client {
namespace {

using nlohmann::json;

[[noreturn]] void raise(const camrig::Error& why) {
    throw Error(std::string(to_string(why.kind)), why.message);
}

}  // namespace

RpcClient Connections::take() {
    {
        const std::lock_guard lock(mutex_);
        while (!idle_.empty()) {
            RpcClient client = std::move(idle_.back());
            idle_.pop_back();
            if (client.is_usable()) return client;
        }
    }
    auto endpoint = Endpoint::parse(options_.control.empty() ? default_control() : options_.control);
    if (!endpoint) raise(endpoint.error());
    auto client = RpcClient::connect(
        {.endpoint = std::move(*endpoint), .token = options_.token, .connect_timeout = options_.timeout});
    if (!client) raise(client.error());
    return std::move(*client);
}

json Connections::call(std::string_view method, const json& params) {
    return call(method, params, options_.timeout);
}

json Connections::call(std::string_view method, const json& params, std::chrono::milliseconds timeout) {
    RpcClient client = take();
    auto result = client.call(method, params, timeout);
    if (client.is_usable()) {
        const std::lock_guard lock(mutex_);
        if (idle_.size() < max_idle) idle_.push_back(std::move(client));
    }
    if (!result) raise(result.error());
    return std::move(*result);
}

std::string Connections::url_of(const std::string& service) {
    json info;
    {
        const std::lock_guard lock(mutex_);
        info = info_;
    }
    if (info.is_null()) {
        info = call("server.info");
        const std::lock_guard lock(mutex_);
        info_ = info;
    }
    const int port = info.value(service, 0);
    if (port == 0) throw Error("unsupported", "this rig serves no " + service);
    // By TCP the rig is where we reached it; by its Unix socket on this machine, but maybe not on the loopback address.
    auto endpoint = Endpoint::parse(options_.control.empty() ? default_control() : options_.control);
    std::string host = endpoint && !endpoint->host.empty() ? endpoint->host : info.value("host", "");
    if (host.empty() || host == "0.0.0.0" || host == "::") host = "127.0.0.1";
    if (host.find(':') != std::string::npos) host = "[" + host + "]";
    const std::string scheme = service == "rtsp" ? info.value("rtsp_scheme", service) : service;
    return scheme + "://" + host + ":" + std::to_string(port);
}

}  // namespace camrig::client
