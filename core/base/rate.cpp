#include "core/base/rate.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <utility>

namespace camrig {
namespace {

__extension__ typedef __int128 Int128;

constexpr std::int64_t max_term = 1'000'000'000;

std::unexpected<Error> bad_rate(std::string_view text) {
    return error(ErrorKind::invalid_argument,
                 "'" + std::string(text) + "' is not a frame rate; give a number or \"num/den\" from 1/10 to 1000");
}

/// Exact fraction of a decimal such as "29.97" or "1e-1". False if it is none or too long.
bool parse_decimal(std::string_view text, std::int64_t& num, std::int64_t& den) {
    num = 0;
    den = 1;
    bool seen_point = false;
    bool seen_digit = false;
    std::size_t i = 0;
    for (; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '.' && !seen_point) {
            seen_point = true;
        } else if (c >= '0' && c <= '9') {
            if (num > max_term * 1000 || (seen_point && den > max_term)) return false;
            num = num * 10 + (c - '0');
            if (seen_point) den *= 10;
            seen_digit = true;
        } else {
            break;
        }
    }
    if (!seen_digit) return false;
    if (i == text.size()) return true;
    if (text[i] != 'e' && text[i] != 'E') return false;
    int exponent = 0;
    const auto* begin = text.data() + i + 1;
    const auto* end = text.data() + text.size();
    if (begin != end && *begin == '+') ++begin;
    const auto parsed = std::from_chars(begin, end, exponent);
    if (parsed.ec != std::errc() || parsed.ptr != end || exponent < -9 || exponent > 9) return false;
    for (; exponent != 0; exponent += exponent > 0 ? -1 : 1) {
        if (num > max_term * 1000 || den > max_term * 1000) return false;
        (exponent > 0 ? num : den) *= 10;
    }
    return true;
}

/// The fraction of least terms that is this very double: the first such of its continued fraction.
std::optional<std::pair<std::int64_t, std::int64_t>> fraction_of(double value) {
    std::int64_t num = 1, den = 0, num_before = 0, den_before = 1;
    for (double rest = value;;) {
        const double whole = std::floor(rest);
        if (whole > static_cast<double>(max_term)) return std::nullopt;
        const auto term = static_cast<std::int64_t>(whole);
        num_before = std::exchange(num, term * num + num_before);
        den_before = std::exchange(den, term * den + den_before);
        if (num > max_term || den > max_term) return std::nullopt;
        if (static_cast<double>(num) / static_cast<double>(den) == value) return std::pair{num, den};
        if (rest == whole) return std::nullopt;
        rest = 1.0 / (rest - whole);
    }
}

}  // namespace

Result<Rate> Rate::create(std::int64_t num, std::int64_t den) {
    const std::string text = std::to_string(num) + "/" + std::to_string(den);
    if (num <= 0 || den <= 0) return bad_rate(text);
    const std::int64_t divisor = std::gcd(num, den);
    Rate rate;
    rate.num_ = num / divisor;
    rate.den_ = den / divisor;
    if (rate.num_ > max_term || rate.den_ > max_term) return bad_rate(text);
    const bool too_slow = Int128{rate.num_} * 10 < rate.den_;
    const bool too_fast = rate.num_ > Int128{rate.den_} * 1000;
    if (too_slow || too_fast) return bad_rate(text);
    return rate;
}

Result<Rate> Rate::parse(std::string_view text) {
    std::int64_t num = 0;
    std::int64_t den = 1;
    const std::size_t slash = text.find('/');
    if (slash == std::string_view::npos) {
        if (!parse_decimal(text, num, den)) return bad_rate(text);
        return create(num, den);
    }
    std::int64_t one = 1;
    if (!parse_decimal(text.substr(0, slash), num, one) || one != 1) return bad_rate(text);
    if (!parse_decimal(text.substr(slash + 1), den, one) || one != 1) return bad_rate(text);
    return create(num, den);
}

Result<Rate> Rate::from_number(double frames_per_second) {
    if (!std::isfinite(frames_per_second)) return bad_rate("nan or infinity");
    char text[32];
    const auto printed = std::to_chars(text, text + sizeof text, frames_per_second);
    auto rate = parse(std::string_view(text, static_cast<std::size_t>(printed.ptr - text)));
    if (rate || frames_per_second < 0.1 || frames_per_second > 1000.0) return rate;
    // 30000/1001 as a program prints it has more digits than a rate.
    const auto fraction = fraction_of(frames_per_second);
    return fraction ? create(fraction->first, fraction->second) : rate;
}

TimeNs Rate::period_ns() const {
    return static_cast<TimeNs>((Int128{den_} * ns_per_s + num_ / 2) / num_);
}

TimeNs Rate::time_of_frame(std::int64_t n) const {
    CHECK(n >= 0);
    return static_cast<TimeNs>(Int128{n} * den_ * ns_per_s / num_);
}

std::int64_t Rate::first_frame_at_or_after(TimeNs t_ns) const {
    if (t_ns <= 0) return 0;
    // floor(n * p) >= t  <=>  n * p >= t, because t is an integer.
    const Int128 period_num = Int128{den_} * ns_per_s;
    return static_cast<std::int64_t>((Int128{t_ns} * num_ + period_num - 1) / period_num);
}

std::string Rate::to_string() const {
    return den_ == 1 ? std::to_string(num_) : std::to_string(num_) + "/" + std::to_string(den_);
}

}  // namespace camrig
