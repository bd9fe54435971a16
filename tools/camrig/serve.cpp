#include "tools/camrig/serve.h"

#include <csignal>
#include <cstdio>
#include <new>
#include <string_view>

#include <fcntl.h>
#include <malloc.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "core/base/descriptors.h"
#include "core/base/write_file.h"
#include "tools/camrig/command_history.h"
#include "tools/camrig/rig_inputs.h"
#include "tools/camrig/rig_servers.h"
#include "tools/camrig/running_rig.h"

// The composition root: makes every part, plugs them together, and takes them down in the opposite order.
namespace camrig::cli {
namespace {

constexpr int max_heaps = 2;
/// Memory of this size and more goes back to the system when it is freed.
constexpr int mapped_bytes = 1 << 18;

int fail(const Error& why) {
    std::fprintf(stderr, "camrig: %s\n", why.message.c_str());
    return 1;
}

/// While it lives, and its is_over() was not called, a program without memory ends with a message instead of an
/// exception in whichever thread it was. Once the rig serves, a request that finds no memory is an error of its own.
class EndWithoutMemory {
public:
    EndWithoutMemory() {
        std::set_new_handler([] {
            constexpr std::string_view text = "camrig: there is not enough memory to start (see ulimit -v)\n";
            static_cast<void>(!::write(STDERR_FILENO, text.data(), text.size()));
            ::_exit(1);
        });
    }
    ~EndWithoutMemory() { is_over(); }
    void is_over() const { std::set_new_handler(nullptr); }
};

/// The signals that end the rig are blocked in every thread and waited for in one.
class StopSignal {
public:
    StopSignal() {
        sigemptyset(&signals_);
        sigaddset(&signals_, SIGINT);
        sigaddset(&signals_, SIGTERM);
        // A terminal that goes ends it in order too, but below nohup.
        struct sigaction hang_up{};
        if (::sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN) sigaddset(&signals_, SIGHUP);
        pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    }
    void wait() {
        int signal = 0;
        sigwait(&signals_, &signal);
    }
    /// Whether one came; what comes later is waited for.
    bool has_come() const {
        sigset_t pending{};
        sigpending(&pending);
        sigset_t both{};
        sigandset(&both, &pending, &signals_);
        return sigisemptyset(&both) == 0;
    }

private:
    sigset_t signals_{};
};

void tell_ready(int fd, const nlohmann::json& facts) {
    if (fd < 0) return;
    const std::string line = facts.dump() + "\n";
    if (auto told = write_all(fd, std::as_bytes(std::span(line)), "--ready-fd " + std::to_string(fd)); !told)
        spdlog::warn("{}", told.error().message);
    if (fd > STDERR_FILENO) ::close(fd);
}

/// To be asked before anything else is opened: a number that nobody opened for us would soon be one of our own files.
Result<void> check_ready_fd(int fd) {
    const int flags = fd < 0 ? O_WRONLY : ::fcntl(fd, F_GETFL);
    if (flags >= 0 && (flags & O_ACCMODE) != O_RDONLY) return {};
    const std::string number = std::to_string(fd);
    return error(ErrorKind::invalid_argument,
                 "--ready-fd " + number +
                     ": no file is open for writing there; in a shell: camrig serve ... --ready-fd " + number + " " +
                     number + ">FILE");
}

void set_up_process() {
    std::signal(SIGPIPE, SIG_IGN);
    if (const std::string problem = raise_descriptor_limit(); !problem.empty()) spdlog::warn(problem);
    // glibc gives new threads heaps of their own, which streams that come and go would leave behind half empty.
    mallopt(M_ARENA_MAX, max_heaps);
    // Without a fixed bound it keeps up to 64 MB of what was freed last: pictures and textures of scenes that are gone.
    mallopt(M_MMAP_THRESHOLD, mapped_bytes);
    mallopt(M_TRIM_THRESHOLD, 32 * mapped_bytes);
}

}  // namespace

int run_serve(const ServeOptions& options) {
    if (auto open = check_ready_fd(options.ready_fd); !open) return fail(open.error());
    const EndWithoutMemory at_start;
    set_up_process();
    StopSignal stop;

    auto inputs = read_inputs(options);
    if (!inputs) return fail(inputs.error());
    auto history = CommandHistory::open(options);
    if (!history) return fail(history.error());
    ServeOptions of_rig = options;
    history->prepare(options, of_rig.engine);
    // The scene is the engine's alone: another may take its place.
    auto rig = RunningRig::start(of_rig, std::move(inputs->scene));
    if (!rig) {
        history->undo();
        return fail(rig.error());
    }
    RigServers servers(options, *inputs, **rig, history->log());
    auto opened = history->begin(options, servers.rpc(), [&stop] { return stop.has_come(); });
    if (opened) opened = servers.open();
    if (opened) {
        servers.print_addresses();
        at_start.is_over();
        tell_ready(options.ready_fd, servers.facts());
        stop.wait();
    }
    servers.stop();
    (*rig)->stop();
    if (!opened) history->undo();
    return opened ? 0 : fail(opened.error());
}

}  // namespace camrig::cli
