#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include <camrig/rig.h>

#include "tools/view/rig_model.h"
#include "tools/view/worker.h"

namespace camrig::view {

/// The rig's state for the window, and the window's edits for the rig.
///
/// Thread: the window's; the rig is asked on threads of this class. Edits are done in order; one with the key of an
/// earlier one that was not begun takes its place, so that a drag sends no more than the rig takes.
class RigLink {
public:
    /// `own_camera` is left out of the model. `changed` is called on another thread whenever there is something new to
    /// show.
    RigLink(client::Rig rig, std::string own_camera, std::function<void()> changed);
    /// Does what still waits.
    ~RigLink();

    RigModel model() const;
    using Edit = std::function<void(const client::Rig&)>;
    void edit(std::string key, Edit edit);
    /// One that no later one takes the place of.
    void order(Edit edit);
    void set_camera(const std::string& name, const std::string& key, client::CameraOptions options);
    /// As the rig describes them: parameters of cameras, without those that have controls of their own (`camera`), and
    /// kinds of outputs (`outputs`) and of faults (`faults`). Null until it has answered.
    nlohmann::json description() const;
    /// Whether an edit with this key waits or is not yet in the model.
    bool is_pending(const std::string& key) const;
    /// For edits, which are done on another thread: what the person is to be told of how they went.
    void tell(std::string words);
    /// The last of it, once.
    std::optional<std::string> take_told();

private:
    std::chrono::milliseconds turn();
    std::chrono::milliseconds follow_events();
    /// Does all that wait; true if any was done.
    bool do_edits();
    void refresh();

    static constexpr std::size_t max_edits = 64;

    const client::Rig rig_;
    const std::string own_camera_;
    const std::function<void()> changed_;
    mutable std::mutex mutex_;
    RigModel model_;                                  ///< guarded by mutex_
    nlohmann::json description_;                      ///< guarded by mutex_
    std::deque<std::pair<std::string, Edit>> edits_;  ///< guarded by mutex_
    std::set<std::string> in_work_;                   ///< guarded by mutex_
    std::optional<std::string> told_;                 ///< guarded by mutex_
    std::uint64_t orders_ = 0;                        ///< guarded by mutex_
    std::int64_t last_firing_ = 0;                    ///< of the thread that follows events
    std::optional<Worker> worker_;
    std::optional<Worker> events_;
};

}  // namespace camrig::view
