#pragma once

#include <expected>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/awaitable.hpp>
#include <glm/glm.hpp>

#include "core/codec/encoder.h"

namespace camrig::unrealcv {

class Session;

/// What an answer says: text, or the bytes of a file.
class Body {
public:
    Body() = default;
    Body(std::string text) : text_(std::move(text)) {}
    Body(codec::BytesRef file) : file_(std::move(file)) {}

    /// They live as long as the body.
    std::string_view bytes() const {
        return file_ ? std::string_view(reinterpret_cast<const char*>(file_->data()), file_->size()) : text_;
    }

private:
    std::string text_;
    codec::BytesRef file_;
};

/// Empty is sent as "ok". The error is sent as "error TEXT".
using Answer = std::expected<Body, std::string>;
using Arguments = std::span<const std::string_view>;

/// A command as its template tells it: "vset /camera/[uint]/location [float] [float] [float]". Placeholders: [uint],
/// [float], [str] (no spaces), and [rest] at the end (all that is left).
struct Command {
    std::string_view pattern;
    std::string_view help;
    /// The arguments are those of the placeholders; they live until it is done.
    boost::asio::awaitable<Answer> (*run)(Session& session, Arguments arguments);
};

/// Whether a command line is one of this template, and what stands for its placeholders.
bool matches(std::string_view pattern, std::string_view line, std::vector<std::string_view>& arguments);

std::span<const Command> plugin_commands();
std::span<const Command> camera_commands();
std::span<const Command> picture_commands();
std::span<const Command> object_commands();
std::span<const Command> action_commands();

/// Makes a camera there; its name is the answer.
boost::asio::awaitable<Answer> spawn_camera(Session& session, glm::dvec3 to);

/// All of them.
std::span<const Command> commands();

inline std::unexpected<std::string> refused(std::string why) {
    return std::unexpected(std::move(why));
}
inline std::unexpected<std::string> bad_arguments() {
    return refused("Argument Invalid");
}

}  // namespace camrig::unrealcv
