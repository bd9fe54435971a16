#pragma once

#include <camrig/client.h>

namespace dummy {

/// A window with the camera's live picture, a button for every move, and the same keys as the menu; ends with q, Escape
/// or when it is closed. Throws cv::Exception where there is no display.
void run_window(const camrig::client::Camera& camera);

}  // namespace dummy
