#pragma once

#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "control/onvif/xml.h"

namespace camrig::onvif {

/// Why an operation is refused, in the terms of ONVIF Core (5.11, "Error handling"): the HTTP status follows.
struct Fault {
    bool is_senders = true;    ///< or the receiver's, ours
    std::string_view subcode;  ///< "InvalidArgVal"; of another namespace than ONVIF's, with its prefix
    std::string_view detail;   ///< "NoProfile"; empty: none
    std::string reason;
    int status() const { return is_senders ? 400 : 500; }
};
template <typename T>
using Answered = std::expected<T, Fault>;
/// Markup of an answer.
using Answer = Answered<std::string>;

inline std::unexpected<Fault> invalid_argument(std::string_view detail, std::string reason) {
    return std::unexpected(Fault{true, "InvalidArgVal", detail, std::move(reason)});
}
/// The texts of these two are what clients look for.
Fault not_authorized();
Fault not_implemented(std::string_view detail = {});

/// What a WS-UsernameToken says (OASIS WSS 1.1).
struct UsernameToken {
    std::string_view name, password, nonce, created;
    bool is_digest = false;
};

/// A message: what it asks, and who asks.
struct SoapMessage {
    pugi::xml_document document;
    XmlElement operation;  ///< the first element of the body
    std::optional<UsernameToken> token;
};
/// SOAP 1.2, and 1.1 for old clients. Pure.
Answered<std::unique_ptr<SoapMessage>> read_soap(std::string_view text);

/// The whole answer, always SOAP 1.2, with the prefixes that documents and scripts use.
std::string envelope(std::string_view body);
std::string fault_envelope(const Fault& fault);

}  // namespace camrig::onvif
