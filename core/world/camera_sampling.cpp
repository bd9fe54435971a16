#include "core/world/camera_sampling.h"

#include <span>
#include <string>

namespace camrig {
namespace {

template <typename T>
struct Named {
    T value;
    std::string_view name;
};

constexpr Named<Antialias> antialias_names[] = {{Antialias::none, "none"},   {Antialias::msaa4, "msaa4"},
                                                {Antialias::ssaa2, "ssaa2"}, {Antialias::ssaa3, "ssaa3"},
                                                {Antialias::ssaa4, "ssaa4"}, {Antialias::automatic, "auto"}};
constexpr Named<LensMethod> method_names[] = {
    {LensMethod::automatic, "auto"}, {LensMethod::warp, "warp"}, {LensMethod::cube, "cube"}};
constexpr Named<LensFilter> filter_names[] = {
    {LensFilter::automatic, "auto"}, {LensFilter::bilinear, "bilinear"}, {LensFilter::bicubic, "bicubic"}};

template <typename T, std::size_t count>
std::string_view name_of(const Named<T> (&names)[count], T value) {
    CHECK(static_cast<std::size_t>(value) < count);
    return names[static_cast<std::size_t>(value)].name;
}

template <typename T, std::size_t count>
Result<T> value_of(const Named<T> (&names)[count], std::string_view name) {
    std::string known;
    for (const auto& entry : names) {
        if (entry.name == name) return entry.value;
        known += (known.empty() ? "" : ", ") + std::string(entry.name);
    }
    return error(ErrorKind::invalid_argument, "'" + std::string(name.substr(0, 40)) + "' is none of " + known);
}

}  // namespace

std::string_view to_string(Antialias antialias) {
    return name_of(antialias_names, antialias);
}
Result<Antialias> parse_antialias(std::string_view name) {
    return value_of(antialias_names, name);
}
int supersampling_of(Antialias antialias) {
    CHECK(antialias != Antialias::automatic);
    switch (antialias) {
        case Antialias::automatic:
        case Antialias::none:
        case Antialias::msaa4:
            return 1;
        case Antialias::ssaa2:
            return 2;
        case Antialias::ssaa3:
            return 3;
        case Antialias::ssaa4:
            return 4;
    }
    return 1;
}
int multisampling_of(Antialias antialias) {
    return antialias == Antialias::msaa4 ? 4 : 1;
}

std::string_view to_string(LensMethod method) {
    return name_of(method_names, method);
}
Result<LensMethod> parse_lens_method(std::string_view name) {
    return value_of(method_names, name);
}

std::string_view to_string(LensFilter filter) {
    return name_of(filter_names, filter);
}
Result<LensFilter> parse_lens_filter(std::string_view name) {
    return value_of(filter_names, name);
}

}  // namespace camrig
