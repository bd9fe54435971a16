#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "control/onvif/device_identity.h"
#include "control/onvif/discovery.h"
#include "control/onvif/xml.h"

// Datagrams of WS-Discovery, which anybody on the network may send. What must hold: no crash, what is read of a
// question is bounded by its datagram, and what is said to who asks is well-formed XML that names the question.
namespace camrig::onvif {
namespace {

void require(bool condition) {
    if (!condition) std::abort();
}

void run(std::string_view text) {
    static const DiscoveredDevice devices[] = {
        {endpoint_address("dome"), scopes_of("dome", true), "http://10.0.0.9:81/onvif/device_service"},
        {endpoint_address(""), scopes_of("", false), "http://10.0.0.9:80/onvif/device_service"}};
    const auto question = read_question(text);
    if (!question) return;
    require(text.size() <= max_discovery_bytes && !question->id.empty());
    for (const auto* words : {&question->types, &question->scopes}) {
        std::size_t bytes = 0;
        for (const std::string& word : *words) bytes += word.size();
        require(bytes <= text.size());
    }
    for (const DiscoveredDevice& device : devices) {
        const bool is_found = is_asked_for(device, *question);
        require(!question->is_resolve || is_found == (question->address == device.address));
        pugi::xml_document document;
        require(parse_xml(match_message({"urn:uuid:1", 2, 3}, *question, device), document).has_value());
        require(XmlElement(document).first_child().child("Header").text("RelatesTo").size() > 0);
    }
}

}  // namespace
}  // namespace camrig::onvif

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    camrig::onvif::run({reinterpret_cast<const char*>(data), size});
    return 0;
}
