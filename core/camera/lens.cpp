#include "core/camera/lens.h"

#include <iterator>
#include <string>

namespace camrig::camera {
namespace {

constexpr struct {
    LensModel model;
    std::string_view name;
    int coefficients;
} models[] = {{LensModel::pinhole, "pinhole", 0},
              {LensModel::plumb_bob, "plumb_bob", 5},
              {LensModel::rational_polynomial, "rational_polynomial", 8},
              {LensModel::equidistant, "equidistant", 4}};

}  // namespace

std::string_view to_string(LensModel model) {
    CHECK(static_cast<std::size_t>(model) < std::size(models));
    return models[static_cast<std::size_t>(model)].name;
}

int coefficient_count(LensModel model) {
    CHECK(static_cast<std::size_t>(model) < std::size(models));
    return models[static_cast<std::size_t>(model)].coefficients;
}

Result<LensModel> parse_lens_model(std::string_view name) {
    for (const auto& entry : models)
        if (entry.name == name) return entry.model;
    return error(ErrorKind::invalid_argument, "'" + std::string(name.substr(0, 40)) +
                                                  "' is no lens model; there are pinhole, plumb_bob, "
                                                  "rational_polynomial and equidistant");
}

}  // namespace camrig::camera
