// SPDX-License-Identifier: BSD-3-Clause
#include "hw/standin/endpoint.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "core/base/error.h"

namespace panoptes::hw {
namespace {

constexpr int kDataBits = 8;
constexpr int kBits = kDataBits + 2;
constexpr int kGoneAfter_ms = 5000;  // a client that takes nothing for so long has lost its cable

constexpr std::array<std::pair<speed_t, int>, 9> kSpeeds = {{{B1200, 1200},
                                                             {B2400, 2400},
                                                             {B4800, 4800},
                                                             {B9600, 9600},
                                                             {B19200, 19200},
                                                             {B38400, 38400},
                                                             {B57600, 57600},
                                                             {B115200, 115200},
                                                             {B230400, 230400}}};

std::string reason() { return std::strerror(errno); }

bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

Bytes misread(std::span<const std::uint8_t> bytes, int sent_baud, int read_baud) {
  if (sent_baud == read_baud) {
    return {bytes.begin(), bytes.end()};
  }
  std::vector<bool> line;  // a bit of the sender's each; idle is high
  for (const std::uint8_t byte : bytes) {
    line.push_back(false);
    for (int bit = 0; bit < kDataBits; ++bit) {
      line.push_back((byte >> bit & 1) != 0);
    }
    line.push_back(true);
  }
  const double sent_bits_per_bit = static_cast<double>(sent_baud) / read_baud;
  const auto level = [&line](double at) {
    const auto bit = static_cast<std::size_t>(at);
    return bit >= line.size() || line[bit];
  };
  Bytes heard;
  double at = 0;  // in the sender's bits
  while (true) {
    while (at < static_cast<double>(line.size()) && level(at)) {
      at = std::floor(at) + 1;
    }
    if (at >= static_cast<double>(line.size())) {
      return heard;
    }
    unsigned byte = 0;
    for (int bit = 0; bit < kDataBits; ++bit) {
      byte |= level(at + (1.5 + bit) * sent_bits_per_bit) ? 1U << bit : 0U;
    }
    heard.push_back(static_cast<std::uint8_t>(byte));
    at += (kBits - 0.5) * sent_bits_per_bit;  // the middle of the stop bit
  }
}

PtyEndpoint::PtyEndpoint(std::string link) {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0) {
    const std::string why = reason();
    ::close(master_);
    throw DeviceError("pty: none can be had: " + why + "; serve on TCP, by --port");
  }
  std::array<char, 128> path{};
  ::ptsname_r(master_, path.data(), path.size());
  termios settings{};
  ::tcgetattr(master_, &settings);
  ::cfmakeraw(&settings);
  ::cfsetspeed(&settings, B9600);
  ::tcsetattr(master_, TCSANOW, &settings);
  // Opened and closed once it tells whether somebody holds it.
  ::close(::open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  name_ = std::string("serial:") + path.data();
  if (link.empty()) {
    return;
  }
  std::error_code error;
  if (std::filesystem::is_symlink(link, error)) {
    std::filesystem::remove(link, error);
  }
  std::filesystem::create_symlink(path.data(), link, error);
  if (error) {
    ::close(master_);
    throw DeviceError(link + ": cannot lead to " + path.data() + ": " + error.message() +
                      "; name another path by --link");
  }
  link_ = std::move(link);
  name_ = "serial:" + link_;
}

PtyEndpoint::~PtyEndpoint() {
  std::error_code ignored;
  if (!link_.empty()) {
    std::filesystem::remove(link_, ignored);
  }
  ::close(master_);
}

bool PtyEndpoint::connected() const {
  pollfd state{master_, 0, 0};
  return ::poll(&state, 1, 0) == 0;  // hung up while nobody holds it
}

std::optional<int> PtyEndpoint::client_baud() const {
  termios settings{};
  if (::tcgetattr(master_, &settings) == 0) {
    for (const auto& [speed, baud] : kSpeeds) {
      if (::cfgetospeed(&settings) == speed) {
        return baud;
      }
    }
  }
  return std::nullopt;
}

Bytes PtyEndpoint::read() {
  Bytes all;
  std::array<std::uint8_t, 4096> some{};
  for (ssize_t got = 0; (got = ::read(master_, some.data(), some.size())) > 0;) {
    all.insert(all.end(), some.begin(), some.begin() + got);
  }
  return all;
}

void PtyEndpoint::write(std::span<const std::uint8_t> bytes) {
  if (connected()) {
    // What is not taken is lost: a wire waits for nobody.
    [[maybe_unused]] const ssize_t taken = ::write(master_, bytes.data(), bytes.size());
  }
}

TcpEndpoint::TcpEndpoint(const std::string& host, int port) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  name_ = "tcp:" + host + ":" + std::to_string(port);
  if (const int fault = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found);
      fault != 0) {
    throw DeviceError(name_ + ": " + ::gai_strerror(fault) +
                      "; give --host an address of this machine");
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> free_found(found, ::freeaddrinfo);
  listener_ =
      ::socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, found->ai_protocol);
  const int yes = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (listener_ < 0 || ::bind(listener_, found->ai_addr, found->ai_addrlen) != 0 ||
      ::listen(listener_, 4) != 0) {
    const int error = errno;
    ::close(listener_);
    throw DeviceError(name_ + ": " + std::strerror(error) +
                      (error == EADDRINUSE ? "; stop what listens there, or give another --port"
                       : error == EACCES   ? "; give a --port over 1023"
                                           : "; give --host an address of this machine"));
  }
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  ::getsockname(listener_, reinterpret_cast<sockaddr*>(&bound), &size);
  std::array<char, NI_MAXSERV> service{};
  ::getnameinfo(reinterpret_cast<const sockaddr*>(&bound), size, nullptr, 0, service.data(),
                service.size(), NI_NUMERICSERV);
  port_ = std::atoi(service.data());
  name_ = "tcp:" + host + ":" + std::to_string(port_);
}

TcpEndpoint::~TcpEndpoint() {
  part();
  ::close(listener_);
}

void TcpEndpoint::part() {
  if (client_ >= 0) {
    ::close(client_);
    client_ = -1;
  }
}

void TcpEndpoint::greet() {
  int comes = -1;
  while ((comes = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0) {
    if (client_ >= 0) {
      ::close(comes);
      continue;
    }
    client_ = comes;
    const int yes = 1;
    ::setsockopt(client_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    ::setsockopt(client_, IPPROTO_TCP, TCP_USER_TIMEOUT, &kGoneAfter_ms, sizeof kGoneAfter_ms);
  }
}

Bytes TcpEndpoint::read() {
  Bytes all;
  std::array<std::uint8_t, 4096> some{};
  while (client_ >= 0) {
    const ssize_t got = ::recv(client_, some.data(), some.size(), 0);
    if (got <= 0) {
      if (got == 0 || !would_block()) {
        part();
      }
      break;
    }
    all.insert(all.end(), some.begin(), some.begin() + got);
  }
  greet();
  return all;
}

void TcpEndpoint::write(std::span<const std::uint8_t> bytes) {
  if (client_ >= 0 && ::send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0 &&
      !would_block()) {
    part();
  }
}

}  // namespace panoptes::hw
