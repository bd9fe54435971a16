#include "rtsp_out/rtsp/rtsp_server.h"

#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include <pthread.h>
#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/base/descriptors.h"
#include "rtsp_out/rtsp/client_table.h"
#include "rtsp_out/rtsp/listener.h"
#include "rtsp_out/rtsp/rtsp_access.h"
#include "rtsp_out/rtsp/rtsp_mount.h"

namespace camrig::rtsp {
namespace {

/// How often idle streams and dead sessions are looked after.
constexpr guint regular_work_ms = 100;
/// Between the end of a stream (BYE) and the end of its connections.
constexpr guint farewell_ms = 200;
/// Where UDP ports are looked for, each mount in a range of its own.
constexpr int first_udp_port = 20'000;
constexpr int udp_ports = 1'000;
/// Free for a new stream, which takes some twenty.
constexpr int descriptors_of_a_stream = 40;

using Task = std::function<void()>;

gboolean run_once(void* task) {
    (*static_cast<Task*>(task))();
    return G_SOURCE_REMOVE;
}
gboolean run_again(void* task) {
    (*static_cast<Task*>(task))();
    return G_SOURCE_CONTINUE;
}
void forget_task(void* task) {
    delete static_cast<Task*>(task);
}

void attach(GSource* source, GMainContext* context, GSourceFunc run, Task task) {
    g_source_set_callback(source, run, new Task(std::move(task)), forget_task);
    g_source_attach(source, context);
    g_source_unref(source);
}

}  // namespace

struct RtspServer::Impl final : stream::CameraObserver {
    explicit Impl(RtspOptions given)
        : options(std::move(given)), context(g_main_context_new()), loop(g_main_loop_new(context, FALSE)) {}
    ~Impl() override {
        g_main_loop_unref(loop);
        g_main_context_unref(context);
    }

    Result<void> listen();
    RtspListener::Hooks listener_hooks(GObjectHandle<GTlsCertificate> certificate);
    void run();
    void stop();

    // Engine thread; the work is done on ours, before anything that a client asks.
    void camera_added(const stream::CameraStream& camera) override { post_camera(camera, true); }
    void camera_changed(const stream::CameraStream& camera) override { post_camera(camera, true); }
    void camera_removed(const stream::CameraStream& camera) override { post_camera(camera, false); }
    void post_camera(const stream::CameraStream& camera, bool is_there) {
        post([this, camera, is_there] { mount(camera, is_there); });
    }
    void post(Task task) {
        GSource* source = g_idle_source_new();
        g_source_set_priority(source, G_PRIORITY_HIGH);
        attach(source, context, run_once, std::move(task));
    }

    // Server thread.
    void mount(const stream::CameraStream& camera, bool is_there);
    void unmount(const std::string& path);
    Result<void> refusal(const std::string& path, const std::string& address) const;
    GObjectHandle<GstRTSPAddressPool> addresses();
    void do_regular_work();

