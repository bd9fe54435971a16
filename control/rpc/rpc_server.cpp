#include "control/rpc/rpc_server.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <system_error>

#include <spdlog/spdlog.h>

#include "control/rpc/json_rpc.h"
#include "control/rpc/methods.h"

namespace camrig::control {
namespace {

using nlohmann::json;

/// Collects the answers of a batch in order; sends when the last one is there.
class Batch {
public:
    Batch(std::size_t size, bool is_batch, std::function<void(RpcAnswer)> done)
        : answers_(size), open_(size), is_batch_(is_batch), done_(std::move(done)) {}

    void answer(std::size_t index, RpcAnswer answer) {
        {
            std::lock_guard lock(mutex_);
            answers_[index] = std::move(answer);
            if (--open_ > 0) return;
        }
        if (!is_batch_) return done_(std::move(answers_.front()));
        RpcAnswer all;
        for (auto& one : answers_) {
            if (one.pieces.empty()) continue;
            all.append(all.pieces.empty() ? "[" : ",");
            all.append(std::move(one));
        }
        if (!all.pieces.empty()) all.append("]");
        done_(std::move(all));
    }

private:
    std::mutex mutex_;
    std::vector<RpcAnswer> answers_;
    std::size_t open_;
    const bool is_batch_;
    const std::function<void(RpcAnswer)> done_;
};

RpcAnswer error_answer(const RpcError& error) {
    RpcAnswer answer;
    answer.append(rpc_error(error));
    return answer;
}

/// The text of a result, if there is room for it.
RpcAnswer answer_of(const json& id, Result<RpcResult> result, const std::shared_ptr<ByteBudget>& budget) {
    Error failed = result ? Error{} : result.error();
    if (result) {
        try {
            const bool is_claimed = result->claim.has_value();
            RpcAnswer answer = rpc_result(id, std::move(*result));
            if (is_claimed) return answer;
            auto claim = budget->claim(answer.size());
            if (claim) {
                answer.claims.push_back(std::move(*claim));
                return answer;
            }
            failed = claim.error();
        } catch (const std::bad_alloc&) {
            failed = out_of_memory();
        }
    }
    return error_answer({rpc_code_of(failed.kind), failed, id});
}

std::string in_mib(std::size_t bytes) {
    return std::to_string(bytes >> 20) + " MiB";
}

constexpr std::size_t max_replies_waiting = 4096;

/// Sees to it that a call is answered exactly once, also when whoever had to answer it was taken down.
class Answer {
public:
    explicit Answer(RpcReply done) : done_(std::move(done)) {}
    ~Answer() { give(error(ErrorKind::unavailable, "the rig is ending")); }
    Answer(const Answer&) = delete;
    Answer& operator=(const Answer&) = delete;

