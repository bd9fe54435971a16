#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace camrig {

/// How many bytes may be in use at once for one purpose: whoever needs some claims them before the memory is taken.
///
/// A budget may be a share of a larger one; a claim then counts in both. Claims keep their budget alive. Any thread.
class ByteBudget : public std::enable_shared_from_this<ByteBudget> {
public:
    /// Bytes in use, until it is destroyed.
    class Claim {
    public:
        Claim() = default;
        Claim(Claim&& other) noexcept : budget_(std::move(other.budget_)), bytes_(std::exchange(other.bytes_, 0)) {}
        Claim& operator=(Claim&& other) noexcept {
            shrink_to(0);
            budget_ = std::move(other.budget_);
            bytes_ = std::exchange(other.bytes_, 0);
            return *this;
        }
        ~Claim() { shrink_to(0); }

        /// Gives back all but so many bytes; a larger number changes nothing.
        void shrink_to(std::size_t bytes) {
            if (bytes >= bytes_) return;
            budget_->give_back(bytes_ - bytes);
            bytes_ = bytes;
        }

    private:
        friend class ByteBudget;
        Claim(std::shared_ptr<ByteBudget> budget, std::size_t bytes) : budget_(std::move(budget)), bytes_(bytes) {}
        std::shared_ptr<ByteBudget> budget_;
        std::size_t bytes_ = 0;
    };

    /// `advice`: the message of the error when a claim is refused: what is used up, and what to do. `whole`: the budget
    /// that this one is a share of, or null.
    static std::shared_ptr<ByteBudget> create(std::size_t limit, std::string advice,
                                              std::shared_ptr<ByteBudget> whole = {}) {
        return std::shared_ptr<ByteBudget>(new ByteBudget(limit, std::move(advice), std::move(whole)));
    }
    /// resource_exhausted, and nothing is taken, when here or in the whole there are not that many left.
    Result<Claim> claim(std::size_t bytes) {
        if (auto taken = take(bytes); !taken) return std::unexpected(taken.error());
        return Claim(shared_from_this(), bytes);
    }
    std::size_t used() const { return used_.load(); }

private:
    ByteBudget(std::size_t limit, std::string advice, std::shared_ptr<ByteBudget> whole)
        : limit_(limit), advice_(std::move(advice)), whole_(std::move(whole)) {}

    Result<void> take(std::size_t bytes) {
        std::size_t used = used_.load();
        do {
            if (bytes > limit_ || used > limit_ - bytes) return error(ErrorKind::resource_exhausted, advice_);
        } while (!used_.compare_exchange_weak(used, used + bytes));
        if (!whole_) return {};
        auto taken = whole_->take(bytes);
        if (!taken) used_.fetch_sub(bytes);
        return taken;
    }
    void give_back(std::size_t bytes) {
        used_.fetch_sub(bytes);
        if (whole_) whole_->give_back(bytes);
    }

    const std::size_t limit_;
    const std::string advice_;
    const std::shared_ptr<ByteBudget> whole_;
    std::atomic<std::size_t> used_{0};
};

}  // namespace camrig
