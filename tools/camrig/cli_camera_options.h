#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/field.h"
#include "core/base/result.h"

namespace CLI {
class App;
}

namespace camrig::cli {

/// The camera options of `camera create` and `camera set`, as typed. Those of the table of camera fields that are a
/// number, a text, a truth value, or an object that is given in part, come from there.
struct CameraOptions {
    struct FromTable {
        Field field;
        std::vector<std::string> values;  ///< of an object NAME=VALUE, else at most one
        bool is_on = false, is_off = false;
    };
    std::deque<FromTable> from_table;
    /// One of each family: --KIND with the value of its key, if it has one, and --KIND-OPTION.
    struct GivenOutput {
        std::string kind;
        bool is_on = false;  ///< of a family without a key
        std::deque<FromTable> options;
    };
    std::deque<GivenOutput> outputs;
    std::string size, fps, position, look_at, orientation, intrinsics, lens;
    std::optional<std::string> mount;
    std::string calibration, calibration_camera;
    std::optional<double> pan_deg, tilt_deg, roll_deg;
    bool no_outputs = false;

    void add_to(CLI::App& command);
    bool has_pose() const;
    bool has_angles() const { return pan_deg || tilt_deg || roll_deg; }
};

/// The parameters of camera.create or camera.set. `present_pose` fills in what a pose leaves open: the place when only
/// the direction is given, the direction when only the place is, and the other angles. null: nothing is there yet.
Result<nlohmann::json> camera_params(const CameraOptions& options, const nlohmann::json& present_pose);

}  // namespace camrig::cli
