#pragma once

#include <numbers>

#include <nlohmann/json.hpp>

#include "core/world/read/actor_json.h"
#include "core/world/read/behaviour_json.h"
#include "core/world/read/event_json.h"
#include "core/world/world.h"

/// Worlds without files: people are models of two clips without vertices, and specs are written as JSON.
namespace camrig::world::world_test {

inline constexpr double walk_ground_m_s = 1.25;

inline ModelRef person_model() {
    auto model = std::make_shared<Model>();
    Animation walk, wait;
    walk.name = "walk";
    walk.duration_ns = 1'040'000'001;
    walk.ground_speed_m_s = walk_ground_m_s;
    wait.name = "wait";
    wait.duration_ns = 3 * ns_per_s;
    model->animations = {walk, wait};
    Node hand;
    hand.name = "hand";
    hand.local.translation = {0.0, 1.0, 0.0};  // glTF is y up: 1 m over the floor
    model->nodes = {hand};
    model->order = {0};
    return model;
}

inline std::shared_ptr<Scene> empty_scene(TimeNs step_ns = 20 * ns_per_ms) {
    auto scene = std::make_shared<Scene>();
    scene->step_ns = step_ns;
    scene->models["man"] = {.model = person_model()};
    scene->areas["square"] = {.points = {{0, 0}, {20, 0}, {20, 20}, {0, 20}}, .obstacles = {}};
    scene->areas["corner"] = {.points = {{0, 0}, {5, 0}, {5, 5}, {0, 5}}, .obstacles = {}};
    scene->routes["line"] = {.points = {{0, 10, 0}, {20, 10, 0}}};
    Light lamp;
    lamp.name = "lamp";
    scene->lights = {lamp};
    return scene;
}

inline ActorSpec actor(const char* text) {
    const auto value = nlohmann::json::parse(text);
    JsonReader reader(value, "");
    return read_actor(reader).value();
}

inline EventSpec event(const char* text) {
    const auto value = nlohmann::json::parse(text);
    JsonReader reader(value, "");
    return read_event(reader).value();
}

inline BehaviourSpec behaviour(const char* text) {
    return read_behaviour(nlohmann::json::parse(text), "behaviour").value();
}

inline ActorReport find(const World& world, const std::string& name) {
    for (const ActorReport& report : world.actors())
        if (report.name == name) return report;
    return {};
}

}  // namespace camrig::world::world_test
