#include "core/codec/bytes_recycler.h"

#include <mutex>

namespace camrig::codec {

struct BytesRecycler::Shelf {
    std::mutex mutex;
    std::vector<std::unique_ptr<std::vector<std::byte>>> idle;
};

BytesRecycler::BytesRecycler() : shelf_(std::make_shared<Shelf>()) {
    shelf_->idle.reserve(max_idle);
}

std::shared_ptr<std::vector<std::byte>> BytesRecycler::acquire() {
    std::unique_ptr<std::vector<std::byte>> bytes;
    {
        std::lock_guard lock(shelf_->mutex);
        if (!shelf_->idle.empty()) {
            bytes = std::move(shelf_->idle.back());
            shelf_->idle.pop_back();
        }
    }
    if (!bytes) bytes = std::make_unique<std::vector<std::byte>>();
    return {bytes.release(), [shelf = shelf_](std::vector<std::byte>* raw) {
                std::unique_ptr<std::vector<std::byte>> used(raw);
                used->clear();
                std::lock_guard lock(shelf->mutex);
                if (shelf->idle.size() < max_idle) shelf->idle.push_back(std::move(used));
            }};
}

}  // namespace camrig::codec
