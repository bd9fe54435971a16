#include <cstdint>
#include <cstdlib>
#include <future>
#include <string>

#include "control/onvif/onvif_service.h"

// Messages to ONVIF devices: their XML, who sends them, and every operation's reading of them, on a camera with a head
// that is told nothing. What must hold: no crash, exactly one answer, and an answer that is well-formed XML.
namespace camrig {
namespace {

void require(bool condition) {
    if (!condition) std::abort();
}

/// Answers with a camera, and with where its head is.
class StandingRig final : public engine::CommandPort, public stream::FrameFetcher {
public:
    void post(engine::Command command) override {
        std::visit([this](auto& request) { answer(request); }, command);
    }
    void fetch(stream::FetchRequest, std::function<void(Result<stream::MediaUnit>)> done) override {
        done(error(ErrorKind::unavailable, "no"));
    }

private:
    static engine::CameraReply camera() {
        world::CameraSpec spec;
        spec.name = "dome";
        spec.ptz = camera::ptz_preset(camera::PtzPreset::dome);
        engine::CameraReply reply;
        reply.camera = world::Camera(std::move(spec));
        return reply;
    }
    void answer(engine::Request<engine::GetCamera>& request) { request.done(camera()); }
    void answer(engine::Request<engine::ListCameras>& request) { request.done(std::vector{camera()}); }
    template <typename C>
    void answer(engine::Request<C>& request) {
        if constexpr (std::is_same_v<typename C::Reply, engine::PtzReply>) {
            engine::PtzReply reply;
            reply.presets["door"] = {};
            request.done(std::move(reply));
        } else {
            request.done(error(ErrorKind::unavailable, "no"));
        }
    }
};

void run(std::string text) {
    static StandingRig rig;
    // Who shows a token is read too; the answers of those who must are refusals.
    static onvif::OnvifService open(rig, {}), guarded(rig, {.token = "a-good-token"});
    for (onvif::OnvifService* service : {&open, &guarded}) {
        std::promise<onvif::OnvifReply> answer;
        service->handle({"", "localhost:80", false, text},
                        [&answer](onvif::OnvifReply reply) { answer.set_value(std::move(reply)); });
        const onvif::OnvifReply reply = answer.get_future().get();
        pugi::xml_document document;
        require(document.load_buffer(reply.text.data(), reply.text.size()));
    }
}

}  // namespace
}  // namespace camrig

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    camrig::run({reinterpret_cast<const char*>(data), size});
    return 0;
}
