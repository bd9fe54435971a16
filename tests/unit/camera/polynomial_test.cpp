#include "core/camera/polynomial.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig::camera::polynomial_test {
namespace {

/// The product of (1 - x / root) over the roots: 1 at zero, like every polynomial of the lens mathematics.
Polynomial with_roots(std::initializer_list<double> roots) {
    Polynomial p{1.0};
    for (const double root : roots) p = product(p, Polynomial{1.0, -1.0 / root});
    return p;
}

void expect_root(const Polynomial& p, double limit, double expected, double tolerance = 1e-12) {
    const auto root = smallest_positive_root(p, limit);
    ASSERT_TRUE(root);
    EXPECT_NEAR(*root / expected, 1.0, tolerance);
}

TEST(SmallestPositiveRoot, KnownAnswers) {
    expect_root({1.0, -2.0}, 1e6, 0.5);
    expect_root({1.0, 0.0, -1.0}, 1e6, 1.0);
    expect_root(with_roots({3, 2, 7, -1}), 1e6, 2.0);
    expect_root(with_roots({1e-6, 1, 1e6}), 1e12, 1e-6);
    expect_root(with_roots({-1e-3, 999999.0}), 1e6, 999999.0);
    EXPECT_FALSE(smallest_positive_root(Polynomial{1.0, 0.0, 1.0}, 1e6));
    EXPECT_FALSE(smallest_positive_root(Polynomial{1.0, 3.0, 2.0, 5.0}, 1e6));
    EXPECT_FALSE(smallest_positive_root(with_roots({2, 3}), 1.9));
    EXPECT_FALSE(smallest_positive_root(Polynomial{1.0}, 1e6));
    EXPECT_FALSE(smallest_positive_root(Polynomial{1.0, 0.0, 0.0}, 1e6));
    EXPECT_FALSE(smallest_positive_root(Polynomial{}, 1e6));
}

TEST(SmallestPositiveRoot, ATouchWithoutACrossingIsARoot) {
    expect_root(with_roots({0.5, 0.5}), 1e6, 0.5, 1e-6);
    expect_root(with_roots({0.3, 0.3, 5, 5, 0.3}), 1e6, 0.3, 1e-4);
    // Just above the touch there is none, and a grid of a million points could not tell.
    Polynomial above = with_roots({0.5, 0.5});
    above[0] += 1e-12;
    EXPECT_FALSE(smallest_positive_root(above, 1e6));
    Polynomial below = with_roots({0.5, 0.5});
    below[0] -= 1e-12;
    expect_root(below, 1e6, 0.5 - 0.5e-6, 1e-8);
}

TEST(SmallestPositiveRoot, TwoRootsCloserThanAnyGridAreFound) {
    expect_root(with_roots({0.7, 0.7 + 1e-7, -3, 40}), 1e6, 0.7, 1e-6);
    expect_root(with_roots({12345.0, 12345.001}), 1e6, 12345.0, 1e-7);
}

TEST(SmallestPositiveRoot, RandomPolynomialsOfEveryDegreeAgreeWithTheirRoots) {
    for (std::uint64_t n = 0; n < 5000; ++n) {
        const int degree = 1 + static_cast<int>(random_bits(3, 0, n) % 12);
        Polynomial p{1.0};
        double smallest = 1e300;
        for (int i = 0; i < degree; ++i) {
            // Kept a factor of 1.3 apart, so that the roots themselves are well conditioned.
            double root = std::pow(1.3, 1 + 2 * i) * std::exp(0.2 * random_unit(3, 1, n * 16 + i) - 2.0);
            if (random_unit(3, 2, n * 16 + i) < 0.5) root = -root;
            if (root > 0.0) smallest = std::min(smallest, root);
            p = product(p, Polynomial{1.0, -1.0 / root});
        }
        const auto root = smallest_positive_root(p, 1e6);
        ASSERT_EQ(root.has_value(), smallest < 1e6) << n;
        if (root) {
            ASSERT_NEAR(*root / smallest, 1.0, 1e-6) << n;
        }
    }
}

TEST(PolynomialArithmetic, KnownAnswers) {
    EXPECT_EQ(product(Polynomial{1, 2}, Polynomial{3, 0, 1}), (Polynomial{3, 6, 1, 2}));
    EXPECT_EQ(sum(Polynomial{1, 2}, Polynomial{3, 0, 1}, -2), (Polynomial{-5, 2, -2}));
    EXPECT_EQ(derivative(Polynomial{5, 1, 2, 3}), (Polynomial{1, 4, 9}));
    EXPECT_EQ(of_square(Polynomial{1, 2, 3}), (Polynomial{1, 0, 2, 0, 3}));
}

}  // namespace
}  // namespace camrig::camera::polynomial_test
