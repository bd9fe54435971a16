#include "core/base/error_list.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/backdrop/mask_pieces.h"
#include "core/world/backdrop/panorama_files.h"
#include "core/world/backdrop/picture_file.h"
#include "core/world/backdrop/proxy_roles.h"
#include "core/world/backdrop/scale_picture.h"
#include "core/world/gltf/image_decode.h"
#include "core/world/gltf/resources.h"
#include "core/world/gltf_loader.h"
#include "core/world/shipped.h"

namespace camrig::world {
namespace {

/// Sides of what is seen through a lens are bent: pieces of a depth image are so small that it does not show.
constexpr int most_depth_piece_px = 16;

Result<std::filesystem::path> file_of(const std::string& file, const std::filesystem::path& folder) {
    if (folder.empty()) {
        if (std::filesystem::path(file).is_absolute() && file.find('\0') == std::string::npos) return file;
        return error(ErrorKind::invalid_argument, "must be an absolute path; relative ones are those of scene files");
    }
    // What a scene file said is an absolute path in what camera.get answers.
    if (leads_below(file)) return std::filesystem::absolute(folder / file);
    return error(ErrorKind::invalid_argument, "must be a path below the scene file's folder");
}

Result<DepthImage> read_depth(const std::filesystem::path& file) {
    try {
        gltf::Budget budget;
        auto depth = gltf::decode_gray16(gltf::read_file(file, max_picture_bytes), "", budget);
        return DepthImage{depth.size, std::move(depth.values)};
    } catch (const gltf::Failure& failure) {
        return at(file.string(), failure.error);
    }
}

std::unexpected<Error> another_size(const std::filesystem::path& file, ImageSize size, const BackdropFiles& files) {
    return error(ErrorKind::invalid_argument,
                 file.string() + ": is " + size.to_string() + ", and the picture is " + files.size().to_string());
}

}  // namespace

Result<void> load_backdrop(CameraPatch& patch, const std::filesystem::path& folder) {
    if (!patch.backdrop || !*patch.backdrop) return {};
    BackdropSpec& spec = **patch.backdrop;
    if (spec.fps && spec.kind != BackdropKind::film)
        return error(ErrorKind::invalid_argument,
                     "backdrop.fps: is that of a film, and the kind is " + std::string(to_string(spec.kind)));
    if (spec.yaw_deg != 0.0 && !spec.is_panorama())
        return error(ErrorKind::invalid_argument,
                     "backdrop.yaw_deg: is that of a panorama, and the kind is " + std::string(to_string(spec.kind)));
    if (!spec.details.empty() && !spec.is_panorama())
        return error(ErrorKind::invalid_argument,
                     "backdrop.details: are those of a panorama, and the kind is " + std::string(to_string(spec.kind)));
    if ((spec.taken_from || spec.lens) && !spec.is_projected())
        return error(ErrorKind::invalid_argument, std::string("backdrop.") + (spec.taken_from ? "taken_from" : "lens") +
                                                      ": is that of a projected picture, and the kind is " +
                                                      std::string(to_string(spec.kind)));
    auto files = std::make_shared<BackdropFiles>();
    const auto read = [&](std::string& file, const char* field, const auto& load) -> Result<void> {
        const ErrorList::Pause paths_of_another_file;
        auto place = file_of(file, folder);
        if (!place) return at(field, place.error());
        if (auto loaded = load(*place); !loaded) return at(field, loaded.error());
        file = place->string();
        return {};
    };
    if (auto good =
            read(spec.file, "backdrop.file",
                 [&](const std::filesystem::path& file) -> Result<void> {
                     if (spec.kind == BackdropKind::film) {
                         auto film = read_film(file);
                         if (!film) return at(file.string(), film.error());
                         files->film = std::move(*film);
                         return {};
                     }
                     // Read below, with its details.
                     if (spec.is_panorama()) return {};
                     auto picture = read_picture(file);
                     if (!picture) return std::unexpected(picture.error());
                     if (spec.is_projected()) {
                         files->projected = std::make_shared<const PicturePyramid>(make_pyramid(std::move(*picture)));
                         return {};
                     }
                     files->picture = std::move(*picture);
                     if (patch.size && has_sides_of(files->picture.size, *patch.size))
                         files->scaled = std::make_shared<const Image>(scaled_picture(files->picture, *patch.size));
                     return {};
                 });
        !good)
        return good;
    for (std::size_t i = 0; i < spec.details.size(); ++i) {
        const std::string field = item_path("backdrop.details", i) + ".file";
        if (auto good =
                read(spec.details[i].file, field.c_str(), [](const std::filesystem::path&) { return Result<void>(); });
            !good)
            return good;
    }
    if (spec.is_panorama()) {
        const ErrorList::Pause paths_of_other_files;
        auto panorama = read_panorama(spec.file, spec.details);
        if (!panorama) return under("backdrop.", panorama.error());
        files->panorama = std::move(*panorama);
    }
    if (!spec.proxies.file.empty()) {
        auto good =
            read(spec.proxies.file, "backdrop.proxies.file", [&](const std::filesystem::path& file) -> Result<void> {
                auto model = load_model(file);
                if (!model) return std::unexpected(model.error());
                auto proxies = proxies_of_model(*model);
                if (!proxies) return at(file.string(), proxies.error());
                files->proxies = std::move(proxies->shapes);
                files->catchers = std::move(proxies->catchers);
                files->walkable = std::move(proxies->walkable);
                return {};
            });
        if (!good) return good;
    }
    files->masks.resize(spec.proxies.cutouts.size());
    for (std::size_t i = 0; i < spec.proxies.cutouts.size(); ++i) {
        CutoutProxy& cutout = spec.proxies.cutouts[i];
        if (cutout.mask.empty() || spec.is_panorama()) continue;
        const std::string field = item_path("backdrop.proxies.cutouts", i) + ".mask";
        auto good = read(cutout.mask, field.c_str(), [&](const std::filesystem::path& file) -> Result<void> {
            auto mask = read_picture(file);
            if (!mask) return std::unexpected(mask.error());
            if (mask->size != files->size()) return another_size(file, mask->size, *files);
            auto pieces = mask_pieces(*mask);
            if (!pieces) return at(file.string(), pieces.error());
            files->masks[i] = std::move(*pieces);
            return {};
        });
        if (!good) return good;
    }
    if (spec.proxies.depth && !spec.is_panorama()) {
        auto good = read(spec.proxies.depth->file, "backdrop.proxies.depth.file",
                         [&](const std::filesystem::path& file) -> Result<void> {
                             auto depth = read_depth(file);
                             if (!depth) return std::unexpected(depth.error());
                             if (depth->size != files->size()) return another_size(file, depth->size, *files);
                             auto pieces = depth_pieces(*depth, most_depth_piece_px);
                             if (!pieces) return at(file.string(), pieces.error());
                             files->depth = std::move(*pieces);
                             return {};
                         });
        if (!good) return good;
    }
    spec.files = std::move(files);
    return {};
}

}  // namespace camrig::world
