#include "tools/camrig/outputs.h"

// Of a test program that reads cameras: camrig's outputs are known before its first test.
namespace {
[[maybe_unused]] const bool is_registered = (camrig::cli::register_outputs(), true);
}
