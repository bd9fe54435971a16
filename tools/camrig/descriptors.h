#pragma once

namespace camrig::cli {

/// Lets the process open as many files and sockets as its bounds add up to, if the machine allows it: raises the soft
/// limit (RLIMIT_NOFILE), which shells set for programs that use select(), up to the hard one. One line in the log says
/// so when that is too low; then connections beyond it wait until others end.
void raise_descriptor_limit();

}  // namespace camrig::cli
