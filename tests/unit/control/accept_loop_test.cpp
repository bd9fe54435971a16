#include "control/server/accept_loop.h"

#include <new>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace camrig::control {
namespace {

using local = boost::asio::local::stream_protocol;

TEST(AcceptLoop, AConnectionThatThereIsNoMemoryForIsLostAndTheNextOneIsTaken) {
    const TemporaryFolder folder;
    const local::endpoint door((folder / "s").string());
    boost::asio::io_context loop;
    local::acceptor acceptor(loop, door);
    int taken = 0;
    const auto take = [&](const local::socket&) {
        if (++taken == 1) throw std::bad_alloc();
        acceptor.close();
    };
    boost::asio::co_spawn(loop, accept_loop(acceptor, "test", take), boost::asio::detached);
    local::socket first(loop), second(loop);
    first.connect(door);
    second.connect(door);
    loop.run_for(std::chrono::seconds(20));
    EXPECT_EQ(taken, 2);
}

}  // namespace
}  // namespace camrig::control
