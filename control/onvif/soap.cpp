#include "control/onvif/soap.h"

namespace camrig::onvif {
namespace {

constexpr std::string_view soap_12 = "http://www.w3.org/2003/05/soap-envelope";
constexpr std::string_view soap_11 = "http://schemas.xmlsoap.org/soap/envelope/";

std::optional<UsernameToken> token_of(XmlElement envelope) {
    const XmlElement given = envelope.child("Header").child("Security").child("UsernameToken");
    if (!given) return std::nullopt;
    const XmlElement password = given.child("Password");
    return UsernameToken{given.text("Username"), password.text(), given.text("Nonce"), given.text("Created"),
                         password.attribute("Type").value_or("").ends_with("#PasswordDigest")};
}

}  // namespace

Fault not_authorized() {
    return {true, "NotAuthorized", {}, "Sender not Authorized"};
}

Fault not_implemented(std::string_view detail) {
    return {false, "ActionNotSupported", detail, "Optional Action Not Implemented"};
}

Answered<std::unique_ptr<SoapMessage>> read_soap(std::string_view text) {
    auto message = std::make_unique<SoapMessage>();
    const auto malformed = [](std::string why) {
        return std::unexpected(Fault{true, "WellFormed", {}, std::move(why)});
    };
    if (auto parsed = parse_xml(text, message->document); !parsed) return malformed(parsed.error().message);
    const XmlElement envelope = XmlElement(message->document).first_child();
    if (envelope.name() != "Envelope" || (envelope.space() != soap_12 && envelope.space() != soap_11))
        return malformed("the message is no SOAP envelope");
    message->operation = envelope.child("Body").first_child();
    if (!message->operation) return malformed("the body of the message is empty");
    message->token = token_of(envelope);
    return message;
}

std::string envelope(std::string_view body) {
    static constexpr std::string_view begin =
        R"(<?xml version="1.0" encoding="UTF-8"?>)"
        "\n"
        R"(<s:Envelope xmlns:s="http://www.w3.org/2003/05/soap-envelope")"
        R"( xmlns:tt="http://www.onvif.org/ver10/schema" xmlns:tds="http://www.onvif.org/ver10/device/wsdl")"
        R"( xmlns:trt="http://www.onvif.org/ver10/media/wsdl" xmlns:tr2="http://www.onvif.org/ver20/media/wsdl")"
        R"( xmlns:tptz="http://www.onvif.org/ver20/ptz/wsdl")"
        R"( xmlns:timg="http://www.onvif.org/ver20/imaging/wsdl" xmlns:tev="http://www.onvif.org/ver10/events/wsdl")"
        R"( xmlns:wsnt="http://docs.oasis-open.org/wsn/b-2" xmlns:wstop="http://docs.oasis-open.org/wsn/t-1")"
        R"( xmlns:wsrf-rw="http://docs.oasis-open.org/wsrf/rw-2" xmlns:wsa5="http://www.w3.org/2005/08/addressing")"
        R"( xmlns:tns1="http://www.onvif.org/ver10/topics" xmlns:xs="http://www.w3.org/2001/XMLSchema")"
        R"( xmlns:ter="http://www.onvif.org/ver10/error">)"
        "<s:Body>";
    return std::string(begin).append(body).append("</s:Body></s:Envelope>");
}

std::string fault_envelope(const Fault& fault) {
    const bool has_prefix = fault.subcode.contains(':');
    std::string subcode = element("s:Value", (has_prefix ? "" : "ter:") + std::string(fault.subcode));
    if (!fault.detail.empty()) subcode += element("s:Subcode", element("s:Value", "ter:" + std::string(fault.detail)));
    return envelope(
        element("s:Fault", element("s:Code", element("s:Value", fault.is_senders ? "s:Sender" : "s:Receiver") +
                                                 element("s:Subcode", subcode)) +
                               element("s:Reason", element("s:Text", escaped(fault.reason), R"(xml:lang="en")"))));
}

}  // namespace camrig::onvif