    const RtspOptions options;
    GMainContext* const context;
    GMainLoop* const loop;
    GObjectHandle<GstRTSPServer> server;
    GObjectHandle<GstRTSPMountPoints> mounts;
    GObjectHandle<GstRTSPSessionPool> sessions;
    unsigned mounts_made = 0;
    WallOffset wall;
    ClientTable clients{options.limits,
                        [this](const std::string& path, const std::string& address) { return refusal(path, address); }};
    std::map<std::string, std::unique_ptr<RtspMount>> mounted;
    std::map<std::string, Error> refused;
    std::map<std::string, std::string> closed;  ///< cameras by path: a fault refuses who comes
    std::unique_ptr<RtspListener> listener;
    std::once_flag stopped;
    std::thread thread;
};

Result<void> RtspServer::Impl::listen() {
    auto certificate = load_rtsp_certificate(options);
    if (!certificate) return std::unexpected(certificate.error());
    auto opened = listen_tcp({.name = "rtsp",
                              .port_option = "--rtsp",
                              .host = options.host,
                              .port = options.port,
                              .asks_for_token = !options.token.empty()});
    if (!opened) return std::unexpected(opened.error());

    server.reset(gst_rtsp_server_new());
    mounts.reset(gst_rtsp_server_get_mount_points(server.get()));
    sessions.reset(gst_rtsp_server_get_session_pool(server.get()));
    gst_rtsp_session_pool_set_max_sessions(sessions.get(), options.limits.sessions);
    if (const auto auth = create_rtsp_auth(options)) gst_rtsp_server_set_auth(server.get(), auth.get());
    // All connections on our thread: what closes, counts and changes them needs no lock.
    const GObjectHandle<GstRTSPThreadPool> threads(gst_rtsp_thread_pool_new());
    gst_rtsp_thread_pool_set_max_threads(threads.get(), 0);
    gst_rtsp_server_set_thread_pool(server.get(), threads.get());

    auto made = RtspListener::create(server.get(), std::move(*opened), listener_hooks(std::move(*certificate)));
    if (!made) return std::unexpected(made.error());
    listener = std::move(*made);

    g_signal_connect(server.get(), "client-connected",
                     G_CALLBACK(+[](GstRTSPServer*, GstRTSPClient* client, void* impl) {
                         static_cast<Impl*>(impl)->clients.add(client);
                     }),
                     this);
    const auto timeout_s = static_cast<guint>(options.limits.session_timeout_s);
    g_signal_connect(server.get(), "client-connected",
                     G_CALLBACK(+[](GstRTSPServer*, GstRTSPClient* client, void* seconds) {
                         const auto set = +[](GstRTSPClient*, GstRTSPSession* session, void* limit) {
                             gst_rtsp_session_set_timeout(session, GPOINTER_TO_UINT(limit));
                         };
                         g_signal_connect(client, "new-session", G_CALLBACK(set), seconds);
                     }),
                     GUINT_TO_POINTER(timeout_s));
    return {};
}

RtspListener::Hooks RtspServer::Impl::listener_hooks(GObjectHandle<GTlsCertificate> certificate) {
    RtspListener::Hooks hooks;
    hooks.admit = [this](const std::string& address) { return clients.make_room(address); };
    hooks.shed = [this] { clients.shed(); };
    hooks.must_wait = [this](const std::string& address) { return clients.must_wait(address); };
    hooks.prepare = [this, certificate = std::shared_ptr<GTlsCertificate>(std::move(certificate))](GSocket* socket) {
        guard_socket(socket, std::make_shared<ConnectionGuard>(RequestBounds(options.limits.requests), certificate));
    };
    return hooks;
}

void RtspServer::Impl::run() {
    ::pthread_setname_np(::pthread_self(), "camrig-rtsp");
    g_main_context_push_thread_default(context);
    listener->start(context);
    attach(g_timeout_source_new(regular_work_ms), context, run_again, [this] { do_regular_work(); });
    g_main_loop_run(loop);
    g_main_context_pop_thread_default(context);
}

void RtspServer::Impl::mount(const stream::CameraStream& camera, bool is_there) {
    for (const StreamSettings& stream : streams_of(camera.outputs, camera.size, camera.rate)) {
        const std::string path = "/" + camera.name + std::string(path_ending(stream.options));
        refused.erase(path);
        closed.erase(path);
        if (!is_there) {
            unmount(path);
            continue;
        }
        if (camera.standing.refuses("rtsp")) closed.emplace(path, camera.name);
        auto plan = RtspMount::plan(stream, camera, options);
        if (!plan) {
            unmount(path);
            refused.insert_or_assign(path, plan.error());
            continue;
        }
        if (const auto old = mounted.find(path); old != mounted.end() && old->second->plan() == *plan) continue;
        unmount(path);
        mounted[path] = std::make_unique<RtspMount>(std::move(*plan), options, mounts.get(), addresses(), &wall);
    }
}

/// Where one mount sends from, and to which group. Null: anywhere, and no multicast.
///
/// With a host that is one address of this machine, UDP ports are that address's too. Multicast is not offered on
/// loopback: it would leave it, and gst-rtsp-server's sockets give no multicast to readers on the same machine.
GObjectHandle<GstRTSPAddressPool> RtspServer::Impl::addresses() {
    const std::string& host = listener->address();
    GObjectHandle<GstRTSPAddressPool> pool(gst_rtsp_address_pool_new());
    const unsigned number = mounts_made++;
    if (!is_any_address(host)) {
        // gst-rtsp-server tries one pair after the other until one is free.
        const auto first = static_cast<guint16>(2 * g_random_int_range(first_udp_port / 2, (65'534 - udp_ports) / 2));
        gst_rtsp_address_pool_add_range(pool.get(), host.c_str(), host.c_str(), first,
                                        static_cast<guint16>(first + udp_ports - 1), 0);
    }
    if (is_loopback_address(host)) return pool;
    // 239.255/16 is for use within a site (RFC 2365); two rigs on one network should not send to the same groups.
    const std::string group =
        "239.255." + std::to_string(listener->port() % 251) + "." + std::to_string(1 + number % 254);
    const auto first_port = static_cast<guint16>(18'888 + 2 * (number % 1000));
    gst_rtsp_address_pool_add_range(pool.get(), group.c_str(), group.c_str(), first_port, first_port + 1, 1);
    return pool;
}

void RtspServer::Impl::unmount(const std::string& path) {
    const auto found = mounted.find(path);
    if (found == mounted.end()) return;
    for (const auto& feed : found->second->feeds()) feed->end();
    mounted.erase(found);
    // The BYE of the stream's end goes out first. Whoever comes in the meantime has the next mount.
    auto leaving = std::make_shared<std::vector<GObjectHandle<GstRTSPClient>>>(clients.clients_of(path));
    if (leaving->empty()) return;
    attach(g_timeout_source_new(farewell_ms), context, run_once, [leaving] {
        for (const auto& client : *leaving) gst_rtsp_client_close(client.get());
    });
}

Result<void> RtspServer::Impl::refusal(const std::string& path, const std::string& address) const {
    if (const auto camera = closed.find(path); camera != closed.end()) {
        options.bus->note_refused(camera->second, "rtsp", address);
        return error(ErrorKind::unavailable, "camera " + camera->second + " refuses connections (a fault)");
    }
    if (const auto known = refused.find(path); known != refused.end()) return std::unexpected(known->second);
    if (mounted.contains(path)) {
        if (!descriptors_are_short(descriptors_of_a_stream)) return {};
        return error(ErrorKind::unavailable, too_many_files);
    }
    std::string paths;
    for (const auto& [mounted_path, mount] : mounted) {
        if (paths.size() > 300) break;
        paths += (paths.empty() ? "" : " ") + mounted_path;
    }
    return error(ErrorKind::not_found, "Not Found; there are: " + paths);
}

void RtspServer::Impl::do_regular_work() {
    const TimeNs now_ns = monotonic_now_ns();
    for (const auto& [path, one] : mounted)
        for (const auto& feed : one->feeds()) {
            feed->repeat_if_idle(now_ns);
            // Whoever stays after the end would keep it, and who comes would share it with him.
            if (!feed->has_ended(now_ns)) continue;
            for (const auto& client : clients.clients_of(path)) {
                if (feed->is_reset()) break_when_closed(client.get());
                gst_rtsp_client_close(client.get());
            }
        }
    gst_rtsp_session_pool_cleanup(sessions.get());
    clients.close_idle(now_ns);
    clients.let_go(now_ns);
    listener->look_after(now_ns);
}

void RtspServer::Impl::stop() {
    std::call_once(stopped, [this] {
        options.bus->remove_observer(this);
        post([this] {
            for (const auto& [path, one] : mounted)
                for (const auto& feed : one->feeds()) feed->end();
            attach(g_timeout_source_new(farewell_ms), context, run_once, [this] {
                listener->stop();
                for (const auto& client : clients.all()) gst_rtsp_client_close(client.get());
                mounted.clear();
                g_main_loop_quit(loop);
            });
        });
        thread.join();
    });
}

RtspServer::RtspServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RtspServer::~RtspServer() {
    stop();
}

Result<std::unique_ptr<RtspServer>> RtspServer::create(RtspOptions options) {
    CHECK(options.bus != nullptr && options.fetcher != nullptr);
    GError* failed = nullptr;
    if (!gst_init_check(nullptr, nullptr, &failed)) {
        const std::string why = failed ? failed->message : "unknown reason";
        g_clear_error(&failed);
        return error(ErrorKind::unavailable, "rtsp: GStreamer does not start: " + why);
    }
    auto impl = std::make_unique<Impl>(std::move(options));
    if (auto listening = impl->listen(); !listening) return std::unexpected(listening.error());
    impl->options.bus->add_observer(impl.get());
    impl->thread = std::thread([raw = impl.get()] { raw->run(); });
    return std::unique_ptr<RtspServer>(new RtspServer(std::move(impl)));
}

std::uint16_t RtspServer::port() const {
    return impl_->listener->port();
}
const char* RtspServer::scheme() const {
    return impl_->options.certificate.empty() ? "rtsp" : "rtsps";
}
ConnectionCounts RtspServer::counts() const {
    return impl_->clients.counts();
}
void RtspServer::stop() {
    impl_->stop();
}

}  // namespace camrig::rtsp
