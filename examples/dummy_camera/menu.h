#pragma once

#include <iosfwd>

#include <camrig/client.h>

namespace dummy {

/// The console menu: one command a line, until `q` or the end of the input. Needs no display.
void run_menu(const camrig::client::Rig& rig, const camrig::client::Camera& camera, std::istream& in,
              std::ostream& out);

}  // namespace dummy
