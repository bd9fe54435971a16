#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/base/result.h"

namespace camrig::world {

/// Reads one PNG picture (ISO/IEC 15948) by libpng. Errors say what is wrong in libpng's words; memory for pixels is
/// the caller's, who has seen what the picture claims to be.
class PngReader {
public:
    /// The file outlives it. resource_exhausted: libpng has no memory.
    static Result<PngReader> open(std::span<const std::byte> file);
    PngReader(PngReader&&) noexcept;
    PngReader& operator=(PngReader&&) = delete;
    ~PngReader();

    std::uint32_t width() const;
    std::uint32_t height() const;
    int bit_depth() const;
    bool is_gray() const;  ///< and has no alpha
    /// Of a row as it is stored.
    std::size_t row_bytes() const;

    /// All rows, one of the two, once: as 8-bit RGBA, or as they are stored (numbers of 16 bits high byte first).
    Result<void> read_rgba(std::uint8_t* pixels);
    Result<void> read_stored(std::uint8_t* rows);

private:
    struct State;
    explicit PngReader(std::unique_ptr<State> state);
    Result<void> failed() const;

    std::unique_ptr<State> state_;
};

}  // namespace camrig::world
