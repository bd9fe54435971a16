#include "core/sensor/expose_row.h"

#include "core/base/cpu_features.h"
#include "core/sensor/row_loops.h"

namespace camrig::sensor {
namespace {

CAMRIG_WIDE_ROWS void expect_wide(const RowExposure& row, const float* light, float* mean_e) {
    RowLoops<EightLanes>::expect_electrons(row, light, mean_e);
}
CAMRIG_WIDE_ROWS void count_wide(const RowExposure& row, const float* mean_e, std::uint16_t* numbers) {
    RowLoops<EightLanes>::count_electrons(row, mean_e, numbers);
}

}  // namespace

void expect_electrons(const RowExposure& row, const float* light, float* mean_e, bool wide) {
    if (wide) return expect_wide(row, light, mean_e);
    RowLoops<FourLanes>::expect_electrons(row, light, mean_e);
}

void count_electrons(const RowExposure& row, const float* mean_e, std::uint16_t* numbers, bool wide) {
    if (wide) return count_wide(row, mean_e, numbers);
    RowLoops<FourLanes>::count_electrons(row, mean_e, numbers);
}

bool has_wide_rows() {
    return has_avx2();
}

}  // namespace camrig::sensor
