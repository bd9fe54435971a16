#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace camrig {

/// An error of a document, and its place there.
struct PlacedError {
    std::string path;  ///< JSON path, as "cameras[0].fps"; empty: the document as a whole
    std::string message;
};

/// While one lives, readers of its thread (JsonReader, checks of names) tell it every error and read on, where they
/// end at the first without. Results are what they are without it: the first error.
///
///     ErrorList errors;
///     auto scene = load_scene(file);       // fails at the first error, or not at all
///     for (const PlacedError& each : errors.all()) ...
///
/// At most one exists per thread at a time.
class ErrorList {
public:
    static constexpr std::size_t max_errors = 100;

    ErrorList();
    ~ErrorList();
    ErrorList(const ErrorList&) = delete;
    ErrorList& operator=(const ErrorList&) = delete;

    /// While one lives, the thread has no list: another document is read, whose paths mean nothing here.
    class Pause {
    public:
        Pause();
        ~Pause();
        Pause(const Pause&) = delete;
        Pause& operator=(const Pause&) = delete;

    private:
        ErrorList* const list_;
    };

    /// The one that lives in this thread, or nullptr.
    static ErrorList* current();

    void add(const std::string& path, const std::string& message);
    /// An error whose message begins with its path, of which `known_path` is the beginning. One that is there already
    /// is not added again, so a nested reader's error may come by once more; one without words is not told.
    void add(std::string_view known_path, const Error& error);
    /// What bears this name could not be read: that others refer to it is no error of theirs.
    void excuse(std::string name) { excused_.insert(std::move(name)); }
    bool excuses(const std::string& name) const { return excused_.contains(name); }

    const std::vector<PlacedError>& all() const { return errors_; }
    /// Errors beyond max_errors.
    std::size_t left_out() const { return left_out_; }

private:
    std::vector<PlacedError> errors_;
    std::set<std::string> texts_;  ///< "path: message" of all
    std::set<std::string> excused_;
    std::size_t left_out_ = 0;
};

}  // namespace camrig
