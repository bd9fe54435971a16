#include "core/truth/network.h"

#include <algorithm>
#include <iterator>
#include <map>

#include "core/base/portable_math.h"

namespace camrig::truth {
namespace {

Sighting sighting(std::size_t camera, const ObjectTruth& object, const glm::dvec3& eye) {
    const glm::dvec3 towards = eye - object.position;
    const glm::dvec3 own = glm::conjugate(object.orientation) * towards;
    return {.camera = camera,
            .pixels = object.pixels,
            .visible_fraction = static_cast<double>(object.pixels) / static_cast<double>(object.pixels_alone),
            .truncated = object.truncated,
            .box = *object.box,
            .azimuth_rad = portable::atan2(own.y, own.x),
            .elevation_rad = portable::atan2(own.z, glm::length(glm::dvec2(own))),
            .distance_m = glm::length(towards)};
}

template <typename T>
std::size_t shared(const std::vector<T>& a, const std::vector<T>& b) {
    std::vector<T> both;
    std::ranges::set_intersection(a, b, std::back_inserter(both));
    return both.size();
}

double share_of(std::size_t both, std::size_t a, std::size_t b) {
    return both == 0 ? 0.0 : static_cast<double>(both) / static_cast<double>(a + b - both);
}

}  // namespace

Network network_of(std::span<const TruthRef> truths, const GroundGrid& grid, std::span<const std::string> classes) {
    Network network;
    const double cell_m2 = grid.cell_m * grid.cell_m;
    std::map<ObjectId, NetworkObject> objects;
    std::vector<std::vector<ObjectId>> seen(truths.size());
    for (std::size_t i = 0; i < truths.size(); ++i) {
        const TruthOfFrame& truth = *truths[i];
        network.world_ns = truth.world_ns;
        for (const ObjectTruth& object : truth.objects) {
            if (!object.box || (!classes.empty() && std::ranges::find(classes, object.object_class) == classes.end()))
                continue;
            objects.try_emplace(object.id, object)
                .first->second.seen_by.push_back(sighting(i, object, truth.pose.position));
            seen[i].push_back(object.id);
        }
        network.cameras.push_back({.name = truth.camera,
                                   .position = truth.pose.position,
                                   .objects = seen[i].size(),
                                   .ground_m2 = cell_m2 * static_cast<double>(truth.ground.size())});
    }
    for (auto& [id, object] : objects) network.objects.push_back(std::move(object));
    for (std::size_t a = 0; a < truths.size(); ++a) {
        for (std::size_t b = a + 1; b < truths.size(); ++b) {
            const auto &ground_a = truths[a]->ground, &ground_b = truths[b]->ground;
            const std::size_t both = shared(seen[a], seen[b]), cells = shared(ground_a, ground_b);
            if (both == 0 && cells == 0) continue;
            network.overlaps.push_back({.a = a,
                                        .b = b,
                                        .objects = both,
                                        .object_share = share_of(both, seen[a].size(), seen[b].size()),
                                        .ground_m2 = cell_m2 * static_cast<double>(cells),
                                        .ground_share = share_of(cells, ground_a.size(), ground_b.size())});
        }
    }
    return network;
}

nlohmann::json network_to_json(const Network& network) {
    using nlohmann::json;
    const auto array_of = [](const glm::dvec3& v) { return json{v.x, v.y, v.z}; };
    json cameras = json::array(), objects = json::array(), overlaps = json::array();
    for (const NetworkCamera& camera : network.cameras)
        cameras.push_back({{"name", camera.name},
                           {"position", array_of(camera.position)},
                           {"objects", camera.objects},
                           {"ground_m2", camera.ground_m2}});
    for (const NetworkObject& object : network.objects) {
        json seen_by = json::array();
        for (const Sighting& one : object.seen_by)
            seen_by.push_back({{"camera", network.cameras[one.camera].name},
                               {"pixels", one.pixels},
                               {"visible_fraction", one.visible_fraction},
                               {"truncated", one.truncated},
                               {"box", {one.box.x, one.box.y, one.box.width, one.box.height}},
                               {"azimuth_deg", glm::degrees(one.azimuth_rad)},
                               {"elevation_deg", glm::degrees(one.elevation_rad)},
                               {"distance_m", one.distance_m}});
        objects.push_back({{"id", static_cast<std::uint32_t>(object.truth.id)},
                           {"name", object.truth.name},
                           {"class", object.truth.object_class},
                           {"position", array_of(object.truth.position)},
                           {"seen_by", std::move(seen_by)}});
    }
    for (const Overlap& one : network.overlaps)
        overlaps.push_back({{"cameras", {network.cameras[one.a].name, network.cameras[one.b].name}},
                            {"objects", one.objects},
                            {"object_share", one.object_share},
                            {"ground_m2", one.ground_m2},
                            {"ground_share", one.ground_share}});
    return {{"time_ns", network.world_ns},
            {"cameras", std::move(cameras)},
            {"objects", std::move(objects)},
            {"overlaps", std::move(overlaps)}};
}

}  // namespace camrig::truth
