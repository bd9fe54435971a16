#pragma once

#include <memory>

#include "core/codec/encoder.h"

namespace camrig::codec {

/// Hands out vectors of encoded bytes and takes their memory back when the last reader is done, so that steady state
/// allocates no buffers. Any thread; what it hands out may outlive it. Keeps at most `max_idle` vectors.
class BytesRecycler {
public:
    BytesRecycler();

    /// An empty vector, with the capacity of an earlier one where there is one.
    std::shared_ptr<std::vector<std::byte>> acquire();

    /// Readers hold a few units at a time: one on its way to each and one in a mailbox.
    static constexpr std::size_t max_idle = 4;

private:
    struct Shelf;
    std::shared_ptr<Shelf> shelf_;
};

}  // namespace camrig::codec
