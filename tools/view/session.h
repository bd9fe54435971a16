#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include <camrig/rig.h>

#include "tools/view/camera_drag.h"
#include "tools/view/fly_camera.h"
#include "tools/view/picture_link.h"
#include "tools/view/rig_link.h"
#include "tools/view/textures.h"
#include "tools/view/timeline.h"

namespace camrig::view {

inline constexpr const char* world_texture = "/world";  ///< of the picture of the world: no camera's name

/// What the panels share: the links to the rig, what is chosen, where one looks from. Thread: the window's.
struct Session {
    Session(const client::Rig& rig, const std::string& own, std::filesystem::path file,
            const std::function<void()>& changed)
        : own_camera(own), arrangement(std::move(file)), link(rig, own, changed), pictures(rig, own, changed) {}

    const std::string own_camera;
    const std::filesystem::path arrangement;  ///< where "save" writes
    RigLink link;
    PictureLink pictures;
    Textures textures;
    RigModel model;  ///< of this turn of the window
    Timeline timeline;

    FlyCamera fly;
    bool has_looked = false;  ///< whether fly has been put where there is something to see
    std::string selected;
    std::string notice;  ///< what has just happened: saved, refused, ...

    /// What the person is asked before it is done; until they answer nothing else is.
    struct Question {
        std::string words;
        std::string yes;  ///< on the button
        std::function<void()> act;
    };
    std::optional<Question> question;
    void answer(bool is_yes);

    std::optional<CameraDrag> drag;
    std::optional<ImVec2> pressed_at, released_at;  ///< the left mouse button in this turn
    /// Poses that were dragged to and are not in the model yet.
    std::map<std::string, camera::Pose> moved;

    /// Where a camera is for the person at the window: in the world, with what they have just done.
    camera::Pose pose_of_camera(const client::CameraState& camera) const;
    /// In the pictures and for the rig at once. Not for mounted cameras, whose pose is in another frame.
    void move_camera(const client::CameraState& camera, const camera::Pose& pose);
    /// The same by hand, which undo() takes back as a whole.
    void drag_camera(const client::CameraState& camera, const camera::Pose& pose);
    /// A name for a camera to be made: `name`, or one like it, that no camera has and none that is being made.
    std::string unused(std::string name) const;
    void create_camera();
    void duplicate_selected();
    /// Asks first.
    void delete_selected();
    /// Asks before it overwrites a file.
    void save();
    /// The last deletion or drag that was not undone yet; as many as max_undos.
    void undo();
    /// Realtime only.
    void play_or_pause();
    /// Lockstep, or paused: the only thing here that moves a world, and only a person's hand does it.
    void step(std::chrono::nanoseconds how_far);
    /// Takes what is new from the links.
    void update();

private:
    static constexpr std::size_t max_undos = 64;
    struct Undo {
        std::string words;
        std::function<void()> act;
    };

    void remember(std::string words, std::function<void()> act);
    void delete_camera(const std::string& name);
    void write_file();

    std::deque<Undo> undos_;  ///< the newest last
};

}  // namespace camrig::view
