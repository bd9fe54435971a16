#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "core/camera/lens.h"

namespace camrig::camera {

// Values of calibration files, from the text scalars of parse_yaml(). `key` names the place in messages.

[[nodiscard]] std::unexpected<Error> bad_value(const std::string& key, const std::string& what);
/// A finite number, the whole scalar.
Result<double> number_value(const nlohmann::json& value, const std::string& key);
Result<int> whole_number_value(const nlohmann::json& value, const std::string& key, int low, int high);
/// A list of `low` to `high` finite numbers.
Result<std::vector<double>> number_list(const nlohmann::json& value, const std::string& key, std::size_t low,
                                        std::size_t high);
/// OpenCV's list of distortion coefficients, whose length (0, 4, 5, 8, 12, 14) says the model.
Result<Lens> lens_from_opencv(std::vector<double> coefficients, const std::string& key);

}  // namespace camrig::camera
