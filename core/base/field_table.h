#pragma once

#include <type_traits>
#include <vector>

namespace camrig {

/// A struct T has a table of its fields when there is
///     FieldTable<T> fields_of(std::type_identity<T>);
/// beside it; field_of.h says what is in it.
template <typename T>
class Changes;
template <typename T, typename Patch = Changes<T>>
struct FieldOf;
template <typename T>
using FieldTable = const std::vector<FieldOf<T>>&;

}  // namespace camrig
