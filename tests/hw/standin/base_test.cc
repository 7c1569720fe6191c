// SPDX-License-Identifier: BSD-3-Clause
// The thread that carries a client's bytes, in real time, against a stand-in behind a terminal or a
// socket.
#include "hw/pioneer/base.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <spawn.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/error.h"
#include "hw/physical/physical_robot.h"
#include "hw/pioneer/line.h"
#include "hw/pioneer/probe.h"
#include "hw/standin/controller.h"
#include "hw/standin/endpoint.h"
#include "tests/support/rolling_robot.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

/// A stand-in that lives in wall-clock time until its cable is pulled.
class Served {
 public:
  explicit Served(std::unique_ptr<Endpoint> endpoint) : endpoint_(std::move(endpoint)) {
    name = endpoint_->name();
    thread_ = std::thread([this] { serve(); });
  }
  ~Served() {
    done_ = true;
    thread_.join();
  }

  void pull_cable() { pulled_ = true; }
  double speed_mps() const { return speed_mps_; }

  std::string name;

 private:
  void serve() {
    const auto begun = Clock::now();
    while (!done_) {
      const Time now(Clock::now() - begun);
      controller_.advance(now);
      if (pulled_) {
        endpoint_.reset();
      }
      if (endpoint_) {
        controller_.receive(now, endpoint_->read());
        for (const Sent& sent : controller_.take_sent()) {
          const int baud = endpoint_->client_baud().value_or(controller_.baud());
          endpoint_->write(misread(sent.bytes, controller_.baud(), baud));
        }
      }
      speed_mps_ = robot_.twist.v_mps;
      std::this_thread::sleep_for(milliseconds(2));
    }
  }

  std::unique_ptr<Endpoint> endpoint_;
  RollingRobot robot_;
  StandInController controller_{robot_, Body(), {}};
  std::atomic<bool> done_ = false;
  std::atomic<bool> pulled_ = false;
  std::atomic<double> speed_mps_ = 0;
  std::thread thread_;
};

class Bases : public testing::TestWithParam<bool> {
 protected:
  static std::unique_ptr<Endpoint> endpoint() {
    if (GetParam()) {
      return std::make_unique<PtyEndpoint>();
    }
    return std::make_unique<TcpEndpoint>("127.0.0.1", 0);
  }
};

TEST_P(Bases, DriveAndStopWhenTheCommanderHangsAndTellOfAPulledCable) {
  Served served(endpoint());
  auto base = std::make_unique<PioneerBase>(served.name, Body());
  connect(*base);
  PhysicalRobot robot(std::move(base), {});
  EXPECT_TRUE(robot.start_unix_ns());
  const auto drive_for = [&](double seconds) {
    const Time end = robot.now() + from_seconds(seconds);
    Observation seen;
    while (robot.now() < end) {
      robot.drive({0.3, 0}, milliseconds(400));
      seen = robot.observe(robot.now() + milliseconds(100));
    }
    return seen;
  };
  const Observation seen = drive_for(1.0);
  EXPECT_GT(seen.odometry.T_odom_body.x_m, 0.02);
  EXPECT_TRUE(seen.health.motors_enabled);
  EXPECT_GT(served.speed_mps(), 0.2);

  // Nobody commands any more: 0.4 s of validity, and braking from 0.3 m/s.
  std::this_thread::sleep_for(milliseconds(1500));
  EXPECT_EQ(served.speed_mps(), 0);

  drive_for(0.7);
  const auto pulled = Clock::now();
  served.pull_cable();
  try {
    drive_for(5);
    ADD_FAILURE() << "the cable is out";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr(served.name));
  }
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - pulled).count(), 1.0);
  EXPECT_THROW(robot.drive({0.1, 0}, milliseconds(400)), DeviceError);
  EXPECT_NO_THROW(robot.stop());
}

