#include "rtsp_out/http/handlers.h"

#include <chrono>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "core/frame/kind_format.h"
#include "rtsp_out/http/metrics.h"
#include "rtsp_out/http/npy.h"

namespace camrig::http {

namespace asio = boost::asio;

namespace {

Reply not_built_in(std::string_view what) {
    return error_reply({ErrorKind::unsupported, std::string(what) + " is not available in this server"});
}

Reply file_reply(ServerState& state, const HttpRequest& request) {
    const auto& files = state.options.hooks.files;
    const auto file = files ? files(request.target.path) : std::nullopt;
    if (!file) {
        std::string all;
        for (const HttpPath& one : rig_paths()) all.append(one.takes_post ? "POST " : "").append(one.path).append(", ");
        return error_reply({ErrorKind::not_found, "no such path; there are " + all + "and /cameras/NAME/stream.mjpg"});
    }
    Reply reply;
    reply.content_type = file->content_type;
    reply.data = std::as_bytes(std::span(*file->bytes));
    reply.keep = file->bytes;
    // No other page may frame ours (a click on it could move a camera), and ours loads nothing from elsewhere.
    reply.fields = {{"Cache-Control", "no-cache"},
                    {"Content-Security-Policy",
                     "default-src 'self'; img-src 'self' data: blob:; style-src 'self'; "
                     "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
                    {"Referrer-Policy", "no-referrer"}};
    return reply;
}

nlohmann::json rate_json(const Rate& rate) {
    if (rate.den() == 1) return rate.num();
    return rate.to_string();
}

Reply cameras_reply(ServerState& state) {
    nlohmann::json list = nlohmann::json::array();
    for (const stream::CameraStream& camera : state.options.bus->cameras()) {
        nlohmann::json urls;
        for (const HttpPath& one : camera_paths())
            urls[std::string(one.url)] = "/cameras/" + camera.name + "/" + std::string(one.path);
        list.push_back({{"name", camera.name},
                        {"size", {camera.size.width, camera.size.height}},
                        {"fps", rate_json(camera.rate)},
                        {"urls", std::move(urls)}});
    }
    return json_reply(nlohmann::json{{"cameras", std::move(list)}}.dump() + "\n");
}

Reply picture_reply(const stream::MediaUnit& unit, const HttpRequest& request, WallOffset& wall) {
    Reply reply;
    if (request.route.kind == RouteKind::floats) {
        const frame::FrameKind kind = request.route.frame;
        if (!unit.frame || unit.frame->info().format != format_of(kind))
            return error_reply({ErrorKind::internal, "the picture came in another form"});
        reply.content_type = "application/octet-stream";
        reply.text = npy_float32_head(unit.frame->info().size, kind == frame::FrameKind::flow ? 2 : 1);
        reply.data = unit.frame->bytes();
        reply.keep = unit.frame;
    } else {
        if (!unit.bytes) return error_reply({ErrorKind::internal, "the picture came without bytes"});
        reply.content_type = request.route.codec == codec::Codec::jpeg ? "image/jpeg" : "image/png";
        reply.data = *unit.bytes;
        reply.keep = unit.bytes;
    }
    const std::string etag = etag_of(unit.info, reply.data);
    reply.fields = frame_fields(unit.info, wall);
    reply.fields.emplace_back("Cache-Control", "no-store");
    reply.fields.emplace_back("ETag", etag);
    if (!etag_matches(request.if_none_match, etag)) return reply;
    Reply same;
    same.status = 304;
    same.fields = std::move(reply.fields);
    return same;
}

Reply too_many_fetches() {
    return error_reply({ErrorKind::resource_exhausted, "too many pictures are being made at once; try again"});
}

asio::awaitable<Reply> picture(ServerState& state, AsyncEventRef event, const HttpRequest& request) {
    auto wanted = fetch_request(request.route, request.target);
    if (!wanted) co_return error_reply(wanted.error());
    const auto ticket = FetchTicket::begin(state);
    if (!ticket) co_return too_many_fetches();
    const auto claim = std::make_shared<ByteBudget::Claim>();
    wanted->admit = [claim, budget = state.pictures, kind = wanted->kind](ImageSize size) -> Result<void> {
        auto claimed = budget->claim(bytes_of(format_of(kind), size));
        if (!claimed) return std::unexpected(claimed.error());
        *claim = std::move(*claimed);
        return {};
    };
    const auto slot = make_answer_slot<Result<stream::MediaUnit>>(event);
    state.options.fetcher->fetch(std::move(*wanted),
                                 [slot, ticket](Result<stream::MediaUnit> unit) { slot->put(std::move(unit)); });
    auto got = co_await wait_for_answer(slot, event, state.options.limits.reply_time);
    if (!got) co_return error_reply(got.error());
    if (!*got) co_return error_reply(got->error());
    Reply reply = picture_reply(**got, request, state.wall);
    claim->shrink_to(reply.data.size());
    reply.keep = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<ByteBudget::Claim>>>(
        std::move(reply.keep), claim);
    co_return reply;
}

asio::awaitable<Reply> truth(ServerState& state, AsyncEventRef event, const HttpRequest& request) {
    if (!state.options.hooks.truth) co_return not_built_in("truth");
    auto wanted = fetch_request(request.route, request.target);
    if (!wanted) co_return error_reply(wanted.error());
    const auto ticket = FetchTicket::begin(state);
    if (!ticket) co_return too_many_fetches();
    const auto slot = make_answer_slot<Result<std::string>>(event);
    state.options.hooks.truth(wanted->camera, wanted->min_ns,
                              [slot, ticket](Result<std::string> text) { slot->put(std::move(text)); });
    auto got = co_await wait_for_answer(slot, event, state.options.limits.reply_time);
    if (!got) co_return error_reply(got.error());
    if (!*got) co_return error_reply(got->error());
    co_return json_reply(std::move(**got));
}

/// Nobody is told to come again (Retry-After): a command would be done twice.
Reply unanswered_rpc(const std::string& why) {
    Reply reply = error_reply(
        {ErrorKind::unavailable, why + "; what was asked was given to the rig and may still be done: ask world.status "
                                       "before you repeat a command"});
    reply.fields.clear();
    return reply;
}

asio::awaitable<Reply> rpc(ServerState& state, AsyncEventRef event, const HttpRequest& request) {
    if (!state.options.hooks.rpc) co_return not_built_in("/rpc");
    const auto slot = make_answer_slot<RpcText>(event);
    state.options.hooks.rpc(request.body, request.may_command, [slot](RpcText text) { slot->put(std::move(text)); });
    const auto time = state.options.limits.rpc_time;
    auto got = co_await wait_for_answer(slot, event, time);
    if (!got) co_return unanswered_rpc("no answer within " + std::to_string(time / std::chrono::seconds(1)) + " s");
    if (got->pieces.empty()) {
        Reply nothing;
        nothing.status = 204;
        co_return nothing;
    }
    Reply reply = json_reply({});
    reply.pieces = std::move(got->pieces);
    reply.keep = std::move(got->keep);
    co_return reply;
}

asio::awaitable<Reply> device(ServerState& state, AsyncEventRef event, const HttpRequest& request) {
    const auto& hooks = state.options.hooks.device;
    DeviceCall call = request.call;
    const bool shows_wrong = call.shows_wrong;
    call.body = request.body;
    const auto slot = make_answer_slot<DeviceAnswer>(event);
    hooks.call(std::move(call), [slot](DeviceAnswer made) { slot->put(std::move(made)); });
    auto got = co_await wait_for_answer(slot, event, state.options.limits.device_time);
    if (!got) co_return error_reply(got.error());
    if (got->is_refused || (got->asks_digest && shows_wrong)) {
        ++state.counts.connections.wrong_tokens;
        asio::steady_timer pause(co_await asio::this_coro::executor, state.options.limits.wrong_token);
        co_await pause.async_wait(asio::as_tuple(asio::use_awaitable));
    }
    Reply reply = text_reply(std::move(got->content_type), std::move(got->text));
    reply.status = got->status;
    if (got->asks_digest) reply.fields.emplace_back("WWW-Authenticate", request.call.challenge);
    co_return reply;
}

asio::awaitable<Reply> metrics(ServerState& state, AsyncEventRef event) {
    stream::RigReport report;
    if (state.options.hooks.stats) {
        const auto slot = make_answer_slot<stream::RigReport>(event);
        state.options.hooks.stats([slot](stream::RigReport made) { slot->put(std::move(made)); });
        auto got = co_await wait_for_answer(slot, event, state.options.limits.reply_time);
        if (!got) co_return error_reply(got.error());
        report = std::move(*got);
    }
    co_return text_reply("text/plain; version=0.0.4; charset=utf-8", to_prometheus(report, state.counts.read()));
}

asio::awaitable<Reply> dispatch(ServerState& state, AsyncEventRef event, const HttpRequest& request) {
    const RouteKind kind = request.route.kind;
    if (kind == RouteKind::device) co_return co_await device(state, event, request);
    if (kind == RouteKind::picture || kind == RouteKind::floats) co_return co_await picture(state, event, request);
    if (kind == RouteKind::truth) co_return co_await truth(state, event, request);
    // The page may read its own query; everything else says what it does not understand.
    if (kind == RouteKind::file) co_return file_reply(state, request);
    if (auto known = no_params(request.target); !known) co_return error_reply(known.error());
    switch (kind) {
        case RouteKind::rpc:
            co_return co_await rpc(state, event, request);
        case RouteKind::metrics:
            co_return co_await metrics(state, event);
        case RouteKind::healthz:
            co_return text_reply("text/plain; charset=utf-8", "ok\n");
        default:
            co_return cameras_reply(state);
    }
}

}  // namespace

asio::awaitable<Reply> answer(ServerState& state, AsyncEventRef event, const HttpRequest& request) {
    std::string what;
    try {
        co_return co_await dispatch(state, event, request);
    } catch (const std::bad_alloc&) {
        if (request.route.kind == RouteKind::rpc) co_return unanswered_rpc("the rig has no memory for this answer");
        co_return error_reply({ErrorKind::resource_exhausted, "the rig has no memory for this answer; try again"});
    } catch (const std::exception& thrown) {
        what = thrown.what();
    }
    spdlog::error("http: {} failed: {}", request.target.path, what);
    co_return error_reply({ErrorKind::internal, "this request failed inside the server; its log says why"});
}

}  // namespace camrig::http
