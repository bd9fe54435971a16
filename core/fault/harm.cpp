#include "core/fault/harm.h"

#include <algorithm>
#include <tuple>

#include "core/fault/fault_plan.h"

namespace camrig::fault {

void Harm::add(std::size_t offset, std::size_t count) {
    if (count == 0) return;
    bytes += count;
    if (runs > 0 && runs == first.size() && first.back().offset + first.back().bytes == offset) {
        first.back().bytes += count;
        return;
    }
    ++runs;
    if (first.size() < max_runs) first.push_back({offset, count});
}

void Harm::add_changes(std::span<const std::byte> before, std::span<const std::byte> after, std::size_t offset) {
    for (std::size_t i = 0; i < before.size();) {
        std::size_t end = i;
        while (end < before.size() && before[end] != after[end]) ++end;
        add(offset + i, end - i);
        i = end + 1;
    }
}

void HarmLog::add(std::string_view output, const Harm& harm) {
    if (harm.bytes == 0) return;
    std::lock_guard lock(mutex_);
    auto of = kept_.find(output);
    if (of == kept_.end()) of = kept_.emplace(output, Entries{}).first;
    Entries& entries = of->second;
    const auto same = std::ranges::find(entries.first, harm, &Entry::harm);
    if (same != entries.first.end()) {
        ++same->times;
    } else if (entries.first.size() < max_entries) {
        entries.first.push_back({harm});
    } else {
        ++entries.left_out;
    }
}

HarmLog::Entries HarmLog::entries(std::string_view output) const {
    Entries found;
    {
        std::lock_guard lock(mutex_);
        if (const auto of = kept_.find(output); of != kept_.end()) found = of->second;
    }
    std::ranges::sort(found.first, {}, [](const Entry& one) {
        const std::size_t begin = one.harm.first.empty() ? 0 : one.harm.first.front().offset;
        return std::tuple(one.harm.size, one.harm.fault, one.harm.bytes, begin);
    });
    return found;
}

void note(const FrameFaults& faults, std::string_view output, const Harm& harm) {
    if (faults.harms) faults.harms->add(output, harm);
}

}  // namespace camrig::fault
