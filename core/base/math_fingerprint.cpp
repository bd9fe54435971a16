#include "core/base/math_fingerprint.h"

#include <cmath>

#include "core/base/digest.h"
#include "core/base/portable_math.h"
#include "core/base/random.h"

namespace camrig {

std::uint64_t math_fingerprint() {
    constexpr std::uint64_t seed = 20, arguments = 10'000;
    Digest digest;
    for (std::uint64_t i = 0; i < arguments; ++i) {
        const double x = 200.0 * random_unit(seed, 0, i) - 100.0, y = 200.0 * random_unit(seed, 1, i) - 100.0;
        digest.add(portable::sin(x), portable::cos(x), portable::tan(x), portable::atan2(x, y), portable::log(x * x));
        digest.add(portable::exp(0.1 * x), std::sqrt(x * x + y * y), std::hypot(x, y), std::floor(x), std::fmod(x, y));
        digest.add(x * y + x);  // fused where it must not be
    }
    return digest.value();
}

}  // namespace camrig
