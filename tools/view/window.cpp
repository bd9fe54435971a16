#include "tools/view/window.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include <GLFW/glfw3.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

namespace camrig::view {
namespace {

/// So often is drawn without a reason: a signal is noticed, a text cursor blinks.
constexpr double idle_s = 0.1;
/// Input comes in bursts, and ImGui needs a turn or two to act on it: a button is pressed in one and let go in another.
constexpr int turns_after_input = 3;

std::string glfw_problem() {
    const char* words = nullptr;
    ::glfwGetError(&words);
    return words ? words : "no reason given";
}

/// The key of the letter that it writes, as keyboards of other countries have it; where it writes none of ours, by its
/// place.
int letter_or_place(int key, int scancode) {
    const char* written = ::glfwGetKeyName(key, scancode);
    if (!written || written[0] == '\0' || written[1] != '\0') return key;
    const auto letter = static_cast<unsigned char>(written[0]);
    return std::isalpha(letter) ? std::toupper(letter) : key;
}

}  // namespace

Result<std::unique_ptr<Window>> Window::open(int width, int height, const std::string& title) {
    if (!::glfwInit())
        return error(ErrorKind::unavailable,
                     "no display: " + glfw_problem() + "; set DISPLAY or WAYLAND_DISPLAY, or use the web page");
    ::glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    ::glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    ::glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    GLFWwindow* window = ::glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window == nullptr) {
        const std::string why = glfw_problem();
        ::glfwTerminate();
        return error(ErrorKind::unavailable,
                     "no window: " + why + "; it takes OpenGL 3.3, which Mesa draws without a GPU");
    }
    return std::unique_ptr<Window>(new Window(window));
}

Window::Window(GLFWwindow* window) : window_(window) {
    ::glfwMakeContextCurrent(window_);
    ::glfwSwapInterval(1);
    // Dear ImGui before 1.87 asks once a turn which keys are down and where the mouse is, so it misses a key that is
    // tapped between two turns, does not notice that a button was let go and pressed again, and takes it to have been
    // pressed where the mouse is some time after.
    ::glfwSetWindowUserPointer(window_, this);
    ::glfwSetKeyCallback(window_, [](GLFWwindow* self, int key, int scancode, int action, int modifiers) {
        auto& keys = static_cast<Window*>(::glfwGetWindowUserPointer(self))->input_.keys;
        if (action == GLFW_PRESS && keys.size() < max_keys)
            keys.push_back({letter_or_place(key, scancode), (modifiers & GLFW_MOD_CONTROL) != 0});
    });
    ::glfwSetCursorPosCallback(window_, [](GLFWwindow* self, double x, double y) {
        static_cast<Window*>(::glfwGetWindowUserPointer(self))->mouse_ = {static_cast<float>(x), static_cast<float>(y)};
    });
    ::glfwSetMouseButtonCallback(window_, [](GLFWwindow* self, int button, int action, int) {
        auto& window_of_it = *static_cast<Window*>(::glfwGetWindowUserPointer(self));
        if (button == GLFW_MOUSE_BUTTON_LEFT && window_of_it.clicks_.size() < max_clicks)
            window_of_it.clicks_.push_back({action == GLFW_PRESS, window_of_it.mouse_});
    });
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // nothing is written beside what is asked for
    ImGui::StyleColorsDark();
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 330");
}

Window::~Window() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    ::glfwDestroyWindow(window_);
    ::glfwTerminate();
}

void Window::run(const std::atomic<bool>& stop, const std::function<void(ImVec2, const Input&)>& draw) {
    int turns = turns_after_input;
    while (!stop && !::glfwWindowShouldClose(window_)) {
        const double before = ::glfwGetTime();
        turns > 0 || !clicks_.empty() ? ::glfwPollEvents() : ::glfwWaitEventsTimeout(idle_s);
        turns = ::glfwGetTime() - before < idle_s && turns == 0 ? turns_after_input : std::max(0, turns - 1);
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        take_click();
        ImGui::NewFrame();
        draw(ImGui::GetIO().DisplaySize, std::exchange(input_, {}));
        ImGui::Render();
        int width = 0, height = 0;
        ::glfwGetFramebufferSize(window_, &width, &height);
        ::glViewport(0, 0, width, height);
        ::glClear(GL_COLOR_BUFFER_BIT);
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        ::glfwSwapBuffers(window_);
    }
}

void Window::take_click() {
    ImGuiIO& io = ImGui::GetIO();
    if (!clicks_.empty()) {
        const Click click = clicks_.front();
        clicks_.pop_front();
        is_down_ = click.is_down;
        io.MousePos = click.at;
        (is_down_ ? input_.pressed_at : input_.released_at) = click.at;
    }
    io.MouseDown[ImGuiMouseButton_Left] = is_down_;
}

void Window::redraw() {
    ::glfwPostEmptyEvent();
}

}  // namespace camrig::view
