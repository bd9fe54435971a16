#include "core/world/camera_sampling.h"

#include "core/base/field_of.h"

namespace camrig::world {

std::span<const Named<Antialias>> names_of(std::type_identity<Antialias>) {
    static constexpr Named<Antialias> names[] = {{Antialias::none, "none"},     {Antialias::coverage, "coverage"},
                                                 {Antialias::msaa4, "msaa4"},   {Antialias::ssaa2, "ssaa2"},
                                                 {Antialias::ssaa3, "ssaa3"},   {Antialias::ssaa4, "ssaa4"},
                                                 {Antialias::automatic, "auto"}};
    return names;
}

int supersampling_of(Antialias antialias) {
    CHECK(antialias != Antialias::automatic);
    switch (antialias) {
        case Antialias::automatic:
        case Antialias::none:
        case Antialias::coverage:
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
    return antialias == Antialias::msaa4 || antialias == Antialias::coverage ? 4 : 1;
}

std::span<const Named<LensMethod>> names_of(std::type_identity<LensMethod>) {
    static constexpr Named<LensMethod> names[] = {
        {LensMethod::automatic, "auto"}, {LensMethod::warp, "warp"}, {LensMethod::cube, "cube"}};
    return names;
}

std::span<const Named<LensFilter>> names_of(std::type_identity<LensFilter>) {
    static constexpr Named<LensFilter> names[] = {
        {LensFilter::automatic, "auto"}, {LensFilter::bilinear, "bilinear"}, {LensFilter::bicubic, "bicubic"}};
    return names;
}

FieldTable<LensSampling> fields_of(std::type_identity<LensSampling>) {
    static const std::vector<FieldOf<LensSampling>> table{
        field_at<&LensSampling::method>(
            {.name = "method",
             .doc = "what the picture is resampled from; warp: one larger pinhole picture, cube: the faces of a cube, "
                    "auto: what needs fewer pixels"}),
        field_at<&LensSampling::filter>(
            {.name = "filter",
             .doc = "bicubic (Catmull-Rom) keeps more contrast; auto: bicubic at quality beautiful; ssaa always takes "
                    "bilinear samples"}),
    };
    return table;
}

}  // namespace camrig::world
