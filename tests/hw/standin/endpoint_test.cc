// SPDX-License-Identifier: BSD-3-Clause
#include "hw/standin/endpoint.h"

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "core/base/error.h"
#include "tests/support/scratch.h"

namespace panoptes::hw {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

/// The kernel hands bytes on by itself, but not at once.
bool soon(const std::function<bool()>& happens) {
  for (int i = 0; i < 2000 && !happens(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return happens();
}

Bytes read_soon(Endpoint& endpoint, std::size_t count) {
  Bytes all;
  soon([&] {
    const Bytes some = endpoint.read();
    all.insert(all.end(), some.begin(), some.end());
    return all.size() >= count;
  });
  return all;
}

Bytes take(int descriptor, std::size_t count) {
  Bytes all(count);
  std::size_t got = 0;
  soon([&] {
    const ssize_t some = ::read(descriptor, all.data() + got, count - got);
    got += some > 0 ? static_cast<std::size_t>(some) : 0;
    return got == count;
  });
  all.resize(got);
  return all;
}

std::string refusal(const std::function<void()>& what) {
  try {
    what();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "nothing refused";
}

Bytes any_bytes() {
  Bytes all;
  for (int i = 0; i < 256; ++i) {
    all.push_back(static_cast<std::uint8_t>(i));
  }
  return all;
}

int connect_to(int port) {
  const int client = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(static_cast<std::uint16_t>(port));
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(client, reinterpret_cast<const sockaddr*>(&there), sizeof there), 0);
  ::fcntl(client, F_SETFL, O_NONBLOCK);
  return client;
}

class EndpointTest : public ScratchTest {};

TEST_F(EndpointTest, APtyCarriesAnyByteBothWays) {
  PtyEndpoint pty;
  ASSERT_THAT(pty.name(), testing::StartsWith("serial:/dev/"));
  EXPECT_FALSE(pty.connected());
  EXPECT_EQ(pty.fd(), -1);
  pty.write(any_bytes());  // nobody is there
  const int client = ::open(pty.name().substr(7).c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  ASSERT_GE(client, 0);
  EXPECT_TRUE(pty.connected());
  const Bytes bytes = any_bytes();
  ASSERT_EQ(::write(client, bytes.data(), bytes.size()), 256);
  EXPECT_EQ(read_soon(pty, 256), bytes);
  pty.write(bytes);
  EXPECT_EQ(take(client, 256), bytes);
  ::close(client);
  EXPECT_TRUE(soon([&] { return !pty.connected(); }));
}

TEST_F(EndpointTest, APtyKnowsTheBaudOfItsClient) {
  PtyEndpoint pty;
  EXPECT_EQ(pty.client_baud(), 9600);
  const int client = ::open(pty.name().substr(7).c_str(), O_RDWR | O_NOCTTY);
  termios settings{};
  ASSERT_EQ(::tcgetattr(client, &settings), 0);
  ::cfsetspeed(&settings, B38400);
  ASSERT_EQ(::tcsetattr(client, TCSANOW, &settings), 0);
  EXPECT_EQ(pty.client_baud(), 38400);
  ::close(client);
}

TEST_F(EndpointTest, ALinkLeadsToThePtyWhileItLives) {
  const fs::path link = folder_ / "pioneer";
  fs::create_directories(folder_);
  fs::create_symlink("/dev/pts/none", link);  // of one that was killed
  {
    const PtyEndpoint pty(link.string());
    EXPECT_EQ(pty.name(), "serial:" + link.string());
    const int client = ::open(link.c_str(), O_RDWR | O_NOCTTY);
    EXPECT_GE(client, 0);
    ::close(client);
  }
  EXPECT_FALSE(fs::is_symlink(link));
  EXPECT_THAT(refusal([&] { const PtyEndpoint pty(folder_.string()); }),
              HasSubstr("name another path by --link"));
}

TEST_F(EndpointTest, ATcpPortServesOneClientAtATime) {
  TcpEndpoint tcp("127.0.0.1", 0);
  EXPECT_EQ(tcp.name(), "tcp:127.0.0.1:" + std::to_string(tcp.port()));
  EXPECT_FALSE(tcp.connected());
  const int first = connect_to(tcp.port());
  EXPECT_TRUE(soon([&] { return tcp.read().empty() && tcp.connected(); }));
  const int second = connect_to(tcp.port());
  const Bytes bytes = any_bytes();
  ASSERT_EQ(::write(first, bytes.data(), bytes.size()), 256);
  EXPECT_EQ(read_soon(tcp, 256), bytes);
  tcp.write(bytes);
  EXPECT_EQ(take(first, 256), bytes);
  char byte = 0;
  EXPECT_TRUE(soon([&] {
    tcp.read();
    return ::read(second, &byte, 1) == 0;
  }));
  ::close(second);
  ::close(first);
  EXPECT_TRUE(soon([&] { return tcp.read().empty() && !tcp.connected(); }));
  const int third = connect_to(tcp.port());
  EXPECT_TRUE(soon([&] { return tcp.read().empty() && tcp.connected(); }));
  ::close(third);
}

TEST_F(EndpointTest, APortThatCannotBeHadIsRefusedWithTheCure) {
  const TcpEndpoint first("127.0.0.1", 0);
  const std::string port = std::to_string(first.port());
  EXPECT_EQ(refusal([&] { const TcpEndpoint again("127.0.0.1", first.port()); }),
            "tcp:127.0.0.1:" + port +
                ": Address already in use; stop what listens there, or give another --port");
  EXPECT_THAT(refusal([] { const TcpEndpoint far("192.0.2.1", 0); }),
              HasSubstr("tcp:192.0.2.1:0: Cannot assign requested address; give --host an address "
                        "of this machine"));
  EXPECT_THAT(refusal([] { const TcpEndpoint nowhere("no host", 0); }),
              HasSubstr("give --host an address of this machine"));
}

TEST(Misread, AtTheSameBaudIsTheSameAndElseGarbage) {
  const Bytes bytes = any_bytes();
  EXPECT_EQ(misread(bytes, 9600, 9600), bytes);
  // Each sent bit is four read ones: start and the first bit fill one byte, 0 up to it.
  EXPECT_EQ(misread(Bytes{0xFF}, 9600, 38400), Bytes{0xF8});
  // Four sent bits are one: of one byte alone what comes first is the start of one with its low
  // bits, the line idle after it.
  EXPECT_EQ(misread(Bytes{0x00}, 38400, 9600), Bytes{0xFE});
  for (const int baud : {19200, 38400, 57600, 115200}) {
    EXPECT_NE(misread(bytes, 9600, baud), bytes);
    EXPECT_NE(misread(bytes, baud, 9600), bytes);
    EXPECT_THAT(misread({}, 9600, baud), IsEmpty());
  }
}

}  // namespace
}  // namespace panoptes::hw
