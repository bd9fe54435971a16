// The C++ client's reader: whatever answers on the control socket, a call ends with a result or an error, and what it
// takes for a result is the answer to its own request.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include <sys/socket.h>

#include "control/client/rpc_client.h"

namespace camrig {
namespace {

void run(std::string_view answers) {
    int pair[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, pair) != 0) std::abort();
    const UniqueFd rig(pair[1]);
    client::RpcClient client(client::LineSocket(UniqueFd(pair[0]), "fuzzer"));
    // What does not fit in the socket's buffer is left out; then nothing more will come.
    static_cast<void>(::send(rig.get(), answers.data(), answers.size(), MSG_NOSIGNAL));
    ::shutdown(rig.get(), SHUT_WR);
    const auto lines = std::ranges::count(answers, '\n');
    int results = 0;
    // Requests are numbered from 1: no answer is to one of them unless it carries its number.
    for (int i = 1; i <= 4; ++i) {
        if (!client.call("world.status").has_value()) continue;
        ++results;
        if (answers.find(std::to_string(i)) == std::string_view::npos) std::abort();
    }
    if (results > lines) std::abort();
}

}  // namespace
}  // namespace camrig

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    camrig::run({reinterpret_cast<const char*>(data), size});
    return 0;
}
