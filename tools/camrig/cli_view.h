#pragma once

#include <string>
#include <vector>

namespace camrig::cli {

/// Becomes the window's program: $CAMRIG_VIEW, else camrig-view beside this program, in ../lib/camrig, or in the build
/// tree of this program. Returns only on failure, after one line on stderr.
int exec_view(const std::vector<std::string>& arguments);

}  // namespace camrig::cli
