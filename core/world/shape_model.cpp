#include "core/world/shape_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"
#include "core/world/box_faces.h"

namespace camrig::world {
namespace {

/// The picture of a grid: so many cells a side, so many texels each. Lines are one texel wide, the bold one three.
constexpr int cells = 10;
constexpr int cell_px = 32;
constexpr std::uint8_t light_cell = 255, dark_cell = 232, line = 176, bold_line = 120;
/// Lights are looked up and clipped by triangle; one of a kilometre would be too coarse for both.
constexpr int ground_pieces = 16;

/// World axes (z up) to those of glTF, in which models are.
glm::vec3 to_gltf(const glm::dvec3& p) {
    return glm::vec3(glm::dvec3(p.x, p.z, -p.y));
}

/// Collects corners; every face is a quad.
struct Mesher {
    Primitive primitive;

    void reserve(std::size_t corners) {
        primitive.positions.reserve(corners);
        primitive.normals.reserve(corners);
        primitive.texcoords[0].reserve(corners);
        primitive.colors.reserve(corners);
        primitive.indices.reserve(6 * corners);
    }
    void corner(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec2& uv) {
        primitive.positions.push_back(to_gltf(position));
        primitive.normals.push_back(to_gltf(normal));
        primitive.texcoords[0].emplace_back(uv);
    }
    /// Between rows of `columns + 1` corners from `first` on; counter-clockwise as seen from the front.
    void grid(int columns, int rows) {
        for (int row = 0; row < rows; ++row) {
            for (int column = 0; column < columns; ++column) {
                const auto at = static_cast<std::uint32_t>(row * (columns + 1) + column);
                const auto above = at + static_cast<std::uint32_t>(columns) + 1;
                for (const std::uint32_t index : {at, at + 1, above + 1, at, above + 1, above})
                    primitive.indices.push_back(index);
            }
        }
    }
    void close() {
        primitive.material = 0;
        primitive.bounds = {primitive.positions.front(), primitive.positions.front()};
        for (const glm::vec3& p : primitive.positions) {
            primitive.bounds.min = glm::min(primitive.bounds.min, p);
            primitive.bounds.max = glm::max(primitive.bounds.max, p);
        }
    }
};

ModelRef model_of(const char* name, Mesher mesher, Material material, std::vector<Image> images = {},
                  double sky_radius_m = 0.0, const Sampler& sampler = {}) {
    mesher.close();
    material.name = name;
    material.metallic = 0.0f;
    auto model = std::make_shared<Model>();
    model->sky_radius_m = sky_radius_m;
    model->name = name;
    model->nodes.push_back({.name = name, .local = {}, .mesh = 0, .weights = {}, .keypoint = {}});
    model->order = {0};
    model->meshes.push_back({.name = name, .primitives = {std::move(mesher.primitive)}, .weights = {}});
    for (std::size_t i = 0; i < images.size(); ++i)
        model->textures.push_back({.image = static_cast<int>(i), .sampler = sampler});
    model->images = std::move(images);
    model->materials.push_back(std::move(material));
    return model;
}

Image grid_picture() {
    constexpr int side = cells * cell_px;
    Image image{.size = {side, side}, .rgba = {}};
    image.rgba.reserve(std::size_t{4} * side * side);
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            const auto near = [](int v, int step, int half_width) {
                const int from = v % step;
                return from <= half_width || step - from <= half_width;
            };
            std::uint8_t gray = (x / cell_px + y / cell_px) % 2 == 0 ? light_cell : dark_cell;
            if (near(x, cell_px, 0) || near(y, cell_px, 0)) gray = line;
            if (near(x, side, 1) || near(y, side, 1)) gray = bold_line;
            image.rgba.insert(image.rgba.end(), {gray, gray, gray, 255});
        }
    }
    return image;
}

