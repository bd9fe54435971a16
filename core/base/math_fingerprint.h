#pragma once

#include <cstdint>

namespace camrig {

/// A digest of 10^5 results of the functions that the world uses (portable::, and what IEEE 754 prescribes), as this
/// program computes them on this processor now. Worlds of one scene go on equally only where it is equal. About 10 ms.
std::uint64_t math_fingerprint();

}  // namespace camrig
