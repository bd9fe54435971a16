#include "core/world/gltf/mesh_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>

#include "core/world/gltf/topology.h"

namespace camrig::world::gltf {
namespace {

using Attributes = std::map<std::string, int>;

template <typename Vec>
std::vector<Vec> pack(const std::vector<float>& values) {
    static_assert(sizeof(Vec) == sizeof(float) * static_cast<std::size_t>(Vec::length()));
    std::vector<Vec> out(values.size() / static_cast<std::size_t>(Vec::length()));
    std::memcpy(out.data(), values.data(), out.size() * sizeof(Vec));
    return out;
}

/// Reads the attributes of one primitive; the count of POSITION rules.
class PrimitiveReader {
public:
    PrimitiveReader(const Document& document, const AccessorReader& accessors, const Attributes& attributes,
                    std::string place)
        : accessors_(accessors),
          attributes_(attributes),
          place_(std::move(place)),
          quantized_(document.uses_extension("KHR_mesh_quantization")) {}

    Primitive read();
    std::vector<MorphTarget> read_targets(const std::vector<Attributes>& targets, bool with_normals);

private:
    std::string at(std::string_view name) const { return place_ + ".attributes." + std::string(name); }
    int find(const std::string& name) const {
        const auto found = attributes_.find(name);
        return found == attributes_.end() ? -1 : found->second;
    }
    unsigned position_types() const {
        return quantized_ ? float32 | int8 | uint8 | int16 | uint16 | int8_normalised | uint8_normalised |
                                int16_normalised | uint16_normalised
                          : float32;
    }
    unsigned direction_types() const { return quantized_ ? float32 | int8_normalised | int16_normalised : float32; }
    template <typename Vec>
    std::vector<Vec> attribute(int accessor, unsigned allowed, const std::string& place) {
        if (accessor < 0) return {};
        auto values = pack<Vec>(accessors_.floats(accessor, Vec::length(), allowed, place));
        require(count_ == 0 || values.size() == count_, place,
                std::to_string(values.size()) + " elements for " + std::to_string(count_) + " vertices");
        return values;
    }
    void read_colors(Primitive& primitive);
    void read_skinning(Primitive& primitive);

