#include "core/base/image_controls.h"

#include "core/base/field_of.h"

namespace camrig {
namespace {

/// A value instead of an automatic: who gives it wants to see it.
FieldOf<ImageControls> instead_of(bool ImageControls::* automatic, std::string automatic_name,
                                  FieldOf<ImageControls> entry) {
    entry.read = [=, name = entry.field.name, read = entry.read](JsonReader& reader, Changes<ImageControls>& changes) {
        if (reader.has(name) && !reader.has(automatic_name))
            changes.change([automatic](ImageControls& controls) { controls.*automatic = false; });
        read(reader, changes);
    };
    return entry;
}

}  // namespace

FieldTable<ImageControls> fields_of(std::type_identity<ImageControls>) {
    using C = ImageControls;
    static const std::vector<FieldOf<C>> table{
        field_at<&C::auto_exposure>(
            {.name = "auto_exposure", .doc = "the scene's exposure; off when exposure_ev is given"}),
        instead_of(&C::auto_exposure, "auto_exposure",
                   field_at<&C::exposure_ev>({.name = "exposure_ev",
                                              .doc = "light is multiplied by 2^ev",
                                              .unit = "EV",
                                              .range = {-6, 6},
                                              .label = "exposure"})),
        field_at<&C::gain_db>({.name = "gain_db",
                               .doc = "light is multiplied by 10^(dB/20)",
                               .unit = "dB",
                               .range = {0, 24},
                               .label = "gain"}),
        field_at<&C::auto_white_balance>(
            {.name = "auto_white_balance", .doc = "neutral; off when white_balance_k is given"}),
        instead_of(
            &C::auto_white_balance, "auto_white_balance",
            field_at<&C::white_balance_k>({.name = "white_balance_k",
                                           .doc = "the light that is taken for white; lower makes bluer pictures",
                                           .unit = "K",
                                           .range = {2800, 10000},
                                           .label = "white balance"})),
        field_at<&C::brightness>(
            {.name = "brightness", .doc = "added to the sRGB codes (1: from black to white)", .range = {-1, 1}}),
        field_at<&C::contrast>({.name = "contrast", .doc = "about the middle code", .range = {0, 2}}),
        field_at<&C::saturation>({.name = "saturation", .doc = "0 is grey", .range = {0, 2}}),
    };
    return table;
}

}  // namespace camrig
