#include "core/base/error_list.h"

#include <utility>

namespace camrig {
namespace {

thread_local ErrorList* current_list = nullptr;

}  // namespace

ErrorList::ErrorList() {
    CHECK(current_list == nullptr);
    current_list = this;
}

ErrorList::~ErrorList() {
    current_list = nullptr;
}

ErrorList::Pause::Pause() : list_(std::exchange(current_list, nullptr)) {}

ErrorList::Pause::~Pause() {
    current_list = list_;
}

ErrorList* ErrorList::current() {
    return current_list;
}

void ErrorList::add(const std::string& path, const std::string& message) {
    const std::string text = path.empty() ? message : path + ": " + message;
    if (texts_.contains(text)) return;
    if (errors_.size() >= max_errors) {
        ++left_out_;
        return;
    }
    texts_.insert(text);
    errors_.push_back({path, message});
}

void ErrorList::add(std::string_view known_path, const Error& error) {
    if (error.message.empty() || texts_.contains(error.message)) return;
    const auto colon = error.message.find(": ", known_path.size());
    if (!error.message.starts_with(known_path) || colon == std::string::npos) return add("", error.message);
    add(error.message.substr(0, colon), error.message.substr(colon + 2));
}

}  // namespace camrig
