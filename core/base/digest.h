#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>

namespace camrig {

/// A number that tells states apart: FNV-1a with 64 bits (Fowler, Noll, Vo) over the bits of what it is given, in this
/// order. Equal input gives equal digests on every machine; it is no protection against who wants them equal.
class Digest {
public:
    void add(std::uint64_t bits) {
        for (int i = 0; i < 8; ++i) add_byte((bits >> (8 * i)) & 0xff);
    }
    void add(std::int64_t number) { add(static_cast<std::uint64_t>(number)); }
    void add(std::uint32_t number) { add(std::uint64_t{number}); }
    void add(int number) { add(std::int64_t{number}); }
    void add(bool is_so) { add(std::uint64_t{is_so}); }
    void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
    void add(float number) { add(double{number}); }
    void add(std::string_view text) {
        add(std::uint64_t{text.size()});
        for (const char one : text) add_byte(static_cast<unsigned char>(one));
    }
    void add(const char* text) { add(std::string_view(text)); }
    /// Bytes as they are, without their number: pieces of one file.
    void add_bytes(std::string_view bytes) {
        for (const char one : bytes) add_byte(static_cast<unsigned char>(one));
    }
    template <typename T>
    void add(const std::optional<T>& value) {
        add(value.has_value());
        if (value) add(*value);
    }
    /// A vector, or a quaternion, by its parts.
    template <typename V>
        requires requires(const V& v) {
            v[0];
            V::length();
        }
    void add(const V& v) {
        for (int i = 0; i < V::length(); ++i) add(v[i]);
    }
    template <typename... Parts>
        requires(sizeof...(Parts) > 1)
    void add(const Parts&... parts) {
        (add(parts), ...);
    }
    std::uint64_t value() const { return value_; }

private:
    void add_byte(std::uint64_t byte) {
        value_ ^= byte;
        value_ *= 0x100000001b3u;
    }
    std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace camrig
