// Listing /dev and /sys: a folder that exists both in the system and in the rig's tree shows the entries of both.

#include <dirent.h>
#include <fcntl.h>
#include <glob.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/hook.h"
#include "v4l2_sink/preload/client/paths.h"
#include "v4l2_sink/preload/client/sys.h"

using DirentFilter = int(const struct dirent*);
using DirentOrder = int(const struct dirent**, const struct dirent**);

HOOK(DIR*, opendir, (const char* name))
HOOK(DIR*, fdopendir, (int fd))
HOOK(struct dirent*, readdir, (DIR * folder))
HOOK(struct dirent*, readdir64, (DIR * folder))
HOOK(void, rewinddir, (DIR * folder))
HOOK(int, closedir, (DIR * folder))
HOOK(int, scandir, (const char* name, struct dirent*** list, DirentFilter* filter, DirentOrder* order))
HOOK(int, scandir64, (const char* name, struct dirent*** list, DirentFilter* filter, DirentOrder* order))
HOOK(int, glob, (const char* pattern, int flags, int (*on_error)(const char*, int), glob_t* found))
HOOK(int, glob64, (const char* pattern, int flags, int (*on_error)(const char*, int), glob_t* found))

using namespace camrig::device;

namespace {

constexpr int max_merged = 64;  // folders of ours listed at one time; further ones show the system's entries only

struct Merged {
    DIR* system = nullptr;
    DIR* ours = nullptr;
    bool nodes = false;  // entries are devices
};
Merged merged[max_merged];
pthread_mutex_t merged_lock = PTHREAD_MUTEX_INITIALIZER;
std::atomic<int> merged_count{0};

void remember(DIR* system, const Place& place) {
    if (system == nullptr || place.kind != PlaceKind::merged) return;
    DIR* ours = real::opendir(place.path);
    if (ours == nullptr) return;
    const size_t length = strlen(place.path);
    Locked guard(merged_lock);
    for (Merged& entry : merged) {
        if (entry.system != nullptr) continue;
        entry = {system, ours, length > 4 && strcmp(place.path + length - 4, "/dev") == 0};
        merged_count.fetch_add(1, std::memory_order_relaxed);
        return;
    }
    real::closedir(ours);
}

Merged* merged_with(DIR* system) {
    if (merged_count.load(std::memory_order_relaxed) == 0) return nullptr;
    Locked guard(merged_lock);
    for (Merged& entry : merged)
        if (entry.system == system) return &entry;
    return nullptr;
}

/// Does the system have an entry of this name itself? Then it has been listed already.
bool in_system(DIR* system, const char* name) {
    struct stat info;
    return !failed(raw_syscall(SYS_newfstatat, dirfd(system), arg(name), arg(&info), AT_SYMLINK_NOFOLLOW));
}

template <typename Real>
struct dirent* read_entry(const Real& next, DIR* folder) {
    struct dirent* entry = next(folder);
    if (entry != nullptr) return entry;
    Merged* both = merged_with(folder);
    if (both == nullptr) return nullptr;
    while ((entry = next(both->ours)) != nullptr) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
        if (in_system(folder, entry->d_name)) continue;
        if (both->nodes && strncmp(entry->d_name, "video", 5) == 0) entry->d_type = DT_CHR;
        return entry;
    }
    return nullptr;
}

/// scandir() over the hooks; libc's own would use its private readdir.
template <typename Real>
int scan(const Real& next, const char* name, struct dirent*** list, DirentFilter* filter, DirentOrder* order) {
    Place place;
    place.kind = PlaceKind::foreign;
    if (may_be_ours(name)) find_place(AT_FDCWD, name, place);
    if (place.kind == PlaceKind::file) return next(place.path, list, filter, order);
    if (place.kind != PlaceKind::merged) return next(name, list, filter, order);
    DIR* folder = hook_opendir(name);
    if (folder == nullptr) return -1;
    struct dirent** entries = nullptr;
    int count = 0, room = 0;
    while (const struct dirent* entry = hook_readdir(folder)) {
        if (filter != nullptr && filter(entry) == 0) continue;
        if (count == room) {
            room = room == 0 ? 64 : 2 * room;
            auto** more = static_cast<struct dirent**>(realloc(entries, static_cast<size_t>(room) * sizeof *entries));
            if (more == nullptr) break;
            entries = more;
        }
        auto* copy = static_cast<struct dirent*>(malloc(sizeof *entry));
        if (copy == nullptr) break;
        memcpy(copy, entry, entry->d_reclen < sizeof *entry ? entry->d_reclen : sizeof *entry);
        entries[count++] = copy;
    }
    hook_closedir(folder);
    if (order != nullptr && count > 1)
        qsort(entries, static_cast<size_t>(count), sizeof *entries,
              reinterpret_cast<int (*)(const void*, const void*)>(order));
    *list = entries;
    return count;
}

