#include "core/base/command_key.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/private_folder.h"

namespace camrig {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

mode_t mode_of(const fs::path& path) {
    struct stat facts{};
    return ::lstat(path.c_str(), &facts) == 0 ? facts.st_mode & 07777 : 0;
}

/// A runtime folder of this test's own.
class CommandKey : public testing::Test {
protected:
    CommandKey() : top_(fs::path(testing::TempDir()) / ("command_key_" + std::to_string(::getpid()))) {
        fs::remove_all(top_);
        fs::create_directories(top_);
        ::setenv("XDG_RUNTIME_DIR", top_.c_str(), 1);
    }
    ~CommandKey() override {
        ::unsetenv("XDG_RUNTIME_DIR");
        fs::remove_all(top_);
    }
    const fs::path top_;
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

TEST_F(CommandKey, OfARigThatIsGoneIsReplaced) {
    ASSERT_TRUE(make_private_folder(user_runtime_folder()));
    std::ofstream(command_key_path("::1", 80)) << "old";
    const auto file = CommandKeyFile::create("new", "::1", 80);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(read_command_key("::1", 80), "new");
}

TEST_F(CommandKey, IsNeitherWrittenToNorReadFromAFolderThatOthersCanEnter) {
    fs::create_directory(top_ / "camrig");
    fs::permissions(top_ / "camrig", fs::perms(0755));
    std::ofstream(command_key_path("::1", 80)) << "planted";
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
