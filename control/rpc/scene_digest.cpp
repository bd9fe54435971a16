#include "control/rpc/scene_digest.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "core/base/digest.h"
#include "core/base/percent.h"
#include "core/world/shipped.h"

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

struct NamedFile {
    fs::path file;
    bool is_shipped = false;  ///< named by "camrig:", or by a file that is
};

/// "camrig:NAME" is a model or, as a base, a scene.
std::vector<NamedFile> shipped_files(std::string_view name) {
    std::vector<NamedFile> files;
    for (const auto find : {world::find_shipped_model, world::find_shipped_scene})
        if (auto found = find(name)) files.push_back({std::move(*found), true});
    return files;
}

/// The files that a JSON file names, and what is found by its own name.
std::vector<NamedFile> named_in(const NamedFile& from) {
    std::vector<NamedFile> files;
    std::error_code failed;
    const fs::path& file = from.file;
    const std::string kind = file.extension().string();
    if ((kind != ".json" && kind != ".gltf") || fs::file_size(file, failed) > max_json_bytes || failed) return files;
    std::ifstream in(file, std::ios::binary);
    const json value = json::parse(in, nullptr, false);
    // The light that was baked for a scene lies beside it, and beside the one that it stands on.
    if (const fs::path light = fs::path(file).replace_extension(".light"); fs::is_regular_file(light, failed))
        files.push_back({light, from.is_shipped});
    std::vector<std::string> texts;
    if (!value.is_discarded()) texts_of(value, texts);
    for (std::string& text : texts) {
        // No name of a file; of pictures inside of a glTF.
        if (text.empty() || text.size() > 1024 || text.contains('\0') || text.starts_with("data:")) continue;
        if (kind == ".json" && text.starts_with(world::shipped_prefix)) {
            std::ranges::move(shipped_files(std::string_view(text).substr(world::shipped_prefix.size())),
                              std::back_inserter(files));
            continue;
        }
        if (kind == ".gltf") text = percent_decode(text).value_or(text);
        const fs::path named = file.parent_path() / text;
        if (fs::is_regular_file(named, failed)) files.push_back({named, from.is_shipped});
    }
    return files;
}

}  // namespace

Result<SceneDigest> digest_of_scene(const fs::path& file_of_scene) {
    std::error_code failed;
    const fs::path scene = fs::absolute(file_of_scene, failed).lexically_normal();
    if (failed) return error(ErrorKind::not_found, "'" + file_of_scene.string() + "' is no file of a scene");
    const fs::path shipped = world::shipped_folder();
    // By the way from the scene's folder, or from that of what comes with the program: the same everywhere.
    std::map<std::string, std::uint64_t> digests;
    std::vector<NamedFile> left{{scene}};
    while (!left.empty()) {
        const NamedFile named = left.back();
        const fs::path& file = named.file;
        left.pop_back();
        const std::string way =
            file.lexically_relative(named.is_shipped ? shipped : scene.parent_path()).lexically_normal().string();
        const std::string name = named.is_shipped ? std::string(world::shipped_prefix) + way : way;
        if (digests.contains(name)) continue;
        if (digests.size() >= max_files)
            return error(ErrorKind::resource_exhausted, "'" + scene.string() + "' names too many files");
        const auto value = digest_of_file(file);
        if (!value) return std::unexpected(value.error());
        digests[name] = *value;
        std::ranges::move(named_in(named), std::back_inserter(left));
    }
    Digest all;
    for (const auto& [name, value] : digests) all.add(std::string_view(name), value);
    return SceneDigest{all.value(), digests.size()};
}

}  // namespace camrig::control
