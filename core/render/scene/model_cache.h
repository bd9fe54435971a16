#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "core/world/model.h"

namespace camrig::render::scene {

/// What is made of a Model to draw it, by the model's identity: made when first asked for, kept as long as anybody
/// holds the Model. The cache does not: several caches may know one, and none of them would ever see the last holder
/// go.
///
/// Thread: any. Who asks for what another thread is making waits until it is made.
template <typename Made>
class ModelCache {
public:
    /// `make(source)` makes it; what that throws comes out here, and the next call tries again. Good as long as
    /// somebody holds the source.
    template <typename Make>
    const Made& of(const world::ModelRef& source, const Make& make) {
        const std::shared_ptr<Entry> entry = entry_of(source);
        // No std::call_once: where what it calls throws, that hangs under the thread sanitizer.
        const std::lock_guard lock(entry->mutex);
        if (!entry->made) entry->made.emplace(make(source));
        return *entry->made;
    }
    /// Frees what was made of models that are gone.
    void evict_unused() {
        const std::lock_guard lock(mutex_);
        std::erase_if(entries_, [](const auto& entry) { return entry.second->source.expired(); });
    }

private:
    struct Entry {
        explicit Entry(const world::ModelRef& model) : source(model) {}
        std::weak_ptr<const world::Model> source;
        std::mutex mutex;
        std::optional<Made> made;
    };
    std::shared_ptr<Entry> entry_of(const world::ModelRef& source) {
        const std::lock_guard lock(mutex_);
        // A new model may lie where one that is gone has been.
        const auto found = entries_.find(source.get());
        if (found != entries_.end() && !found->second->source.expired()) return found->second;
        auto entry = std::make_shared<Entry>(source);
        entries_.insert_or_assign(source.get(), entry);
        return entry;
    }

    std::mutex mutex_;
    std::map<const world::Model*, std::shared_ptr<Entry>> entries_;
};

}  // namespace camrig::render::scene
