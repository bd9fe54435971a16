#include "control/unrealcv/session.h"

#include <algorithm>
#include <new>
#include <utility>

#include <spdlog/spdlog.h>

#include "control/unrealcv/units.h"
#include "core/base/clock.h"
#include "core/base/out_of_memory.h"
#include "core/frame/kind_format.h"

namespace camrig::unrealcv {
namespace asio = boost::asio;
namespace {

/// Of one picture as it is drawn.
constexpr std::size_t max_picture_bytes = std::size_t{48} << 20;

const Command* find_command(std::string_view line, std::vector<std::string_view>& arguments) {
    for (const Command& one : commands())
        if (matches(one.pattern, line, arguments)) return &one;
    return nullptr;
}

}  // namespace

std::string shown_name(std::string_view name) {
    std::string shown(name);
    std::ranges::replace_if(shown, [](char c) { return c == ' ' || c == '/' || c == '\t'; }, '_');
    return shown;
}

Session::Session(DoorState& door, const asio::any_io_executor& executor) : door_(door), answered_(executor) {}

asio::awaitable<Answer> Session::answer(std::string_view line) {
    thread_.check();
    while (line.ends_with(' ')) line.remove_suffix(1);
    if (vbatch_left_ > 0) --vbatch_left_;
    std::vector<std::string_view> arguments;
    const Command* const command = find_command(line, arguments);
    // The words of the plugin for Unreal Engine 5, and those that its tests look for.
    if (!command)
        co_return refused("No handler found for URI '" + std::string(line.substr(0, 200)) +
                          "' (Can not find a handler)");
    Answer answer;
    try {
        answer = co_await command->run(*this, arguments);
    } catch (const std::bad_alloc&) {
        moment_.reset();
        answer = refused("the rig has no memory for this answer; ask for less at once");
    }
    // Clients set without looking at the answers.
    if (!answer && !line.starts_with("vget"))
        if (const auto left_out = door_.refusal_log.due(monotonic_now_ns()))
            spdlog::warn("unrealcv: {}: {} ({} more were refused before it)", line.substr(0, 200), answer.error(),
                         *left_out);
    co_return answer;
}

void Session::end_batch() {
    if (vbatch_left_ == 0) moment_.reset();
}

void Session::close() {
    thread_.check();
    is_closed_ = true;
    answered_.set();
}

asio::awaitable<std::expected<const Moment*, std::string>> Session::moment() {
    if (moment_) co_return &*moment_;
    auto instant = co_await ask(engine::GetInstant{});
    if (!instant) co_return std::unexpected(instant.error().message);
    moment_.emplace();
    moment_->instant = std::move(*instant);
    if (door_.scene != moment_->instant->scene) {
        door_.scene = moment_->instant->scene;
        door_.colors = std::make_shared<const Colors>();
    }
    co_return &*moment_;
}

asio::awaitable<std::expected<const Moment*, std::string>> Session::moment_of_cameras() {
    const auto now = co_await moment();
    if (!now || !moment_->cameras.empty()) co_return now;
    auto cameras = co_await ask(engine::ListCameras{});
    if (!cameras) co_return std::unexpected(cameras.error().message);
    moment_->cameras = std::move(*cameras);
    co_return &*moment_;
}

asio::awaitable<Result<Body>> Session::picture(const engine::CameraReply& camera, frame::FrameKind kind,
                                               std::function<Result<Body>(const frame::Frame&)> make) {
    stream::FetchRequest request;
    request.camera = camera.camera.spec()->name;
    request.kind = kind;
    request.instant = moment_->instant;
    request.format = {codec::Codec::raw, format_of(kind), 0, {}};
    claim_ = std::make_shared<std::optional<ByteBudget::Claim>>();
    request.admit = [claim = claim_, budget = door_.budget,
                     format = request.format.pixels](ImageSize size) -> Result<void> {
        const std::size_t bytes = bytes_of(format, size);
        if (bytes > max_picture_bytes)
            return error(ErrorKind::resource_exhausted, "a picture of " + std::to_string(bytes) + " bytes; at most " +
                                                            std::to_string(max_picture_bytes) + " are given here");
        auto claimed = budget->claim(2 * bytes);
        if (!claimed) return std::unexpected(claimed.error());
        *claim = std::move(*claimed);
        return {};
    };
    auto slot = std::make_shared<Slot<Body>>();
    door_.frames.fetch(std::move(request),
                       [fill = filler(slot), make = std::move(make)](Result<stream::MediaUnit> unit) {
                           if (!unit) return fill(std::unexpected(unit.error()));
                           fill(or_out_of_memory("encoding", [&] { return make(*unit->frame); }));
                       });
    co_await filled(*slot);
    co_return std::move(*slot->value);
}

asio::awaitable<Result<std::string>> Session::work(std::function<Result<std::string>()> make) {
    auto slot = std::make_shared<Slot<std::string>>();
    std::function<void()> job = [fill = filler(slot), make = std::move(make)] {
        fill(or_out_of_memory("this", [&] { return make(); }));
    };
    if (!door_.workers->post(std::move(job)))
        co_return error(ErrorKind::resource_exhausted, "too much waits to be made; ask again later");
    co_await filled(*slot);
    co_return std::move(*slot->value);
}

std::expected<const engine::CameraReply*, std::string> camera_at(const Moment& moment, std::string_view id) {
    const auto index = integer_of(id);
    if (moment.cameras.empty()) return std::unexpected("No sensor id is available");
    if (!index || static_cast<std::size_t>(*index) >= moment.cameras.size())
        return std::unexpected("Invalid sensor id");
    return &moment.cameras[static_cast<std::size_t>(*index)];
}

std::expected<FoundObject, std::string> object_named(DoorState& door, const Moment& moment, std::string_view name) {
    const world::Snapshot& world = moment.world();
    for (const auto* movers : {&world.movers, &world.hidden})
        for (const world::Instance& one : *movers)
            if (one.info->name.size() == name.size() && shown_name(one.info->name) == name)
                return FoundObject{&one, true};
    StandingObjects& standing = door.standing;
    if (standing.set != world.statics) {
        standing = {.set = world.statics, .by_name = {}};
        for (const auto* objects : {&world.statics->objects, &world.statics->hidden})
            for (const world::Instance& one : *objects) standing.by_name.try_emplace(shown_name(one.info->name), &one);
    }
    const auto found = standing.by_name.find(std::string(name));
    if (found == standing.by_name.end()) return std::unexpected("Cannot find object");
    return FoundObject{found->second, false};
}

}  // namespace camrig::unrealcv
