#include <chrono>
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

std::future<onvif::OnvifReply> ask(onvif::OnvifService& service, const std::string& text) {
    auto answer = std::make_shared<std::promise<onvif::OnvifReply>>();
    service.handle({.device = {}, .host = "localhost:80", .path = "/onvif/sub/1", .body = text},
                   [answer](onvif::OnvifReply reply) { answer->set_value(std::move(reply)); });
    return answer->get_future();
}

std::string envelope(const std::string& body) {
    return "<e:Envelope xmlns:e=\"http://www.w3.org/2003/05/soap-envelope\"><e:Body>" + body + "</e:Body></e:Envelope>";
}

void run(const std::string& text) {
    static StandingRig rig;
    // Who shows a token is read too; the answers of those who must are refusals.
    static onvif::OnvifService guarded(rig, rig, {.token = "a-good-token"});
    onvif::OnvifService open(rig, rig, {});
    // The first subscription, for what is done about one.
    ask(open, envelope("<v:CreatePullPointSubscription xmlns:v=\"http://www.onvif.org/ver10/events/wsdl\"/>")).get();
    for (onvif::OnvifService* service : {&open, &guarded}) {
        auto answer = ask(*service, text);
        // A pull that waits is answered by the next one.
        if (answer.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
            ask(*service, envelope("<v:PullMessages xmlns:v=\"http://www.onvif.org/ver10/events/wsdl\">"
                                   "<v:Timeout>PT0S</v:Timeout></v:PullMessages>"));
        const onvif::OnvifReply reply = answer.get();
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
