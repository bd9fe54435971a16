#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace camrig {

/// One output that a camera is to have: the name of its family (core/base/output_family.h), and those of the family's
/// options that were given. Valid by construction: made by read_output() only.
struct OutputSpec {
    std::string kind;
    nlohmann::json options = nlohmann::json::object();  ///< without `kind`
    friend bool operator==(const OutputSpec&, const OutputSpec&) = default;
};

}  // namespace camrig
