#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/base/time.h"

namespace camrig {

/// A frame rate as the exact fraction num/den frames per second, in lowest terms.
///
/// Frame n is due floor(n * den * 1e9 / num) ns after frame 0, in 128-bit integers: no drift at any n.
/// Limits: 1/10 .. 1000 frames per second (contract), num and den at most 1e9.
class Rate {
public:
    /// Default: 25 frames per second.
    Rate() = default;

    static Result<Rate> create(std::int64_t num, std::int64_t den);
    /// "25", "29.97" (taken as the decimal 2997/100) or "30000/1001".
    static Result<Rate> parse(std::string_view text);
    /// The shortest decimal that names the double, taken exactly: 0.1 is 1/10.
    static Result<Rate> from_number(double frames_per_second);

    std::int64_t num() const { return num_; }
    std::int64_t den() const { return den_; }
    double hertz() const { return static_cast<double>(num_) / static_cast<double>(den_); }
    /// Rounded period in ns; for pacing and display, never to sum up.
    TimeNs period_ns() const;

    /// When frame `n` (>= 0) is due, in ns after frame 0. Exact for every n whose answer is below max_time_ns.
    TimeNs time_of_frame(std::int64_t n) const;
    /// The smallest n >= 0 with time_of_frame(n) >= t_ns.
    std::int64_t first_frame_at_or_after(TimeNs t_ns) const;
    /// How many frames are due until t_ns, that time included; also the number of the first one after it.
    std::int64_t frames_until(TimeNs t_ns) const { return first_frame_at_or_after(t_ns + 1); }
    /// When the first frame after `after_ns` is due.
    TimeNs next_due_ns(TimeNs after_ns) const { return time_of_frame(frames_until(after_ns)); }

    /// "25" or "30000/1001".
    std::string to_string() const;

    friend bool operator==(const Rate&, const Rate&) = default;

private:
    std::int64_t num_ = 25;
    std::int64_t den_ = 1;
};

}  // namespace camrig
