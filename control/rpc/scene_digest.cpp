#include "control/rpc/scene_digest.h"

#include <array>
#include <fstream>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "core/base/digest.h"

namespace camrig::control {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t max_files = 4096;
constexpr std::uintmax_t max_json_bytes = std::uintmax_t{64} << 20;

Result<std::uint64_t> digest_of_file(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) return error(ErrorKind::not_found, "'" + file.string() + "' cannot be read");
    Digest digest;
    std::array<char, 1 << 16> chunk;
    while (in.read(chunk.data(), chunk.size()) || in.gcount() > 0)
        digest.add_bytes({chunk.data(), static_cast<std::size_t>(in.gcount())});
    return digest.value();
}

/// Every text in it, at any depth.
void texts_of(const json& value, std::vector<std::string>& out) {
    if (value.is_string()) out.push_back(value.get<std::string>());
    if (value.is_structured())
        for (const json& each : value) texts_of(each, out);
}

/// The files that a JSON file names, and what is found by its own name.
std::vector<fs::path> named_in(const fs::path& file) {
    std::vector<fs::path> files;
    std::error_code failed;
    const std::string kind = file.extension().string();
    if ((kind != ".json" && kind != ".gltf") || fs::file_size(file, failed) > max_json_bytes || failed) return files;
    std::ifstream in(file, std::ios::binary);
    const json value = json::parse(in, nullptr, false);
    // The light that was baked for a scene lies beside it, and beside the one that it stands on.
    if (const fs::path light = fs::path(file).replace_extension(".light"); fs::is_regular_file(light, failed))
        files.push_back(light);
    std::vector<std::string> texts;
    if (!value.is_discarded()) texts_of(value, texts);
    for (const std::string& text : texts) {
        // No name of a file; of pictures inside of a glTF.
        if (text.empty() || text.size() > 1024 || text.contains('\0') || text.starts_with("data:")) continue;
        const fs::path named = file.parent_path() / text;
        if (fs::is_regular_file(named, failed)) files.push_back(named);
    }
    return files;
}

}  // namespace

Result<SceneDigest> digest_of_scene(const fs::path& file_of_scene) {
    std::error_code failed;
    const fs::path scene = fs::absolute(file_of_scene, failed).lexically_normal();
    if (failed) return error(ErrorKind::not_found, "'" + file_of_scene.string() + "' is no file of a scene");
    std::map<std::string, std::uint64_t> digests;  // by the way from the scene's folder, so in one order everywhere
    std::vector<fs::path> left{scene};
    while (!left.empty()) {
        const fs::path file = left.back();
        left.pop_back();
        const std::string name = file.lexically_relative(scene.parent_path()).lexically_normal().string();
        if (digests.contains(name)) continue;
        if (digests.size() >= max_files)
            return error(ErrorKind::resource_exhausted, "'" + scene.string() + "' names too many files");
        const auto value = digest_of_file(file);
        if (!value) return std::unexpected(value.error());
        digests[name] = *value;
        for (fs::path& named : named_in(file)) left.push_back(std::move(named));
    }
    Digest all;
    for (const auto& [name, value] : digests) all.add(std::string_view(name), value);
    return SceneDigest{all.value(), digests.size()};
}

}  // namespace camrig::control
