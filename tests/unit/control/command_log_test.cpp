#include "control/rpc/command_log.h"

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace camrig::control {
namespace {

TEST(CommandLog, HasAPlaceThatIsWhatWasWritten) {
    const TemporaryFolder folder;
    const auto writer = CommandLogWriter::create(folder / "log").value();
    writer->begin({{"seed", 1}});
    writer->note(5, R"({"method":"world.pause","params":{}})", false);
    EXPECT_EQ(writer->place().value().bytes, std::filesystem::file_size(folder / "log"));
}

TEST(CommandLog, ThatHasEndedIsNothingToSaveAWorldOf) {
    const auto writer = CommandLogWriter::create("/dev/full").value();
    writer->begin({{"seed", 1}});
    const auto place = writer->place();
    ASSERT_FALSE(place);
    EXPECT_EQ(place.error().kind, ErrorKind::unavailable);
}

}  // namespace
}  // namespace camrig::control
