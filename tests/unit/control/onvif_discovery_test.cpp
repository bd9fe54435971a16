#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "control/onvif/device_identity.h"
#include "control/onvif/discovery.h"
#include "control/onvif/discovery_server.h"
#include "tests/unit/control/fake_rig.h"

namespace camrig::onvif {
namespace {

using testing::HasSubstr;
using testing::Not;

const DiscoveredDevice dome{endpoint_address("dome"), scopes_of("dome", true),
                            "http://10.0.0.9:81/onvif/device_service"};
const std::string scope_begin = "onvif://www.onvif.org/";

std::string asked(const std::string& body, const std::string& header = "<a:MessageID>urn:uuid:1</a:MessageID>") {
    return "<e:Envelope xmlns:e=\"http://www.w3.org/2003/05/soap-envelope\" "
           "xmlns:a=\"http://schemas.xmlsoap.org/ws/2004/08/addressing\" "
           "xmlns:d=\"http://schemas.xmlsoap.org/ws/2005/04/discovery\"><e:Header>" +
           header + "</e:Header><e:Body>" + body + "</e:Body></e:Envelope>";
}

bool finds(const std::string& inside) {
    const auto question = read_question(asked("<d:Probe>" + inside + "</d:Probe>"));
    return question && is_asked_for(dome, *question);
}

TEST(OnvifDiscovery, AProbeFindsWhatHasAllItsTypesAndScopes) {
    EXPECT_TRUE(finds(""));
    EXPECT_TRUE(finds("<d:Types>dn:NetworkVideoTransmitter tds:Device</d:Types>"));
    EXPECT_FALSE(finds("<d:Types>dn:NetworkVideoTransmitter dn:Printer</d:Types>"));
    const auto scopes = [](const std::string& text) { return finds("<d:Scopes>" + text + "</d:Scopes>"); };
    EXPECT_TRUE(scopes(scope_begin + "Profile/Streaming"));
    EXPECT_TRUE(scopes(" " + scope_begin + "Profile \n" + scope_begin + "type/ptz "));
    EXPECT_TRUE(scopes("ONVIF://WWW.onvif.org/Profile/"));
    EXPECT_FALSE(scopes(scope_begin + "Profile/Stream")) << "not a whole segment";
    EXPECT_FALSE(scopes(scope_begin + "profile")) << "paths have upper and lower case";
    EXPECT_FALSE(scopes(scope_begin + "Profile " + scope_begin + "Profile/G"));
}

TEST(OnvifDiscovery, ScopesAreMatchedByTheRuleThatIsAskedFor) {
    const std::string rule = "http://schemas.xmlsoap.org/ws/2005/04/discovery/";
    const auto by = [&](const std::string& name, const std::string& scope) {
        return finds("<d:Scopes MatchBy=\"" + rule + name + "\">" + scope_begin + scope + "</d:Scopes>");
    };
    EXPECT_TRUE(by("rfc3986", "Profile"));
    EXPECT_FALSE(by("strcmp0", "Profile"));
    EXPECT_TRUE(by("strcmp0", "Profile/Streaming"));
    EXPECT_FALSE(by("ldap", "Profile/Streaming")) << "silence, as the standard has it";
}

TEST(OnvifDiscovery, WhatIsNoQuestionIsNotAnswered) {
    EXPECT_FALSE(read_question(""));
    EXPECT_FALSE(read_question(asked("<d:Probe/>", ""))) << "answers name the question";
    EXPECT_FALSE(read_question(asked("<d:Hello/>")));
    EXPECT_FALSE(read_question(asked("<x:Probe xmlns:x=\"urn:x\"/>")));
    EXPECT_FALSE(read_question(asked("<d:Probe/>" + std::string(max_discovery_bytes, ' '))));
}

TEST(OnvifDiscovery, ResolveAnswersForOneAddressAndByeNamesIt) {
    const auto resolve = [](const std::string& address) {
        return *read_question(asked("<d:Resolve><a:EndpointReference><a:Address>" + address +
                                    "</a:Address></a:EndpointReference></d:Resolve>"));
    };
    EXPECT_TRUE(is_asked_for(dome, resolve(dome.address)));
    EXPECT_FALSE(is_asked_for(dome, resolve(endpoint_address("plain"))));
    const std::string match = match_message({"urn:uuid:2", 7, 8}, resolve(dome.address), dome);
    EXPECT_THAT(match, HasSubstr("<a:RelatesTo>urn:uuid:1</a:RelatesTo>"));
    EXPECT_THAT(match, HasSubstr("<d:ResolveMatches><d:ResolveMatch><a:EndpointReference><a:Address>" + dome.address));
    EXPECT_THAT(match, HasSubstr("<d:AppSequence InstanceId=\"7\" MessageNumber=\"8\"/>"));
    EXPECT_THAT(match, HasSubstr("<d:XAddrs>" + dome.url));
    EXPECT_THAT(bye_message({}, dome), HasSubstr(dome.address));
    EXPECT_THAT(bye_message({}, dome), Not(HasSubstr("XAddrs")));
    EXPECT_THAT(hello_message({}, dome), HasSubstr("<d:XAddrs>" + dome.url));
}

TEST(OnvifDiscovery, AnInterfaceOnWhichPortsCannotBeReachedIsRefused) {
    control::FakeRig rig;
    EXPECT_THAT(DiscoveryServer::create("nothing0", "0.0.0.0", rig).error().message, HasSubstr("there are"));
    EXPECT_THAT(DiscoveryServer::create("lo", "10.1.2.3", rig).error().message, HasSubstr("give --host 127.0.0.1"));
}

}  // namespace
}  // namespace camrig::onvif
