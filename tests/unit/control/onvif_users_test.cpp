#include <algorithm>
#include <filesystem>
#include <fstream>
#include <future>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include "control/onvif/onvif_service.h"
#include "tests/temporary_folder.h"
#include "tests/unit/control/fake_rig.h"

namespace camrig::onvif {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr TimeNs now = 1'800'000'000 * ns_per_s;
const std::vector<User> three{{"ann", Role::administrator, "password-of-ann"},
                              {"otto", Role::op, "password-of-otto"},
                              {"ute", Role::user, "password-of-ute"}};

std::string hex_of_hash(const EVP_MD* kind, const std::string& text) {
    unsigned char bytes[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EXPECT_EQ(EVP_Digest(text.data(), text.size(), bytes, &size, kind, nullptr), 1);
    std::string made;
    for (unsigned int i = 0; i < size; ++i) {
        made += "0123456789abcdef"[bytes[i] >> 4];
        made += "0123456789abcdef"[bytes[i] & 15];
    }
    return made;
}

/// What a client answers to a challenge, by RFC 7616, 3.4.1: its `count`th message with this nonce, GET /a.
std::string answer_to(const std::string& challenge, const std::string& name, const std::string& password, int count = 1,
                      const std::string& algorithm = "MD5") {
    const std::size_t at = challenge.find("nonce=\"") + 7;
    const std::string nonce = challenge.substr(at, challenge.find('"', at) - at);
    const std::string nc = "0000000" + std::to_string(count);
    const auto hashed = [&](const std::string& text) {
        return hex_of_hash(algorithm == "MD5" ? EVP_md5() : EVP_sha256(), text);
    };
    const std::string response =
        hashed(hashed(name + ":camrig:" + password) + ":" + nonce + ":" + nc + ":c:auth:" + hashed("GET:/a"));
    return "Digest username=\"" + name + "\", realm=\"camrig\", nonce=\"" + nonce +
           "\", uri=\"/a\", qop=auth, algorithm=" + algorithm + ", nc=" + nc + ", cnonce=\"c\", response=\"" +
           response + "\"";
}

TEST(OnvifUsers, HaveTheirRolesAndTheTokenIsAPasswordOfAnyName) {
    Authentication access("the-token", three);
    const auto by_http = [&](const std::string& name, const std::string& password) {
        return access.http_caller("GET", "/a", answer_to(access.http_challenge(now), name, password), now).role;
    };
    const auto by_text = [&](std::string_view name, std::string_view password) {
        return access.role_of({.name = name, .password = password, .nonce = {}, .created = {}}, now);
    };
    for (const User& user : three) {
        EXPECT_EQ(by_http(user.name, user.password), user.role) << user.name;
        EXPECT_EQ(by_text(user.name, user.password), user.role) << user.name;
    }
    EXPECT_EQ(by_http("ute", "the-token"), Role::administrator);
    EXPECT_EQ(by_text("anybody", "the-token"), Role::administrator);
    EXPECT_FALSE(by_http("ute", "password-of-ann"));
    EXPECT_FALSE(by_text("ute", "password-of-ann"));
    EXPECT_FALSE(Authentication("", three).role_of({.name = "x", .password = "", .nonce = {}, .created = {}}, now))
        << "no token is no empty password";
}

TEST(OnvifDigest, AnOldNonceIsStaleOnlyToWhoKnowsThePassword) {
    const TimeNs later = now + Authentication::max_skew_ns + 1;
    Authentication access("", three);
    const std::string challenge = access.http_challenge(now);
    EXPECT_THAT(challenge, Not(HasSubstr("stale")));
    EXPECT_TRUE(access.http_caller("GET", "/a", answer_to(challenge, "ute", "password-of-ute"), later - 1).role);
    const auto old = access.http_caller("GET", "/a", answer_to(challenge, "ute", "password-of-ute", 2), later);
    EXPECT_TRUE(!old.role && old.is_stale);
    const auto wrong = access.http_caller("GET", "/a", answer_to(challenge, "ute", "a-wrong-one"), later);
    EXPECT_TRUE(!wrong.role && !wrong.is_stale);
    EXPECT_THAT(access.http_challenge(later, true), HasSubstr(", stale=true"));
}

TEST(OnvifDigest, AnAnswerIsGoodForOneMessageAndOneTarget) {
    Authentication access("", three);
    const std::string challenge = access.http_challenge(now);
    const std::string first = answer_to(challenge, "otto", "password-of-otto");
    EXPECT_FALSE(access.http_caller("POST", "/a", first, now).role) << "another method";
    EXPECT_FALSE(access.http_caller("GET", "/b", first, now).role) << "another target";
    EXPECT_EQ(access.http_caller("GET", "/a", first, now).role, Role::op);
    const auto again = access.http_caller("GET", "/a", first, now);
    EXPECT_TRUE(!again.role && again.is_stale) << "replayed: its sender, if he it is, may come with a new nonce";
    EXPECT_EQ(access.http_caller("GET", "/a", answer_to(challenge, "otto", "password-of-otto", 2), now).role, Role::op)
        << "the next message counts on";
    EXPECT_NE(access.http_challenge(now), access.http_challenge(now + 1)) << "no two clients share a nonce";
}

TEST(OnvifDigest, Sha256IsUnderstoodAndOtherAlgorithmsAreNot) {
    Authentication access("", three);
    std::string answer = answer_to(access.http_challenge(now), "ann", "password-of-ann", 1, "SHA-256");
    EXPECT_EQ(access.http_caller("GET", "/a", answer, now).role, Role::administrator);
    answer = answer_to(access.http_challenge(now), "ann", "password-of-ann", 2);
    answer.replace(answer.find("=MD5"), 4, "=MD5-sess");
    EXPECT_FALSE(access.http_caller("GET", "/a", answer, now).role);
}

TEST(OnvifDigest, HashesThatOpenSslForbidsRefuseAndDoNotEndTheRig) {
    Authentication access("", three);
    const std::string answer = answer_to(access.http_challenge(now), "ann", "password-of-ann");
    EXPECT_THAT(access.http_challenge(now), HasSubstr("algorithm=MD5"));
    // No provider of this process has this property, so nothing can be hashed.
    ASSERT_EQ(EVP_set_default_properties(nullptr, "provider=nobody"), 1);
    EXPECT_FALSE(access.http_caller("GET", "/a", answer, now).role);
    EXPECT_FALSE(access.http_caller("GET", "/a", "Digest response=\"\", nonce=\"\"", now).role);
    EXPECT_THAT(access.http_challenge(now), HasSubstr("algorithm=SHA-256"));
    EXPECT_FALSE(access.role_of({.name = "ann",
                                 .password = "tuOSpGlFlIXsozq4HFNeeGeFLEI=",
                                 .nonce = "LKqI6G/AikKCQrN0zqZFlg==",
                                 .created = "2027-01-15T08:00:00Z",
                                 .is_digest = true},
                                now));
    ASSERT_EQ(EVP_set_default_properties(nullptr, ""), 1);
    EXPECT_TRUE(access.http_caller("GET", "/a", answer, now).role);
}

class OnvifUsersFile : public testing::Test {
protected:
    Result<std::vector<User>> read(const std::string& text,
                                   std::filesystem::perms mode = std::filesystem::perms::owner_read) const {
        std::filesystem::remove(file);
        std::ofstream(file) << text;
        std::filesystem::permissions(file, mode);
        return read_users_file(file);
    }
    std::string refusal(const std::string& text) const {
        const auto users = read(text);
        return users ? "" : users.error().message;
    }
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / "onvif-users";
};

TEST_F(OnvifUsersFile, HasAUserALine) {
    const auto users =
        read("# who may\n\nann  administrator\tpass word 1 \r\nute user password\notto operator #pass#word");
    ASSERT_TRUE(users) << users.error().message;
    ASSERT_EQ(users->size(), 3U);
    EXPECT_EQ((*users)[0].name, "ann");
    EXPECT_EQ((*users)[0].password, "pass word 1");
    EXPECT_EQ((*users)[1].role, Role::user);
    EXPECT_EQ((*users)[2].role, Role::op);
    EXPECT_EQ((*users)[2].password, "#pass#word");
}

TEST_F(OnvifUsersFile, IsItsOwnersAlone) {
    using std::filesystem::perms;
    for (const perms others : {perms::group_read, perms::group_write, perms::others_read, perms::others_write}) {
        const auto users = read("ute user password\n", perms::owner_read | others);
        ASSERT_FALSE(users);
        EXPECT_THAT(users.error().message, HasSubstr("chmod 600"));
    }
    std::filesystem::remove(file);
    EXPECT_THAT(read_users_file(file).error().message, HasSubstr("cannot be read: No such file"));
    EXPECT_THAT(read_users_file(testing::TempDir()).error().message, HasSubstr("is no file"));
}

TEST_F(OnvifUsersFile, SaysWhichLineIsWrong) {
    EXPECT_THAT(refusal("ute user password\nann admin password\n"), HasSubstr("onvif-users:2: after the name"));
    EXPECT_THAT(refusal("ute\n"), HasSubstr("onvif-users:1: after the name"));
    EXPECT_THAT(refusal("u\"te user password\n"), HasSubstr("onvif-users:1: a name is"));
    EXPECT_THAT(refusal("\n" + std::string(65, 'u') + " user password\n"), HasSubstr("onvif-users:2: a name is"));
    EXPECT_EQ(refusal(std::string(64, 'u') + " user " + std::string(128, 'p')), "");
    EXPECT_EQ(refusal("ute user eight-88\n"), "");
    for (const std::string& bad :
         {std::string("short"), std::string(129, 'p'), std::string("pass\x01word"), std::string("")})
        EXPECT_THAT(refusal("ute user " + bad + "\n"), HasSubstr("onvif-users:1: after the role")) << bad;
    EXPECT_THAT(refusal("ute user password\nute operator password\n"),
                HasSubstr("onvif-users:2: the user ute is there twice"));
    EXPECT_THAT(refusal("# nobody\n"), HasSubstr("holds no user"));
    EXPECT_THAT(refusal(std::string(65 * 1024, '#')), HasSubstr("larger than 64 KiB"));
    std::string many;
    for (std::size_t i = 0; i < max_users; ++i) many += "u" + std::to_string(i) + " user password\n";
    EXPECT_EQ(refusal(many), "");
    EXPECT_THAT(refusal(many + "one-more user password\n"), HasSubstr("onvif-users:65: there are more than 64"));
}

TEST(OnvifAccess, ClassesAreForWhomTheDefaultPolicyOfTheStandardHasThem) {
    const std::pair<Access, Role> policy[] = {{Access::read_system, Role::user},
                                              {Access::read_media, Role::user},
                                              {Access::actuate, Role::op},
                                              {Access::read_system_sensitive, Role::op},
                                              {Access::write_system, Role::administrator},
                                              {Access::read_system_secret, Role::administrator},
                                              {Access::unrecoverable, Role::administrator}};
    for (const auto& [access, least] : policy) EXPECT_EQ(least_role(access), least) << static_cast<int>(access);
}

TEST(OnvifAccess, OperationsThatChangeSomethingAreOfAClassThatDoes) {
    std::size_t changes = 0;
    for (const Service& service : {device_service(), media_service(), media2_service(), ptz_service(),
                                   imaging_service(), event_service(), subscription_service()})
        for (const Operation& one : service.operations) {
            // Of a client's own subscription or stream; nothing that others see.
            if (one.name == "SetSynchronizationPoint" || one.name == "CreatePullPointSubscription") continue;
            const bool names_change = std::ranges::any_of(
                std::initializer_list<std::string_view>{"Set", "Create", "Delete", "Remove", "Goto", "Stop", "Absolute",
                                                        "Relative", "Continuous", "Add", "Start", "Send"},
                [&](std::string_view begin) { return one.name.starts_with(begin); });
            EXPECT_EQ(is_change(one.access), names_change) << one.name;
            changes += names_change;
        }
    EXPECT_GE(changes, 14U);
}

class OnvifRoles : public testing::Test {
protected:
    OnvifRoles() {
        world::CameraPatch patch;
        patch.change([](world::CameraSpec& spec) { spec.ptz = camera::ptz_preset(camera::PtzPreset::ideal); });
        rig.post(
            engine::Request<engine::CreateCamera>{{"dome", {}, patch}, [](const auto& made) { ASSERT_TRUE(made); }});
        service = std::make_unique<OnvifService>(rig, rig, OnvifService::Options{.users = three});
    }
    OnvifReply ask(const std::string& body, const std::string& header, std::optional<Role> by_http = {}) {
        std::promise<OnvifReply> answer;
        service->handle({"dome", "10.0.0.9:81", "/onvif/device_service", by_http,
                         "<x:Envelope xmlns:x=\"http://www.w3.org/2003/05/soap-envelope\" "
                         "xmlns:a=\"http://www.onvif.org/ver10/device/wsdl\" "
                         "xmlns:b=\"http://www.onvif.org/ver20/ptz/wsdl\"><x:Header>" +
                             header + "</x:Header><x:Body>" + body + "</x:Body></x:Envelope>"},
                        [&answer](OnvifReply reply) { answer.set_value(std::move(reply)); });
        return answer.get_future().get();
    }
    OnvifReply as(const User& user, const std::string& body) {
        return ask(body, "<Security><UsernameToken><Username>" + user.name + "</Username><Password>" + user.password +
                             "</Password></UsernameToken></Security>");
    }
    control::FakeRig rig;
    std::unique_ptr<OnvifService> service;
};

TEST_F(OnvifRoles, AreHeldToWhetherSoapOrHttpTellsWhoAsks) {
    const auto of_dome = [](const std::string& name) {
        return "<b:" + name + "><b:ProfileToken>dome</b:ProfileToken></b:" + name + ">";
    };
    const std::pair<std::string, std::optional<Role>> table[] = {{"<a:GetSystemDateAndTime/>", std::nullopt},
                                                                 {"<a:GetCapabilities/>", std::nullopt},
                                                                 {"<a:GetDeviceInformation/>", Role::user},
                                                                 {of_dome("GetStatus"), Role::user},
                                                                 {of_dome("Stop"), Role::op},
                                                                 {of_dome("GotoHomePosition"), Role::op},
                                                                 {"<a:GetUsers/>", Role::administrator}};
    for (const auto& [operation, least] : table) {
        EXPECT_EQ(ask(operation, "").status, least ? 401 : 200) << operation;
        for (const User& user : three) {
            const int status = !least || user.role >= *least ? 200 : 400;
            EXPECT_EQ(as(user, operation).status, status) << operation << " of " << user.name;
            EXPECT_EQ(ask(operation, "", user.role).status, status) << operation << " of " << user.name;
        }
    }
    const OnvifReply refused = as(three[2], of_dome("Stop"));
    EXPECT_THAT(refused.text, HasSubstr("not Authorized: this user's role does not allow it"));
    EXPECT_FALSE(refused.is_refused) << "the password is right";
}

TEST_F(OnvifRoles, UsersAreListedWithoutPasswordsAndAreThoseOfTheFile) {
    const std::string users = as(three[0], "<a:GetUsers/>").text;
    EXPECT_THAT(users, HasSubstr("<tt:Username>otto</tt:Username><tt:UserLevel>Operator</tt:UserLevel>"));
    EXPECT_THAT(users, HasSubstr("<tt:Username>ann</tt:Username><tt:UserLevel>Administrator</tt:UserLevel>"));
    EXPECT_THAT(users, Not(HasSubstr("password-of")));
    for (const auto& [operation, fault] : {std::pair{"<a:CreateUsers/>", "ter:TooManyUsers"},
                                           {"<a:SetUser/>", "ter:FixedUser"},
                                           {"<a:DeleteUsers/>", "ter:FixedUser"}}) {
        const OnvifReply refused = as(three[0], operation);
        EXPECT_THAT(refused.text, HasSubstr(fault)) << operation;
        EXPECT_THAT(refused.text, HasSubstr("--onvif-users"));
        EXPECT_THAT(as(three[1], operation).text, HasSubstr("not Authorized"));
    }
}

}  // namespace
}  // namespace camrig::onvif
