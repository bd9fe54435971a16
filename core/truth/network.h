#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/truth/ground.h"
#include "core/truth/truth.h"

/// Who sees whom in a network of cameras, at one instant.
namespace camrig::truth {

/// What a camera sees of an object. Angles by the object's own axes: 0 where its front (+x) faces the camera, positive
/// to its left; elevation upwards from its x and y.
struct Sighting {
    std::size_t camera = 0;  ///< into Network::cameras
    std::int64_t pixels = 0;
    double visible_fraction = 0.0;
    double truncated = 0.0;
    PixelBox box;
    double azimuth_rad = 0.0;
    double elevation_rad = 0.0;
    double distance_m = 0.0;  ///< to its origin
};

struct NetworkObject {
    ObjectTruth truth;  ///< as the first of the cameras has it
    std::vector<Sighting> seen_by;
};

struct NetworkCamera {
    std::string name;
    glm::dvec3 position{0.0};
    std::size_t objects = 0;  ///< that it sees
    double ground_m2 = 0.0;
};

/// An edge of the overlap graph. Shares are of what one of the two sees at least (Jaccard index).
struct Overlap {
    std::size_t a = 0, b = 0;  ///< into Network::cameras, a < b
    std::size_t objects = 0;   ///< that both see
    double object_share = 0.0;
    double ground_m2 = 0.0;  ///< that both see
    double ground_share = 0.0;
};

struct Network {
    TimeNs world_ns = 0;
    std::vector<NetworkCamera> cameras;
    std::vector<NetworkObject> objects;  ///< that one of the cameras sees, by rising id
    std::vector<Overlap> overlaps;       ///< of cameras that share anything
};

/// From truths of one instant, each with its ground. classes: only objects of these; empty: all.
Network network_of(std::span<const TruthRef> truths, const GroundGrid& grid, std::span<const std::string> classes);

/// As truth.network gives it.
nlohmann::json network_to_json(const Network& network);

}  // namespace camrig::truth
