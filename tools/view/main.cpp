// `camrig view`: a window on a running rig. A program of its own, so that the rig needs no window system; a client like
// any other.
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>

#include <GLFW/glfw3.h>
#include <camrig/error.h>
#include <unistd.h>

#include "core/base/token.h"
#include "tools/view/panels.h"
#include "tools/view/window.h"

namespace {

using namespace camrig::view;

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free);

/// What run() would delete at its end. Xlib ends the program by exit() when the X server has gone away or has thrown us
/// out, and then nothing of run() is left but this.
std::function<void()> left_behind;

void delete_left_behind() {
    if (!left_behind) return;
    try {
        left_behind();
    } catch (const camrig::client::Error& why) {
        std::cerr << "camrig: view: its camera may be left behind: " << why.what() << std::endl;
    }
    std::_Exit(1);  // other threads are still at work
}

/// Says what is left behind as long as it lives.
struct LeftBehind {
    explicit LeftBehind(std::function<void()> deletes) { left_behind = std::move(deletes); }
    ~LeftBehind() { left_behind = nullptr; }
    LeftBehind(const LeftBehind&) = delete;
    LeftBehind& operator=(const LeftBehind&) = delete;
};

void stop_at_signals() {
    struct sigaction action{};
    action.sa_handler = [](int) { stop = true; };
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(number, &action, nullptr);
}

void obey(Session& session, Window::Key pressed) {
    if (session.question) {
        const bool is_yes = pressed.key == GLFW_KEY_ENTER || pressed.key == GLFW_KEY_KP_ENTER;
        if (is_yes || pressed.key == GLFW_KEY_ESCAPE) session.answer(is_yes);
        return;
    }
    if (pressed.with_ctrl) {
        if (pressed.key == GLFW_KEY_Z) session.undo();
        if (pressed.key == GLFW_KEY_S) session.save();
        if (pressed.key == GLFW_KEY_D) session.duplicate_selected();
        return;
    }
    if (pressed.key == GLFW_KEY_N) session.create_camera();
    if (pressed.key == GLFW_KEY_DELETE) session.delete_selected();
    if (pressed.key == GLFW_KEY_SPACE && session.model.world.mode == "realtime") session.play_or_pause();
}

void draw(Session& session, ImVec2 size, const Window::Input& input) {
    session.update();
    session.pressed_at = input.pressed_at;
    session.released_at = input.released_at;
    const float middle = std::max(100.0F, size.x - list_width - camera_width);
    const float above = std::max(100.0F, size.y - timeline_height);
    draw_camera_list(session, {{0, 0}, {list_width, size.y}});
    draw_scene(session, {{list_width, 0}, {middle, above}});
    draw_camera(session, {{list_width + middle, 0}, {camera_width, size.y}});
    draw_timeline(session, {{list_width, above}, {middle, timeline_height}});
    draw_question(session, {{0, 0}, size});
    // After the mouse: a key that follows a click is about what was clicked.
    if (!ImGui::GetIO().WantTextInput)
        for (const Window::Key key : input.keys) obey(session, key);
}

/// As tools/camrig/cli_view.cpp gives them, in this order.
struct Options {
    std::string control;
    std::filesystem::path token_file;  ///< may be empty
    std::filesystem::path file;
    int width;
    int height;
};

int run(const Options& options) {
    std::string token;
    if (!options.token_file.empty()) {
        auto read = camrig::read_token_file(options.token_file);
        if (!read) throw camrig::client::Error(std::string(to_string(read.error().kind)), read.error().message);
        token = std::move(*read);
    }
    const auto rig = camrig::client::connect({.control = options.control, .token = token});
    auto window = Window::open(options.width, options.height, "camrig view");
    if (!window) throw camrig::client::Error(std::string(to_string(window.error().kind)), window.error().message);
    stop_at_signals();
    // Windows of other machines or containers may have the same process number.
    std::string own = "view_" + std::to_string(::getpid());
    const auto others = rig.cameras();
    while (std::ranges::any_of(others, [&](const auto& camera) { return camera.name() == own; })) own += "_";
    std::atexit(delete_left_behind);
    Session session(rig, own, std::filesystem::absolute(options.file), &Window::redraw);
    const LeftBehind camera([&session] { session.pictures.leave(); });
    (*window)->run(stop, [&](ImVec2 size, const auto& input) { draw(session, size, input); });
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 6) {
        std::cerr << "camrig-view: is started by: camrig view\n";
        return 2;
    }
    try {
        return run({.control = argv[1],
                    .token_file = argv[2],
                    .file = argv[3],
                    .width = std::stoi(argv[4]),
                    .height = std::stoi(argv[5])});
    } catch (const std::exception& problem) {
        std::cerr << "camrig: view: " << problem.what() << "\n";
        return 1;
    }
}
