#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/time.h"
#include "core/world/backdrop/film_decoder.h"

namespace camrig::world {

/// A film as its file has it. Immutable.
struct FilmFile {
    std::filesystem::path path;
    FilmIndex index;
};

/// Reads what there is in it, and decodes the first picture to see that it can be. Takes as long as reading the file.
Result<std::shared_ptr<const FilmFile>> read_film(const std::filesystem::path& file);

/// The picture of a film that a camera shows at some instant.
struct FilmShot {
    std::int64_t frame = 0;                ///< of the film, from 0
    std::int64_t late = 0;                 ///< how many instants so far were shown an earlier picture
    std::shared_ptr<const Image> picture;  ///< null: FilmPlayer::picture_of() waits for it
};

/// Shows a film in step with world time, over and over: its pictures are due as the frames of cameras are (Rate), and
/// the last one that is shows: floor(world_ns * rate) mod N in whole numbers, so that a camera of the film's rate shows
/// each picture once. It is decoded, and brought to a camera's size, ahead on a thread of its own, which begins when
/// the film is first asked for. So many pictures are held at most as fit into 128 MiB, and two to eight.
class FilmPlayer {
public:
    FilmPlayer(std::shared_ptr<const FilmFile> file, Rate rate, ImageSize size);
    ~FilmPlayer();

    /// Which picture that is.
    std::int64_t frame_at(TimeNs world_ns) const;
    /// What is shown at an instant; never waits. is_exact: the picture of that time. Else, where it is not decoded yet,
    /// the one that was shown last, which is counted; the same for whoever asks for one of the last few instants again.
    /// Any thread.
    FilmShot at(TimeNs world_ns, bool is_exact);
    /// Waits until it is decoded. A picture that cannot be decoded shows the one before it. Any thread.
    std::shared_ptr<const Image> picture_of(const FilmShot& shot);

private:
    struct Held {
        std::int64_t frame;
        std::shared_ptr<const Image> picture;
    };
    struct Asked {
        TimeNs world_ns;
        std::int64_t due;
        FilmShot shot;
    };
    const Held* held(std::int64_t frame) const;
    void ask_for(TimeNs world_ns);
    /// The next picture to decode; -1: none is missing.
    std::int64_t missing() const;
    void make_room();
    void run();

    const std::shared_ptr<const FilmFile> file_;
    const Rate rate_;
    const ImageSize size_;
    const std::size_t capacity_;

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Held> held_;
    std::deque<Asked> asked_;            ///< the newest last
    std::vector<std::int64_t> ahead_;    ///< what is shown next, soonest first
    std::vector<std::int64_t> waiting_;  ///< somebody waits for them
    std::shared_ptr<const Image> last_;  ///< that was decoded
    TimeNs step_ns_ = 0;
    std::int64_t late_ = 0;
    bool has_begun_ = false, is_over_ = false;
    std::thread thread_;
};

}  // namespace camrig::world