ModelRef make(const GroundShape& ground) {
    Mesher mesher;
    for (int row = 0; row <= ground_pieces; ++row) {
        for (int column = 0; column <= ground_pieces; ++column) {
            const glm::dvec2 place = ground.size * (glm::dvec2(column, row) / double{ground_pieces} - 0.5);
            // A bold line goes through the origin.
            const glm::dvec2 uv = ground.grid_m > 0.0 ? place / (ground.grid_m * cells) : glm::dvec2(0.0);
            mesher.corner({place, 0.0}, {0.0, 0.0, 1.0}, uv);
        }
    }
    mesher.grid(ground_pieces, ground_pieces);
    Material material;
    material.base_color = {ground.color, 1.0f};
    material.roughness = ground.roughness;
    if (ground.grid_m <= 0.0) return model_of("ground", std::move(mesher), material);
    material.base_color_texture.texture = 0;
    std::vector<Image> images;
    images.push_back(grid_picture());
    return model_of("ground", std::move(mesher), material, std::move(images));
}

ModelRef make(const BoxShape& box) {
    Mesher mesher;
    const glm::dvec3 middle(0.0, 0.0, 0.5 * box.size.z);
    for (const BoxFace& face : box_faces()) {
        const auto first = static_cast<std::uint32_t>(mesher.primitive.positions.size());
        for (std::size_t c = 0; c < face.corners.size(); ++c)
            mesher.corner(middle + 0.5 * box.size * face.corners[c], face.normal, 0.5 * (box_face_sides[c] + 1.0));
        for (const auto& triangle : box_face_triangles)
            for (const std::uint32_t index : triangle) mesher.primitive.indices.push_back(first + index);
    }
    Material material;
    material.base_color = {box.color, 1.0f};
    material.roughness = box.roughness;
    return model_of("box", std::move(mesher), material);
}

ModelRef make(const SkyShape& sky) {
    return sky_model(sky.radius_m, 1, [&](const glm::dvec3& towards) {
        return glm::mix(sky.horizon, sky.color, static_cast<float>(std::sqrt(std::max(0.0, towards.z))));
    });
}

double sky_pan(int column, int columns) {
    return -2.0 * std::numbers::pi * column / columns;
}
double sky_elevation(int row, int rows) {
    const double part = static_cast<double>(row) / rows;
    return 0.5 * std::numbers::pi * part * std::abs(part);
}

}  // namespace

ModelRef shape_model(const Shape& shape) {
    return std::visit([](const auto& one) { return make(one); }, shape);
}

glm::dvec3 sky_corner(int column, int columns, int row, int rows) {
    const double pan = sky_pan(column, columns), elevation = sky_elevation(row, rows);
    const double level = portable::cos(elevation);
    return {level * portable::cos(pan), level * portable::sin(pan), portable::sin(elevation)};
}

ModelRef sky_model(double radius_m, int fineness, const std::function<glm::vec3(const glm::dvec3& towards)>& color,
                   Image picture) {
    Mesher mesher;
    const int rows = sky_rows * fineness, columns = sky_columns * fineness;
    const bool has_picture = !picture.rgba.empty();
    // A change of daylight makes all of this anew between two steps of the world: no sine twice, no vector grown.
    std::vector<glm::dvec2> around;
    for (int column = 0; column <= columns; ++column) {
        const double pan = sky_pan(column, columns);
        around.emplace_back(portable::cos(pan), portable::sin(pan));
    }
    mesher.reserve(around.size() * static_cast<std::size_t>(2 * rows + 1));
    for (int row = -rows; row <= rows; ++row) {
        const double elevation = sky_elevation(row, rows);
        const double level = portable::cos(elevation), up = portable::sin(elevation);
        for (std::size_t column = 0; column < around.size(); ++column) {
            const glm::dvec3 out(level * around[column].x, level * around[column].y, up);
            const glm::dvec2 uv(static_cast<double>(column) / columns, std::max(0.0, static_cast<double>(row) / rows));
            mesher.corner(radius_m * out, -out, has_picture ? uv : glm::dvec2(0.0));
            mesher.primitive.colors.emplace_back(color(out), 1.0f);
        }
    }
    mesher.grid(columns, 2 * rows);
    Material material;
    material.unlit = true;
    std::vector<Image> images;
    if (has_picture) {
        material.base_color_texture.texture = 0;
        images.push_back(std::move(picture));
    }
    // Smaller levels would be chosen by the columns, which are crowded at the zenith, and blur the rows there.
    const Sampler sampler{.wrap_t = Wrap::clamp_to_edge, .mipmaps = false};
    return model_of("sky", std::move(mesher), material, std::move(images), radius_m, sampler);
}

}  // namespace camrig::world
