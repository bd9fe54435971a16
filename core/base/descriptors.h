#pragma once

#include <string>

namespace camrig {

/// What clients of the network leave free: for the owner on the Unix socket, who is never refused, for files of the rig
/// itself, and for GLib, which ends the process where it finds none for its own needs (g_wakeup_new).
inline constexpr int reserved_descriptors = 48;
/// The error text where a connection or stream is refused because descriptors are short.
inline constexpr const char* too_many_files =
    "too many open files; close some connections, or raise the limit (ulimit -n)";

/// Are fewer descriptors than `reserve` free? Takes none itself. Any thread.
bool descriptors_are_short(int reserve = reserved_descriptors);

/// Lets the process open as many files and sockets as its bounds add up to, if the machine allows it: raises the soft
/// limit (RLIMIT_NOFILE), which shells set for programs that use select(), up to the hard one. What is wrong with it
/// then, for the log: it is too low, and connections beyond it wait until others end. Empty: nothing.
[[nodiscard]] std::string raise_descriptor_limit();

}  // namespace camrig
