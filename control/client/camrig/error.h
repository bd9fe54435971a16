#pragma once

#include <stdexcept>
#include <string>

namespace camrig::client {

/// What goes wrong, in the rig or on the way to it: the one exception of this library.
///
/// `kind` is that of the control protocol: invalid_argument, not_found, already_exists, unavailable (nobody there, gone
/// away, no answer in time), unsupported, resource_exhausted, unauthorized or internal. `what()` says what was wrong
/// and what to do.
class Error : public std::runtime_error {
public:
    Error(std::string kind, const std::string& message) : std::runtime_error(message), kind_(std::move(kind)) {}
    const std::string& kind() const noexcept { return kind_; }

private:
    std::string kind_;
};

}  // namespace camrig::client
