#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace camrig::view {

/// A value as a person reads and types it: null is empty, a list has spaces between.
std::string text_of(const nlohmann::json& value);
/// The value of that parameter that was typed so; what cannot be is given as text.
nlohmann::json typed_value(const nlohmann::json& field, const std::string& text);
/// What a control of that parameter begins with where there is no value yet: its default, else its first choice or
/// lowest number.
nlohmann::json empty_value(const nlohmann::json& field);

}  // namespace camrig::view
