#include "control/onvif/operation.h"

// ONVIF Imaging: a source's settings, of which these cameras offer none. Clients ask for them nevertheless.
namespace camrig::onvif {
namespace {

Answer nothing_of_source(const Asked& asked, std::string_view operation, std::string_view content) {
    if (const auto camera = camera_of(asked, "VideoSourceToken", "NoSource"); !camera)
        return std::unexpected(camera.error());
    return response(operation, content);
}

const Operation operations[] = {
    {"GetServiceCapabilities",
     [](const Asked&) -> Answer {
         return response("timg:GetServiceCapabilities", R"(<timg:Capabilities ImageStabilization="false"/>)");
     },
     Access::pre_auth},
    {"GetImagingSettings",
     [](const Asked& asked) { return nothing_of_source(asked, "timg:GetImagingSettings", "<timg:ImagingSettings/>"); }},
    {"GetOptions",
     [](const Asked& asked) { return nothing_of_source(asked, "timg:GetOptions", "<timg:ImagingOptions/>"); }},
    {"GetMoveOptions",
     [](const Asked& asked) { return nothing_of_source(asked, "timg:GetMoveOptions", "<timg:MoveOptions/>"); }},
    {"GetStatus", [](const Asked& asked) { return nothing_of_source(asked, "timg:GetStatus", "<timg:Status/>"); }},
};

}  // namespace

Service imaging_service() {
    return {"http://www.onvif.org/ver20/imaging/wsdl", operations};
}

}  // namespace camrig::onvif