    const AccessorReader& accessors_;
    const Attributes& attributes_;
    std::string place_;
    bool quantized_;
    std::size_t count_ = 0;
};

void normalise(std::vector<glm::vec3>& normals) {
    for (glm::vec3& normal : normals) {
        const float length = glm::length(normal);
        normal = length > 0.0f ? normal / length : glm::vec3(0.0f, 1.0f, 0.0f);
    }
}

Primitive PrimitiveReader::read() {
    Primitive primitive;
    const int position = find("POSITION");
    require(position >= 0, at("POSITION"), "is missing");
    const std::size_t count = accessors_.count(position, at("POSITION"));
    require(count <= max_vertices, at("POSITION"), "more than " + std::to_string(max_vertices) + " vertices");
    primitive.positions = attribute<glm::vec3>(position, position_types(), at("POSITION"));
    count_ = primitive.positions.size();
    primitive.normals = attribute<glm::vec3>(find("NORMAL"), direction_types(), at("NORMAL"));
    normalise(primitive.normals);
    if (!primitive.normals.empty())
        primitive.tangents = attribute<glm::vec4>(find("TANGENT"), direction_types(), at("TANGENT"));
    const unsigned coordinates =
        quantized_ ? position_types() : unsigned{float32 | uint8_normalised | uint16_normalised};
    for (int set = 0; set < 2; ++set) {
        const std::string name = "TEXCOORD_" + std::to_string(set);
        primitive.texcoords[set] = attribute<glm::vec2>(find(name), coordinates, at(name));
    }
    read_colors(primitive);
    read_skinning(primitive);
    return primitive;
}

void PrimitiveReader::read_colors(Primitive& primitive) {
    const int accessor = find("COLOR_0");
    if (accessor < 0) return;
    const unsigned allowed = float32 | uint8_normalised | uint16_normalised;
    if (accessors_.width(accessor, at("COLOR_0")) == 4) {
        primitive.colors = attribute<glm::vec4>(accessor, allowed, at("COLOR_0"));
    } else {
        const auto rgb = attribute<glm::vec3>(accessor, allowed, at("COLOR_0"));
        primitive.colors.reserve(rgb.size());
        for (const glm::vec3& color : rgb) primitive.colors.emplace_back(color, 1.0f);
    }
    for (glm::vec4& color : primitive.colors) color = glm::clamp(color, 0.0f, 1.0f);
}

/// One vertex: the four greatest weights, scaled to sum 1; joints without weight become 0. A vertex without any weight
/// follows the first joint.
void keep_strongest(std::span<const float> weights, std::span<const std::uint32_t> joints, glm::vec4& out_weights,
                    glm::u16vec4& out_joints) {
    std::array<std::size_t, 8> order{};
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(weights.size());
    std::iota(order.begin(), end, std::size_t{0});
    std::stable_sort(order.begin(), end, [&](std::size_t a, std::size_t b) { return weights[a] > weights[b]; });
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) sum += static_cast<double>(weights[order[i]]);
    for (std::size_t i = 0; i < 4; ++i) {
        const auto lane = static_cast<glm::length_t>(i);
        const float weight = sum > 0.0 ? static_cast<float>(static_cast<double>(weights[order[i]]) / sum) : 0.0f;
        out_weights[lane] = weight;
        out_joints[lane] = weight > 0.0f ? static_cast<std::uint16_t>(joints[order[i]]) : std::uint16_t{0};
    }
    if (!(sum > 0.0)) {
        out_weights.x = 1.0f;
        out_joints.x = static_cast<std::uint16_t>(joints[0]);
    }
}

void PrimitiveReader::read_skinning(Primitive& primitive) {
    if (find("JOINTS_0") < 0 && find("WEIGHTS_0") < 0) return;
    const std::size_t sets = find("JOINTS_1") >= 0 && find("WEIGHTS_1") >= 0 ? 2 : 1;
    std::array<std::vector<std::uint32_t>, 2> joints;
    std::array<std::vector<float>, 2> weights;
    for (std::size_t set = 0; set < sets; ++set) {
        const std::string suffix = "_" + std::to_string(set);
        joints[set] = accessors_.integers(find("JOINTS" + suffix), 4, uint8 | uint16, at("JOINTS" + suffix));
        weights[set] = accessors_.floats(find("WEIGHTS" + suffix), 4, float32 | uint8_normalised | uint16_normalised,
                                         at("WEIGHTS" + suffix));
        require(joints[set].size() == count_ * 4 && weights[set].size() == count_ * 4, at("JOINTS" + suffix),
                "joints and weights do not match the number of vertices");
        for (const float weight : weights[set]) require(weight >= 0.0f, at("WEIGHTS" + suffix), "a weight is negative");
    }
    primitive.joints.resize(count_);
    primitive.weights.resize(count_);
    for (std::size_t v = 0; v < count_; ++v) {
        std::array<float, 8> weight{};
        std::array<std::uint32_t, 8> joint{};
        for (std::size_t set = 0; set < sets; ++set) {
            std::copy_n(weights[set].data() + v * 4, 4, weight.data() + set * 4);
            std::copy_n(joints[set].data() + v * 4, 4, joint.data() + set * 4);
        }
        keep_strongest(std::span(weight).first(sets * 4), joint, primitive.weights[v], primitive.joints[v]);
    }
}

std::vector<MorphTarget> PrimitiveReader::read_targets(const std::vector<Attributes>& targets, bool with_normals) {
    require(targets.size() <= max_morph_targets, place_ + ".targets",
            "more than " + std::to_string(max_morph_targets) + " morph targets");
    std::vector<MorphTarget> out(targets.size());
    for (std::size_t i = 0; i < targets.size(); ++i) {
        const std::string place = item(place_ + ".targets", i);
        const auto read = [&](const char* name, unsigned allowed) {
            const auto found = targets[i].find(name);
            return attribute<glm::vec3>(found == targets[i].end() ? -1 : found->second, allowed, place + "." + name);
        };
        out[i].positions = read("POSITION", position_types());
        if (with_normals) out[i].normals = read("NORMAL", direction_types());
    }
    return out;
}

std::vector<std::uint32_t> read_indices(const tinygltf::Primitive& from, std::size_t vertices,
                                        const AccessorReader& accessors, const std::string& place) {
    std::vector<std::uint32_t> indices;
    if (from.indices < 0) {
        indices.resize(vertices);
        std::iota(indices.begin(), indices.end(), 0u);
        return indices;
    }
    indices = accessors.integers(from.indices, 1, uint8 | uint16 | uint32, place + ".indices");
    for (const std::uint32_t index : indices) {
        if (index < vertices) continue;
        fail(place + ".indices", "index " + std::to_string(index) + " of " + std::to_string(vertices) + " vertices");
    }
    return indices;
}

Box bounds_of(const std::vector<glm::vec3>& positions) {
    Box box{positions.front(), positions.front()};
    for (const glm::vec3& p : positions) {
        box.min = glm::min(box.min, p);
        box.max = glm::max(box.max, p);
    }
    return box;
}

Primitive read_primitive(const Document& document, const tinygltf::Primitive& from, const AccessorReader& accessors,
                         Budget& budget, const std::string& place) {
    require(from.mode >= 0 && from.mode <= static_cast<int>(Mode::triangle_fan), place + ".mode",
            std::to_string(from.mode) + " is no primitive mode");
    const Mode mode{from.mode};
    PrimitiveReader reader(document, accessors, from.attributes, place);
    Primitive primitive = reader.read();
    primitive.topology = topology_of(mode);
    primitive.material = from.material;
    require(from.material < std::ssize(document.gltf.materials), place + ".material",
            "material " + std::to_string(from.material) + " of " + std::to_string(document.gltf.materials.size()));
    primitive.targets = reader.read_targets(from.targets, !primitive.normals.empty());
    auto indices = read_indices(from, primitive.positions.size(), accessors, place);
    budget.take(indices.size() * 3 * sizeof(std::uint32_t), place);
    primitive.indices = to_list(mode, std::move(indices));
    if (primitive.topology == Topology::triangles && primitive.normals.empty() && !primitive.indices.empty()) {
        require(primitive.indices.size() <= max_vertices, place, "too many triangles without normals");
        budget.take(primitive.indices.size() * (132 + 24 * primitive.targets.size()), place);
        make_flat(primitive);
    }
    primitive.bounds = bounds_of(primitive.positions);
    return primitive;
}

}  // namespace