void glob_close(void* folder) {
    hook_closedir(static_cast<DIR*>(folder));
}
struct dirent* glob_read(void* folder) {
    return hook_readdir(static_cast<DIR*>(folder));
}
void* glob_open(const char* name) {
    return hook_opendir(name);
}
int glob_lstat(const char* name, struct stat* info) {
    return fstatat(AT_FDCWD, name, info, AT_SYMLINK_NOFOLLOW);
}
int glob_stat(const char* name, struct stat* info) {
    return fstatat(AT_FDCWD, name, info, 0);
}

/// glob() with our folder functions (GLOB_ALTDIRFUNC) for patterns that can match a device.
template <typename Real>
int glob_with(const Real& next, const char* pattern, int flags, int (*on_error)(const char*, int), glob_t* found) {
    const bool ours = pattern != nullptr && found != nullptr && (flags & GLOB_ALTDIRFUNC) == 0 &&
                      (strncmp(pattern, "/dev/", 5) == 0 || strncmp(pattern, "/sys/", 5) == 0);
    if (!ours) return next(pattern, flags, on_error, found);
    found->gl_closedir = glob_close;
    found->gl_readdir = glob_read;
    found->gl_opendir = glob_open;
    found->gl_lstat = glob_lstat;
    found->gl_stat = glob_stat;
    return next(pattern, flags | GLOB_ALTDIRFUNC, on_error, found);
}

}  // namespace

DIR* hook_opendir(const char* name) {
    if (!may_be_ours(name)) return real::opendir(name);
    Place place;
    find_place(AT_FDCWD, name, place);
    if (place.kind == PlaceKind::file) return real::opendir(place.path);
    DIR* folder = real::opendir(name);
    remember(folder, place);
    return folder;
}

DIR* hook_fdopendir(int fd) {
    DIR* folder = real::fdopendir(fd);
    if (folder == nullptr) return nullptr;
    // Which folder is it? Only asked of libc's view, the name "." relative to it.
    Place place;
    find_place(fd, ".", place);
    remember(folder, place);
    return folder;
}

struct dirent* hook_readdir(DIR* folder) {
    return read_entry(real::readdir, folder);
}
struct dirent* hook_readdir64(DIR* folder) {
    return read_entry(real::readdir64, folder);
}

void hook_rewinddir(DIR* folder) {
    real::rewinddir(folder);
    if (Merged* both = merged_with(folder)) real::rewinddir(both->ours);
}

int hook_closedir(DIR* folder) {
    if (Merged* both = merged_with(folder)) {
        DIR* ours;
        {
            Locked guard(merged_lock);
            ours = both->ours;
            *both = {};
            merged_count.fetch_sub(1, std::memory_order_relaxed);
        }
        real::closedir(ours);
    }
    return real::closedir(folder);
}

int hook_scandir(const char* name, struct dirent*** list, DirentFilter* filter, DirentOrder* order) {
    return scan(real::scandir, name, list, filter, order);
}
int hook_scandir64(const char* name, struct dirent*** list, DirentFilter* filter, DirentOrder* order) {
    return scan(real::scandir64, name, list, filter, order);
}
int hook_glob(const char* pattern, int flags, int (*on_error)(const char*, int), glob_t* found) {
    return glob_with(real::glob, pattern, flags, on_error, found);
}
int hook_glob64(const char* pattern, int flags, int (*on_error)(const char*, int), glob_t* found) {
    return glob_with(real::glob64, pattern, flags, on_error, found);
}
