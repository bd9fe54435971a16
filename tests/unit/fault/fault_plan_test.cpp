#include "core/fault/fault_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace camrig::fault {
namespace {

using testing::ElementsAre;

std::vector<std::uint64_t> ids_at(const FaultPlan& plan, TimeNs world_ns) {
    std::vector<std::uint64_t> ids;
    if (const auto faults = plan.at({0, world_ns}))
        for (const FaultRef& one : faults->active) ids.push_back(one->id);
    return ids;
}

TEST(FaultPlan, AFaultIsThereFromItsBeginUntilBeforeItsEnd) {
    FaultPlan plan;
    ASSERT_TRUE(plan.set({.kind = Black{}, .begin_ns = 100, .end_ns = 200}, 1, 0, 0));
    EXPECT_FALSE(plan.at({0, 99}));
    EXPECT_TRUE(plan.at({0, 100}));
    EXPECT_TRUE(plan.at({0, 199}));
    EXPECT_FALSE(plan.at({0, 200}));
}

TEST(FaultPlan, WithoutTimesItBeginsNowAndStaysUntilItIsCleared) {
    FaultPlan plan;
    const auto fault = plan.set({.kind = Freeze{}, .begin_ns = {}, .end_ns = {}}, 1, 0, 50);
    ASSERT_TRUE(fault);
    EXPECT_EQ((*fault)->begin_ns, 50);
    EXPECT_TRUE(plan.at({0, ns_per_s * 1'000'000}));
    EXPECT_EQ(plan.clear(80, [](const Fault&) { return true; }), 1U);
    EXPECT_TRUE(plan.at({0, 79}));
    EXPECT_FALSE(plan.at({0, 80}));
    EXPECT_EQ(plan.clear(90, [](const Fault&) { return true; }), 0U) << "it is over";
}

TEST(FaultPlan, FaultsActInTheOrderOfTheTableWhateverTheOrderInWhichTheyWereSet) {
    FaultPlan plan;
    ASSERT_TRUE(plan.set({.kind = Drop{}, .begin_ns = {}, .end_ns = {}}, 1, 0, 0));
    ASSERT_TRUE(plan.set({.kind = Freeze{}, .begin_ns = {}, .end_ns = {}}, 2, 0, 0));
    ASSERT_TRUE(plan.set({.kind = Black{}, .begin_ns = {}, .end_ns = {}}, 3, 0, 0));
    ASSERT_TRUE(plan.set({.kind = Freeze{}, .begin_ns = {}, .end_ns = {}}, 4, 0, 0));
    EXPECT_THAT(ids_at(plan, 0), ElementsAre(3, 2, 4, 1));
}

TEST(FaultPlan, TheTableGoesFromTheBodyToTheTransport) {
    for (std::size_t i = 1; i < fault_kinds().size(); ++i) {
        const nlohmann::json none = nlohmann::json::object();
        JsonReader before(none, ""), after(none, "");
        EXPECT_LE(layer_of(fault_kinds()[i - 1].read(before)), layer_of(fault_kinds()[i].read(after)))
            << fault_kinds()[i].description.name;
    }
}

TEST(FaultPlan, AtSeverity0ThereIsNothing) {
    FaultPlan plan;
    ASSERT_TRUE(plan.set({.kind = Black{}, .begin_ns = {}, .end_ns = {}, .severity = 0.0}, 1, 0, 0));
    EXPECT_FALSE(plan.at({0, 0}));
}

TEST(FaultPlan, RefusesWhatEndsBeforeItBeginsIsPastOrOneTooMany) {
    FaultPlan plan;
    EXPECT_EQ(plan.set({.kind = Black{}, .begin_ns = 200, .end_ns = 200}, 1, 0, 0).error().kind,
              ErrorKind::invalid_argument);
    EXPECT_EQ(plan.set({.kind = Black{}, .begin_ns = 0, .end_ns = 100}, 1, 0, 100).error().kind,
              ErrorKind::invalid_argument);
    for (std::size_t i = 0; i < FaultPlan::max_faults; ++i)
        ASSERT_TRUE(plan.set({.kind = Black{}, .begin_ns = {}, .end_ns = 1000}, i + 1, 0, 0));
    EXPECT_EQ(plan.set({.kind = Black{}, .begin_ns = {}, .end_ns = {}}, 99, 0, 0).error().kind,
              ErrorKind::resource_exhausted);
    EXPECT_TRUE(plan.set({.kind = Black{}, .begin_ns = {}, .end_ns = {}}, 99, 0, 1000 + FaultPlan::kept_ns))
        << "what is over makes room";
}

TEST(FaultPlan, WhatWasClearedMakesRoomAtOnceInAWorldThatStands) {
    FaultPlan plan;
    for (std::uint64_t id = 1; id <= 3 * FaultPlan::max_faults; ++id) {
        ASSERT_TRUE(plan.set({.kind = Black{}, .begin_ns = {}, .end_ns = {}}, id, 0, 0)) << id;
        ASSERT_EQ(plan.clear(0, [](const Fault&) { return true; }), 1u);
    }
    EXPECT_TRUE(plan.present(0).empty());
}

TEST(FaultPlan, ParametersAreWrittenAsTheyAreRead) {
    for (const auto& kind : fault_kinds()) {
        const nlohmann::json none = nlohmann::json::object();
        JsonReader reader(none, "");
        const FaultKind made = kind.read(reader);
        EXPECT_EQ(name_of(made), kind.description.name);
        const nlohmann::json params = params_of(made);
        EXPECT_EQ(params.size(), kind.description.fields.size()) << kind.description.name;
        JsonReader again(params, "");
        EXPECT_EQ(params_of(kind.read(again)), params);
        EXPECT_TRUE(again.finish());
    }
}

}  // namespace
}  // namespace camrig::fault
