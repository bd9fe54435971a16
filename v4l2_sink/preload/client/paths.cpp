#include "v4l2_sink/preload/client/paths.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/sys.h"

namespace camrig::device {

namespace {

char socket_name[PATH_MAX];
char tree_name[PATH_MAX];

/// Appends text; false when there is no room.
bool append(char* to, size_t& length, const char* text, size_t bytes) {
    if (length + bytes + 1 > PATH_MAX) return false;
    memcpy(to + length, text, bytes);
    length += bytes;
    to[length] = 0;
    return true;
}
bool append(char* to, size_t& length, const char* text) {
    return append(to, length, text, strlen(text));
}

bool starts_with(const char* text, const char* prefix) {
    return strncmp(text, prefix, strlen(prefix)) == 0;
}
bool is_at_or_below(const char* name, const char* folder) {
    const size_t length = strlen(folder);
    return strncmp(name, folder, length) == 0 && (name[length] == 0 || name[length] == '/');
}
/// Where devices are named and described. Only what udev knows of them is ours in /run.
bool is_of_devices(const char* name) {
    return is_at_or_below(name, "/dev") || is_at_or_below(name, "/sys") || is_at_or_below(name, "/run/udev");
}

/// "videoN" with N in range and nothing behind: the number, else -1.
int video_number(const char* name) {
    if (!starts_with(name, "video")) return -1;
    const char* digit = name + 5;
    if (*digit == 0 || (*digit == '0' && digit[1] != 0)) return -1;
    int number = 0;
    for (; *digit != 0; ++digit) {
        if (*digit < '0' || *digit > '9') return -1;
        number = number * 10 + (*digit - '0');
        if (number > camrig_max_device_number) return -1;
    }
    return number;
}

const char* last_component(const char* name) {
    const char* slash = strrchr(name, '/');
    return slash != nullptr ? slash + 1 : name;
}

long mode_of(const char* path, bool follow, uint32_t& mode) {
    struct stat info;
    const long result = raw_syscall(SYS_newfstatat, AT_FDCWD, arg(path), arg(&info), follow ? 0 : AT_SYMLINK_NOFOLLOW);
    mode = failed(result) ? 0 : info.st_mode;
    return result;
}

/// Where a symbolic link leads.
bool read_link(const char* path, char* target) {
    const long got = raw_syscall(SYS_readlinkat, AT_FDCWD, arg(path), arg(target), PATH_MAX - 1);
    if (got <= 0) return false;
    target[got] = 0;
    return true;
}

/// A name without the tree that it may lead into: a folder of ours that the program has opened.
const char* without_tree(const char* full) {
    return starts_with(full, tree_name) ? full + strlen(tree_name) : full;
}

/// In our tree links are relative and lead to folders and nodes, never to further links.
constexpr int max_links = 1;

bool tidy(const char* name, char* out, size_t& length, int links = max_links);

/// Goes to the folder above, as ".." does: of a link, above the folder it leads to. False: not of a folder of ours.
bool go_up(char* out, size_t& length, int links) {
    const char* inside = without_tree(out);
    if (*inside == 0) return true;  // above the root is the root
    char path[PATH_MAX];
    size_t path_length = 0;
    if (!append(path, path_length, tree_name) || !append(path, path_length, inside)) return false;
    uint32_t mode = 0;
    mode_of(path, false, mode);
    if (!S_ISDIR(mode) && !S_ISLNK(mode)) return false;
    length = static_cast<size_t>(strrchr(out, '/') - out);
    out[length] = 0;
    if (S_ISDIR(mode)) return true;
    char target[PATH_MAX];
    return links > 0 && read_link(path, target) && tidy(target, out, length, links - 1) &&
           go_up(out, length, links - 1);
}

/// Removes double slashes, "." and ".." components of an absolute name; ".." of what is not ours is left to the kernel
/// (false).
bool tidy(const char* name, char* out, size_t& length, int links) {
    while (*name != 0) {
        while (*name == '/') ++name;
        const char* end = strchr(name, '/');
        const size_t bytes = end != nullptr ? static_cast<size_t>(end - name) : strlen(name);
        if (bytes == 2 && name[0] == '.' && name[1] == '.') {
            if (!go_up(out, length, links)) return false;
        } else if (bytes > 0 && !(bytes == 1 && name[0] == '.')) {
            if (!append(out, length, "/", 1) || !append(out, length, name, bytes)) return false;
        }
        name += bytes;
    }
    return true;
}

/// The folder a relative name starts from, as an absolute name.
bool base_folder(int directory_fd, char* out, size_t& length) {
    long got;
    if (directory_fd == AT_FDCWD) {
        got = raw_syscall(SYS_getcwd, arg(out), PATH_MAX);
        if (got <= 1 || out[0] != '/') return false;
        length = static_cast<size_t>(got) - 1;
        return true;
    }
    char link[40] = "/proc/self/fd/";
    char digits[12];
    int at = sizeof digits - 1;
    digits[at] = 0;
    unsigned value = static_cast<unsigned>(directory_fd);
    do digits[--at] = static_cast<char>('0' + value % 10);
    while ((value /= 10) != 0);
    strcat(link, digits + at);
    got = raw_syscall(SYS_readlinkat, AT_FDCWD, arg(link), arg(out), PATH_MAX - 1);
    if (got <= 0 || out[0] != '/') return false;
    length = static_cast<size_t>(got);
    out[length] = 0;
    return true;
}

}  // namespace

const char* socket_path() {
    return socket_name;
}

const char* tree_path() {
    return tree_name;
}

__attribute__((constructor)) void read_environment() {
    socket_name[0] = tree_name[0] = 0;
    size_t length = 0;
    const char* given = getenv("CAMRIG_DEVICE_SOCKET");
    if (given == nullptr || *given == 0 || !append(socket_name, length, given)) return;
    length = 0;
    if (!append(tree_name, length, socket_name) || !append(tree_name, length, ".tree")) tree_name[0] = 0;
}

bool may_be_ours(const char* name) {
    if (name == nullptr || tree_name[0] == 0) return false;
    if (name[0] == '/') {
        while (name[1] == '/') ++name;
        return is_of_devices(name) || starts_with(name, tree_name);
    }
    return true;
}

bool is_in_our_sys(int fd) {
    char name[PATH_MAX];
    size_t length = 0;
    if (tree_name[0] == 0 || fd < 0 || !base_folder(fd, name, length)) return false;
    return starts_with(name, tree_name) && is_at_or_below(name + strlen(tree_name), "/sys");
}

void find_place(int directory_fd, const char* name, Place& place) {
    place.kind = PlaceKind::foreign;
    place.link = false;
    if (!may_be_ours(name)) return;
    char full[PATH_MAX];
    size_t length = 0;
    full[0] = 0;
    if (name[0] != '/') {
        // Programs hardly ever use relative names for devices; only the last component decides whether to look closer.
        if (directory_fd == AT_FDCWD && video_number(last_component(name)) < 0) return;
        char base[PATH_MAX];
        size_t base_length = 0;
        if (name[0] == 0 || !base_folder(directory_fd, base, base_length)) return;
        if (!is_of_devices(base) && !starts_with(base, tree_name)) return;
        if (!tidy(base, full, length)) return;
    }
    if (!tidy(name, full, length)) return;
    const char* inside = without_tree(full);
    if (!is_of_devices(inside)) return;
    if (strcmp(inside, "/dev/null") == 0) return;

    size_t tree_length = 0;
    if (!append(place.path, tree_length, tree_name) || !append(place.path, tree_length, inside)) return;
    uint32_t mode = 0;
    if (failed(mode_of(place.path, false, mode))) return;

    const bool is_link = (mode & S_IFMT) == S_IFLNK;
    if (starts_with(inside, "/dev/")) {
        int number = video_number(inside + 5);
        if (number < 0 && is_link) {
            char target[PATH_MAX];
            if (read_link(place.path, target)) number = video_number(last_component(target));
        }
        if (number >= 0) {
            place.kind = PlaceKind::node;
            place.number = static_cast<uint32_t>(number);
            place.link = is_link;
            return;
        }
    }
    place.kind = PlaceKind::file;
    if ((mode & S_IFMT) == S_IFDIR) {
        uint32_t system_mode = 0;
        if (!failed(mode_of(inside, true, system_mode))) place.kind = PlaceKind::merged;
    }
}

}  // namespace camrig::device
