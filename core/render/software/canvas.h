#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>

#include "core/base/image_size.h"

namespace camrig::render::software {

/// So many neighbouring pixels are worked on at once (lanes.h).
inline constexpr int lane_count = 8;

/// The rows of a Plane, by value: what is written through them cannot change where they are.
template <typename T>
struct Rows {
    T* data = nullptr;
    std::ptrdiff_t stride = 0;

    T* operator()(int y) const { return data + y * stride; }
};

/// A picture in memory with rows of whole groups of lanes, aligned to them.
template <typename T>
class Plane {
public:
    static_assert(sizeof(T) == 4);
    static constexpr std::size_t alignment = lane_count * sizeof(T);

    Plane() = default;
    /// All 0.
    explicit Plane(ImageSize size)
        : stride_(stride_for(size)),
          count_(static_cast<std::size_t>(bytes_for(size)) / sizeof(T)),
          data_(static_cast<T*>(::operator new(count_ * sizeof(T), std::align_val_t{alignment}))) {
        std::fill_n(data_.get(), count_, T{});
    }

    static std::int64_t bytes_for(ImageSize size) {
        return std::int64_t{stride_for(size)} * size.height * std::int64_t{sizeof(T)};
    }
    /// Makes this a plane of that size; what it held lies anywhere then.
    void fit(ImageSize size) {
        if (static_cast<std::size_t>(bytes_for(size)) > count_ * sizeof(T)) *this = Plane(size);
        stride_ = stride_for(size);
    }

    explicit operator bool() const { return data_ != nullptr; }
    Rows<T> rows() const { return {data_.get(), stride_}; }

private:
    static int stride_for(ImageSize size) { return (size.width + lane_count - 1) / lane_count * lane_count; }

    struct Free {
        void operator()(T* data) const { ::operator delete(data, std::align_val_t{alignment}); }
    };
    int stride_ = 0;
    std::size_t count_ = 0;
    std::unique_ptr<T[], Free> data_;
};

/// Depth where a camera sees nothing: in front of everything.
inline constexpr float blind_depth = std::numeric_limits<float>::infinity();

/// Linear light, not clamped, in aligned rows.
struct LightRows {
    Rows<float> red, green, blue;

    explicit operator bool() const { return red.data != nullptr; }
};

inline LightRows light_rows(const std::array<Plane<float>, 3>& planes) {
    return {planes[0].rows(), planes[1].rows(), planes[2].rows()};
}

/// What a view is drawn into: rows of whole groups of lanes; those of depth are aligned to them.
struct Canvas {
    Rows<std::uint32_t> color;  ///< rgba8
    Rows<float> depth;
    LightRows light;  ///< of a camera with a sensor, instead of colour
};

}  // namespace camrig::render::software
