#include "core/world/backdrop/film_player.h"

#include <algorithm>

#include <pthread.h>
#include <spdlog/spdlog.h>

#include "core/base/out_of_memory.h"
#include "core/world/backdrop/scale_picture.h"

namespace camrig::world {
namespace {

constexpr std::int64_t max_held_bytes = std::int64_t{128} << 20;
constexpr std::size_t max_asked = 4;
/// Instants farther apart say nothing of the next one.
constexpr TimeNs max_picture_ns = 10 * ns_per_s;

}  // namespace

Result<std::shared_ptr<const FilmFile>> read_film(const std::filesystem::path& file) {
    // A pipe or a device might keep who opens it waiting for ever.
    std::error_code failed;
    const auto type = std::filesystem::status(file, failed).type();
    if (type != std::filesystem::file_type::regular && type != std::filesystem::file_type::not_found)
        return error(ErrorKind::invalid_argument, "is not a regular file");
    auto decoder = FilmDecoder::open(file);
    if (!decoder) return std::unexpected(decoder.error());
    auto index = (*decoder)->index();
    if (!index) return std::unexpected(index.error());
    if (auto first = (*decoder)->picture(*index, 0); !first) return std::unexpected(first.error());
    return std::make_shared<const FilmFile>(FilmFile{file, std::move(*index)});
}

FilmPlayer::FilmPlayer(std::shared_ptr<const FilmFile> file, Rate rate, ImageSize size)
    : file_(std::move(file)),
      rate_(rate),
      size_(size),
      capacity_(static_cast<std::size_t>(std::clamp<std::int64_t>(max_held_bytes / (4 * size.pixels()), 2, 8))) {}

FilmPlayer::~FilmPlayer() {
    {
        const std::lock_guard lock(mutex_);
        is_over_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

std::int64_t FilmPlayer::frame_at(TimeNs world_ns) const {
    return (rate_.frames_until(world_ns) - 1) % static_cast<std::int64_t>(file_->index.times.size());
}

const FilmPlayer::Held* FilmPlayer::held(std::int64_t frame) const {
    const auto found = std::ranges::find(held_, frame, &Held::frame);
    return found == held_.end() ? nullptr : &*found;
}

void FilmPlayer::ask_for(TimeNs world_ns) {
    if (!asked_.empty()) {
        const TimeNs step_ns = world_ns - asked_.back().world_ns;
        if (step_ns > 0 && step_ns <= max_picture_ns) step_ns_ = step_ns;
    }
    if (step_ns_ == 0) step_ns_ = rate_.period_ns();
    ahead_.clear();
    // A camera that is faster than the film shows its pictures several times.
    constexpr int most_steps = 64;
    for (int i = 0; i < most_steps && ahead_.size() < capacity_; ++i)
        if (const std::int64_t frame = frame_at(world_ns + i * step_ns_);
            std::ranges::find(ahead_, frame) == ahead_.end())
            ahead_.push_back(frame);
    if (!has_begun_) thread_ = std::thread([this] { run(); });
    has_begun_ = true;
    changed_.notify_all();
}

FilmShot FilmPlayer::at(TimeNs world_ns, bool is_exact) {
    const std::lock_guard lock(mutex_);
    // What was waited for is there by now.
    for (Asked& earlier : asked_)
        if (const Held* const one = held(earlier.shot.frame); one != nullptr && earlier.shot.picture == nullptr)
            earlier.shot.picture = one->picture;
    if (const auto known = std::ranges::find(asked_, world_ns, &Asked::world_ns); known != asked_.end())
        return known->shot;
    ask_for(world_ns);
    const std::int64_t due = frame_at(world_ns);
    FilmShot shot{.frame = due, .late = late_, .picture = nullptr};
    if (const Held* const one = held(due)) {
        shot.picture = one->picture;
    } else if (!is_exact) {
        // What has become ready since counts as the last one.
        for (auto earlier = asked_.rbegin(); earlier != asked_.rend() && shot.picture == nullptr; ++earlier) {
            if (const Held* const other = held(earlier->due))
                shot = {.frame = other->frame, .late = 0, .picture = other->picture};
            else if (earlier->shot.picture != nullptr)
                shot = earlier->shot;
        }
        if (shot.picture != nullptr) shot.late = ++late_;
    }
    asked_.push_back({world_ns, due, shot});
    if (asked_.size() > max_asked) asked_.pop_front();
    return shot;
}

std::shared_ptr<const Image> FilmPlayer::picture_of(const FilmShot& shot) {
    if (shot.picture != nullptr) return shot.picture;
    std::unique_lock lock(mutex_);
    waiting_.push_back(shot.frame);
    changed_.notify_all();
    changed_.wait(lock, [&] { return held(shot.frame) != nullptr; });
    const auto picture = held(shot.frame)->picture;
    waiting_.erase(std::ranges::find(waiting_, shot.frame));
    return picture;
}

std::int64_t FilmPlayer::missing() const {
    for (const auto* list : {&waiting_, &ahead_})
        for (const std::int64_t frame : *list)
            if (held(frame) == nullptr) return frame;
    return -1;
}

void FilmPlayer::make_room() {
    while (held_.size() >= capacity_) {
        const auto is_needed = [&](const Held& one) {
            return std::ranges::find(waiting_, one.frame) != waiting_.end() ||
                   std::ranges::find(ahead_, one.frame) != ahead_.end();
        };
        const auto idle = std::ranges::find_if_not(held_, is_needed);
        if (idle != held_.end()) {
            held_.erase(idle);
            continue;
        }
        // All of them are wanted: those that somebody waits for first, of the others the soonest.
        const auto is_waited_for = [&](const Held& one) {
            return std::ranges::find(waiting_, one.frame) != waiting_.end();
        };
        const auto other = std::ranges::find_if_not(held_, is_waited_for);
        if (other == held_.end()) return;
        held_.erase(other);
    }
}

void FilmPlayer::run() {
    pthread_setname_np(pthread_self(), "camrig-film");
    std::unique_ptr<FilmDecoder> decoder;
    bool has_told = false;
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return is_over_ || missing() >= 0; });
        if (is_over_) return;
        const std::int64_t frame = missing();
        std::shared_ptr<const Image> picture = last_;
        lock.unlock();
        Result<Image> decoded = or_out_of_memory("decoding a film", [&]() -> Result<Image> {
            if (decoder == nullptr) {
                auto opened = FilmDecoder::open(file_->path);
                if (!opened) return std::unexpected(opened.error());
                decoder = std::move(*opened);
            }
            auto made = decoder->picture(file_->index, static_cast<std::size_t>(frame));
            return made && made->size != size_ ? scaled_picture(*made, size_) : std::move(made);
        });
        if (decoded) {
            picture = std::make_shared<const Image>(std::move(*decoded));
        } else if (!has_told) {
            has_told = true;
            spdlog::warn("{}: {}; the picture before it is shown", file_->path.string(), decoded.error().message);
        }
        if (picture == nullptr)
            picture = std::make_shared<const Image>(Image{
                .size = size_, .rgba = std::vector<std::uint8_t>(static_cast<std::size_t>(size_.pixels()) * 4, 255)});
        lock.lock();
        last_ = picture;
        make_room();
        held_.push_back({frame, std::move(picture)});
        changed_.notify_all();
    }
}

}  // namespace camrig::world
