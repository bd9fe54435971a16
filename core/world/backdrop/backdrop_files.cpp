#include <cstring>

#include "core/base/error_list.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/backdrop/mask_pieces.h"
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
constexpr std::size_t max_picture_bytes = std::size_t{256} << 20;

Result<std::filesystem::path> file_of(const std::string& file, const std::filesystem::path& folder) {
    if (folder.empty()) {
        if (std::filesystem::path(file).is_absolute() && file.find('\0') == std::string::npos) return file;
        return error(ErrorKind::invalid_argument, "must be an absolute path; relative ones are those of scene files");
    }
    // What a scene file said is an absolute path in what camera.get answers.
    if (leads_below(file)) return std::filesystem::absolute(folder / file);
    return error(ErrorKind::invalid_argument, "must be a path below the scene file's folder");
}

/// A JPEG as a camera wrote it may lie on its side, and say so (Exif 2.3, 4.6.4, tag 0x0112); 0 and 1: upright or not
/// said.
int orientation_of(std::span<const std::byte> bytes) {
    const auto at = [&](std::size_t i) { return i < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i]) : 0u; };
    if (at(0) != 0xFF || at(1) != 0xD8) return 1;
    for (std::size_t from = 2; at(from) == 0xFF && at(from + 1) >= 0xE0 && at(from + 1) <= 0xEF;) {
        const std::size_t length = at(from + 2) << 8 | at(from + 3), body = from + 4;
        if (at(from + 1) == 0xE1 && length > 8 && body + 6 <= bytes.size() &&
            std::memcmp(bytes.data() + body, "Exif\0\0", 6) == 0) {
            const std::size_t tiff = body + 6;
            const bool is_little = at(tiff) == 'I';
            const auto word = [&](std::size_t i) {
                return is_little ? at(i) | at(i + 1) << 8 : at(i) << 8 | at(i + 1);
            };
            const std::size_t directory =
                tiff + (is_little ? word(tiff + 4) | word(tiff + 6) << 16 : word(tiff + 4) << 16 | word(tiff + 6));
            const std::uint32_t entries = word(directory);
            for (std::uint32_t i = 0; i < entries && directory + 14 + 12 * i <= bytes.size(); ++i)
                if (word(directory + 2 + 12 * i) == 0x0112) return static_cast<int>(word(directory + 10 + 12 * i));
        }
        if (length < 2) break;
        from += 2 + length;
    }
    return 1;
}

Result<Image> read_picture(const std::filesystem::path& file) {
    try {
        const auto bytes = gltf::read_file(file, max_picture_bytes);
        if (const int turned = orientation_of(bytes); turned > 1)
            gltf::fail("", "is stored turned (Exif orientation " + std::to_string(turned) + "); save it upright",
                       ErrorKind::unsupported);
        gltf::Budget budget;
        return gltf::decode_image(bytes, "", budget);
    } catch (const gltf::Failure& failure) {
        return at(file.string(), failure.error);
    }
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

/// Cameras of one place share it: it may take most of a gigabyte.
Result<std::shared_ptr<const Panorama>> read_panorama(const std::filesystem::path& file) {
    struct Known {
        std::filesystem::path file;
        std::filesystem::file_time_type written;
        std::weak_ptr<const Panorama> panorama;
    };
    static std::mutex mutex;
    static std::vector<Known> known;
    const std::lock_guard lock(mutex);
    std::erase_if(known, [](const Known& one) { return one.panorama.expired(); });
    std::error_code missing;
    const auto written = std::filesystem::last_write_time(file, missing);
    for (const Known& one : known)
        if (one.file == file && one.written == written)
            if (auto panorama = one.panorama.lock()) return panorama;
    auto picture = read_picture(file);
    if (!picture) return std::unexpected(picture.error());
    auto made = make_panorama(std::move(*picture));
    if (!made) return at(file.string(), made.error());
    known.push_back({file, written, *made});
    return made;
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
                     if (spec.is_panorama()) {
                         auto panorama = read_panorama(file);
                         if (!panorama) return std::unexpected(panorama.error());
                         files->panorama = std::move(*panorama);
                         return {};
                     }
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
