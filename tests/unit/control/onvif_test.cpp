#include <cmath>
#include <future>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include "control/onvif/onvif_service.h"
#include "control/onvif/ptz_vector.h"
#include "core/base/clock.h"
#include "tests/unit/control/fake_rig.h"

namespace camrig::onvif {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::string soap(const std::string& body, const std::string& header = {}) {
    return "<x:Envelope xmlns:x=\"http://www.w3.org/2003/05/soap-envelope\" "
           "xmlns:a=\"http://www.onvif.org/ver10/device/wsdl\" xmlns:b=\"http://www.onvif.org/ver20/ptz/wsdl\" "
           "xmlns:c=\"http://www.onvif.org/ver10/media/wsdl\" "
           "xmlns:d=\"http://www.onvif.org/ver20/imaging/wsdl\"><x:Header>" +
           header + "</x:Header><x:Body>" + body + "</x:Body></x:Envelope>";
}

std::string nested(int depth) {
    std::string text;
    for (int i = 0; i < depth; ++i) text += "<a>";
    for (int i = 0; i < depth; ++i) text += "</a>";
    return text;
}

bool parses(const std::string& text) {
    pugi::xml_document document;
    return parse_xml(text, document).has_value();
}

TEST(OnvifXml, DepthElementsBytesAndDocumentTypesAreBounded) {
    EXPECT_TRUE(parses(nested(max_xml_depth)));
    EXPECT_FALSE(parses(nested(max_xml_depth + 1)));
    std::string many;
    for (std::size_t i = 1; i < max_xml_elements; ++i) many += "<b/>";
    EXPECT_TRUE(parses("<a>" + many + "</a>"));
    EXPECT_FALSE(parses("<a>" + many + "<b/></a>"));
    EXPECT_FALSE(parses("<a>" + std::string(max_xml_bytes, ' ') + "</a>"));
    EXPECT_FALSE(parses("<!DOCTYPE a [<!ENTITY b \"bbbb\">]><a>&b;</a>"));
    EXPECT_FALSE(parses("<a><b></a>"));
    EXPECT_FALSE(parses(""));
}

TEST(OnvifXml, PrefixesStandForNamespacesWhereverTheyAreDeclared) {
    pugi::xml_document document;
    ASSERT_TRUE(parse_xml(
        "<p:a xmlns:p='one' xmlns='two'><b><p:c xmlns:p='three' d=' 1 ' p:e='2'> text </p:c></b></p:a>", document));
    const XmlElement a = XmlElement(document).first_child();
    EXPECT_EQ(a.name(), "a");
    EXPECT_EQ(a.space(), "one");
    EXPECT_EQ(a.child("b").space(), "two");
    const XmlElement c = a.child("b").child("c");
    EXPECT_EQ(c.space(), "three");
    EXPECT_EQ(c.text(), "text");
    EXPECT_EQ(c.attribute("d"), " 1 ");
    EXPECT_FALSE(c.attribute("e")) << "that is another one, of a namespace";
    EXPECT_FALSE(c.attribute("f"));
    EXPECT_FALSE(a.child("nothing").child("deeper"));
    EXPECT_EQ(a.child("nothing").space(), "");
}

TEST(OnvifXml, TextIsEscapedAndNumbersHaveSixDecimalsInEveryLocale) {
    EXPECT_EQ(escaped("a<b>&\"c"), "a&lt;b&gt;&amp;&quot;c");
    EXPECT_EQ(escaped("\x01\xff gr\xc3\xbc\xc3\x9f \xed\xa0\x80"), "?? gr\xc3\xbc\xc3\x9f ???");
    EXPECT_EQ(number(-0.5), "-0.500000");
    EXPECT_EQ(number(-1e-17), "0.000000");
    EXPECT_EQ(number(1.0), "1.000000");
    EXPECT_EQ(number(std::nan("")), "0.000000");
}

TEST(OnvifXml, DurationsAreThoseOfXmlSchema) {
    EXPECT_EQ(duration_of("PT2.5S"), 2'500'000'000);
    EXPECT_EQ(duration_of("PT1M1S"), 61 * ns_per_s);
    EXPECT_EQ(duration_of("PT0S"), 0);
    EXPECT_EQ(duration_of("P1D"), 86'400 * ns_per_s);
    EXPECT_EQ(duration_of("P0DT2H"), 7200 * ns_per_s);
    EXPECT_EQ(duration_of("P1DT2H", 2 * 86'400 * ns_per_s), 93'600 * ns_per_s);
    EXPECT_EQ(duration_of("P0Y0M0DT0H0M5.000S"), 5 * ns_per_s) << "as Java writes it";
    EXPECT_EQ(duration_of("P1M", 40 * 86'400 * ns_per_s), 30 * 86'400 * ns_per_s);
    for (const char* bad : {"P1D1M", "P1S", "PTT1S", "P1YT"}) EXPECT_FALSE(duration_of(bad)) << bad;
    for (const char* bad : {"P", "P1", "P1DT", "PT1D", "P1D2H", "P-1D", "P1DT2H", "P1Y"})
        EXPECT_FALSE(duration_of(bad)) << bad;
    for (const char* bad : {"", "PT", "2S", "PTS", "PT-1S", "PT1D", "PT1S1M", "PT100H", "PT1e5S", "PTnanS"})
        EXPECT_FALSE(duration_of(bad)) << bad;
}

TEST(OnvifXml, ASpeedIsOfWhatMoves) {
    pugi::xml_document document;
    ASSERT_TRUE(parse_xml("<Speed><PanTilt x='1' y='1'/><Zoom x='0.25'/></Speed>", document));
    const XmlElement speed = XmlElement(document).first_child();
    EXPECT_EQ(speed_of(speed), 1.0);
    EXPECT_EQ(speed_of(speed, false), 0.25);
}

TEST(OnvifXml, TimesAreThoseOfUtc) {
    EXPECT_EQ(time_of_text("1970-01-02T00:00:01Z"), 86'401 * ns_per_s);
    EXPECT_EQ(time_of_text("2026-11-23T20:00:00.123Z"), time_of_text("2026-11-23T20:00:00"));
    EXPECT_EQ(text_of_time(*time_of_text("2026-11-23T20:01:02Z")), "2026-11-23T20:01:02Z");
    EXPECT_EQ(time_of_text("2026-11-23T20:00:00.5+02:00"), time_of_text("2026-11-23T18:00:00Z"));
    EXPECT_EQ(time_of_text("2026-11-23T20:00:00-03:30"), time_of_text("2026-11-23T23:30:00Z"));
    // Of a camera whose clock is that wrong, too.
    EXPECT_EQ(text_of_time(-1), "1969-12-31T23:59:59Z");
    EXPECT_EQ(time_of_text("1963-02-28T12:00:01Z").value_or(0) % ns_per_s, 0);
    EXPECT_EQ(text_of_time(time_of_text("1963-02-28T12:00:01Z").value_or(0)), "1963-02-28T12:00:01Z");
    for (const char* bad : {"", "now", "2026-13-01T00:00:00Z", "2026-02-30T00:00:00Z", "2026-01-01T25:00:00Z",
                            "2026-01-01T00:00:00+02", "2026-01-01T00:00:00+15:00", "2026-01-01T00:00:00+01:60",
                            "2026-01-01T00:00:00 02:00", "2026-01-01T00:00:00+02:00Z"})
        EXPECT_FALSE(time_of_text(bad)) << bad;
}

/// The example of the WS-UsernameToken profile 1.1 as ONVIF's programmer's guide (6.1.1) has it.
constexpr UsernameToken known{.name = "user",
                              .password = "tuOSpGlFlIXsozq4HFNeeGeFLEI=",
                              .nonce = "LKqI6G/AikKCQrN0zqZFlg==",
                              .created = "2010-09-16T07:50:45Z",
                              .is_digest = true};

TEST(OnvifAuthentication, ADigestIsThatOfTheStandardAndGoodOnceAndSoon) {
    const TimeNs then = *time_of_text(known.created);
    Authentication access("userpassword");
    EXPECT_FALSE(access.role_of(known, then + Authentication::max_skew_ns + ns_per_s));
    EXPECT_FALSE(access.role_of(known, then - Authentication::max_skew_ns - ns_per_s));
    EXPECT_TRUE(access.role_of(known, then + 10 * ns_per_s));
    EXPECT_FALSE(access.role_of(known, then + 11 * ns_per_s)) << "replayed";
    UsernameToken respelt = known;
    respelt.nonce = "LKqI6G/AikKCQrN0zqZFlh==";  // the same bytes: of the last letter two bits count
    EXPECT_FALSE(access.role_of(respelt, then + 11 * ns_per_s)) << "replayed in another spelling";
    EXPECT_FALSE(Authentication("another").role_of(known, then));
    EXPECT_TRUE(Authentication("").role_of(known, 0)) << "without a token everybody may";
    UsernameToken text{.name = {}, .password = "userpassword", .nonce = {}, .created = {}};
    EXPECT_TRUE(access.role_of(text, then));
    text.password = "userpasswor";
    EXPECT_FALSE(access.role_of(text, then));
}

TEST(OnvifAuthentication, MadeUpNoncesOfHttpAreRefused) {
    Authentication access("userpassword");
    const TimeNs now = 1'800'000'000 * ns_per_s;
    EXPECT_THAT(access.http_challenge(now), StartsWith("Digest realm=\"camrig\""));
    EXPECT_FALSE(access
                     .http_caller("GET", "/a",
                                  "Digest username=\"u\", realm=\"camrig\", nonce=\"1800000000-00\", "
                                  "uri=\"/a\", response=\"00\"",
                                  now)
                     .role);
    EXPECT_FALSE(access.http_caller("GET", "/a", "Digest ===,,\"", now).role);
    for (const char* time : {"-9223372036854775808", "9223372036854775807", "1900000000", "0"}) {
        const std::string nonce = std::string(time) + "-00";
        EXPECT_FALSE(access
                         .http_caller("GET", "/a",
                                      "Digest username=\"u\", realm=\"camrig\", nonce=\"" + nonce +
                                          "\", uri=\"/a\", response=\"00\"",
                                      now)
                         .role)
            << time;
    }
    EXPECT_FALSE(access.http_caller("GET", "/a", "", now).role);
}

class OnvifServiceTest : public testing::Test {
protected:
    OnvifServiceTest() {
        for (const char* name : {"dome", "plain"}) {
            world::CameraPatch patch;
            if (name == std::string("dome"))
                patch.change([](world::CameraSpec& spec) {
                    spec.ptz = camera::ptz_preset(camera::PtzPreset::ideal);
                    spec.ptz->pan_limits_deg = camera::PtzLimits{-90, 90};
                    spec.ptz->tilt_limits_deg = {-60, 30};
                });
            rig.post(
                engine::Request<engine::CreateCamera>{{name, {}, patch}, [](const auto& made) { ASSERT_TRUE(made); }});
        }
    }

    OnvifReply ask(const std::string& text, const std::string& device = {},
                   const std::string& path = "/onvif/device_service", std::uint16_t port = 80) {
        std::promise<OnvifReply> answer;
        service->handle({device, "10.0.0.9:81", path, std::nullopt, text, port},
                        [&answer](OnvifReply reply) { answer.set_value(std::move(reply)); });
        return answer.get_future().get();
    }
    std::string ptz(const std::string& name, const std::string& inner = {}) {
        return soap("<b:" + name + "><b:ProfileToken>dome</b:ProfileToken>" + inner + "</b:" + name + ">");
    }
    void start(OnvifService::Options options) {
        options.site.rtsp_port = 8554;
        options.site.streams = [](const world::CameraSpec& camera) {
            std::vector<VideoStream> streams;
            for (const std::string_view ending : stream_endings)
                streams.push_back({.ending = std::string(ending),
                                   .codec = ending == "mjpeg" ? "mjpeg" : "h264",
                                   .size = camera.size,
                                   .rate = camera.rate});
            return streams;
        };
        service = std::make_unique<OnvifService>(rig, rig, std::move(options));
    }

    control::FakeRig rig;
    std::unique_ptr<OnvifService> service;
};

TEST_F(OnvifServiceTest, ADeviceIsOneCameraOrHasThemAll) {
    start({});
    const std::string all = ask(soap("<c:GetProfiles/>")).text;
    EXPECT_THAT(all, HasSubstr("<trt:Profiles token=\"dome\" fixed=\"true\">"));
    EXPECT_THAT(all, HasSubstr("<trt:Profiles token=\"plain-mjpeg\" fixed=\"true\">"));
    const std::string one = ask(soap("<c:GetProfiles/>"), "plain").text;
    EXPECT_THAT(one, Not(HasSubstr("dome")));
    EXPECT_THAT(one, Not(HasSubstr("PTZConfiguration")));
    EXPECT_THAT(ask(soap("<a:GetServices/>"), "plain").text, Not(HasSubstr("/ptz/wsdl<")));
    EXPECT_THAT(ask(soap("<a:GetServices/>"), "dome").text, HasSubstr("http://10.0.0.9:81/onvif/device_service"));
    EXPECT_EQ(ask(ptz("GetStatus"), "plain").status, 400) << "the head of another device";
    const std::string uri = "<c:GetStreamUri><c:ProfileToken>dome-mjpeg</c:ProfileToken></c:GetStreamUri>";
    EXPECT_THAT(ask(soap(uri)).text, HasSubstr("<tt:Uri>rtsp://10.0.0.9:8554/dome/mjpeg</tt:Uri>"));
}

TEST_F(OnvifServiceTest, OnlyProfilesHaveTokensOfStreams) {
    start({});
    const auto status = [&](const std::string& operation, const std::string& child, const std::string& token) {
        return ask(soap("<" + operation + "><" + child + ">" + token + "</" + child + "></" + operation + ">")).status;
    };
    EXPECT_EQ(status("b:GetCompatibleConfigurations", "b:ProfileToken", "dome"), 200);
    EXPECT_EQ(status("b:GetCompatibleConfigurations", "b:ProfileToken", "dome-sub"), 200);
    for (const auto& [operation, child] : {std::pair{"b:GetNode", "b:NodeToken"},
                                           {"b:GetConfiguration", "b:PTZConfigurationToken"},
                                           {"b:GetConfigurationOptions", "b:ConfigurationToken"},
                                           {"c:GetVideoSourceConfiguration", "c:ConfigurationToken"}}) {
        EXPECT_EQ(status(operation, child, "dome"), 200) << operation;
        EXPECT_EQ(status(operation, child, "dome-sub"), 400) << operation;
    }
}

TEST_F(OnvifServiceTest, RightIsPositiveForClientsAndNegativeForTheHead) {
    start({});
    EXPECT_EQ(ask(ptz("AbsoluteMove", "<b:Position><PanTilt x=\"1\" y=\"-1\"/><Zoom x=\"1\"/></b:Position>")).status,
              200);
    std::promise<camera::PtzPosition> there;
    rig.post(engine::Request<engine::GetCamera>{{"dome"}, [&there](const Result<engine::CameraReply>& reply) {
                                                    there.set_value((*reply->camera.head())->at(60 * ns_per_s));
                                                }});
    EXPECT_EQ(there.get_future().get(), (camera::PtzPosition{-90, -60, 30}));
    EXPECT_THAT(ask(ptz("GetStatus")).text, HasSubstr("<tt:MoveStatus><tt:PanTilt>MOVING</tt:PanTilt>"));
}

TEST_F(OnvifServiceTest, TheEndsOfAnAxisAreWithinItsLimitsToTheLastBit) {
    start({});
    world::CameraPatch patch;
    patch.change([](world::CameraSpec& spec) {
        spec.ptz = camera::ptz_preset(camera::PtzPreset::ideal);
        spec.ptz->pan_limits_deg = camera::PtzLimits{-15.2, 86.4};
        spec.ptz->tilt_limits_deg = {-15.2, 86.4};
    });
    rig.post(engine::Request<engine::CreateCamera>{{"odd", {}, patch}, [](const auto& made) { ASSERT_TRUE(made); }});
    for (const char* end : {"x=\"1\" y=\"-1\"", "x=\"-1\" y=\"1\""}) {
        const std::string to = std::string("<b:Position><PanTilt ") + end + "/></b:Position>";
        const std::string move = "<b:AbsoluteMove><b:ProfileToken>odd</b:ProfileToken>" + to + "</b:AbsoluteMove>";
        EXPECT_EQ(ask(soap(move)).status, 200) << end;
    }
    EXPECT_THAT(ask(soap("<b:AbsoluteMove><b:ProfileToken>odd</b:ProfileToken><b:Position><PanTilt x=\"1.1\" "
                         "y=\"0\"/></b:Position></b:AbsoluteMove>"))
                    .text,
                HasSubstr("ter:InvalidPosition"));
}

/// The camera "dome" gets this output.
void give_output(control::FakeRig& rig, nlohmann::json options) {
    world::CameraPatch patch;
    patch.change([&options](world::CameraSpec& spec) { spec.outputs = {{.kind = "onvif", .options = options}}; });
    rig.post(engine::Request<engine::SetCamera>{{"dome", patch}, [](const auto& set) { ASSERT_TRUE(set); }});
}

TEST_F(OnvifServiceTest, ADeviceWithoutMoveStatusSaysSoAndOneThatSticksMovesForEver) {
    start({});
    const auto status = [&](std::uint16_t port) {
        return ask(ptz("GetStatus"), "dome", "/onvif/device_service", port).text;
    };
    const std::string capabilities = soap("<b:GetServiceCapabilities/>");
    const std::string move = ptz("AbsoluteMove", "<b:Position><PanTilt x=\"1\" y=\"-1\"/></b:Position>");

    give_output(rig, {{"port", 81}, {"move_status", "none"}});
    EXPECT_EQ(ask(move, "dome", "/onvif/device_service", 81).status, 200);
    EXPECT_THAT(status(81), AllOf(HasSubstr("<tt:Position>"), Not(HasSubstr("MoveStatus")), Not(HasSubstr("MOVING"))));
    EXPECT_THAT(ask(capabilities, "dome", "/onvif/device_service", 81).text, HasSubstr("MoveStatus=\"false\""));
    // It is the manner of that port, not of the camera.
    EXPECT_THAT(status(82), HasSubstr("<tt:PanTilt>MOVING</tt:PanTilt>"));
    EXPECT_THAT(ask(capabilities).text, HasSubstr("MoveStatus=\"true\""));

    give_output(rig, {{"port", 81}, {"move_status", "stuck"}});
    rig.post(engine::Request<engine::StepWorld>{{60 * ns_per_s}, [](const auto&) {}});
    EXPECT_THAT(status(82), HasSubstr("<tt:PanTilt>IDLE</tt:PanTilt><tt:Zoom>IDLE</tt:Zoom>"));
    EXPECT_THAT(status(81), HasSubstr("<tt:PanTilt>MOVING</tt:PanTilt><tt:Zoom>MOVING</tt:Zoom>"));
    EXPECT_THAT(ask(capabilities, "dome", "/onvif/device_service", 81).text, HasSubstr("MoveStatus=\"true\""));
}

TEST_F(OnvifServiceTest, ADeviceWithoutMovesByFieldOfViewNamesNoneAndRefusesThem) {
    start({});
    give_output(rig, {{"port", 81}, {"relative_fov", false}});
    const std::string options = soap(
        "<b:GetConfigurationOptions><b:ConfigurationToken>dome</b:ConfigurationToken></b:GetConfigurationOptions>");
    const std::string move = ptz("RelativeMove",
                                 "<b:Translation><PanTilt x=\"0.1\" y=\"0\" space=\"http://www.onvif.org/ver10/tptz/"
                                 "PanTiltSpaces/TranslationSpaceFov\"/></b:Translation>");
    const auto at = [&](const std::string& text, std::uint16_t port) {
        return ask(text, "dome", "/onvif/device_service", port).text;
    };
    EXPECT_THAT(at(options, 81), AllOf(HasSubstr("TranslationGenericSpace"), Not(HasSubstr("TranslationSpaceFov"))));
    EXPECT_THAT(at(soap("<b:GetNodes/>"), 81), Not(HasSubstr("TranslationSpaceFov")));
    EXPECT_THAT(at(move, 81), HasSubstr("ter:SpaceNotSupported"));
    EXPECT_THAT(at(options, 82), HasSubstr("TranslationSpaceFov"));
    EXPECT_THAT(at(soap("<b:GetNodes/>"), 82), HasSubstr("TranslationSpaceFov"));
    EXPECT_THAT(at(move, 82), HasSubstr("RelativeMoveResponse"));
}

TEST_F(OnvifServiceTest, ImageControlsAreImagingFromZeroToAHundred) {
    start({});
    const auto about = [&](const std::string& name, const std::string& inner = {}) {
        return ask(soap("<d:" + name + "><d:VideoSourceToken>dome</d:VideoSourceToken>" + inner + "</d:" + name + ">"))
            .text;
    };
    const auto set = [&](const std::string& inner) {
        return about("SetImagingSettings", "<d:ImagingSettings>" + inner + "</d:ImagingSettings>");
    };
    EXPECT_THAT(about("GetImagingSettings"),
                HasSubstr("<tt:Brightness>50.000000</tt:Brightness><tt:ColorSaturation>50.000000</tt:ColorSaturation>"
                          "<tt:Contrast>50.000000</tt:Contrast>"));
    EXPECT_THAT(set("<Brightness>75</Brightness><Contrast>0</Contrast><Sharpness>7</Sharpness>"),
                HasSubstr("SetImagingSettingsResponse"));
    std::promise<ImageControls> there;
    rig.post(engine::Request<engine::GetCamera>{{"dome"}, [&there](const Result<engine::CameraReply>& reply) {
                                                    there.set_value(reply->camera.spec()->controls);
                                                }});
    EXPECT_EQ(there.get_future().get(), (ImageControls{.brightness = 0.5, .contrast = 0.0, .saturation = 1.0}));
    EXPECT_THAT(set("<Contrast>101</Contrast>"), HasSubstr("ter:SettingsInvalid"));
    EXPECT_THAT(set("<Contrast>much</Contrast>"), HasSubstr("ter:SettingsInvalid"));
    EXPECT_THAT(about("GetImagingSettings"), HasSubstr("<tt:Brightness>75.000000<"));
    EXPECT_THAT(about("GetOptions"), HasSubstr("<tt:Contrast><tt:Min>0.000000</tt:Min><tt:Max>100.000000</tt:Max>"));
}

TEST_F(OnvifServiceTest, APresetWhoseNameXmlCannotSayIsFoundByWhatItIsToldAs) {
    start({});
    rig.post(engine::Request<engine::PtzPresets>{{"dome",
                                                  "a\x01"
                                                  "b",
                                                  engine::PtzPresets::Action::set},
                                                 [](const auto& set) { ASSERT_TRUE(set); }});
    EXPECT_THAT(ask(ptz("GetPresets")).text, HasSubstr("token=\"a?b\""));
    EXPECT_EQ(ask(ptz("GotoPreset", "<b:PresetToken>a?b</b:PresetToken>")).status, 200);
    EXPECT_EQ(ask(ptz("SetPreset", "<b:PresetToken>a?b</b:PresetToken>")).status, 200);
    EXPECT_THAT(ask(ptz("GotoPreset", "<b:PresetToken>a?c</b:PresetToken>")).text, HasSubstr("ter:NoToken"));
    EXPECT_EQ(ask(ptz("RemovePreset", "<b:PresetToken>a?b</b:PresetToken>")).status, 200);
    EXPECT_THAT(ask(ptz("GetPresets")).text, Not(HasSubstr("a?b")));
}

TEST_F(OnvifServiceTest, PresetsAreThoseOfTheHeadAndGetNumbersWhereTheyGetNoNames) {
    start({});
    EXPECT_THAT(ask(ptz("SetPreset")).text, HasSubstr("<tptz:PresetToken>1</tptz:PresetToken>"));
    EXPECT_THAT(ask(ptz("SetPreset")).text, HasSubstr("<tptz:PresetToken>2</tptz:PresetToken>"));
    EXPECT_EQ(ask(ptz("SetPreset", "<b:PresetName>a&lt;b</b:PresetName>")).status, 200);
    EXPECT_THAT(ask(ptz("GetPresets")).text, HasSubstr("<tptz:Preset token=\"a&lt;b\"><tt:Name>a&lt;b</tt:Name>"));
    EXPECT_THAT(ask(ptz("SetPreset", "<b:PresetName>a&lt;b</b:PresetName>")).text, HasSubstr("ter:PresetExist"));
    EXPECT_EQ(ask(ptz("SetPreset", "<b:PresetToken>1</b:PresetToken>")).status, 200);
    EXPECT_THAT(ask(ptz("SetPreset", "<b:PresetToken>9</b:PresetToken>")).text, HasSubstr("ter:NoToken"));
    EXPECT_THAT(ask(ptz("SetPreset", "<b:PresetName>where?</b:PresetName>")).text, HasSubstr(">where?<"));
    EXPECT_EQ(ask(ptz("GotoPreset", "<b:PresetToken>home</b:PresetToken>")).status, 200);
    EXPECT_EQ(ask(ptz("RemovePreset", "<b:PresetToken>1</b:PresetToken>")).status, 200);
}

/// A rig on which, between what a client is told of the presets and what it sets, another one was quicker.
class OvertakenRig final : public engine::CommandPort {
public:
    OvertakenRig(control::FakeRig& rig, int times) : rig_(rig), times_(times) {}
    void post(engine::Command command) override {
        if (auto* set = std::get_if<engine::Request<engine::PtzPresets>>(&command); set && times_-- > 0)
            rig_.post(engine::Request<engine::PtzPresets>{set->command, [](const auto&) {}});
        rig_.post(std::move(command));
    }

private:
    control::FakeRig& rig_;
    int times_;
};

TEST_F(OnvifServiceTest, OfTwoThatSetPresetsAtOnceNeitherTakesTheOthers) {
    OvertakenRig overtaken(rig, 2);
    service = std::make_unique<OnvifService>(overtaken, rig, OnvifService::Options{});
    EXPECT_THAT(ask(ptz("SetPreset")).text, HasSubstr("<tptz:PresetToken>3</tptz:PresetToken>"));
    OvertakenRig again(rig, 1);
    service = std::make_unique<OnvifService>(again, rig, OnvifService::Options{});
    EXPECT_THAT(ask(ptz("SetPreset", "<b:PresetName>door</b:PresetName>")).text, HasSubstr("ter:PresetExist"));
}

/// As a client of that clock signs.
std::string signed_at(TimeNs utc_ns, const std::string& password) {
    const std::string nonce = "0123456789abcdef", created = text_of_time(utc_ns);
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    const std::string text = nonce + created + password;
    EVP_Digest(text.data(), text.size(), digest, &size, EVP_sha1(), nullptr);
    const auto encoded = [](std::string_view bytes) {
        std::string made((bytes.size() + 2) / 3 * 4 + 1, '\0');
        made.resize(static_cast<std::size_t>(EVP_EncodeBlock(reinterpret_cast<unsigned char*>(made.data()),
                                                             reinterpret_cast<const unsigned char*>(bytes.data()),
                                                             static_cast<int>(bytes.size()))));
        return made;
    };
    return "<Security><UsernameToken><Username>a</Username><Password Type=\"x#PasswordDigest\">" +
           encoded({reinterpret_cast<const char*>(digest), size}) + "</Password><Nonce>" + encoded(nonce) +
           "</Nonce><Created>" + created + "</Created></UsernameToken></Security>";
}

TEST_F(OnvifServiceTest, AMessageThatIsGivenOnceMoreIsJudgedOnce) {
    OvertakenRig overtaken(rig, 2);
    service = std::make_unique<OnvifService>(overtaken, rig, OnvifService::Options{.token = "a-good-token"});
    const std::string order = "<b:SetPreset><b:ProfileToken>dome</b:ProfileToken></b:SetPreset>";
    const OnvifReply made = ask(soap(order, signed_at(realtime_now_ns(), "a-good-token")), "dome");
    EXPECT_THAT(made.text, HasSubstr("<tptz:PresetToken>3</tptz:PresetToken>"));
}

TEST_F(OnvifServiceTest, AWrongDigestOnACamerasPortChangesNothing) {
    /// Fails for whatever is more than a look.
    struct LookedAt final : engine::CommandPort {
        explicit LookedAt(control::FakeRig& port) : rig(port) {}
        void post(engine::Command command) override {
            EXPECT_TRUE(std::holds_alternative<engine::Request<engine::GetCamera>>(command));
            rig.post(std::move(command));
        }
        control::FakeRig& rig;
    } looked(rig);
    service = std::make_unique<OnvifService>(looked, rig, OnvifService::Options{.token = "a-good-token"});
    const std::string wrong = signed_at(realtime_now_ns(), "a-bad-token");
    const std::string of_dome = "<b:ProfileToken>dome</b:ProfileToken>";
    for (const std::string& order :
         {"<b:ContinuousMove>" + of_dome + "<b:Velocity><PanTilt x=\"1\" y=\"0\"/></b:Velocity></b:ContinuousMove>",
          "<b:SetPreset>" + of_dome + "</b:SetPreset>",
          std::string("<c:SetVideoEncoderConfiguration><c:Configuration token=\"dome\"/>"
                      "</c:SetVideoEncoderConfiguration>"),
          std::string("<e:CreatePullPointSubscription xmlns:e=\"http://www.onvif.org/ver10/events/wsdl\"/>")}) {
        const OnvifReply refused = ask(soap(order, wrong), "dome");
        EXPECT_EQ(refused.status, 400);
        EXPECT_TRUE(refused.is_refused) << refused.text;
        EXPECT_THAT(refused.text, HasSubstr("not Authorized"));
    }
}

TEST_F(OnvifServiceTest, OfACameraThatIsGoneNobodyLearnsTheOthersNames) {
    start({.token = "a-good-token"});
    const OnvifReply gone = ask(soap("<b:Stop/>", signed_at(realtime_now_ns(), "a-bad-token")), "gone");
    EXPECT_THAT(gone.text, AllOf(HasSubstr("the camera of this device is gone"), Not(HasSubstr("plain"))));
}

TEST_F(OnvifServiceTest, OnlyACamerasOwnDeviceGoesByItsClock) {
    world::CameraPatch patch;
    patch.change([](world::CameraSpec& spec) {
        spec.ptz = camera::ptz_preset(camera::PtzPreset::ideal);
        spec.clock = camera::ClockSpec{.offset_ns = 86'400 * 400 * ns_per_s};
    });
    rig.post(engine::Request<engine::CreateCamera>{{"late", {}, patch}, [](const auto& made) { ASSERT_TRUE(made); }});
    /// Tells what that camera's clock would.
    struct Late final : engine::CommandPort {
        explicit Late(control::FakeRig& port) : rig(port) {}
        void post(engine::Command command) override {
            if (auto* get = std::get_if<engine::Request<engine::GetCamera>>(&command))
                get->done = [done = std::move(get->done)](Result<engine::CameraReply> made) {
                    if (made) made->now.clock = ClockReading{.stamp_error_ns = 86'400 * 400 * ns_per_s};
                    done(std::move(made));
                };
            rig.post(std::move(command));
        }
        control::FakeRig& rig;
    } late(rig);
    service = std::make_unique<OnvifService>(late, rig, OnvifService::Options{});
    const std::string status = soap("<b:GetStatus><b:ProfileToken>late</b:ProfileToken></b:GetStatus>");
    const auto year = [](TimeNs ns) { return "UtcTime>" + text_of_time(ns).substr(0, 5); };
    EXPECT_THAT(ask(status).text, HasSubstr(year(realtime_now_ns())));
    EXPECT_THAT(ask(status, "late").text, HasSubstr(year(realtime_now_ns() + 86'400 * 400 * ns_per_s)));
}

TEST_F(OnvifServiceTest, OnlyAFullHeadHasTooManyPresets) {
    start({});
    for (std::size_t i = 0; i < camera::PtzHead::max_presets; ++i) EXPECT_EQ(ask(ptz("SetPreset")).status, 200);
    EXPECT_THAT(ask(ptz("SetPreset")).text, HasSubstr("ter:TooManyPresets"));
    EXPECT_EQ(ask(ptz("SetPreset", "<b:PresetToken>1</b:PresetToken>")).status, 200);
    struct BusyRig final : engine::CommandPort {
        explicit BusyRig(control::FakeRig& port) : rig(port) {}
        void post(engine::Command command) override {
            if (auto* set = std::get_if<engine::Request<engine::PtzPresets>>(&command))
                return set->done(error(ErrorKind::resource_exhausted, "too many commands wait"));
            rig.post(std::move(command));
        }
        control::FakeRig& rig;
    } busy(rig);
    service = std::make_unique<OnvifService>(busy, rig, OnvifService::Options{});
    const std::string refused = ask(ptz("SetPreset", "<b:PresetToken>1</b:PresetToken>")).text;
    EXPECT_THAT(refused, AllOf(HasSubstr("ter:Action<"), Not(HasSubstr("TooManyPresets"))));
}

TEST_F(OnvifServiceTest, MovesThatNoHeadCanMakeAreTheProperFaults) {
    start({});
    const auto fault = [&](const char* name, const std::string& inner) { return ask(ptz(name, inner)).text; };
    EXPECT_THAT(fault("AbsoluteMove", ""), HasSubstr("ter:InvalidPosition"));
    EXPECT_THAT(fault("AbsoluteMove", "<b:Position><PanTilt x=\"nan\" y=\"0\"/></b:Position>"),
                HasSubstr("ter:InvalidPosition"));
    EXPECT_THAT(fault("RelativeMove", "<b:Translation><PanTilt x=\"2\" y=\"0\"/></b:Translation>"),
                HasSubstr("ter:InvalidTranslation"));
    EXPECT_THAT(fault("ContinuousMove", "<b:Velocity><Zoom x=\"-1.1\"/></b:Velocity>"),
                HasSubstr("ter:InvalidVelocity"));
    EXPECT_THAT(fault("ContinuousMove", "<b:Velocity><Zoom x=\"0\"/></b:Velocity><b:Timeout>soon</b:Timeout>"),
                HasSubstr("ter:TimeoutNotSupported"));
    EXPECT_THAT(fault("ContinuousMove", "<b:Velocity><Zoom x=\"0\" space=\"urn:x\"/></b:Velocity>"),
                HasSubstr("ter:SpaceNotSupported"));
}

TEST_F(OnvifServiceTest, WhoMayNotCommandIsRefusedButToldTheTime) {
    start({.token = "a-good-token"});
    const OnvifReply anonymous = ask(ptz("Stop"));
    EXPECT_EQ(anonymous.status, 401);
    EXPECT_TRUE(anonymous.asks_digest && !anonymous.is_refused);
    const std::string wrong =
        "<Security><UsernameToken><Username>a</Username><Password>a-bad-token</Password></UsernameToken></Security>";
    const OnvifReply refused = ask(soap("<b:Stop><b:ProfileToken>dome</b:ProfileToken></b:Stop>", wrong));
    EXPECT_EQ(refused.status, 400);
    EXPECT_TRUE(refused.is_refused);
    EXPECT_THAT(refused.text, HasSubstr("not Authorized"));
    EXPECT_EQ(ask(soap("<a:GetSystemDateAndTime/>", wrong)).status, 200);
    start({.token = "a-good-token", .may_command = false});
    const auto good = [] { return signed_at(realtime_now_ns(), "a-good-token"); };
    EXPECT_THAT(ask(soap("<b:Stop><b:ProfileToken>dome</b:ProfileToken></b:Stop>", good()), "dome").text,
                HasSubstr("--read-only"));
    start({.may_command = false});
    EXPECT_THAT(ask(ptz("Stop")).text, HasSubstr("--read-only"));
    EXPECT_EQ(ask(ptz("GetStatus")).status, 200);
}

}  // namespace
}  // namespace camrig::onvif
