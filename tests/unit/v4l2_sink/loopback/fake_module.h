#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <linux/videodev2.h>

#include "v4l2_sink/loopback/kernel.h"
#include "v4l2_sink/loopback/module_abi.h"

namespace camrig::device {

/// The device that most tests here are about.
inline constexpr int video_number = 10;

/// A picture as a reader of the device gets it.
struct ReadPicture {
    std::vector<std::byte> bytes;
    std::int64_t stamp_us = 0;
    std::uint32_t sequence = 0;
    std::uint32_t index = 0;
};

/// v4l2loopback in memory, in one of its generations: the answers that its sources give, as far as a writer sees them.
class FakeModule final : public LoopbackKernel {
public:
    /// 12: no control node, no version told, write() only. 13: control node, events. 14: streaming. 15: tells its
    /// version by ioctl too.
    explicit FakeModule(int minor) : minor_(minor) {}
    ~FakeModule() override;

    struct Device {
        std::string driver = "v4l2 loopback";
        std::string card;
        int max_buffers = 4;
        bool exclusive = true;
        bool keep_format = false;
        bool has_format = false;  ///< somebody fixed it
        v4l2_pix_format pix{};
        v4l2_fract interval{1, 30};
        int writer = -1;  ///< descriptor that streams
        std::vector<std::vector<std::byte>> memory;
        std::uint64_t written = 0;
        std::vector<ReadPicture> pictures;
        bool is_held = false;  ///< a reader has it open and its buffers mapped
        std::uint32_t readers = 0;
        bool s_parm_came = false;
    };

    // What tests set up and look at.
    bool loaded = true;
    bool tells_version = true;      ///< /sys/module/v4l2loopback/version; 12 never does
    int control_problem = 0;        ///< errno of opening the control node
    int open_problem = 0;           ///< errno of opening a device
    int write_problem = 0;          ///< errno of giving it a picture
    int add_gives = -1;             ///< number that add gives instead of the asked one
    std::string version;            ///< instead of the generation's
    std::map<int, Device> devices;  ///< by number
    std::vector<std::string> calls;
    int added = 0, removed = 0;

    Device& plug(int number, const std::string& card = "by hand");
    /// A reader opens the device and streams, or goes.
    void reader_comes(int number);
    void reader_leaves(int number);
    /// As the kernel does when the rig is killed.
    void close_all();
    std::size_t open_descriptors() const { return open_.size(); }

    bool exists(const std::string& path) override;
    std::optional<std::string> read_line(const std::string& path) override;
    int open(const std::string& path) override;
    void close(int fd) override;
    int ioctl(int fd, unsigned long request, void* argument) override;
    std::byte* map(int fd, std::size_t bytes, std::int64_t offset) override;
    void unmap(std::byte* data, std::size_t bytes) override;
    std::int64_t write(int fd, std::span<const std::byte> bytes) override;

private:
    static constexpr int control = -1;
    struct Opener {
        int number = control;
        bool has_format = false;
        std::uint32_t buffers = 0;
        bool subscribed = false;
        std::optional<std::uint32_t> event;
    };

    int control_ioctl(unsigned long request, void* argument);
    int set_format(Opener& opener, Device& device, v4l2_format& format);
    int queue(Opener& opener, Device& device, v4l2_buffer& buffer);
    void tell_usage(int number);
    void free_if_unused(int number);
    bool in_use_by_others(const Device& device, int fd) const;

    const int minor_;
    int next_fd_ = 100;
    std::map<int, Opener> open_;
    std::set<std::byte*> mapped_;
};

}  // namespace camrig::device
