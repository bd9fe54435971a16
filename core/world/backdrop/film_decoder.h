#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/rate.h"
#include "core/base/result.h"
#include "core/world/model.h"

namespace camrig::world {

/// What is known of a film without decoding it.
struct FilmIndex {
    ImageSize size;
    Rate rate;                         ///< on average
    std::vector<std::int64_t> times;   ///< of its pictures as they are shown, in the file's own units, rising
    std::vector<std::int64_t> starts;  ///< of those among them that need no other (key frames), rising
};

/// Reads pictures of a film by their numbers: MP4, Matroska, WebM, AVI, MPEG-TS and MJPEG, with what codecs libav has.
///
/// Limited and full range and the matrices of BT.601 and BT.709 are told apart by what the file says; of one that says
/// no matrix, BT.709 from 720 rows on, else and for JPEG BT.601.
///
/// Thread: one at a time.
class FilmDecoder {
public:
    /// Errors: no film of these; turned by its metadata, of pixels that are no squares, interlaced, of a wide gamut or
    /// high dynamic range; larger than 8192 pixels a side.
    static Result<std::unique_ptr<FilmDecoder>> open(const std::filesystem::path& file);
    virtual ~FilmDecoder() = default;

    /// Reads the whole file, from its beginning. Errors: pictures without times or with the same, none, or more than a
    /// million of them; no rate within 1/10 .. 1000.
    virtual Result<FilmIndex> index() = 0;
    /// The picture of that number, opaque. In order, or nearly so, is fast; else it is decoded from the last key frame
    /// before it. Error: it cannot be decoded.
    virtual Result<Image> picture(const FilmIndex& index, std::size_t number) = 0;
};

}  // namespace camrig::world
