#include <algorithm>
#include <array>

#include "control/onvif/media.h"
#include "control/onvif/operation.h"

// ONVIF Imaging (ver20): what the camera's image controls (camera field `controls`) do to its picture. Of them those
// that every client knows; clients are told of no others, and what they send beside them is of no account, as many send
// all that the schema has.
namespace camrig::onvif {
namespace {

/// A setting from 0 to 100, as cameras have them; 50 changes nothing.
struct Setting {
    std::string_view name;
    double ImageControls::* member;
    double low, high;  ///< of the member
};
constexpr double scale = 100.0;
/// In the order of the schema.
constexpr std::array settings{Setting{"Brightness", &ImageControls::brightness, -1.0, 1.0},
                              Setting{"ColorSaturation", &ImageControls::saturation, 0.0, 2.0},
                              Setting{"Contrast", &ImageControls::contrast, 0.0, 2.0}};

Answer of_source(const Asked& asked, std::string_view operation, std::string (*make)(const world::CameraSpec&)) {
    const auto camera = camera_of(asked, "VideoSourceToken", "NoSource");
    if (!camera) return std::unexpected(camera.error());
    return response(operation, make(**camera));
}

std::string settings_of(const world::CameraSpec& camera) {
    std::string all;
    for (const Setting& one : settings)
        all += element("tt:" + std::string(one.name),
                       number(scale * (camera.controls.*one.member - one.low) / (one.high - one.low)));
    return element("timg:ImagingSettings", all);
}

std::string options_of_settings(const world::CameraSpec&) {
    std::string all;
    for (const Setting& one : settings)
        all +=
            element("tt:" + std::string(one.name), element("tt:Min", number(0.0)) + element("tt:Max", number(scale)));
    return element("timg:ImagingOptions", all);
}

Answered<engine::SetCamera> set_settings(const Asked& asked) {
    const auto camera = camera_of(asked, "VideoSourceToken", "NoSource");
    if (!camera) return std::unexpected(camera.error());
    engine::SetCamera command{.name = (*camera)->name, .patch = {}};
    for (const Setting& one : settings) {
        const std::string_view text = asked.request.child("ImagingSettings").text(one.name);
        const auto given = number_in(text);
        if (!given || (*given && !(**given >= 0.0 && **given <= scale)))
            return invalid_argument("SettingsInvalid", std::string(one.name) + " is a number from 0 to 100");
        if (*given)
            command.patch.change([one, value = one.low + **given / scale * (one.high - one.low)](
                                     world::CameraSpec& spec) { spec.controls.*one.member = value; });
    }
    return command;
}

const Operation operations[] = {
    {"GetServiceCapabilities",
     [](const Asked&) -> Answer {
         return response("timg:GetServiceCapabilities", R"(<timg:Capabilities ImageStabilization="false"/>)");
     },
     Access::pre_auth},
    {"GetImagingSettings", [](const Asked& asked) { return of_source(asked, "timg:GetImagingSettings", settings_of); }},
    {"GetOptions", [](const Asked& asked) { return of_source(asked, "timg:GetOptions", options_of_settings); }},
    {.name = "SetImagingSettings",
     .answer = [](const Asked&) -> Answer { return response("timg:SetImagingSettings", ""); },
     .access = Access::actuate,
     .change = set_settings},
    // There is no focus that moves.
    {"GetMoveOptions",
     [](const Asked& asked) {
         return of_source(asked, "timg:GetMoveOptions",
                          [](const world::CameraSpec&) { return element("timg:MoveOptions", ""); });
     }},
    {"GetStatus",
     [](const Asked& asked) {
         return of_source(asked, "timg:GetStatus", [](const world::CameraSpec&) { return element("timg:Status", ""); });
     }},
};

}  // namespace

Service imaging_service() {
    return {"http://www.onvif.org/ver20/imaging/wsdl", operations};
}

}  // namespace camrig::onvif
