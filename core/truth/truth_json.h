#pragma once

#include <nlohmann/json.hpp>

#include "core/truth/truth.h"

namespace camrig::truth {

/// The truth as truth.get, HTTP and recordings give it; docs/truth.md explains each member.
nlohmann::json truth_to_json(const TruthOfFrame& truth);

}  // namespace camrig::truth
