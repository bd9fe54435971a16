#include "window.h"

#include <algorithm>

#include <camrig/opencv.h>
#include <opencv2/highgui.hpp>
#include <opencv2/imgproc.hpp>

#include "moves.h"

namespace dummy {
namespace {

constexpr int button_width = 150;
constexpr int button_height = 36;
constexpr int columns = 4;
constexpr int frame_ms = 40;

/// Buttons are drawn into the picture and found by their place: HighGUI's own exist only with Qt.
struct Panel {
    cv::Size picture;
    char clicked = 0;

    cv::Rect button(std::size_t index) const {
        const int i = static_cast<int>(index);
        return {i % columns * button_width + 4, picture.height + i / columns * button_height + 4, button_width - 8,
                button_height - 8};
    }
    cv::Size size() const {
        const int rows = (static_cast<int>(moves().size()) + columns - 1) / columns;
        return {std::max(picture.width, columns * button_width), picture.height + rows * button_height + 28};
    }
};

void on_mouse(int event, int x, int y, int, void* data) {
    auto& panel = *static_cast<Panel*>(data);
    if (event != cv::EVENT_LBUTTONDOWN) return;
    for (std::size_t i = 0; i < moves().size(); ++i)
        if (panel.button(i).contains({x, y})) panel.clicked = moves()[i].key;
}

cv::Mat draw(const Panel& panel, const cv::Mat& picture, const std::string& words) {
    cv::Mat canvas(panel.size(), CV_8UC3, cv::Scalar(40, 36, 32));
    picture.copyTo(canvas(cv::Rect({0, 0}, picture.size())));
    const auto write = [&](const std::string& text, cv::Point at) {
        cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, {230, 230, 230}, 1, cv::LINE_AA);
    };
    for (std::size_t i = 0; i < moves().size(); ++i) {
        const cv::Rect box = panel.button(i);
        cv::rectangle(canvas, box, {110, 90, 70}, cv::FILLED);
        write(std::string(1, moves()[i].key) + "  " + moves()[i].label, box.tl() + cv::Point(8, 18));
    }
    write(words, {8, canvas.rows - 10});
    return canvas;
}

}  // namespace

void run_window(const camrig::client::Camera& camera) {
    const std::string title = "camrig: " + camera.name();
    Panel panel;
    cv::namedWindow(title, cv::WINDOW_AUTOSIZE | cv::WINDOW_GUI_NORMAL);  // without Qt's tool bar
    cv::setMouseCallback(title, on_mouse, &panel);
    while (true) {
        const cv::Mat picture = to_mat(camera.frame());
        panel.picture = picture.size();
        cv::imshow(title, draw(panel, picture, describe(camera.get())));
        const int key = cv::waitKey(frame_ms);
        if (key == 'q' || key == 27 || cv::getWindowProperty(title, cv::WND_PROP_VISIBLE) < 1) break;
        if (key > 0) do_move(camera, static_cast<char>(key));
        if (panel.clicked != 0) do_move(camera, std::exchange(panel.clicked, '\0'));
    }
    cv::destroyWindow(title);
}

}  // namespace dummy
