#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <imgui.h>

#include "core/base/result.h"

struct GLFWwindow;

namespace camrig::view {

/// A window with OpenGL 3.3 and Dear ImGui in it. One a process, on the main thread.
class Window {
public:
    /// Error unavailable where there is no display or no OpenGL; says what would help.
    static Result<std::unique_ptr<Window>> open(int width, int height, const std::string& title);
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;
    ~Window();

    /// A key of GLFW's with Ctrl held or not.
    struct Key {
        int key = 0;
        bool with_ctrl = false;
    };
    /// What came since the last turn.
    struct Input {
        std::vector<Key> keys = {};
        /// Where the left mouse button went down, or up.
        std::optional<ImVec2> pressed_at = {}, released_at = {};
    };
    /// Draws until the window is closed or `stop` is set: when there is input or redraw() was called, and now and then
    /// without.
    void run(const std::atomic<bool>& stop, const std::function<void(ImVec2 size, const Input& input)>& draw);
    /// From any thread: there is something new to draw.
    static void redraw();

private:
    explicit Window(GLFWwindow* window);

    static constexpr std::size_t max_keys = 64, max_clicks = 64;
    /// The left mouse button goes down, or up.
    struct Click {
        bool is_down;
        ImVec2 at;
    };
    /// A turn that comes late has one of them: each is where the mouse was then, and not where it is now.
    void take_click();

    GLFWwindow* window_;
    Input input_;
    std::deque<Click> clicks_;  ///< that no turn has had
    bool is_down_ = false;
    ImVec2 mouse_;  ///< at the event that is being handled
};

}  // namespace camrig::view
