#include "core/render/scene/contact_shadows.h"

#include <algorithm>
#include <cmath>

namespace camrig::render::scene {
namespace {

/// Share of the light that is lost where the darkest patches are darkest.
constexpr double darkest_foot = 0.6, darkest_body = 0.35;
/// What is higher above the ground has no patch, metres.
constexpr double highest_part_m = 0.3;
/// A patch reaches so far beyond its part, and wider by as much of the height of it.
constexpr double foot_margin_m = 0.05, body_margin_m = 0.2, margin_of_height = 0.5;
/// At this height half of the darkness is left.
constexpr double half_dark_m = 0.08;
/// Patches lie so far above the ground that it does not cut through them.
constexpr double lift_m = 0.008;
constexpr int picture_px = 64;
/// More parts near the ground, of somebody who lies there, have the wide patch only.
constexpr std::size_t max_parts = 12;

world::Image picture_of_patch() {
    world::Image image{.size = {picture_px, picture_px}, .rgba = {}};
    image.rgba.reserve(std::size_t{4} * picture_px * picture_px);
    for (int y = 0; y < picture_px; ++y) {
        for (int x = 0; x < picture_px; ++x) {
            const auto at = [](int i) { return std::abs((2.0 * i + 1.0) / picture_px - 1.0); };
            // Between a disc and a square; full to a quarter of the way out.
            const auto fourth = [](double v) { return v * v * v * v; };
            const double r = std::min(std::sqrt(std::sqrt(fourth(at(x)) + fourth(at(y)))), 1.0);
            const double out = std::max((r - 0.25) / 0.75, 0.0);
            const double alpha = 1.0 - out * out * (3.0 - 2.0 * out);
            image.rgba.insert(image.rgba.end(), {0, 0, 0, static_cast<std::uint8_t>(std::lround(255.0 * alpha))});
        }
    }
    return image;
}

world::ModelRef make_contact_model() {
    auto model = std::make_shared<world::Model>();
    model->name = "contact shadow";
    model->images.push_back(picture_of_patch());
    const auto edge = world::Wrap::clamp_to_edge;
    model->textures.push_back({.image = 0, .sampler = {.wrap_s = edge, .wrap_t = edge}});
    world::Mesh mesh{.name = model->name, .primitives = {}, .weights = {}};
    for (int shade = 0; shade < contact_shades; ++shade) {
        world::Primitive patch;
        patch.material = shade;
        patch.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        patch.normals.assign(4, {0, 0, 1});
        patch.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
        patch.indices = {0, 1, 2, 0, 2, 3};
        patch.bounds = {{-1, -1, 0}, {1, 1, 0}};
        mesh.primitives.push_back(std::move(patch));
        world::Material material;
        material.name = model->name;
        material.base_color = {0, 0, 0, static_cast<float>(darkest_foot * (shade + 1) / contact_shades)};
        material.base_color_texture.texture = 0;
        material.alpha_mode = world::AlphaMode::blend;
        material.unlit = true;
        model->materials.push_back(std::move(material));
    }
    model->meshes.push_back(std::move(mesh));
    model->nodes.push_back({.name = model->name, .local = {}, .mesh = 0, .weights = {}, .keypoint = {}});
    model->order = {0};
    return model;
}

}  // namespace

const world::ModelRef& contact_model() {
    static const world::ModelRef model = make_contact_model();
    return model;
}

void ContactShadows::begin() {
    parts_.clear();
    all_.reset();
    shadows_.clear();
}

void ContactShadows::Footprint::join(const Footprint& other) {
    min = glm::min(min, other.min);
    max = glm::max(max, other.max);
    height_m = std::min(height_m, other.height_m);
}

void ContactShadows::add(int joint, const world::Box& box) {
    if (box.min.z > highest_part_m) return;
    const Footprint part{joint, glm::dvec2(box.min), glm::dvec2(box.max), std::max(double{box.min.z}, 0.0)};
    if (!all_) all_ = part;
    all_->join(part);
    // A shoe and the trousers above it are one part.
    const auto same = std::ranges::find(parts_, joint, &Footprint::joint);
    if (same != parts_.end()) {
        same->join(part);
    } else if (parts_.size() < max_parts) {
        parts_.push_back(part);
    }
}

std::span<const ContactShadow> ContactShadows::find() {
    shadows_.clear();
    for (const Footprint& part : parts_) add_shadow(part, foot_margin_m, darkest_foot);
    if (all_) add_shadow(*all_, body_margin_m, darkest_body);
    return shadows_;
}

void ContactShadows::add_shadow(const Footprint& of, double margin_m, double darkest) {
    const double raised = of.height_m / half_dark_m;
    const double dark = darkest / darkest_foot / (1.0 + raised * raised);
    const int shade = static_cast<int>(std::lround(dark * contact_shades)) - 1;
    if (shade < 0) return;
    const glm::dvec2 half = 0.5 * (of.max - of.min) + margin_m + margin_of_height * of.height_m;
    const glm::dvec2 middle = 0.5 * (of.min + of.max);
    ContactShadow& made = shadows_.emplace_back();
    made.shade = shade;
    made.model_from_patch = glm::dmat4({half.x, 0.0, 0.0, 0.0}, {0.0, half.y, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0},
                                       {middle.x, middle.y, lift_m, 1.0});
}

}  // namespace camrig::render::scene
