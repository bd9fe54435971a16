#pragma once

#include <new>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/result.h"

namespace camrig {

/// What `work` gives, a Result; resource_exhausted where memory ran out on the way. doing: "drawing", for the message.
template <typename Work>
std::invoke_result_t<Work> or_out_of_memory(std::string_view doing, const Work& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return error(ErrorKind::resource_exhausted,
                     "memory ran out while " + std::string(doing) + "; fewer or smaller cameras need less");
    }
}

}  // namespace camrig
