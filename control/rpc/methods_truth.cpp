#include <algorithm>

#include "control/rpc/method_fields.h"
#include "control/rpc/methods.h"
#include "core/truth/network.h"
#include "core/truth/truth_json.h"

namespace camrig::control {

namespace {

constexpr std::size_t max_names = 256;

/// What truth.network is asked.
struct NetworkQuestion {
    std::vector<std::string> cameras;
    std::vector<std::string> classes;
    truth::GroundGrid ground;
};

template <auto member>
auto names_at(Field field) {
    field.type = "array of strings";
    return world::entry_by<member>(std::move(field), [](JsonReader& reader, std::string_view key, auto& out) {
        for (const nlohmann::json& item : reader.array(key, max_names)) {
            if (!item.is_string()) return reader.fail(key, "has an item that is no string");
            out.push_back(item);
        }
    });
}

template <double truth::GroundGrid::* member>
FieldOf<NetworkQuestion> ground_at(Field field) {
    field.type = "number";
    field.unit = "m";
    FieldOf<NetworkQuestion> entry{.field = field};
    entry.read = [field](JsonReader& reader, Changes<NetworkQuestion>& changes) {
        if (const auto value = read_value<double>(reader, field))
            changes.change([value](NetworkQuestion& question) { question.ground.*member = *value; });
    };
    return entry;
}

std::vector<FieldOf<NetworkQuestion>> network_fields() {
    return {
        names_at<&NetworkQuestion::cameras>({.name = "cameras", .doc = "their names; left out: all"}),
        names_at<&NetworkQuestion::classes>(
            {.name = "classes", .doc = "only objects of these classes, as `person`; left out: of all"}),
        ground_at<&truth::GroundGrid::cell_m>({.name = "cell_m",
                                               .doc = "side of the squares in which ground is counted",
                                               .fallback = "0.5",
                                               .range = {0.05, 10.0}}),
        ground_at<&truth::GroundGrid::range_m>({.name = "range_m",
                                                .doc = "so far from a camera, along x and y, ground counts",
                                                .fallback = "30",
                                                .range = {1.0, 1000.0}}),
        ground_at<&truth::GroundGrid::height_m>({.name = "ground_z", .doc = "height of the ground", .fallback = "0"})};
}

/// Asks for the truth of one camera after the other, all of one instant.
class NetworkQuest : public std::enable_shared_from_this<NetworkQuest> {
public:
    NetworkQuest(RpcContext& context, NetworkQuestion question, RpcReply done)
        : context_(context), question_(std::move(question)), done_(std::move(done)) {}

    void begin() {
        ask(engine::GetInstant{}, [this](const auto& instant) {
            instant_ = instant;
            if (!question_.cameras.empty()) return next();
            ask(engine::ListCameras{}, [this](const auto& cameras) {
                for (const engine::CameraReply& camera : cameras)
                    question_.cameras.push_back(camera.camera.spec()->name);
                next();
            });
        });
    }

private:
    template <typename C, typename Then>
    void ask(C command, Then then) {
        auto answered = [self = shared_from_this(), then](const Result<typename C::Reply>& reply) {
            if (!reply) return self->done_(std::unexpected(reply.error()));
            then(reply.value());
        };
        context_.commands.post(engine::Request<C>{std::move(command), std::move(answered)});
    }
    void next() {
        if (truths_.size() == question_.cameras.size()) return answer();
        ask(engine::GetTruth{question_.cameras[truths_.size()], 0, instant_, question_.ground},
            [this](const auto& truth) {
                truths_.push_back(truth);
                next();
            });
    }
    void answer() {
        std::function<void()> job = [self = shared_from_this()] {
            self->done_(unless_out_of_memory([&] {
                return RpcResult(
                    network_to_json(network_of(self->truths_, self->question_.ground, self->question_.classes)));
            }));
        };
        if (!context_.replies->post(std::move(job))) job();
    }

