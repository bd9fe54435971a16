#include "core/sensor/poisson_tables.h"

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "core/base/portable_math.h"

namespace camrig::sensor {
namespace {

constexpr std::int64_t column_share = std::int64_t{1} << PoissonTables::share_bits;

/// Of each number, in shares that add up to all columns exactly.
std::array<std::int64_t, PoissonTables::columns> shares_of(double mean) {
    std::array<std::int64_t, PoissonTables::columns> shares{};
    double probability = portable::exp(-mean), sum = 0.0;
    std::int64_t given = 0;
    for (std::size_t n = 0; n < shares.size(); ++n) {
        sum += probability;
        probability *= mean / static_cast<double>(n + 1);
        // The last has what is left: nothing at these means.
        const std::int64_t till = n + 1 == shares.size()
                                      ? column_share * PoissonTables::columns
                                      : std::llround(sum * static_cast<double>(column_share * PoissonTables::columns));
        shares[n] = till - given;
        given = till;
    }
    return shares;
}

/// Columns that have too little are filled up by one that has too much (M. D. Vose, IEEE TSE 17:9, 1991).
void fill_columns(std::array<std::int64_t, PoissonTables::columns> shares, std::span<std::uint32_t> entries) {
    std::vector<std::size_t> few, many;
    for (std::size_t n = 0; n < shares.size(); ++n) (shares[n] < column_share ? few : many).push_back(n);
    while (!few.empty()) {
        const std::size_t n = few.back(), other = many.back();
        few.pop_back();
        entries[n] = static_cast<std::uint32_t>(shares[n] * PoissonTables::columns) + static_cast<std::uint32_t>(other);
        shares[other] -= column_share - shares[n];
        if (shares[other] >= column_share) continue;
        many.pop_back();
        few.push_back(other);
    }
    for (const std::size_t n : many)
        entries[n] = static_cast<std::uint32_t>(column_share * PoissonTables::columns) + static_cast<std::uint32_t>(n);
}

std::unique_ptr<const PoissonTables> make_tables_of_poisson() {
    auto tables = std::make_unique<PoissonTables>();
    constexpr auto columns = static_cast<std::size_t>(PoissonTables::columns);
    for (std::size_t row = 0; row * columns < tables->entries.size(); ++row)
        fill_columns(shares_of(static_cast<double>(row) / PoissonTables::per_electron),
                     std::span(tables->entries).subspan(row * columns, columns));
    return tables;
}

}  // namespace

const PoissonTables& poisson_tables() {
    static const std::unique_ptr<const PoissonTables> tables = make_tables_of_poisson();
    return *tables;
}

}  // namespace camrig::sensor
