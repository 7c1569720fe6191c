// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/line.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "hw/pioneer/port_access.h"

namespace panoptes::hw {
namespace {

constexpr std::string_view kSerial = "serial:";
constexpr std::string_view kTcp = "tcp:";

speed_t speed_of(int baud) {
  switch (baud) {
    case 9600:
      return B9600;
    case 19200:
      return B19200;
    case 38400:
      return B38400;
    case 57600:
      return B57600;
    case 115200:
      return B115200;
    default:
      PANOPTES_CHECK(false, "a Pioneer has this baud");
      return B0;
  }
}

// Who else has the port, as a fault with its cure; empty where nobody is seen. Root may open what
// another has taken for itself alone.
std::string held_by(int fd, const std::string& path) {
  int exclusive = 0;
  std::error_code error;
  const std::string holder = port_holder(std::filesystem::canonical(path, error).string());
  if (flock(fd, LOCK_EX | LOCK_NB) != 0 ||
      (ioctl(fd, TIOCGEXCL, &exclusive) == 0 && exclusive != 0)) {
    return "in use by another program" + (holder.empty() ? "" : ", " + holder) + "; close that one";
  }
  return holder.empty() ? ""
                        : "perhaps held by another program: " + holder +
                              " has it open, and would take what the robot answers; close that one";
}

int open_serial(const std::string& address, const std::string& path) {
  const int fd = open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  const int error = errno;
  if (fd < 0 && (error == ENOENT || error == ENXIO || error == ENODEV)) {
    throw DeviceError(address +
                      ": no such port; is the cable plugged in? 'panoptes doctor' lists "
                      "the ports that are here");
  }
  if (fd < 0 && (error == EACCES || error == EPERM)) {
    throw DeviceError(address + ": no permission to open it; " +
                      access_cure(access_of(path, path)));
  }
  if (fd < 0 && error == EBUSY) {
    throw DeviceError(address + ": in use by another program; close that one");
  }
  if (fd < 0) {
    throw DeviceError(address + ": cannot be opened: " + std::strerror(error));
  }
  termios settings = {};
  std::string fault;
  if (tcgetattr(fd, &settings) != 0) {
    fault = "not a serial port; name one, such as serial:/dev/ttyUSB0";
  } else if (const std::string by = held_by(fd, path); !by.empty()) {
    fault = by;  // what it waits for is not taken from it
  } else {
    cfmakeraw(&settings);
    // It leaves what others may have set: a host that sends XOFF when it reads late, say.
    settings.c_iflag &= ~static_cast<tcflag_t>(IXOFF | IXANY | INPCK | IGNPAR);
    settings.c_cflag |= CLOCAL | CREAD;
    settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
    cfsetspeed(&settings, B9600);
    if (tcsetattr(fd, TCSANOW, &settings) != 0) {
      fault = std::string("cannot be set to 9600 baud: ") + std::strerror(errno);
    }
  }
  if (!fault.empty()) {
    close(fd);
    throw DeviceError(address + ": " + fault);
  }
  ioctl(fd, TIOCEXCL);
  tcflush(fd, TCIOFLUSH);
  return fd;
}

int open_tcp(const std::string& address, const LineAddress& to, Duration at_most) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(to.path.c_str(), to.port.c_str(), &hints, &found); error != 0) {
    throw DeviceError(address + ": the host " + to.path + " is not known (" + gai_strerror(error) +
                      "); check its name and the network");
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> all(found, freeaddrinfo);
  std::string fault = "has no address";
  for (const addrinfo* one = all.get(); one != nullptr; one = one->ai_next) {
    const int fd = socket(one->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) {
      fault = std::strerror(errno);
      continue;
    }
    int error = connect(fd, one->ai_addr, one->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
      pollfd waited{fd, POLLOUT, 0};
      const int ready = poll(&waited, 1, static_cast<int>(at_most / std::chrono::milliseconds(1)));
      socklen_t size = sizeof error;
      if (ready <= 0) {
        error = ETIMEDOUT;
      } else {
        getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
      }
    }
    if (error == 0) {
      const int on = 1;
      setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      return fd;
    }
    close(fd);
    fault = error == ECONNREFUSED
                ? "the host refuses: nothing listens there; start 'panoptes serve MISSION', the "
                  "simulator or the robot's serial server first, or correct the port"
            : error == ETIMEDOUT ? "the host does not answer; check the network and the address"
                                 : std::string("cannot be reached: ") + std::strerror(error);
  }
  throw DeviceError(address + ": " + fault);
}

}  // namespace

