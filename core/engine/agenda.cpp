#include "core/engine/agenda.h"

namespace camrig::engine {

Result<void> Agenda::add(TimeNs at_ns, Command& command) {
    if (waiting_.size() >= max_waiting)
        return error(ErrorKind::resource_exhausted,
                     "at_ns: " + std::to_string(max_waiting) + " commands wait for their time already; send it later");
    waiting_.emplace(at_ns, std::move(command));
    return {};
}

Command Agenda::take() {
    Command first = std::move(waiting_.begin()->second);
    waiting_.erase(waiting_.begin());
    return first;
}

void Agenda::refuse_all(const Error& why) {
    for (auto& [at_ns, command] : std::exchange(waiting_, {}))
        std::visit([&](auto& request) { request.done(std::unexpected(why)); }, command);
}

}  // namespace camrig::engine
