#include "core/world/backdrop/panorama_files.h"

#include <algorithm>
#include <mutex>
#include <string>
#include <vector>

#include "core/world/backdrop/picture_file.h"
#include "core/world/backdrop/proxy_maker.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

namespace fs = std::filesystem;

/// What a panorama was made of.
struct Source {
    fs::path file;
    std::vector<PanoramaDetail> details;
    std::vector<fs::file_time_type> written;  ///< of the file and those of its details
    friend bool operator==(const Source&, const Source&) = default;
};

Source source_of(const fs::path& file, std::span<const PanoramaDetail> details) {
    Source source{file, {details.begin(), details.end()}, {}};
    std::error_code missing;
    source.written.push_back(fs::last_write_time(file, missing));
    for (const PanoramaDetail& detail : details) source.written.push_back(fs::last_write_time(detail.file, missing));
    return source;
}

Result<std::shared_ptr<const Panorama>> make(const fs::path& file, std::span<const PanoramaDetail> details) {
    const auto opened = PictureFile::open(file);
    if (!opened) return at("file", opened.error());
    int finest = 1;
    for (std::size_t i = 0; i < details.size(); ++i) {
        const std::string problem = PanoramaMaker::scale_problem(details[i].scale, opened->size().width);
        if (!problem.empty()) return std::unexpected(refused(item_path("details", i) + ".scale: " + problem));
        finest = std::max(finest, details[i].scale);
    }
    auto whole = opened->decode();
    if (!whole) return at("file", whole.error());
    auto maker = PanoramaMaker::create(std::move(*whole), finest);
    if (!maker) return at("file: " + file.string(), maker.error());
    // All that is to be refused is, before any is decoded.
    std::vector<ImageSize> sizes;
    for (std::size_t i = 0; i < details.size(); ++i) {
        const std::string place = item_path("details", i);
        const auto part = PictureFile::open(details[i].file);
        if (!part) return at(place + ".file", part.error());
        if (auto room = maker->reserve(details[i], part->size()); !room) return under(place + ".", room.error());
        sizes.push_back(part->size());
    }
    for (std::size_t i = 0; i < details.size(); ++i) {
        const std::string place = item_path("details", i) + ".file";
        const auto picture = read_picture(details[i].file);
        if (!picture) return at(place, picture.error());
        if (picture->size != sizes[i]) return std::unexpected(refused(place + ": was changed while it was read"));
        maker->put(details[i], *picture);
    }
    return maker->finish();
}

}  // namespace

Result<std::shared_ptr<const Panorama>> read_panorama(const fs::path& file, std::span<const PanoramaDetail> details) {
    struct Known {
        Source source;
        std::weak_ptr<const Panorama> panorama;
    };
    static std::mutex mutex;
    static std::vector<Known> known;
    const std::lock_guard lock(mutex);
    std::erase_if(known, [](const Known& one) { return one.panorama.expired(); });
    Source source = source_of(file, details);
    for (const Known& one : known)
        if (one.source == source)
            if (auto panorama = one.panorama.lock()) return panorama;
    auto made = make(file, details);
    if (made) known.push_back({std::move(source), *made});
    return made;
}

}  // namespace camrig::world