std::vector<Mesh> read_meshes(const Document& document, const AccessorReader& accessors, Budget& budget) {
    std::vector<Mesh> meshes;
    for (std::size_t m = 0; m < document.gltf.meshes.size(); ++m) {
        const tinygltf::Mesh& from = document.gltf.meshes[m];
        const std::string place = item("meshes", m);
        require(!from.primitives.empty(), place + ".primitives", "is missing or empty");
        Mesh mesh;
        mesh.name = from.name.substr(0, max_name_bytes);
        const std::size_t targets = from.primitives.front().targets.size();
        for (std::size_t p = 0; p < from.primitives.size(); ++p) {
            const std::string at = item(place + ".primitives", p);
            require(from.primitives[p].targets.size() == targets, at + ".targets",
                    "all primitives of a mesh must have the same number of morph targets");
            Primitive primitive = read_primitive(document, from.primitives[p], accessors, budget, at);
            if (!primitive.indices.empty()) mesh.primitives.push_back(std::move(primitive));
        }
        require(from.weights.empty() || from.weights.size() == targets, place + ".weights",
                std::to_string(from.weights.size()) + " weights for " + std::to_string(targets) + " morph targets");
        mesh.weights.assign(targets, 0.0f);
        for (std::size_t i = 0; i < from.weights.size(); ++i) {
            require(std::abs(from.weights[i]) <= max_value, place + ".weights", "a weight is not finite");
            mesh.weights[i] = static_cast<float>(from.weights[i]);
        }
        meshes.push_back(std::move(mesh));
    }
    return meshes;
}

}  // namespace camrig::world::gltf
