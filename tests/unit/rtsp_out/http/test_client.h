#pragma once

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>

#include "core/base/unique_fd.h"

namespace camrig::http {

/// A plain blocking HTTP client that sees every byte. Reads give up after ten seconds.
class TestClient {
public:
    struct Reply {
        int status = 0;
        std::map<std::string, std::string> fields;
        std::string body;
    };

    explicit TestClient(std::uint16_t port, int receive_buffer = 0) : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
        const timeval limit{10, 0};
        ::setsockopt(fd_.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
        if (receive_buffer > 0) ::setsockopt(fd_.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(fd_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    }

    void send(std::string_view text) {
        while (!text.empty()) {
            const auto sent = ::send(fd_.get(), text.data(), text.size(), MSG_NOSIGNAL);
            if (sent <= 0) return;
            text.remove_prefix(static_cast<std::size_t>(sent));
        }
    }
    void get(std::string_view target, std::string_view fields = {}) {
        send("GET " + std::string(target) + " HTTP/1.1\r\nHost: localhost\r\n" + std::string(fields) + "\r\n");
    }

    /// Everything up to and including `end`; what came before the connection closed if it never comes.
    std::string read_until(std::string_view end) {
        std::size_t at;
        while ((at = kept_.find(end)) == std::string::npos)
            if (!receive()) return std::exchange(kept_, {});
        return take(at + end.size());
    }
    std::string read_line() {
        std::string line = read_until("\r\n");
        if (line.ends_with("\r\n")) line.resize(line.size() - 2);
        return line;
    }
    std::string read_exactly(std::size_t size) {
        while (kept_.size() < size)
            if (!receive()) break;
        return take(std::min(size, kept_.size()));
    }
    std::string read_to_end() {
        while (receive()) {
        }
        return take(kept_.size());
    }
    /// True when the server closed the connection and nothing is left to read.
    bool at_end() { return kept_.empty() && !receive() && closed_; }

    Reply read_head() {
        Reply reply;
        const std::string status = read_line();
        if (status.size() > 12) reply.status = std::stoi(status.substr(9, 3));
        for (std::string line = read_line(); !line.empty(); line = read_line()) {
            const std::size_t colon = line.find(": ");
            if (colon == std::string::npos) {
                ADD_FAILURE() << "header line: " << line;
                break;
            }
            reply.fields[line.substr(0, colon)] = line.substr(colon + 2);
        }
        return reply;
    }
    Reply read_reply() {
        Reply reply = read_head();
        if (reply.fields.contains("Content-Length"))
            reply.body = read_exactly(std::stoul(reply.fields["Content-Length"]));
        return reply;
    }
    /// One part of a stream, read by ffmpeg's rules: a line that starts with "--", fields, an empty line,
    /// Content-Length bytes. The line end after the picture belongs to the next boundary.
    Reply read_part() {
        Reply part;
        std::string line = read_line();
        if (line.empty()) line = read_line();
        if (!line.starts_with("--")) {
            ADD_FAILURE() << "boundary expected: " << line;
            return part;
        }
        for (line = read_line(); !line.empty(); line = read_line()) {
            EXPECT_LT(line.size(), 127U);
            const std::size_t colon = line.find(':');
            if (colon == std::string::npos) return part;
            part.fields[line.substr(0, colon)] = line.substr(colon + 2);
        }
        if (part.fields.contains("Content-Length")) part.body = read_exactly(std::stoul(part.fields["Content-Length"]));
        return part;
    }
    void close() { fd_.reset(); }
    int fd() const { return fd_.get(); }

private:
    bool receive() {
        char buffer[65536];
        const auto size = ::recv(fd_.get(), buffer, sizeof buffer, 0);
        closed_ = size == 0 || (size < 0 && errno == ECONNRESET);
        if (size <= 0) return false;
        kept_.append(buffer, static_cast<std::size_t>(size));
        return true;
    }
    std::string take(std::size_t size) {
        std::string taken = kept_.substr(0, size);
        kept_.erase(0, size);
        return taken;
    }

    UniqueFd fd_;
    std::string kept_;
    bool closed_ = false;
};

}  // namespace camrig::http
