#pragma once

#include "tools/camrig/cli_context.h"

namespace CLI {
class App;
}

namespace camrig::cli {

/// The commands of `plate`.
void add_plate_calibrate(CLI::App& plate, CliContext& context);
void add_plate_light(CLI::App& plate, CliContext& context);

}  // namespace camrig::cli
