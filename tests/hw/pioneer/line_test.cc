// SPDX-License-Identifier: BSD-3-Clause
// Lines over terminals and sockets of the machine itself. What addresses and ports can be wrong by
// is tested in tests/hw/standin/base_test.cc too.
#include "hw/pioneer/line.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include "core/base/error.h"
#include "tests/support/scratch.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;
using Clock = std::chrono::steady_clock;

constexpr Duration kAtMost = milliseconds(500);
constexpr int kAtOnce_ms = 500;  // however busy the machine is

/// An open file of the machine.
class File {
 public:
  explicit File(int fd = -1) : fd_(fd) {}
  ~File() { shut(); }
  File(File&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  File& operator=(File&&) = delete;
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  int fd() const { return fd_; }
  void shut() {
    if (fd_ >= 0) {
      ::close(fd_);
    }
    fd_ = -1;
  }
  void send(const Bytes& bytes) const {
    ASSERT_EQ(::write(fd_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  /// So many bytes; fewer where nothing has come for a while.
  Bytes take(std::size_t count_max, std::size_t at_once = 1 << 16) const {
    constexpr int kAWhile_ms = 50;
    Bytes all;
    Bytes some(at_once);
    pollfd state{fd_, POLLIN, 0};
    while (all.size() < count_max && ::poll(&state, 1, kAWhile_ms) > 0) {
      const ssize_t count = ::read(fd_, some.data(), some.size());
      if (count <= 0) {
        break;
      }
      all.insert(all.end(), some.begin(), some.begin() + count);
    }
    return all;
  }

 private:
  int fd_;
};

/// A terminal as another program may have left it: cooked, echoing, with flow control, and seven
/// bits to a byte.
class Pty {
 public:
  Pty() : master(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    EXPECT_EQ(grantpt(master.fd()), 0);
    EXPECT_EQ(unlockpt(master.fd()), 0);
    path = ptsname(master.fd());
    termios settings = this->settings();
    settings.c_iflag |= BRKINT | INPCK | IGNPAR | ISTRIP | ICRNL | IXON | IXOFF | IXANY;
    settings.c_oflag |= OPOST | ONLCR;
    settings.c_lflag |= ISIG | ICANON | IEXTEN | ECHO;
    settings.c_cflag |= CSTOPB | CRTSCTS;
    cfsetspeed(&settings, B115200);
    EXPECT_EQ(tcsetattr(master.fd(), TCSANOW, &settings), 0);
  }

  std::string address() const { return "serial:" + path; }
  File open() const { return File(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK)); }
  termios settings() const {
    termios now = {};
    EXPECT_EQ(tcgetattr(master.fd(), &now), 0);
    return now;
  }
  speed_t baud() const {
    const termios now = settings();
    EXPECT_EQ(cfgetispeed(&now), cfgetospeed(&now));
    return cfgetospeed(&now);
  }

  File master;
  std::string path;
};

/// Listens on the loopback interface.
class Listener {
 public:
  explicit Listener(int backlog = 4) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in here = {};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    EXPECT_EQ(::bind(socket_.fd(), reinterpret_cast<sockaddr*>(&here), size), 0);
    EXPECT_EQ(::listen(socket_.fd(), backlog), 0);
    EXPECT_EQ(::getsockname(socket_.fd(), reinterpret_cast<sockaddr*>(&here), &size), 0);
    there = here;
  }

  std::string address() const { return "tcp:127.0.0.1:" + std::to_string(ntohs(there.sin_port)); }
  File accept() const { return File(::accept(socket_.fd(), nullptr, nullptr)); }

  sockaddr_in there = {};

 private:
  File socket_;
};

/// Everybody's rights, for as long as it lives; root may open what nobody else may.
class AsNobody {
 public:
  AsNobody() : was_(geteuid()) {
    if (was_ == 0) {
      constexpr uid_t kNobody = 65534;
      EXPECT_EQ(seteuid(kNobody), 0);
    }
  }
  ~AsNobody() { EXPECT_EQ(seteuid(was_), 0); }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  uid_t was_;
};

Bytes every_byte() {
  Bytes all;
  for (int i = 0; i < 256; ++i) {
    all.push_back(static_cast<std::uint8_t>(i));
  }
  return all;
}

/// Longer than any buffer of the machine, and nowhere like itself.
Bytes long_message() {
  Bytes all;
  for (std::uint32_t i = 0; i < (4U << 20U); ++i) {
    all.push_back(static_cast<std::uint8_t>((i * 2654435761U) >> 24U));
  }
  return all;
}

bool soon(const std::function<bool()>& happens) {
  for (int i = 0; i < 2000; ++i) {
    if (happens()) {
      return true;
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  return false;
}

Bytes read_soon(Line& line, std::size_t count) {
  Bytes all;
  soon([&] {
    const Bytes some = line.read();
    all.insert(all.end(), some.begin(), some.end());
    return all.size() >= count;
  });
  return all;
}

std::string fault(const std::function<void()>& what) {
  try {
    what();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "no fault";
}

std::string fault_of(const std::string& address, Duration at_most = kAtMost) {
  return fault([&] { const Line line(address, at_most); });
}

/// What reading says in the end.
std::string fault_soon(Line& line) {
  std::string said;
  soon([&] {
    said = fault([&] { line.read(); });
    return said != "no fault";
  });
  return said;
}

int waiting_bytes(int fd) {
  int count = 0;
  EXPECT_EQ(ioctl(fd, FIONREAD, &count), 0);
  return count;
}

TEST(LineAddress, IsWhatStandsBehindItsKind) {
  const std::string by_path = "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0";
  const LineAddress serial = LineAddress::parse("serial:" + by_path);
  EXPECT_TRUE(serial.serial);
  EXPECT_EQ(serial.path, by_path);
  const LineAddress tcp = LineAddress::parse("tcp:robot.local:8101");
  EXPECT_FALSE(tcp.serial);
  EXPECT_EQ(tcp.path, "robot.local");
  EXPECT_EQ(tcp.port, "8101");
  const LineAddress six = LineAddress::parse("tcp:fe80::1:8101");
  EXPECT_EQ(six.path, "fe80::1");
  EXPECT_EQ(six.port, "8101");
  for (const char* none : {"", "serial:", "tcp:", "tcp::8101", "tcp:host:", "tcp:host:0",
                           "tcp:host:65536", "tcp:host:-1", "tcp:host:999999", "Serial:/dev/x"}) {
    EXPECT_NE(LineAddress::fault(none), "") << none;
  }
  EXPECT_EQ(LineAddress::fault("tcp:host:1"), "");
  EXPECT_EQ(LineAddress::fault("tcp:host:65535"), "");
}

TEST(SerialLine, CarriesEveryByteBothWaysUnchanged) {
  const Pty pty;
  Line line(pty.address(), kAtMost);
  EXPECT_TRUE(line.serial());
  EXPECT_EQ(line.address(), pty.address());
  const Bytes bytes = every_byte();
  pty.master.send(bytes);
  EXPECT_EQ(read_soon(line, bytes.size()), bytes);
  EXPECT_THAT(pty.master.take(1), IsEmpty());  // no echo
  line.write(bytes);
  EXPECT_EQ(pty.master.take(bytes.size()), bytes);
  // what a terminal takes for itself, alone and at the start
  for (const std::uint8_t special :
       {0x00, 0x03, 0x04, 0x0a, 0x0d, 0x11, 0x13, 0x1a, 0x1c, 0x7f, 0xff}) {
    pty.master.send({special});
    EXPECT_EQ(read_soon(line, 1), Bytes{special});
    line.write(Bytes{special});
    EXPECT_EQ(pty.master.take(1), Bytes{special});
  }
}

TEST(SerialLine, IsSetTo9600BaudAndEightBitsWithOneStopBit) {
  const Pty pty;
  const Line line(pty.address(), kAtMost);
  EXPECT_EQ(pty.baud(), speed_t{B9600});
  const termios settings = pty.settings();
  EXPECT_EQ(settings.c_cflag & CSIZE, tcflag_t{CS8});
  EXPECT_EQ(settings.c_cflag & (CSTOPB | PARENB | CRTSCTS), 0U);
  EXPECT_EQ(settings.c_iflag & (IXON | IXOFF | IXANY | INPCK | IGNPAR), 0U);
  EXPECT_NE(settings.c_cflag & CLOCAL, 0U);  // no carrier is waited for
  EXPECT_NE(settings.c_cflag & CREAD, 0U);
}

TEST(SerialLine, TakesEveryBaudOfAPioneer) {
  const Pty pty;
  Line line(pty.address(), kAtMost);
  for (const auto& [baud, speed] : std::vector<std::pair<int, speed_t>>{
           {19200, B19200}, {38400, B38400}, {57600, B57600}, {115200, B115200}, {9600, B9600}}) {
    line.set_baud(baud);
    EXPECT_EQ(pty.baud(), speed) << baud;
  }
}

TEST(SerialLine, ANewBaudDropsWhatCameAtTheOldOneAndSendsWhatWasWritten) {
  const Pty pty;
  Line line(pty.address(), kAtMost);
  pty.master.send({1, 2, 3});
  ASSERT_TRUE(soon([&] { return waiting_bytes(line.fd()) == 3; }));
  line.write(Bytes{4, 5, 6});
  line.set_baud(38400);
  EXPECT_THAT(line.read(), IsEmpty());
  EXPECT_EQ(pty.master.take(3), (Bytes{4, 5, 6}));
}

TEST(SerialLine, OpensWithNothingOfWhatCameBefore) {
  const Pty pty;
  const File kept = pty.open();  // a terminal forgets what nobody has open
  Bytes line_of_text{'o', 'l', 'd', '\n'};
  pty.master.send(line_of_text);
  ASSERT_TRUE(soon([&] { return waiting_bytes(kept.fd()) > 0; }));
  pty.master.take(5);  // the echo
  Line line(pty.address(), kAtMost);
  EXPECT_THAT(line.read(), IsEmpty());
  pty.master.send({7});
  EXPECT_EQ(read_soon(line, 1), Bytes{7});
}

// Both kinds of line, and the robot's side of each.
struct Ends {
  explicit Ends(bool serial) {
    if (serial) {
      pty = std::make_unique<Pty>();
      line = std::make_unique<Line>(pty->address(), kAtMost);
    } else {
      listener = std::make_unique<Listener>();
      line = std::make_unique<Line>(listener->address(), kAtMost);
      peer = std::make_unique<File>(listener->accept());
    }
  }
  File& robot() { return pty ? pty->master : *peer; }

  std::unique_ptr<Pty> pty;
  std::unique_ptr<Listener> listener;
  std::unique_ptr<File> peer;
  std::unique_ptr<Line> line;
};

class Lines : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(SerialAndTcp, Lines, testing::Values(true, false),
                         [](const auto& one) { return one.param ? "Serial" : "Tcp"; });

TEST_P(Lines, NeverWaitToRead) {
  Ends ends(GetParam());
  const auto begun = Clock::now();
  for (int i = 0; i < 10; ++i) {
    EXPECT_THAT(ends.line->read(), IsEmpty());
  }
  EXPECT_LT(Clock::now() - begun, milliseconds(kAtOnce_ms));
  ends.robot().send({1});
  EXPECT_EQ(read_soon(*ends.line, 1), Bytes{1});
  ends.robot().send({2, 3});
  EXPECT_EQ(read_soon(*ends.line, 2), (Bytes{2, 3}));
  EXPECT_THAT(ends.line->read(), IsEmpty());
}

TEST_P(Lines, LoseNothingToAReaderThatTakesAFewBytesAtATime) {
  Ends ends(GetParam());
  Bytes sent;
  for (int i = 0; i < 60; ++i) {
    const Bytes frame(30, static_cast<std::uint8_t>(i));
    ends.line->write(frame);
    sent.insert(sent.end(), frame.begin(), frame.end());
  }
  EXPECT_EQ(ends.robot().take(sent.size(), 7), sent);
}

TEST_P(Lines, NeverWaitToWriteAndCutOffWhatIsNotTaken) {
  Ends ends(GetParam());
  const Bytes message = long_message();
  const auto begun = Clock::now();
  ends.line->write(message);
  ends.line->write(message);
  EXPECT_LT(Clock::now() - begun, milliseconds(2 * kAtOnce_ms));
  const Bytes got = ends.robot().take(2 * message.size());
  ASSERT_GT(got.size(), 1000U);
  ASSERT_LT(got.size(), message.size());
  EXPECT_TRUE(std::equal(got.begin(), got.end(), message.begin()));  // each byte once, in order
  ends.line->write(Bytes{1, 2, 3});
  EXPECT_EQ(ends.robot().take(3), (Bytes{1, 2, 3}));
}

TEST_P(Lines, ThatTheRobotHasLeftSaySoWithTheirAddress) {
  Ends ends(GetParam());
  const std::string address = ends.line->address();
  ends.robot().shut();
  EXPECT_EQ(fault_soon(*ends.line),
            address + (GetParam() ? ": the port has gone: the cable is out"
                                  : ": the robot's side has closed the connection"));
  // and once more: it does not come back
  EXPECT_NE(fault([&] { ends.line->read(); }), "no fault");
  std::string said;
  soon([&] {  // a peer's refusal takes its time, and is no signal that ends the program
    said = fault([&] { ends.line->write(Bytes{1}); });
    return said != "no fault";
  });
  EXPECT_THAT(said, AllOf(StartsWith(address + ": cannot be written to ("),
                          HasSubstr("): the cable is out, or the robot's side has closed")));
}

TEST(SerialLine, ThatIsOutTakesNoBaud) {
  Pty pty;
  Line line(pty.address(), kAtMost);
  pty.master.shut();
  EXPECT_EQ(fault([&] { line.set_baud(38400); }),
            pty.address() + ": the port has gone: the cable is out");
}

TEST(SerialLine, APortThatIsLockedIsLeftAsItIs) {
  const Pty pty;
  const File other = pty.open();
  ASSERT_EQ(flock(other.fd(), LOCK_EX | LOCK_NB), 0);
  pty.master.send({'h', 'i', '\n'});
  ASSERT_TRUE(soon([&] { return waiting_bytes(other.fd()) == 3; }));
  EXPECT_EQ(fault_of(pty.address()), pty.address() + ": in use by another program; close that one");
  EXPECT_EQ(pty.baud(), speed_t{B115200});
  EXPECT_NE(pty.settings().c_lflag & ICANON, 0U);
  EXPECT_EQ(other.take(3), (Bytes{'h', 'i', '\n'}));
  flock(other.fd(), LOCK_UN);
  EXPECT_EQ(fault_of(pty.address()), "no fault");
}

TEST(SerialLine, IsNobodyElsesWhileItLivesAndEverybodysAfter) {
  const Pty pty;
  ASSERT_EQ(chmod(pty.path.c_str(), 0666), 0);
  const File watcher = pty.open();  // keeps the terminal, so that it would keep what is left of it
  const auto exclusive = [&watcher] {
    int is = -1;
    EXPECT_EQ(ioctl(watcher.fd(), TIOCGEXCL, &is), 0);
    return is != 0;
  };
  {
    const Line line(pty.address(), kAtMost);
    EXPECT_TRUE(exclusive());
    EXPECT_NE(flock(watcher.fd(), LOCK_EX | LOCK_NB), 0);
    EXPECT_THAT(fault_of(pty.address()), HasSubstr(": in use by another program"));
    const AsNobody nobody;
    EXPECT_EQ(fault_of(pty.address()),
              pty.address() + ": in use by another program; close that one");
  }
  EXPECT_FALSE(exclusive());
  EXPECT_EQ(flock(watcher.fd(), LOCK_EX | LOCK_NB), 0);
  flock(watcher.fd(), LOCK_UN);
  EXPECT_EQ(fault_of(pty.address()), "no fault");
}

TEST(SerialLine, APortThatMayNotBeOpenedSaysHowToGetTheRight) {
  const Pty pty;
  ASSERT_EQ(chmod(pty.path.c_str(), 0), 0);
  const AsNobody nobody;
  EXPECT_THAT(
      fault_of(pty.address()),
      AllOf(StartsWith(pty.address() + ": no permission to open it; "), HasSubstr("usermod -aG")));
}

class SerialPaths : public ScratchTest {};

TEST_F(SerialPaths, ThatAreNoPortsAreRefused) {
  EXPECT_EQ(fault_of("serial:" + path("ttyUSB0")),
            "serial:" + path("ttyUSB0") +
                ": no such port; is the cable plugged in? 'panoptes doctor' lists the ports that "
                "are here");
  EXPECT_EQ(fault_of("serial:" + folder_.string()),
            "serial:" + folder_.string() + ": cannot be opened: Is a directory");
  File(::open(path("file").c_str(), O_CREAT | O_WRONLY, 0600)).send({1, 2});
  EXPECT_EQ(
      fault_of("serial:" + path("file")),
      "serial:" + path("file") + ": not a serial port; name one, such as serial:/dev/ttyUSB0");
}

TEST(TcpLine, CarriesEveryByteBothWaysUnchangedAndAtOnce) {
  const Listener listener;
  Line line(listener.address(), kAtMost);
  EXPECT_FALSE(line.serial());
  const File robot = listener.accept();
  const Bytes bytes = every_byte();
  robot.send(bytes);
  EXPECT_EQ(read_soon(line, bytes.size()), bytes);
  line.write(bytes);
  EXPECT_EQ(robot.take(bytes.size()), bytes);
  int undelayed = 0;
  socklen_t size = sizeof undelayed;
  ASSERT_EQ(getsockopt(line.fd(), IPPROTO_TCP, TCP_NODELAY, &undelayed, &size), 0);
  EXPECT_NE(undelayed, 0);  // a command does not wait for the next one
}

TEST(TcpLine, GivesTheLastBytesBeforeItTellsOfTheEnd) {
  const Listener listener;
  Line line(listener.address(), kAtMost);
  File robot = listener.accept();
  robot.send({1, 2, 3});
  robot.shut();
  EXPECT_EQ(read_soon(line, 3), (Bytes{1, 2, 3}));
  EXPECT_THAT(fault_soon(line), StartsWith(listener.address()));
}

TEST(TcpLine, AHostThatDoesNotAnswerIsNotWaitedForLonger) {
  const Listener listener(0);
  std::vector<File> before;  // nobody takes them: what comes after them finds no room
  for (int i = 0; i < 4; ++i) {
    before.emplace_back(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    ::connect(before.back().fd(), reinterpret_cast<const sockaddr*>(&listener.there),
              sizeof listener.there);
  }
  const auto begun = Clock::now();
  EXPECT_EQ(fault_of(listener.address(), milliseconds(50)),
            listener.address() + ": the host does not answer; check the network and the address");
  EXPECT_LT(Clock::now() - begun, milliseconds(50 + kAtOnce_ms));
}

TEST(TcpLine, AHostThatRefusesIsToldWithTheCure) {
  std::string address;
  {
    const Listener gone;
    address = gone.address();
  }
  EXPECT_EQ(fault_of(address),
            address +
                ": the host refuses: nothing listens there; start 'panoptes serve MISSION', the "
                "simulator or the robot's serial server first, or correct the port");
}

}  // namespace
}  // namespace panoptes::hw