std::string LineAddress::fault(const std::string& address) {
  constexpr const char* kForms =
      "must be serial:PORT, such as serial:/dev/ttyUSB0, or tcp:HOST:PORT, such as "
      "tcp:192.168.1.5:8101";
  if (address.starts_with(kSerial)) {
    return address.size() > kSerial.size() ? "" : kForms;
  }
  const auto colon = address.rfind(':');
  if (!address.starts_with(kTcp) || colon <= kTcp.size() || colon + 1 == address.size()) {
    return kForms;
  }
  const std::string port = address.substr(colon + 1);
  const bool digits = port.find_first_not_of("0123456789") == std::string::npos;
  return digits && port.size() <= 5 && std::stoi(port) >= 1 && std::stoi(port) <= 65535
             ? ""
             : "its port must be a number between 1 and 65535";
}

LineAddress LineAddress::parse(const std::string& address) {
  PANOPTES_CHECK(fault(address).empty(), "the address is one");
  if (address.starts_with(kSerial)) {
    return {true, address.substr(kSerial.size()), ""};
  }
  const auto colon = address.rfind(':');
  return {false, address.substr(kTcp.size(), colon - kTcp.size()), address.substr(colon + 1)};
}

Line::Line(const std::string& address, Duration at_most) : address_(address) {
  if (const std::string fault = LineAddress::fault(address); !fault.empty()) {
    throw DeviceError(address + ": " + fault);
  }
  const LineAddress to = LineAddress::parse(address);
  serial_ = to.serial;
  fd_ = to.serial ? open_serial(address, to.path) : open_tcp(address, to, at_most);
}

Line::~Line() {
  if (serial_) {
    ioctl(fd_, TIOCNXCL);
  }
  close(fd_);
}

void Line::set_baud(int baud) {
  termios settings = {};
  if (tcgetattr(fd_, &settings) != 0) {
    throw DeviceError(address_ + ": the port has gone: the cable is out");
  }
  cfsetspeed(&settings, speed_of(baud));
  if (tcsetattr(fd_, TCSADRAIN, &settings) != 0) {
    throw DeviceError(address_ + ": cannot be set to " + std::to_string(baud) +
                      " baud: " + std::strerror(errno));
  }
  tcflush(fd_, TCIFLUSH);
}

Bytes Line::read() {
  Bytes bytes;
  std::array<std::uint8_t, 4096> chunk;
  while (true) {
    const ssize_t count = ::read(fd_, chunk.data(), chunk.size());
    if (count > 0) {
      bytes.insert(bytes.end(), chunk.begin(), chunk.begin() + count);
      continue;
    }
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      return bytes;
    }
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (!bytes.empty()) {  // the end is told the next time
      return bytes;
    }
    if (count == 0 && serial_) {  // a port in raw mode says so when nothing is there
      pollfd state{fd_, POLLIN, 0};
      if (::poll(&state, 1, 0) == 0 || (state.revents & (POLLHUP | POLLERR | POLLNVAL)) == 0) {
        return bytes;
      }
    }
    throw DeviceError(address_ + (serial_ ? ": the port has gone: the cable is out"
                                          : ": the robot's side has closed the connection"));
  }
}

void Line::write(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = serial_ ? ::write(fd_, bytes.data(), bytes.size())
                                  : send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      return;
    }
    if (count < 0) {
      throw DeviceError(address_ + ": cannot be written to (" + std::strerror(errno) +
                        "): the cable is out, or the robot's side has closed");
    }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

}  // namespace panoptes::hw