// As cameras do. A line whose robot reports lets whoever waits ask some dozens of times a second.
TEST_P(Bases, AskAgainWheneverSomebodyWakesThem) {
  constexpr int kAsked = 1000;
  Served served(endpoint());
  PioneerBase base(served.name, Body());
  connect(base);
  std::atomic<bool> done = false;
  std::thread waker([&] {
    while (!done) {
      base.wake();
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
  });
  int asked = 0;
  base.work(base.now() + std::chrono::seconds(10),
            [&](const PioneerClient&) { return ++asked == kAsked; });
  done = true;
  waker.join();
  EXPECT_EQ(asked, kAsked);
}

INSTANTIATE_TEST_SUITE_P(PtyAndTcp, Bases, testing::Bool());

TEST(Probe, TellsWhoAnswers) {
  Served served(std::make_unique<PtyEndpoint>());
  const PioneerIdentity identity = probe_pioneer(served.name);
  EXPECT_EQ(identity.class_name, "Pioneer");
  EXPECT_EQ(identity.subclass, "p3dx-sh");
  EXPECT_FALSE(identity.firmware.empty());
  EXPECT_GT(identity.battery_v, 11);
  EXPECT_EQ(identity.baud, 38400);
  EXPECT_EQ(probe_pioneer(served.name).name, identity.name);  // it left the line as it should
}

std::string fault_of(const std::string& address) {
  try {
    const Line line(address, milliseconds(500));
    return "";
  } catch (const DeviceError& error) {
    return error.what();
  }
}

TEST(Line, SaysWhatIsWrongWithAPort) {
  EXPECT_THAT(fault_of("serial:/dev/ttyNONE"),
              AllOf(HasSubstr("serial:/dev/ttyNONE: no such port"), HasSubstr("doctor")));
  EXPECT_THAT(fault_of("serial:/dev/null"), HasSubstr("not a serial port"));
  EXPECT_THAT(fault_of("usb:1"), HasSubstr("must be serial:PORT"));
  EXPECT_THAT(fault_of("tcp:localhost"), HasSubstr("tcp:HOST:PORT"));
  EXPECT_THAT(fault_of("tcp:localhost:70000"), HasSubstr("between 1 and 65535"));
  EXPECT_THAT(fault_of("tcp:localhost:abc"), HasSubstr("between 1 and 65535"));
  const PtyEndpoint pty;
  const Line first(pty.name(), milliseconds(500));
  EXPECT_THAT(fault_of(pty.name()), HasSubstr("in use by another program"));
}

// Somebody else waits there for the robot's bytes, whether it has locked the port or not.
TEST(Line, IsNotReadFromWhereAnotherProgramHoldsThePort) {
  PtyEndpoint pty;
  const std::string path = pty.name().substr(pty.name().find(':') + 1);
  const std::string waits = "exec sleep 30 < " + path;
  const char* const arguments[] = {"sh", "-c", waits.c_str(), nullptr};
  pid_t other = 0;
  ASSERT_EQ(posix_spawn(&other, "/bin/sh", nullptr, nullptr, const_cast<char* const*>(arguments),
                        environ),
            0);
  while (!pty.connected()) {
    std::this_thread::sleep_for(milliseconds(5));
  }
  const Bytes report{1, 2, 3};
  pty.write(report);
  EXPECT_THAT(fault_of(pty.name()), AllOf(HasSubstr("perhaps held by"),
                                          HasSubstr("(pid " + std::to_string(other) + ")")));
  const int there = open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  Bytes left(8);
  EXPECT_EQ(read(there, left.data(), left.size()), 3);
  ioctl(there, TIOCEXCL);
  EXPECT_THAT(fault_of(pty.name()), HasSubstr("in use by another program"));
  ioctl(there, TIOCNXCL);
  close(there);
  kill(other, SIGKILL);
  waitpid(other, nullptr, 0);
  EXPECT_EQ(fault_of(pty.name()), "");
}

TEST(Line, SaysWhenAHostRefuses) {
  int port = 0;
  {
    const TcpEndpoint gone("127.0.0.1", 0);
    port = gone.port();
  }
  EXPECT_THAT(fault_of("tcp:127.0.0.1:" + std::to_string(port)),
              AllOf(HasSubstr("refuses"), HasSubstr("panoptes serve")));
  EXPECT_THAT(fault_of("tcp:no-such-host.invalid:8101"), HasSubstr("is not known"));
}

}  // namespace
}  // namespace panoptes::hw