    void give(Result<RpcResult> result) {
        if (!given_.exchange(true)) done_(std::move(result));
    }

private:
    const RpcReply done_;
    std::atomic<bool> given_{false};
};

/// Unknown and missing parameter names, from the table.
Result<void> check_names(const Method& method, const json& params) {
    for (const auto& [key, value] : params.items()) {
        if (std::ranges::find(method.params, key, &Field::name) != method.params.end()) continue;
        std::string known;
        for (const auto& field : method.params) known += (known.empty() ? "" : ", ") + field.name;
        return error(ErrorKind::invalid_argument, method.name + ": unknown parameter '" + key.substr(0, 60) + "'; " +
                                                      (known.empty() ? "it takes none" : "it takes " + known));
    }
    for (const auto& field : method.params) {
        if (field.required && !params.contains(field.name))
            return error(ErrorKind::invalid_argument,
                         method.name + ": parameter '" + field.name + "' is missing: " + field.doc);
    }
    return {};
}

/// As the command log has it: one line, keys sorted, numbers in the shortest form that reads back the same.
std::shared_ptr<const std::string> command_text(const std::string& method, const json& params) {
    return std::make_shared<const std::string>(
        json{{"method", method}, {"params", params}}.dump(-1, ' ', false, json::error_handler_t::replace));
}

/// Whether a command decodes the pictures of a backdrop, which may take seconds.
bool reads_backdrop(const Method& method, const json& params) {
    const auto backdrop = params.find("backdrop");
    return method.reads_files && backdrop != params.end() && backdrop->is_object();
}

/// Where a path leads when every link is followed: a link below our folder may lead anywhere. Its last part need not be
/// there. Empty: nobody can tell.
std::filesystem::path real_place(const std::filesystem::path& path) {
    std::error_code failed, ignored;
    const auto place = std::filesystem::canonical(path, failed);
    if (!failed) return place;
    const auto folder = std::filesystem::canonical(path.has_parent_path() ? path.parent_path() : ".", failed);
    if (failed || std::filesystem::is_symlink(std::filesystem::symlink_status(path, ignored))) return {};
    return folder / path.filename();
}

/// What a command names that may be a file: its scene, and the absolute paths of a camera's backdrop, which has no
/// others.
std::vector<std::string> files_of(const json& params) {
    std::vector<std::string> files;
    if (const auto scene = params.find("scene"); scene != params.end() && scene->is_string())
        files.push_back(scene->get<std::string>());
    if (const auto backdrop = params.find("backdrop"); backdrop != params.end() && backdrop->is_structured()) {
        const json values = backdrop->flatten();
        for (const json& value : values) {
            const auto* const text = value.get_ptr<const std::string*>();
            if (text != nullptr && text->starts_with('/')) files.push_back(*text);
        }
    }
    return files;
}

}  // namespace

RpcServer::RpcServer(RpcContext context)
    : context_([&] {
          context.loader = std::make_shared<stream::WorkerPool>(1, max_scenes_waiting);
          context.backdrops = std::make_shared<stream::WorkerPool>(1, 0);  // at most one of each connection
          context.replies = std::make_shared<stream::WorkerPool>(1, max_replies_waiting);
          context.searches = std::make_shared<stream::WorkerPool>(1, max_searches_waiting);
          context.budget = ByteBudget::create(
              context.limits.total_reply_bytes,
              "the rig has " + in_mib(context.limits.total_reply_bytes) +
                  " of pictures and answers under way; read the answers that are due, then ask again");
          return std::move(context);
      }()),
      methods_(make_methods(context_, [this] { return json(calls()); })),
      calls_(methods_.size()) {
    for (std::size_t i = 0; i < methods_.size(); ++i) by_name_.emplace(methods_[i].name, i);
}

RpcServer::~RpcServer() {
    stop();
    context_.replies->stop();
}

void RpcServer::stop() {
    context_.loader->stop();
    context_.backdrops->stop();
    context_.searches->stop();
}

std::map<std::string, std::uint64_t> RpcServer::calls() const {
    std::map<std::string, std::uint64_t> counts;
    for (std::size_t i = 0; i < methods_.size(); ++i) counts[methods_[i].name] = calls_[i].load();
    return counts;
}

RpcReply RpcServer::without_foreign_files(const json& params, RpcReply done) const {
    const auto folder = real_place(context_.scenes);
    const auto is_foreign = [&](const std::string& file) {
        return folder.empty() || std::ranges::mismatch(folder, real_place(file)).in1 != folder.end();
    };
    const std::vector<std::string> files = files_of(params);
    const auto foreign = std::ranges::find_if(files, is_foreign);
    if (foreign == files.end()) return done;
    const auto budget = done.budget();
    const auto tell = [file = foreign->substr(0, 200), folder, done = std::move(done)](Result<RpcResult> result) {
        // What a check finds is a result.
        const json errors = result ? result->fields.value("errors", json()) : json();
        if (result && errors.empty()) return done(std::move(result));
        spdlog::warn("control: refused to a client of the network: {}",
                     result ? errors.dump(-1, ' ', false, json::error_handler_t::replace) : result.error().message);
        done(error(ErrorKind::invalid_argument,
                   "'" + file + "' cannot be loaded; of files outside of '" + folder.string() +
                       "' the reason is told only in the rig's log and on its control socket"));
    };
    return {tell, budget};
}

void RpcServer::call(const json& params, std::size_t index, Authority authority, RpcReply done) {
    const Method& method = methods_[index];
    if (authority == Authority::look && !method.only_looks)
        return done(error(ErrorKind::unauthorized, method.name + ": " + context_.how_to_command));
    calls_[index].fetch_add(1);
    if (authority != Authority::own && method.reads_files) done = without_foreign_files(params, std::move(done));
    if (auto good = check_names(method, params); !good) return done(std::unexpected(good.error()));
    const auto given = method.handler.takes_time() ? params.find("at_ns") : params.end();
    RpcReply::Asked asked;
    if (given != params.end()) {
        if (!given->is_number_integer() || *given < 0 || *given > max_time_ns)
            return done(error(ErrorKind::invalid_argument, "at_ns: must be a world time in whole nanoseconds"));
        asked.at_ns = given->get<std::int64_t>();
    }
    json rest;  // what the method itself reads
    if (asked.at_ns) (rest = params).erase("at_ns");
    const json& own = asked.at_ns ? rest : params;
    if (context_.keeps_text && !method.only_looks) asked.text = command_text(method.name, own);
    done.set_asked(std::move(asked));
    try {
        method.handler(own, done);
    } catch (const std::bad_alloc&) {
        done(std::unexpected(out_of_memory()));
    }
}

bool RpcServer::handle(std::string_view text, std::function<void(RpcAnswer)> done, Authority authority,
                       const std::shared_ptr<ByteBudget>& peer_budget, bool takes_bytes,
                       std::function<void()> started) {
    RpcMessage message = parse_rpc(text);
    const auto budget =
        ByteBudget::create(context_.limits.reply_bytes,
                           std::string(message.is_batch ? "the answers of a batch have" : "an answer has") +
                               " at most " + in_mib(context_.limits.reply_bytes) +
                               " together; ask one at a time, or take pictures by HTTP: GET "
                               "/cameras/NAME/snapshot.png, depth.npy or instance.png",
                           peer_budget ? peer_budget : context_.budget);
    const auto batch = std::make_shared<Batch>(message.items.size(), message.is_batch, std::move(done));
    struct Call {
        json params;
        std::size_t method;
        RpcReply reply;
    };
    const auto calls = std::make_shared<std::vector<Call>>();
    bool reads = false;
    for (std::size_t i = 0; i < message.items.size(); ++i) {
        if (const auto* bad = std::get_if<RpcError>(&message.items[i])) {
            batch->answer(i, bad->is_of_notification ? RpcAnswer() : error_answer(*bad));
            continue;
        }
        auto& request = std::get<RpcRequest>(message.items[i]);
        const auto found = by_name_.find(request.method);
        if (found == by_name_.end()) {
            const RpcError unknown{rpc_code::method_not_found,
                                   {ErrorKind::not_found,
                                    "no method '" + request.method.substr(0, 60) + "'; server.info lists the methods"},
                                   request.id.value_or(nullptr)};
            batch->answer(i, request.id ? error_answer(unknown) : RpcAnswer());
            continue;
        }
        const auto done_one = [batch, budget, i, id = request.id](Result<RpcResult> result) {
            batch->answer(i, id ? answer_of(*id, std::move(result), budget) : RpcAnswer());
        };
        const auto answer = std::make_shared<Answer>(done_one);
        reads |= authority != Authority::look && reads_backdrop(methods_[found->second], request.params);
        calls->push_back({std::move(request.params), found->second,
                          RpcReply([answer](Result<RpcResult> result) { answer->give(std::move(result)); }, budget,
                                   takes_bytes && !message.is_batch && request.id)});
    }
    const auto start = [this, calls, authority] {
        for (Call& one : *calls) call(one.params, one.method, authority, std::move(one.reply));
    };
    if (!reads) {
        start();
        return true;
    }
    return !context_.backdrops->post_beyond_limit([start, started = std::move(started)] {
        try {
            start();
        } catch (const std::exception& problem) {  // memory ran out: those that are left are answered when they go
            spdlog::error("control: a message with a backdrop was not started: {}", problem.what());
        }
        if (started) started();
    });
}

namespace {

void add_times(std::vector<Method>& methods) {
    for (Method& method : methods) {
        if (!method.handler.takes_time()) continue;
        method.params.push_back(
            {"at_ns", "integer",
             "world time at which it is done: after the frames that are due then, before the world's next step; those "
             "of one time in the order in which they came. The answer comes when it was done. Not past, and at most "
             "an hour ahead; 4096 may wait. Default: at once",
             false, "ns"});
    }
}

}  // namespace

std::vector<Method> make_methods(RpcContext& context, std::function<json()> call_counts) {
    std::vector<Method> all;
    const auto add = [&](std::vector<Method> some) { std::ranges::move(some, std::back_inserter(all)); };
    add(camera_methods(context));
    add(ptz_methods(context));
    add(fault_methods(context));
    add(world_methods(context));
    add(actor_methods(context));
    add(object_methods(context));
    add(event_methods(context));
    add(frame_methods(context));
    add(truth_methods(context));
    add(replica_methods(context));
    add(plate_methods(context));
    add_times(all);
    auto rig = rig_methods(context, std::move(call_counts));
    // server.info lists all methods, its own family too.
    json names = json::array();
    for (const auto& method : all) names.push_back(method.name);
    for (const auto& method : rig) names.push_back(method.name);
    for (auto& method : rig) {
        if (method.name != "server.info") continue;
        method.handler = [inner = std::move(method.handler), names](const json& params, RpcReply done) {
            inner(params, [names, done = std::move(done)](Result<RpcResult> result) {
                if (result) result->fields["methods"] = names;
                done(std::move(result));
            });
        };
    }
    add(std::move(rig));
    return all;
}

}  // namespace camrig::control
