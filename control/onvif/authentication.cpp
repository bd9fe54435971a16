#include "control/onvif/authentication.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>

#include <openssl/evp.h>
#include <openssl/rand.h>

#include "core/base/base64.h"
#include "core/base/result.h"
#include "core/base/token.h"

namespace camrig::onvif {
namespace {

constexpr std::string_view realm = "camrig";
constexpr std::size_t max_nonce_bytes = 256;

/// nullopt: OpenSSL has no such hash, or may not make one.
std::optional<std::string> hash(const EVP_MD* kind, std::string_view text) {
    unsigned char bytes[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    if (EVP_Digest(text.data(), text.size(), bytes, &size, kind, nullptr) != 1) return std::nullopt;
    return std::string(reinterpret_cast<const char*>(bytes), size);
}

std::string hex(std::string_view bytes) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const char one : bytes) {
        text += digits[static_cast<unsigned char>(one) >> 4];
        text += digits[static_cast<unsigned char>(one) & 15];
    }
    return text;
}

struct HttpAlgorithm {
    std::string_view name;
    const EVP_MD* kind;
    std::optional<std::string> hash_of(std::string_view text) const {
        const auto bytes = hash(kind, text);
        return bytes ? std::optional(hex(*bytes)) : std::nullopt;
    }
};

/// RFC 7616, 3.3: no name is MD5.
std::optional<HttpAlgorithm> http_algorithm(std::string_view name) {
    if (name.empty() || name == "MD5") return HttpAlgorithm{"MD5", EVP_md5()};
    if (name == "SHA-256") return HttpAlgorithm{"SHA-256", EVP_sha256()};
    return std::nullopt;
}

std::string random_bytes() {
    std::string bytes(32, '\0');
    CHECK(RAND_bytes(reinterpret_cast<unsigned char*>(bytes.data()), static_cast<int>(bytes.size())) == 1);
    return bytes;
}

/// Of `Digest name="value", name=value`: RFC 7616, 3.4. Empty: it is none.
std::map<std::string, std::string, std::less<>> digest_fields(std::string_view text) {
    constexpr std::string_view scheme = "Digest ";
    std::map<std::string, std::string, std::less<>> fields;
    if (!text.starts_with(scheme)) return fields;
    text.remove_prefix(scheme.size());
    while (!text.empty()) {
        text.remove_prefix(std::min(text.find_first_not_of(" ,\t"), text.size()));
        const std::size_t equals = text.find('=');
        if (equals == std::string_view::npos) break;
        const std::string name(text.substr(0, equals));
        text.remove_prefix(equals + 1);
        const bool is_quoted = text.starts_with('"');
        if (is_quoted) text.remove_prefix(1);
        const std::size_t end = std::min(text.find_first_of(is_quoted ? "\"" : ", \t"), text.size());
        fields[name] = std::string(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return fields;
}

}  // namespace

Authentication::Authentication(std::string token, std::vector<User> users)
    : token_(std::move(token)), users_(std::move(users)), secret_(random_bytes()) {}

template <typename IsRight>
std::optional<Role> Authentication::find(std::string_view name, IsRight is_right) const {
    const auto user = std::ranges::find(users_, name, &User::name);
    if (user != users_.end() && is_right(user->password)) return user->role;
    if (!token_.empty() && is_right(token_)) return Role::administrator;
    return std::nullopt;
}

bool Authentication::remember(const std::string& digest) {
    const std::lock_guard lock(mutex_);
    if (!digests_.insert(digest).second) return false;
    digests_by_age_.push_back(digest);
    if (digests_by_age_.size() > max_digests) {
        digests_.erase(digests_by_age_.front());
        digests_by_age_.pop_front();
    }
    return true;
}

std::optional<Role> Authentication::role_of(const UsernameToken& token, TimeNs now_ns) {
    if (is_open()) return Role::administrator;
    if (!token.is_digest)
        return find(token.name, [&](const std::string& password) { return equal_tokens(token.password, password); });
    const auto nonce = base64_decode(token.nonce);
    const auto created = time_of_text(token.created);
    if (!nonce || nonce->size() > max_nonce_bytes || !created) return std::nullopt;
    if (*created < now_ns - max_skew_ns || *created > now_ns + max_skew_ns) return std::nullopt;
    std::string begin(reinterpret_cast<const char*>(nonce->data()), nonce->size());
    begin.append(token.created);
    std::string right;
    const auto role = find(token.name, [&](const std::string& password) {
        const auto digest = hash(EVP_sha1(), begin + password);
        if (!digest || !equal_tokens(token.password, base64_encode(std::as_bytes(std::span(*digest))))) return false;
        right = *digest;
        return true;
    });
    // Not the texts: the same nonce can be written in several ways.
    return role && remember(right) ? role : std::nullopt;
}

std::string Authentication::http_nonce(TimeNs made_ns) const {
    const std::string time = std::to_string(made_ns);
    const auto made = hash(EVP_sha256(), time + secret_);
    return made ? time + "-" + hex(*made) : "";
}

std::string Authentication::http_challenge(TimeNs now_ns, bool is_stale) const {
    const char* const algorithm = hash(EVP_md5(), "") ? "MD5" : "SHA-256";
    return "Digest realm=\"" + std::string(realm) + "\", qop=\"auth\", nonce=\"" + http_nonce(now_ns) +
           "\", algorithm=" + algorithm + (is_stale ? ", stale=true" : "");
}

Authentication::HttpCaller Authentication::http_caller(std::string_view method, std::string_view target,
                                                       std::string_view authorization, TimeNs now_ns) {
    auto fields = digest_fields(authorization);
    const std::string& nonce = fields["nonce"];
    TimeNs made_ns = 0;
    std::from_chars(nonce.data(), nonce.data() + nonce.size(), made_ns);
    if (nonce.empty() || made_ns < 0 || made_ns > now_ns || !equal_tokens(nonce, http_nonce(made_ns))) return {};
    if (fields["realm"] != realm || fields["uri"] != target) return {};
    const auto algorithm = http_algorithm(fields["algorithm"]);
    if (!algorithm) return {};
    const std::string chosen =
        fields["qop"].empty() ? "" : fields["nc"] + ":" + fields["cnonce"] + ":" + fields["qop"] + ":";
    const auto asked = algorithm->hash_of(std::string(method) + ":" + std::string(target));
    const std::string& name = fields["username"];
    const auto role = find(name, [&](const std::string& password) {
        const auto who = algorithm->hash_of(name + ":" + std::string(realm) + ":" + password);
        if (!who || !asked) return false;
        const auto expected = algorithm->hash_of(*who + ":" + nonce + ":" + chosen + *asked);
        return expected && equal_tokens(fields["response"], *expected);
    });
    if (!role) return {};
    if (now_ns - made_ns > max_skew_ns || !remember(fields["response"])) return {std::nullopt, true};
    return {role};
}

std::optional<TimeNs> time_of_text(std::string_view text) {
    constexpr std::size_t longest = 40;
    if (text.size() > longest) return std::nullopt;
    const std::string date(text);
    int year = 0, used = 0;
    unsigned month = 0, day = 0, hour = 0, minute = 0, second = 0;
    if (std::sscanf(date.c_str(), "%4d-%2u-%2uT%2u:%2u:%2u%n", &year, &month, &day, &hour, &minute, &second, &used) !=
        6)
        return std::nullopt;
    const std::chrono::year_month_day when{std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)};
    if (!when.ok() || year < 1900 || year > 2200 || hour > 23 || minute > 59 || second > 60) return std::nullopt;
    std::string_view rest = std::string_view(date).substr(static_cast<std::size_t>(used));
    if (rest.starts_with('.')) rest.remove_prefix(std::min(rest.find_first_not_of("0123456789", 1), rest.size()));
    std::chrono::minutes ahead{0};  // of UTC
    if (!rest.empty() && rest != "Z") {
        constexpr unsigned most_hours = 14;
        char sign = 0;
        unsigned hours = 0, minutes = 0;
        int all = 0;
        if (std::sscanf(rest.data(), "%c%2u:%2u%n", &sign, &hours, &minutes, &all) != 3 ||
            static_cast<std::size_t>(all) != rest.size() || (sign != '+' && sign != '-') || hours > most_hours ||
            minutes > 59)
            return std::nullopt;
        ahead = std::chrono::hours(hours) + std::chrono::minutes(minutes);
        if (sign == '-') ahead = -ahead;
    }
    const auto seconds = std::chrono::sys_days(when).time_since_epoch() + std::chrono::hours(hour) +
                         std::chrono::minutes(minute) + std::chrono::seconds(second) - ahead;
    return std::chrono::nanoseconds(seconds).count();
}

std::string text_of_time(TimeNs utc_ns) {
    // A camera's clock may be before 1970, where rounding to 0 would name the next second.
    const auto at = std::chrono::floor<std::chrono::seconds>(std::chrono::sys_time(std::chrono::nanoseconds(utc_ns)));
    const auto days = std::chrono::floor<std::chrono::days>(at);
    const std::chrono::year_month_day date(days);
    const std::chrono::hh_mm_ss time(at - days);
    char text[40];
    std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02dZ", static_cast<int>(date.year()),
                  static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                  static_cast<int>(time.hours().count()), static_cast<int>(time.minutes().count()),
                  static_cast<int>(time.seconds().count()));
    return text;
}

}  // namespace camrig::onvif