    RpcContext& context_;
    NetworkQuestion question_;
    RpcReply done_;
    std::shared_ptr<const engine::HeldInstant> instant_;
    std::vector<truth::TruthRef> truths_;
};

void get_network(RpcContext& context, const nlohmann::json& params, RpcReply done) {
    JsonReader reader(params, "");
    auto question =
        read_all<NetworkQuestion>(network_fields(), reader, [](const NetworkQuestion& asked, JsonReader& keys) {
            std::vector<std::string> names = asked.cameras;
            std::ranges::sort(names);
            if (std::ranges::adjacent_find(names) != names.end()) keys.fail("cameras", "names one of them twice");
            const double side = 2.0 * asked.ground.range_m / asked.ground.cell_m;
            if (side * side > truth::max_ground_cells)
                keys.fail("range_m", "is too far for squares so small: at most " +
                                         std::to_string(truth::max_ground_cells) +
                                         " of them a camera, (2 range_m / cell_m) squared");
        });
    if (!question) return done(std::unexpected(question.error()));
    std::make_shared<NetworkQuest>(context, std::move(*question), std::move(done))->begin();
}

}  // namespace

std::vector<Method> truth_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<engine::GetTruth>> params{camera_name_at<&engine::GetTruth::camera>("camera"),
                                                        min_ns_at<&engine::GetTruth::min_ns>()};
    return {
        {.name = "truth.get",
         .summary = "The truth of the camera's latest due frame: every object that it sees or would see if nothing "
                    "stood in front, through its lens, at the frame's instant. docs/truth.md explains the members "
                    "of `objects`.",
         .params = descriptions_of(params),
         .result =
             {{"camera", "string", "its name"},
              {"sequence", "integer", "number of the frame, as in frame.get"},
              time_field,
              monotonic_field,
              stamp_field,
              steady_field,
              {"clock", "object or null",
               "the camera's own clock (see clock): state, offset_ns, drift_ppb and so on, as its last command has it"},
              {"clock_now", "object or null",
               "how that clock stands at this frame: state, offset_ns (of its time of day, jitter and all: what is "
               "added to the true time), steady_offset_ns (of its monotonic clock), drift_ppb (how fast it runs, "
               "slewing included, without random walk)"},
              {"exposure_start_ns", "integer or null",
               "of a camera with a sensor: world time at which the first row begins to count", false, "ns"},
              {"exposure_end_ns", "integer or null", "the same: at which the last row ends, `time_ns`", false, "ns"},
              {"row_ns", "integer or null",
               "the same: from the begin of a row to that of the next; 0: all rows at once", false, "ns"},
              {"sensor", "object or null",
               "of a camera with a sensor: how the frame is taken, as in frame.get; of one whose picture nobody "
               "asked for yet, how it would be"},
              {"size", "[width, height]", "size of the picture", false, "px"},
              {"intrinsics", "object", "see intrinsics"},
              {"lens", "object", "see lens"},
              {"pose", "object", "position and orientation of the camera's body frame at that instant"},
              {"pose_believed", "object",
               "the same as its calibration has it: another one when the camera was knocked"},
              {"faults", "array of objects",
               "what fails at this frame (fault.set): id, kind, layer, severity, since_ns, until_ns"},
              {"delivered", "boolean", "false: a fault keeps the frame back"},
              {"outputs", "object",
               "for each kind of output (mjpeg, rtsp, device, v4l2) what faults make of the frame on the way to its "
               "readers: fate (`sent`; `dropped` by the driver; `not_drawn`; `disconnected`; `stalled`); late_frames, "
               "so "
               "many later ones are due before it comes, and late_ns, so long later that is; refuses, who comes is "
               "refused; of mjpeg size (of a picture) and bad_part (what the stream says wrong of it: `length`, "
               "`boundary` or null), of device error_flag; damaged, what of the bytes that have gone out so far is "
               "wrong or missing, at "
               "most 16: fault (its id), kind, mode, size (bytes of the whole picture), bytes (so many of them), runs "
               "(offset and length of the first 64), more_runs, times (sent so to so many readers); more_damaged, "
               "so many were damaged otherwise"},
              {"not_drawn", "string or null",
               "why no stream or device has this frame though somebody reads there: `overload`, `own_cost`, `request`, "
               "`held` "
               "or `failure`, as dropped_for of stats.get; what readers have by then lost for being slow, the books "
               "tell"},
              {"covered_fraction", "number",
               "share of the picture's pixels of which dirt and covers hide more than half of the light"},
              {"focus_error_px", "number",
               "radius of the disc that a point is blurred to by what is out of focus (defocus, condensation)", false,
               "px"},
              {"shown_sequence", "integer",
               "the frame whose picture it has, its own but for faults; of one kept back, whose was seen last"},
              {"ptz", "object or null",
               "of a camera on a head: pan_deg, tilt_deg and zoom as it believes, turning, zooming, and under "
               "`true` where it is"},
              {"depth_source", "string",
               "`render`: depth is that of what is drawn; `proxy`: where a backdrop shows, that of its proxies"},
              {"backdrop", "object or null", "of a camera with a backdrop: its kind and file"},
              {"backdrop_frame", "integer or null", "of a camera with a film: which of its pictures shows, from 0"},
              {"backdrop_late", "integer or null",
               "of the same: how many instants so far were shown an earlier picture than theirs, because it was not "
               "decoded in time; always 0 in lockstep"},
              {"ignore", "array of objects",
               "where the backdrop shows people and vehicles that are not in `objects`: polygon_px in pixels of "
               "this frame, class"},
              {"classes", "object", "number of each class, as in semantic pictures, by its name"},
              {"objects", "array of objects",
               "id, name, class, class_number, box, box_full, clipped, truncated, pixels, pixels_soiled, "
               "pixels_alone, visible_fraction, visible_fraction_soiled, occluded_by, position, orientation, center, "
               "dimensions, velocity; people "
               "also keypoints and keypoints_world"}},
         .errors = {invalid_argument, not_found, unavailable, unsupported, resource_exhausted},
         .handler = handler_of(context, params, [](const truth::TruthRef& truth) { return truth_to_json(*truth); }),
         .example = R"({"camera": "lobby"})",
         .only_looks = true},
        {.name = "truth.network",
         .summary =
             "Who sees whom: what each camera sees of each object at one instant, that of the world's last step, "
             "and what cameras share. The same truth as truth.get.",
         .params = descriptions_of(network_fields()),
         .result =
             {{"time_ns", "integer", "world time of the instant", false, "ns"},
              {"cameras", "array of objects",
               "name, position, objects (how many it sees) and ground_m2 (how much ground)"},
              {"objects", "array of objects",
               "those that a camera sees: id, name, class, position, and seen_by, for each camera that sees it: "
               "camera, pixels, visible_fraction, truncated, box, azimuth_deg (of the camera around the object: 0 "
               "before its front, positive to its left), elevation_deg and distance_m"},
              {"overlaps", "array of objects",
               "for two cameras that share anything: cameras, objects (how many both see), object_share, "
               "ground_m2 (that both see) and ground_share; shares are of what one of them sees at least"}},
         .errors = {invalid_argument, not_found, unavailable, unsupported, resource_exhausted},
         .handler = [&context](const nlohmann::json& asked,
                               RpcReply done) { get_network(context, asked, std::move(done)); },
         .example = R"({"classes": ["person"], "cell_m": 1})",
         .only_looks = true}};
}

}  // namespace camrig::control
