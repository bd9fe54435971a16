#include "core/base/command_key.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/private_folder.h"
#include "tests/temporary_folder.h"

namespace camrig {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

mode_t mode_of(const fs::path& path) {
    struct stat facts{};
    return ::lstat(path.c_str(), &facts) == 0 ? facts.st_mode & 07777 : 0;
}

/// Locks what stands there as a rig that lives does.
UniqueFd hold(const fs::path& key) {
    UniqueFd lock(::open(key.c_str(), O_RDONLY | O_CLOEXEC));
    EXPECT_EQ(::flock(lock.get(), LOCK_EX), 0) << key;
    return lock;
}

/// A runtime folder of this test's own.
class CommandKey : public testing::Test {
protected:
    CommandKey() { ::setenv("XDG_RUNTIME_DIR", top_.path().c_str(), 1); }
    ~CommandKey() override { ::unsetenv("XDG_RUNTIME_DIR"); }
    const TemporaryFolder top_;
};

TEST_F(CommandKey, IsReadByItsOwnerAtItsAddressOnlyWhileTheRigListens) {
    EXPECT_EQ(read_command_key("127.0.0.1", 80), std::nullopt);
    {
        const auto file = CommandKeyFile::create("abcdef", "127.0.0.1", 80);
        ASSERT_TRUE(file) << file.error().message;
        EXPECT_EQ(file->path(), top_ / "camrig/127.0.0.1:80.key");
        EXPECT_EQ(mode_of(file->path()), 0600u);
        EXPECT_EQ(mode_of(top_ / "camrig"), 0700u);
        EXPECT_EQ(read_command_key("127.0.0.1", 80), "abcdef");
        // Another user may listen on the same port of another address.
        EXPECT_EQ(read_command_key("::1", 80), std::nullopt);
        EXPECT_EQ(read_command_key("127.0.0.2", 80), std::nullopt);
    }
    EXPECT_TRUE(fs::is_empty(top_ / "camrig"));
}

TEST_F(CommandKey, OfARigThatWasKilledIsNotBelievedAndGoesWithTheNext) {
    const pid_t rig = ::fork();
    ASSERT_GE(rig, 0);
    if (rig == 0) {
        const auto one = CommandKeyFile::create("old", "::1", 80), other = CommandKeyFile::create("older", "::1", 81);
        ::_exit(one && other && read_command_key("::1", 80) == "old" && read_command_key("::1", 81) ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(rig, &status, 0), rig);
    ASSERT_EQ(status, 0);
    ASSERT_TRUE(fs::exists(command_key_path("::1", 80)));
    EXPECT_EQ(read_command_key("::1", 80), std::nullopt);
    const auto of_another = CommandKeyFile::create("another's", "127.0.0.1", 80);
    EXPECT_FALSE(fs::exists(command_key_path("::1", 80)) || fs::exists(command_key_path("::1", 81)));
    const auto file = CommandKeyFile::create("new", "::1", 80);
    ASSERT_TRUE(of_another && file) << file.error().message;
    EXPECT_EQ(read_command_key("::1", 80), "new");
    EXPECT_EQ(read_command_key("127.0.0.1", 80), "another's");
}

TEST_F(CommandKey, IsNeitherWrittenToNorReadFromAFolderThatOthersCanEnter) {
    fs::create_directory(top_ / "camrig");
    fs::permissions(top_ / "camrig", fs::perms(0755));
    std::ofstream(command_key_path("::1", 80)) << "planted";
    const UniqueFd planter = hold(command_key_path("::1", 80));
    EXPECT_EQ(read_command_key("::1", 80), std::nullopt);
    EXPECT_THAT(CommandKeyFile::create("key", "::1", 80).error().message, HasSubstr("chmod 700"));
    fs::rename(top_ / "camrig", top_ / "elsewhere");
    fs::permissions(top_ / "elsewhere", fs::perms(0700));
    fs::create_directory_symlink(top_ / "elsewhere", top_ / "camrig");
    EXPECT_EQ(read_command_key("::1", 80), std::nullopt);
    EXPECT_THAT(CommandKeyFile::create("key", "::1", 80).error().message, HasSubstr("is no folder"));
}

TEST_F(CommandKey, IsNotReadThroughALink) {
    ASSERT_TRUE(make_private_folder(user_runtime_folder()));
    std::ofstream(top_ / "other") << "other";
    const UniqueFd planter = hold(top_ / "other");
    fs::create_symlink(top_ / "other", command_key_path("::1", 80));
    EXPECT_EQ(read_command_key("::1", 80), std::nullopt);
}

TEST(NewCommandKey, IsAnotherOneEachTime) {
    const auto one = new_command_key(), other = new_command_key();
    ASSERT_TRUE(one && other);
    EXPECT_EQ(one->size(), 48u);
    EXPECT_EQ(one->find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_NE(*one, *other);
}

}  // namespace
}  // namespace camrig
