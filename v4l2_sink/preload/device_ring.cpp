#include "v4l2_sink/preload/device_ring.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include "core/base/clock.h"
#include "core/fault/delivery.h"
#include "core/fault/sending.h"
#include "core/fault/standing.h"
#include "core/stream/silence.h"

namespace camrig::device {

namespace {

constexpr std::size_t wanted_ring_bytes = std::size_t{16} << 20;  // small pictures get more slots, up to this
constexpr std::size_t page_mask = 4095;

std::uint64_t load(const std::uint64_t& shared) {
    return __atomic_load_n(&shared, __ATOMIC_SEQ_CST);
}

/// A picture that comes later than it was due says nothing of what fails now.
bool fails_stream(const fault::FrameFaults& faults) {
    return standing_of(faults).fails(fault::DeviceCall::streaming) &&
           fault::frames_late(faults, to_string(fault::Output::device)) == 0;
}

}  // namespace

Result<SharedMemory> SharedMemory::create(const char* name, std::size_t bytes, bool readers_only_read) {
    SharedMemory memory;
    memory.fd_.reset(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
    if (!memory.fd_ || ::ftruncate(memory.fd_.get(), static_cast<off_t>(bytes)) != 0)
        return error(ErrorKind::resource_exhausted,
                     std::string("no shared memory for devices: ") + std::strerror(errno));
    void* data = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, memory.fd_.get(), 0);
    if (data == MAP_FAILED)
        return error(ErrorKind::resource_exhausted,
                     std::string("no shared memory for devices: ") + std::strerror(errno));
    memory.data_ = static_cast<std::byte*>(data);
    memory.size_ = bytes;
    const int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL | (readers_only_read ? F_SEAL_FUTURE_WRITE : 0);
    if (::fcntl(memory.fd_.get(), F_ADD_SEALS, seals) != 0)
        return error(ErrorKind::unsupported,
                     std::string("user-space devices need Linux 5.1 or later (memory seals): ") + std::strerror(errno));
    return memory;
}

SharedMemory::SharedMemory(SharedMemory&& other) noexcept
    : fd_(std::move(other.fd_)), data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

SharedMemory& SharedMemory::operator=(SharedMemory&& other) noexcept {
    std::swap(fd_, other.fd_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
}

SharedMemory::~SharedMemory() {
    if (data_ != nullptr) ::munmap(data_, size_);
}

void RingReader::start(std::uint32_t slots) {
    allowed_ = slots - camrig_slot_margin;
    tokens_ = displaced_ = 0;
    pending_.clear();
    __atomic_store_n(&page_->displaced, 0, __ATOMIC_SEQ_CST);
    __atomic_store_n(&page_->wants_credit, 0, __ATOMIC_SEQ_CST);
}

void RingReader::stop() {
    stats_->dropped += pending_.size();
    pending_.clear();
}

bool RingReader::may_send() const {
    // Both numbers come from the other process. Whatever they say, no more than `allowed_` tokens are under way.
    return tokens_ < load(page_->queued) && tokens_ - load(page_->taken) < allowed_;
}

bool RingReader::send_token() {
    const char token = 1;
    return ::send(event_socket_, &token, sizeof token, MSG_DONTWAIT | MSG_NOSIGNAL) == sizeof token;
}

void RingReader::advance() {
    while (!pending_.empty() && may_send() && send_token()) {
        ++tokens_;
        ++stats_->delivered;
        pending_.pop_front();  // the token is in the program's socket: the picture counts as sent
    }
}

void RingReader::offer(const std::shared_ptr<stream::DeliveryLatch>& latch, std::size_t bytes, TimeNs latency_ns) {
    ++stats_->offered;
    pending_.push_back(hold_if(latch, stats_->peer));
    const std::uint64_t delivered = stats_->delivered;
    advance();
    if (stats_->delivered != delivered) {
        stats_->bytes += bytes;
        stats_->last_latency_ns = latency_ns;
    }
    if (latch && !pending_.empty()) {
        // Ask to be told, then look once more: either we see the buffer or the library sees the request.
        __atomic_store_n(&page_->wants_credit, 1, __ATOMIC_SEQ_CST);
        advance();
    }
    const std::uint64_t under_way = std::min(tokens_ - load(page_->taken), allowed_);
    const std::size_t may_wait = latch ? allowed_ - under_way : 0;
    while (pending_.size() > std::max<std::size_t>(may_wait, latch ? 1 : 0)) {
        __atomic_store_n(&page_->displaced, ++displaced_, __ATOMIC_RELEASE);
        ++stats_->dropped;
        pending_.pop_front();
    }
}

Result<std::shared_ptr<DeviceRing>> DeviceRing::create(ImageSize size, std::size_t picture_bytes,
                                                       std::optional<Rate> rate) {
    const std::size_t stride = (picture_bytes + page_mask) & ~page_mask;
    const std::size_t data_offset = (sizeof(camrig_ring_header) + page_mask) & ~page_mask;
    const std::size_t slots = std::clamp<std::size_t>(wanted_ring_bytes / stride, camrig_min_slots, camrig_max_slots);
    auto memory = SharedMemory::create("camrig ring", data_offset + slots * stride, true);
    if (!memory) return std::unexpected(memory.error());
    auto& header = *reinterpret_cast<camrig_ring_header*>(memory->data());
    header.protocol = CAMRIG_DEVICE_PROTOCOL;
    header.slots = static_cast<std::uint32_t>(slots);
    header.slot_bytes = static_cast<std::uint32_t>(picture_bytes);
    header.slot_stride = static_cast<std::uint32_t>(stride);
    header.data_offset = data_offset;
    return std::shared_ptr<DeviceRing>(new DeviceRing(std::move(*memory), size, rate));
}

DeviceRing::DeviceRing(SharedMemory memory, ImageSize size, std::optional<Rate> rate)
    : memory_(std::move(memory)), size_(size), rate_(rate) {}

Result<void> DeviceRing::open(const stream::StreamInfo& info) {
    if (info.size != size_)
        return error(ErrorKind::internal,
                     "device ring of " + size_.to_string() + " was given pictures of " + info.size.to_string());
    std::lock_guard lock(mutex_);
    stats_ = info.stats;
    return {};
}

void DeviceRing::close() noexcept {}

std::uint32_t DeviceRing::next_sequence(const frame::FrameInfo& info) {
    // With a lower rate than the camera's, the ticks of that rate are counted: a gap is a loss, never the rate. The
    // camera may have become slower still.
    const std::int64_t frames = info.sequence - std::exchange(camera_sequence_, info.sequence);
    const std::int64_t until = rate_ ? rate_->frames_until(info.world_ns) : info.sequence;
    counted_ += std::min(frames, until - std::exchange(ticks_, until));
    std::int64_t sequence = counted_ + sequence_offset_;
    if (sequence <= last_sequence_) {  // after repeated pictures, or a world that was loaded anew
        sequence_offset_ += last_sequence_ + 1 - sequence;
        sequence = last_sequence_ + 1;
    } else if (last_sequence_ < 0) {
        sequence_offset_ -= sequence;
        sequence = 0;
    }
    last_sequence_ = sequence;
    return static_cast<std::uint32_t>(sequence);
}

Result<void> DeviceRing::write(const stream::MediaUnit& unit) {
    const std::span<const std::byte> bytes = unit.frame   ? unit.frame->bytes()
                                             : unit.bytes ? std::span<const std::byte>(*unit.bytes)
                                                          : std::span<const std::byte>{};
    std::lock_guard lock(mutex_);
    is_held_back_ = false;
    const std::uint32_t sequence = next_sequence(unit.info);
    if (bytes.empty() || bytes.size() > header().slot_bytes) {
        if (stats_) ++stats_->dropped;
        return {};
    }
    clock_error_ns_ = unit.info.steady_ns() - unit.info.monotonic_ns;
    const fault::FrameFaults* const faults = unit.info.faults.get();
    const auto missing = faults ? fault::bytes_missing(*faults, bytes.size()) : std::nullopt;
    const std::span<const std::byte> sent = bytes.first(bytes.size() - (missing ? missing->bytes : 0));
    if (missing) fault::note(*faults, to_string(fault::Output::device), *missing);
    const bool is_bad = faults && fault::has_buffer_error(*faults);
    const std::uint32_t flags =
        (is_bad ? camrig_slot_error : 0) | (faults && fails_stream(*faults) ? camrig_slot_failed : 0);
    publish({sent, sequence, flags}, unit.info.monotonic_ns, unit.info.steady_ns(), unit.latch);
    late_ns_ = last_write_ns_ - unit.info.monotonic_ns;
    if (stats_ && (is_bad || sent.size() != bytes.size())) ++stats_->damaged;
    if (stats_) {
        ++stats_->delivered;
        stats_->bytes += sent.size();
        stats_->last_latency_ns = late_ns_;
    }
    return {};
}

void DeviceRing::publish(const Picture& picture, TimeNs monotonic_ns, TimeNs stamp_ns,
                         const std::shared_ptr<stream::DeliveryLatch>& latch) {
    const std::span<const std::byte> bytes = picture.bytes;
    const std::uint64_t number = published_++;
    const std::uint32_t index = static_cast<std::uint32_t>(number % header().slots);
    camrig_ring_slot& slot = header().slot[index];
    last_stamp_ns_ = std::max(stamp_ns, last_stamp_ns_ + ns_per_us);  // strictly rising, also in microseconds

    __atomic_store_n(&slot.version, 2 * number + 1, __ATOMIC_RELAXED);
    std::atomic_thread_fence(std::memory_order_release);
    slot.monotonic_ns = static_cast<std::uint64_t>(last_stamp_ns_);
    slot.sequence = picture.sequence;
    slot.bytes = static_cast<std::uint32_t>(bytes.size());
    slot.flags = picture.flags;
    std::memcpy(memory_.data() + header().data_offset + std::size_t{index} * header().slot_stride, bytes.data(),
                bytes.size());
    __atomic_store_n(&slot.version, 2 * number + 2, __ATOMIC_RELEASE);
    __atomic_store_n(&header().published, published_, __ATOMIC_RELEASE);

    last_write_ns_ = monotonic_now_ns();
    for (const auto& reader : readers_) reader->offer(latch, bytes.size(), last_write_ns_ - monotonic_ns);
}

void DeviceRing::hold_back() {
    std::lock_guard lock(mutex_);
    is_held_back_ = true;
}

void DeviceRing::repeat_if_idle(TimeNs monotonic_ns, TimeNs idle_ns) {
    std::lock_guard lock(mutex_);
    if (published_ == 0 || is_held_back_ || monotonic_ns - last_write_ns_ < idle_ns) return;
    const std::uint32_t index = static_cast<std::uint32_t>((published_ - 1) % header().slots);
    const std::byte* last = memory_.data() + header().data_offset + std::size_t{index} * header().slot_stride;
    const std::uint32_t bytes = header().slot[index].bytes;
    const TimeNs stamp_ns = monotonic_ns - stream::repeat_age_ns(late_ns_) + clock_error_ns_;
    publish({{last, bytes}, static_cast<std::uint32_t>(++last_sequence_)}, monotonic_ns, stamp_ns, nullptr);
}

camrig_ring_place DeviceRing::attach(const std::shared_ptr<RingReader>& reader) {
    std::lock_guard lock(mutex_);
    reader->start(header().slots);
    readers_.push_back(reader);
    camrig_ring_place place{};
    place.first = published_;
    place.ring_bytes = memory_.size();
    place.slots = header().slots;
    place.slot_bytes = header().slot_bytes;
    return place;
}

void DeviceRing::detach(const std::shared_ptr<RingReader>& reader) {
    std::lock_guard lock(mutex_);
    if (std::erase(readers_, reader) > 0) reader->stop();
}

void DeviceRing::credit(RingReader& reader) {
    std::lock_guard lock(mutex_);
    reader.advance();
    if (reader.pending_.empty()) __atomic_store_n(&reader.page_->wants_credit, 0, __ATOMIC_SEQ_CST);
}

std::vector<stream::ReaderReport> DeviceRing::readers() const {
    std::vector<stream::ReaderReport> reports;
    std::lock_guard lock(mutex_);
    for (const auto& reader : readers_) reports.push_back(reader->report());
    return reports;
}

}  // namespace camrig::device
