#include "v4l2_sink/preload/device_tree.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <sys/stat.h>

namespace camrig::device {

namespace fs = std::filesystem;

namespace {

constexpr int video_major = 81;

std::string link_name(const std::string& root, std::string_view camera) {
    return root + "/dev/v4l/by-id/camrig-" + std::string(camera) + "-video-index0";
}
std::string class_folder(const std::string& root, int number) {
    return root + "/sys/class/video4linux/video" + std::to_string(number);
}
std::string char_link(const std::string& root, int number) {
    return root + "/sys/dev/char/" + std::to_string(video_major) + ":" + std::to_string(number);
}

std::string udev_file(const std::string& root, int number) {
    return root + "/run/udev/data/c" + std::to_string(video_major) + ":" + std::to_string(number);
}
/// What udev would know of a camera (systemd's own format, which only libudev reads): that it is set up, what its rules
/// found out by asking the device, and its link, if it has one.
std::string udev_text(std::string_view camera, bool has_link) {
    const std::string name(camera);
    return (has_link ? "S:v4l/by-id/camrig-" + name + "-video-index0\n" : "") +
           "I:1\nE:ID_V4L_VERSION=2\nE:ID_V4L_PRODUCT=" + name + "\nE:ID_V4L_CAPABILITIES=:capture:\nV:1\n";
}

Result<void> write_file(const std::string& path, const std::string& text) {
    std::ofstream file(path);
    if (file << text << std::flush) return {};
    return error(ErrorKind::unavailable, path + ": cannot be written: " + std::strerror(errno));
}

Result<void> write_device(const std::string& root, int number, std::string_view camera) {
    const std::string node = "video" + std::to_string(number), folder = class_folder(root, number);
    const std::string dev = std::to_string(video_major) + ":" + std::to_string(number);
    const std::pair<const char*, std::string> files[] = {
        {"/name", std::string(camera) + "\n"},
        {"/index", "0\n"},
        {"/dev", dev + "\n"},
        {"/uevent",
         "MAJOR=" + std::to_string(video_major) + "\nMINOR=" + std::to_string(number) + "\nDEVNAME=" + node + "\n"}};
    std::error_code problem;
    fs::create_directories(folder, problem);
    if (!problem) fs::create_directories(root + "/run/udev/data", problem);
    if (!problem) fs::create_symlink("../../class/video4linux/" + node, char_link(root, number), problem);
    if (!problem) fs::create_symlink("../../video4linux", folder + "/subsystem", problem);
    if (problem)
        return error(ErrorKind::unavailable,
                     root + ": cannot make the files of /dev/" + node + ": " + problem.message());
    for (const auto& [name, text] : files)
        if (auto done = write_file(folder + name, text); !done) return done;
    std::error_code taken;  // a camera may have two devices; its name leads to the first
    fs::create_symlink("../../" + node, link_name(root, camera), taken);
    if (auto done = write_file(udev_file(root, number), udev_text(camera, !taken)); !done) return done;
    // The node comes last: who sees it sees everything.
    return write_file(root + "/dev/" + node, "");
}

}  // namespace

Result<DeviceTree> DeviceTree::create(std::string_view socket_path) {
    const std::string root = std::string(socket_path) + ".tree";
    std::error_code problem;
    fs::remove_all(root, problem);
    // Only a folder that did not exist a moment ago is empty and ours: in one that somebody prepared, a link named like
    // a device would send what we write into any file of this user.
    if (!problem && ::mkdir(root.c_str(), 0700) != 0) problem = std::error_code(errno, std::generic_category());
    if (problem)
        return error(ErrorKind::unavailable,
                     root + ": " + problem.message() +
                         "; the files of devices need a new folder of that name: have the old one removed");
    for (const char* folder : {"/dev/v4l/by-id", "/sys/class/video4linux", "/sys/dev/char"}) {
        fs::create_directories(root + folder, problem);
        if (problem)
            return error(ErrorKind::unavailable,
                         root + ": " + problem.message() + "; devices in user space need a folder they can write to");
    }
    return DeviceTree(root);
}

DeviceTree::~DeviceTree() {
    if (root_.empty()) return;
    std::error_code ignored;
    fs::remove_all(root_, ignored);
}

Result<void> DeviceTree::add(int number, std::string_view camera) {
    auto added = write_device(root_, number, camera);
    if (!added) remove(number, camera);
    return added;
}

void DeviceTree::remove(int number, std::string_view camera) {
    std::error_code ignored;
    fs::remove(root_ + "/dev/video" + std::to_string(number), ignored);
    // A camera may have another device, to which its name leads.
    const std::string link = link_name(root_, camera);
    if (fs::read_symlink(link, ignored).filename() == "video" + std::to_string(number)) fs::remove(link, ignored);
    fs::remove(char_link(root_, number), ignored);
    fs::remove(udev_file(root_, number), ignored);
    fs::remove_all(class_folder(root_, number), ignored);
}

}  // namespace camrig::device
