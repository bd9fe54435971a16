#include "core/base/descriptors.h"

#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "core/base/unique_fd.h"

namespace camrig {
namespace {

/// Few descriptors are allowed while it lives, and nearly all of them are taken.
class FewDescriptors {
public:
    explicit FewDescriptors(rlim_t allowed) {
        ::getrlimit(RLIMIT_NOFILE, &before_);
        const rlimit few{.rlim_cur = allowed, .rlim_max = before_.rlim_max};
        ::setrlimit(RLIMIT_NOFILE, &few);
        for (UniqueFd one = open_one(); one; one = open_one()) taken_.push_back(std::move(one));
    }
    ~FewDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }
    FewDescriptors(const FewDescriptors&) = delete;
    FewDescriptors& operator=(const FewDescriptors&) = delete;
    /// Gives back the lowest, which the kernel hands out next.
    void give_back(std::ptrdiff_t count) { taken_.erase(taken_.begin(), taken_.begin() + count); }

private:
    static UniqueFd open_one() { return UniqueFd(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }
    rlimit before_{};
    std::vector<UniqueFd> taken_;
};

TEST(Descriptors, AreShortWhenFewerThanTheReserveAreFreeWhereverTheyLie) {
    EXPECT_FALSE(descriptors_are_short());
    for (const rlim_t allowed : {200, 600}) {
        FewDescriptors process(allowed);
        EXPECT_TRUE(descriptors_are_short(1));
        process.give_back(7);
        EXPECT_TRUE(descriptors_are_short(8));
        EXPECT_FALSE(descriptors_are_short(7));
        process.give_back(reserved_descriptors - 7);
        EXPECT_FALSE(descriptors_are_short());
    }
}

}  // namespace
}  // namespace camrig
