#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>

#include "core/base/image_size.h"

namespace camrig {

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
    explicit Plane(ImageSize size)
        : stride_((size.width + lane_count - 1) / lane_count * lane_count),
          count_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(size.height)),
          data_(static_cast<T*>(::operator new(count_ * sizeof(T), std::align_val_t{alignment}))) {}

    explicit operator bool() const { return data_ != nullptr; }
    int stride() const { return stride_; }
    std::size_t count() const { return count_; }
    std::int64_t bytes() const { return static_cast<std::int64_t>(count_ * sizeof(T)); }
    T* data() const { return data_.get(); }
    T* row(int y) const { return data_.get() + static_cast<std::ptrdiff_t>(y) * stride_; }
    Rows<T> rows() const { return {data_.get(), stride_}; }

private:
    struct Free {
        void operator()(T* data) const { ::operator delete(data, std::align_val_t{alignment}); }
    };
    int stride_ = 0;
    std::size_t count_ = 0;
    std::unique_ptr<T[], Free> data_;
};

/// What a view is drawn into.
struct Canvas {
    ImageSize size;
    Plane<std::uint32_t> color;  ///< rgba8
    Plane<float> depth;
};

}  // namespace camrig
