// SPDX-License-Identifier: BSD-3-Clause
// Both ends of a Pioneer's wire, in the time of the robot behind it.
#include "hw/standin/link.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "tests/support/rolling_robot.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
using State = PioneerClient::State;
using Wire = StandInLink::Wire;

const Duration kNavigator = milliseconds(67);  // between two commands
constexpr Duration kValid = milliseconds(400);

Body quick() {
  Body body;
  body.max_speed_mps = 1.6;
  body.max_accel_mps2 = 1;
  return body;
}

struct Ends {
  explicit Ends(Wire wire = Wire::kMemory, const StandInOptions& options = {},
                const Body& body = quick()) {
    auto made = std::make_unique<RollingRobot>(body);
    robot = made.get();
    link = std::make_unique<StandInLink>(std::move(made), body, options, body, wire,
                                         [this](const Observation& seen) { sets.push_back(seen); });
  }

  template <class Ask>
  auto ask(const Ask& of) {
    decltype(of(std::declval<PioneerClient&>())) answer{};
    link->with([&](PioneerClient& client) { answer = of(client); });
    return answer;
  }
  State state() {
    return ask([](const PioneerClient& client) { return client.state(); });
  }
  std::string fault() {
    return ask([](const PioneerClient& client) { return client.fault(); });
  }
  LinkCounts counts() {
    return ask([](const PioneerClient& client) { return client.counts(); });
  }
  void pass(Duration during) {
    link->work(link->now() + during, [](const PioneerClient&) { return false; });
  }
  void enable() {
    link->with([&](PioneerClient& client) { client.enable(link->now()); });
  }
  void drive(const Twist2& command) {
    link->with([&](PioneerClient& client) { client.drive(link->now(), command, kValid); });
  }
  void drive(const Twist2& command, Duration during) {
    for (const Time end = link->now() + during; link->now() < end;) {
      drive(command);
      pass(std::min(kNavigator, end - link->now()));
    }
  }
  /// All that would be heard on the wire towards the robot from now on.
  void listen() {
    link->damage([this](Bytes bytes, bool to_robot) {
      if (to_robot) {
        for (const PacketReader::Packet& packet : reader.read(bytes)) {
          heard.emplace_back(link->now(), *read_command(packet.payload));
        }
      }
      return bytes;
    });
  }

  RollingRobot* robot = nullptr;
  std::unique_ptr<StandInLink> link;
  std::vector<Observation> sets;
  PacketReader reader;
  std::vector<std::pair<Time, CommandPacket>> heard;
};

class Wires : public testing::TestWithParam<Wire> {};

TEST_P(Wires, ConnectDriveAndTellWhereTheRobotIs) {
  Ends ends(GetParam());
  connect(*ends.link);
  EXPECT_LT(to_seconds(ends.link->now()), 1.0);
  EXPECT_EQ(ends.ask([](const PioneerClient& client) { return client.baud(); }),
            GetParam() == Wire::kTcp ? 0 : 38400);
  EXPECT_EQ(ends.ask([](const PioneerClient& client) { return client.names().subclass; }),
            "p3dx-sh");
  ASSERT_TRUE(ends.ask([](const PioneerClient& client) { return client.config(); }));
  ends.enable();
  ends.drive({0.4, 0.5}, std::chrono::seconds(5));
  ends.drive({}, std::chrono::seconds(2));
  EXPECT_NEAR(ends.robot->twist.v_mps, 0, 1e-9);
  const auto pose = ends.ask([](const PioneerClient& client) { return client.pose(); });
  ASSERT_TRUE(pose);
  EXPECT_NEAR((pose->T_odom_body.position() - ends.robot->pose.position()).norm(), 0, 1.5e-3);
  EXPECT_NEAR(wrap_angle(pose->T_odom_body.theta_rad - ends.robot->pose.theta_rad), 0, 0.0016);
  EXPECT_GT(ends.robot->pose.position().norm(), 0.3);
  const LinkCounts counts = ends.counts();
  EXPECT_EQ(counts.rejected_implausible, 0U);
  EXPECT_EQ(counts.rejected_malformed, 0U);
}

INSTANTIATE_TEST_SUITE_P(All, Wires, testing::Values(Wire::kMemory, Wire::kPty, Wire::kTcp));

TEST(StandInLink, ComesOutTheSameOverEveryWire) {
  std::vector<Pose2> ways;
  for (const Wire wire : {Wire::kMemory, Wire::kPty, Wire::kPty}) {
    Ends ends(wire);
    connect(*ends.link);
    ends.enable();
    ends.drive({0.5, -0.3}, std::chrono::seconds(3));
    ways.push_back(ends.robot->pose);
  }
  EXPECT_EQ(ways[0], ways[1]);
  EXPECT_EQ(ways[0], ways[2]);
}

// Idle, in an old session at any baud, in the middle of a packet, after garbage: 200 of 200.
TEST(Handshake, ConnectsFromAnyStateWithinSixSeconds) {
  Rng rng(5);
  double worst_s = 0;
  for (int i = 0; i < 200; ++i) {
    Ends ends(i % 10 == 9 ? Wire::kPty : Wire::kMemory);
    StandInController& robot = ends.link->controller();
    const int baud = static_cast<int>(rng.uniform(0, 5));
    const auto tell = [&](const Bytes& bytes) { robot.receive(ends.link->now(), bytes); };
    if (i % 4 != 0) {  // an old session, or half of one
      const int far = i % 4 == 1 ? static_cast<int>(rng.uniform(1, 5)) : 5;
      for (int k = 0; k < std::min(far, 3); ++k) {
        tell(command_frame(static_cast<Command>(k)));
      }
      if (far > 3) {
        tell(command_frame(Command::kOpen, 1));
        tell(command_frame(Command::kEnable, 1));
        tell(command_frame(Command::kVelocity, 300));
        tell(command_frame(Command::kHostBaud, baud));
      }
    }
    if (i % 3 == 1) {  // a packet that nobody ended
      tell(Bytes{0xFA, 0xFB, static_cast<std::uint8_t>(rng.uniform(3, 256)), 0x0B});
    } else if (i % 3 == 2) {
      Bytes garbage;
      for (int k = 0; k < 300; ++k) {
        garbage.push_back(static_cast<std::uint8_t>(rng.uniform(0, 256)));
      }
      tell(garbage);
    }
    ends.pass(from_seconds(rng.uniform(0, 0.35)));
    const Time from = ends.link->now();
    ASSERT_NO_THROW(connect(*ends.link)) << i;
    worst_s = std::max(worst_s, to_seconds(ends.link->now() - from));
    // Whatever it was driving: it stands, and moves only when it is told to anew.
    ends.pass(std::chrono::seconds(2));
    EXPECT_EQ(ends.robot->twist.v_mps, 0) << i;
    const Pose2 stood = ends.robot->pose;
    ends.pass(std::chrono::seconds(3));
    EXPECT_EQ(ends.robot->pose, stood) << i;
  }
  EXPECT_LT(worst_s, 6);
  RecordProperty("worst_s", std::to_string(worst_s));
}

/// An old session of a program that died while it drove; the robot's watchdog has stopped it.
void leave_moving(Ends& ends, int host_baud, int v_mmps, int w_degps) {
  StandInController& robot = ends.link->controller();
  for (const Bytes& frame :
       {command_frame(Command::kPulse), command_frame(Command::kOpen),
        command_frame(Command::kClose), command_frame(Command::kOpen, 1),
        command_frame(Command::kEnable, 1), command_frame(Command::kVelocity, v_mmps),
        command_frame(Command::kTurnVelocity, w_degps),
        command_frame(Command::kHostBaud, host_baud)}) {
    robot.receive(ends.link->now(), frame);
  }
  ends.link->damage([](const Bytes&, bool) { return Bytes(); });  // nobody is there yet
  ends.pass(std::chrono::seconds(6));
  ends.link->damage({});
  ASSERT_EQ(ends.robot->twist.v_mps, 0);
  ASSERT_GT(ends.robot->pose.position().norm() + std::abs(ends.robot->pose.theta_rad), 0.1);
}

// To an old session SYNC0 is PULSE, after which the robot goes on as it was last told.
TEST(Handshake, MovesNothingInAnOldSessionWhicheverWayIsMuted) {
  Rng rng(11);
  for (int i = 0; i < 100; ++i) {
    Ends ends(i % 10 == 8 ? Wire::kTcp : i % 10 == 9 ? Wire::kPty : Wire::kMemory);
    leave_moving(ends, static_cast<int>(rng.uniform(0, 5)),
                 static_cast<int>(rng.uniform(-600, 600)), static_cast<int>(rng.uniform(-90, 90)));
    const bool mute_robot = i % 3 == 0;
    const bool mute_client = i % 3 == 1;
    ends.link->damage([=](Bytes bytes, bool to_robot) {
      return (to_robot ? mute_client : mute_robot) ? Bytes() : bytes;
    });
    ends.pass(from_seconds(rng.uniform(0, 0.35)));
    const Pose2 stood = ends.robot->pose;
    if (mute_robot || mute_client) {
      EXPECT_THROW(connect(*ends.link), DeviceError) << i;
    } else {
      ASSERT_NO_THROW(connect(*ends.link)) << i;
    }
    ends.pass(std::chrono::seconds(3));
    EXPECT_EQ(ends.robot->pose, stood) << i;
    ends.link->damage({});
    ends.pass(std::chrono::seconds(3));
    EXPECT_EQ(ends.robot->pose, stood) << i;
  }
}

// Any one frame of ours is lost, and its like every time that it comes again.
TEST(Handshake, MovesNothingInAnOldSessionThoughAStopIsLost) {
  for (int lost = 0; lost < 6; ++lost) {
    Ends ends(lost % 2 == 0 ? Wire::kMemory : Wire::kTcp);
    leave_moving(ends, 1, 400, 30);
    int sent = 0;
    ends.link->damage([&](Bytes bytes, bool to_robot) {
      return !to_robot || sent++ % 6 != lost ? bytes : Bytes();
    });
    const Pose2 stood = ends.robot->pose;
    try {
      connect(*ends.link);
    } catch (const DeviceError&) {  // where every SYNC0 is among them
    }
    ends.pass(std::chrono::seconds(2));
    EXPECT_EQ(ends.robot->pose, stood) << lost;
  }
}

/// What a client says of a line that answers like this, and when.
template <class Answer>
std::pair<std::string, double> refusal(const Answer& answer) {
  PioneerClient client("serial:/dev/ttyX", true, Body());
  Time now{};
  client.connect(now);
  while (client.state() == State::kConnecting && now < time_at(20)) {
    for (const PioneerClient::Transmission& sent : client.poll(now)) {
      const Bytes back = answer(now, sent.bytes);
      client.receive(now + milliseconds(5), back);
    }
    now = std::max(now + milliseconds(6), std::min(client.next_poll(), now + milliseconds(20)));
  }
  return {client.fault(), to_seconds(now)};
}

TEST(Handshake, RefusesWhatIsNoPioneerWithinTenSeconds) {
  const auto silence = refusal([](Time, const Bytes&) { return Bytes(); });
  EXPECT_THAT(silence.first, AllOf(HasSubstr("serial:/dev/ttyX: nothing answers at any baud"),
                                   HasSubstr("HOST port")));
  EXPECT_LT(silence.second, 10);
  const auto echo = refusal([](Time, const Bytes& bytes) { return bytes; });
  EXPECT_THAT(echo.first, HasSubstr("not an ARCOS robot"));
  EXPECT_LT(echo.second, 10);
  const auto chatter = refusal([](Time, const Bytes&) {
    const std::string_view gps = "$GPGGA,120000,5130.0,N,00010.0,W,1,08,0.9,35.0,M,,,,*47\r\n";
    return Bytes(gps.begin(), gps.end());
  });
  EXPECT_THAT(chatter.first, HasSubstr("no right packet among them: not an ARCOS robot"));
  EXPECT_LT(chatter.second, 10);
  Rng rng(1);
  const auto noise = refusal([&](Time, const Bytes&) {
    Bytes bytes;
    for (int i = 0; i < 40; ++i) {
      bytes.push_back(static_cast<std::uint8_t>(rng.uniform(0, 256)));
    }
    return bytes;
  });
  EXPECT_THAT(noise.first, HasSubstr("not an ARCOS robot"));
  EXPECT_LT(noise.second, 10);
}

TEST(Handshake, RefusesASubclassItDoesNotKnow) {
  int synced = 0;
  const auto [fault, at_s] = refusal([&](Time, const Bytes& bytes) {
    if (bytes == command_frame(Command::kClose) && synced == 2) {
      return arcos_frame(names_payload({"Nemo", "Pioneer", "p9dx"}));
    }
    synced = bytes == command_frame(Command::kPulse)  ? 1
             : bytes == command_frame(Command::kOpen) ? 2
                                                      : 0;
    return bytes;
  });
  EXPECT_THAT(fault, AllOf(HasSubstr("unknown subclass 'p9dx'"), HasSubstr("p3dx-sh")));
  EXPECT_LT(at_s, 1);
}

// A way with everything in it: straight, turns, reverse, rests.
Twist2 wander(double t_s) {
  const double leg = std::fmod(t_s, 24);
  return leg < 8    ? Twist2{0.5, 0}
         : leg < 14 ? Twist2{0.4, deg_to_rad(60)}
         : leg < 17 ? Twist2{0, deg_to_rad(-45)}
         : leg < 22 ? Twist2{-0.3, 0.2}
                    : Twist2{};
}

// 1 % of the bytes both ways flipped, inserted or deleted over ten minutes.
TEST(Corruption, NeverMovesThePoseFurtherThanTheGateAndIsMendedByTheNextReport) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Ends ends;
    connect(*ends.link);
    ends.enable();
    Rng rng(seed);
    Time last_good{};
    bool clean_since_good = true;
    int clean_missed = 0;
    int worst_missed = 0;
    std::size_t reports_sent = 0;
    std::size_t damaged_reports = 0;
    bool sent_clean = false;
    Pose2 sent_pose;
    ends.link->damage([&](Bytes bytes, bool to_robot) {
      const bool is_report = !to_robot && bytes.size() > 20;
      Bytes out;
      bool damaged = false;
      for (const std::uint8_t byte : bytes) {
        if (rng.uniform(0, 1) >= 0.01) {
          out.push_back(byte);
          continue;
        }
        damaged = true;
        const double kind = rng.uniform(0, 3);
        if (kind < 1) {
          out.push_back(static_cast<std::uint8_t>(byte ^ 1 << static_cast<int>(rng.uniform(0, 8))));
        } else if (kind < 2) {
          out.push_back(byte);
          out.push_back(static_cast<std::uint8_t>(rng.uniform(0, 256)));
        }
      }
      if (is_report) {
        ++reports_sent;
        damaged_reports += damaged ? 1 : 0;
        sent_clean = !damaged;
        sent_pose = ends.robot->pose;
      }
      return out;
    });
    const double begin_s = to_seconds(ends.link->now());
    Time seen{};
    while (to_seconds(ends.link->now()) < begin_s + 600) {
      ends.drive(wander(to_seconds(ends.link->now())));
      const Time until = ends.link->now() + kNavigator;
      while (ends.link->now() < until) {
        const std::size_t before = reports_sent;
        ends.link->work(until, [&](const PioneerClient& client) {
          return reports_sent != before || client.pose()->stamp != seen;
        });
        const WheelPose pose = *ends.ask([](const PioneerClient& client) { return client.pose(); });
        if (pose.stamp != seen) {
          seen = pose.stamp;
          // The gate where the robot was when it sent: 60 mm + v dt, dt up to the last accepted.
          const double gate_m = 0.06 + 0.5 * to_seconds(seen - last_good) + 2e-3;
          ASSERT_LT((pose.T_odom_body.position() - sent_pose.position()).norm(), gate_m);
          ASSERT_EQ(pose.epoch, 0);
          if (sent_clean) {
            ASSERT_LT((pose.T_odom_body.position() - sent_pose.position()).norm(), 2e-3);
            ASSERT_LT(std::abs(wrap_angle(pose.T_odom_body.theta_rad - sent_pose.theta_rad)),
                      0.004);
          }
          last_good = seen;
          clean_missed = 0;
          clean_since_good = true;
        } else if (reports_sent != before && sent_clean) {
          // On its way still, or lost: counted when the next one is sent.
          clean_missed += clean_since_good ? 0 : 1;
          worst_missed = std::max(worst_missed, clean_missed);
          clean_since_good = false;
        }
      }
    }
    EXPECT_EQ(ends.state(), State::kReady) << ends.fault();
    const LinkCounts counts = ends.counts();
    EXPECT_GT(reports_sent, 5900U);
    EXPECT_GT(damaged_reports, reports_sent / 5);
    EXPECT_GE(counts.reports, reports_sent - damaged_reports - 20);
    EXPECT_GT(counts.rejected_checksum + counts.rejected_implausible, damaged_reports / 4);
    EXPECT_LE(worst_missed, 1);  // one further valid frame
  }
}

// Long reports on a bad cable: most are damaged, and the link lives.
TEST(Corruption, OfMostReportsDoesNotEndTheSession) {
  Ends ends;
  connect(*ends.link);
  ends.enable();
  Rng rng(8);
  ends.link->damage([&](Bytes bytes, bool) {
    for (std::uint8_t& byte : bytes) {
      byte = rng.uniform(0, 1) < 0.024 ? static_cast<std::uint8_t>(byte ^ 0x10) : byte;
    }
    return bytes;
  });
  const Time end = ends.link->now() + std::chrono::seconds(600);
  while (ends.link->now() < end && ends.state() == State::kReady) {
    ends.drive(wander(to_seconds(ends.link->now())));
    ends.pass(kNavigator);
  }
  EXPECT_EQ(ends.state(), State::kReady) << ends.fault();
  EXPECT_LT(ends.counts().reports, 3500U);
}

// The frames that say zero are lost: it is said again until the wheels stand.
TEST(Commander, IsStoppedThoughFramesAreLost) {
  Ends ends;
  connect(*ends.link);
  ends.enable();
  ends.drive({0.5, 0}, std::chrono::seconds(3));
  int lost = 0;
  ends.link->damage([&](Bytes bytes, bool to_robot) {
    const bool is_zero = to_robot && (bytes == command_frame(Command::kVelocity, 0) ||
                                      bytes == command_frame(Command::kTurnVelocity, 0));
    return is_zero && ++lost <= 4 ? Bytes() : bytes;
  });
  ends.pass(std::chrono::seconds(2));
  EXPECT_GT(lost, 4);
  EXPECT_EQ(ends.robot->twist.v_mps, 0);
}

TEST(Cable, PulledIsSaidWithinASecondAndTheRobotStops) {
  Ends ends;
  connect(*ends.link);
  ends.enable();
  ends.drive({0.5, 0}, std::chrono::seconds(4));
  EXPECT_NEAR(ends.robot->twist.v_mps, 0.5, 0.001);
  ends.link->damage([](const Bytes&, bool) { return Bytes(); });
  const Time pulled = ends.link->now();
  while (ends.state() == State::kReady && ends.link->now() < pulled + std::chrono::seconds(5)) {
    ends.drive({0.5, 0});
    ends.pass(milliseconds(10));
  }
  EXPECT_LE(to_seconds(ends.link->now() - pulled), 1.0);
  EXPECT_THAT(ends.fault(),
              AllOf(HasSubstr("standin: no report from the robot for"), HasSubstr("cable is out")));
  EXPECT_THROW(ends.drive({0.5, 0}), DeviceError);
  ends.pass(pulled + std::chrono::seconds(2) + milliseconds(520) - ends.link->now());
  EXPECT_EQ(ends.robot->twist.v_mps, 0);  // its watchdog: 2 s, and braking from 0.5 m/s

  // Back again: nothing moves before the motors are enabled and a new command is given.
  ends.link->damage({});
  connect(*ends.link);
  const Pose2 stood = ends.robot->pose;
  EXPECT_THROW(ends.drive({0.5, 0}), DeviceError);
  ends.pass(std::chrono::seconds(5));
  EXPECT_EQ(ends.robot->pose, stood);
  ends.enable();
  ends.pass(std::chrono::seconds(5));
  EXPECT_EQ(ends.robot->pose, stood);
  EXPECT_EQ(ends.ask([](const PioneerClient& client) { return client.pose(); })->epoch, 1);
  ends.drive({0.3, 0}, std::chrono::seconds(2));
  EXPECT_GT((ends.robot->pose.position() - stood.position()).norm(), 0.3);
}

TEST(Commander, HungIsFollowedByZeroOnTheWireWithinHalfASecond) {
  Ends ends;
  connect(*ends.link);
  ends.enable();
  ends.drive({0.5, 0.3}, std::chrono::seconds(3));
  const Time hung = ends.link->now();
  ends.listen();
  ends.pass(std::chrono::seconds(4));
  std::vector<Command> zeros;
  for (const auto& [at, packet] : ends.heard) {
    const bool velocity =
        packet.command == Command::kVelocity || packet.command == Command::kTurnVelocity;
    if (velocity) {
      EXPECT_EQ(std::get<int>(packet.argument), 0);
      EXPECT_TRUE(to_seconds(at - hung) <= 0.5 || !zeros.empty());
      zeros.push_back(packet.command);
    } else {
      EXPECT_EQ(packet.command, Command::kStop);  // the link lives on, the command does not
    }
  }
  EXPECT_GE(zeros.size(), 4U);  // again while it still rolls: one frame may be lost
  EXPECT_LE(zeros.size(), 12U);
  EXPECT_EQ(ends.robot->twist.v_mps, 0);
  EXPECT_EQ(ends.counts().expired, 1U);
}

// A process that was suspended: the robot's watchdog has stopped it, and whatever it hears first
// would set it going again.
TEST(Commander, SuspendedSaysStopFirst) {
  const Body body = quick();
  RollingRobot robot(body);
  StandInController controller(robot, body, {});
  PioneerClient client("tcp:x:1", false, body);
  Time now{};
  const auto run = [&](Time until) {
    while (now < until) {
      now += milliseconds(5);
      controller.advance(now);
      for (const Sent& sent : controller.take_sent()) {
        client.receive(now, sent.bytes);
      }
      for (const auto& sent : client.poll(now)) {
        controller.receive(now, sent.bytes);
      }
    }
  };
  client.connect(now);
  run(time_at(2));
  client.enable(now);
  client.drive(now, {0.5, 0}, kValid);
  run(time_at(2.3));
  now = time_at(6);
  controller.advance(now);
  const std::vector<Sent> late = controller.take_sent();
  client.receive(now, late.back().bytes);
  const auto woken = client.poll(now);
  ASSERT_FALSE(woken.empty());
  EXPECT_EQ(woken.front().bytes, command_frame(Command::kStop));
}

// What it is told does not reach it any more, but something keeps its watchdog quiet.
TEST(Commander, SaysWithinASecondThatTheRobotDoesNotObeyAndGoesOnSayingStop) {
  for (const bool emergency : {false, true}) {
    StandInOptions patient;
    patient.watchdog_ms = 60'000;
    Ends ends(Wire::kMemory, patient);
    connect(*ends.link);
    ends.enable();
    ends.drive({0.3, 0}, std::chrono::seconds(3));
    ends.link->damage([](Bytes bytes, bool to_robot) { return to_robot ? Bytes() : bytes; });
    const Time told = ends.link->now();
    if (emergency) {
      ends.link->with([&](PioneerClient& client) { client.emergency_stop(told); });
    } else {
      ends.drive({});
    }
    ends.link->work(told + std::chrono::seconds(5),
                    [](const PioneerClient& client) { return client.state() == State::kRefused; });
    EXPECT_LE(to_seconds(ends.link->now() - told), 1.0);
    EXPECT_THAT(ends.fault(), HasSubstr("does not do what it is told: it goes 0.30 m/s"));
    EXPECT_NEAR(ends.robot->twist.v_mps, 0.3, 1e-6);
    ends.listen();
    ends.pass(std::chrono::seconds(2));
    EXPECT_GE(ends.heard.size(), 5U);
    for (const auto& [at, packet] : ends.heard) {
      EXPECT_EQ(packet.command, Command::kStop);
    }
    EXPECT_EQ(ends.robot->twist.v_mps, 0);  // it hears again
  }
}

// 0.25 s each way, or answers that come 0.4 s late.
TEST(Handshake, ConnectsOverSlowLinks) {
  for (const Wire wire : {Wire::kMemory, Wire::kTcp}) {
    for (const auto& [there_s, back_s] :
         {std::pair(0.25, 0.25), std::pair(0.3, 0.3), std::pair(0.2, 0.2), std::pair(0.0, 0.4)}) {
      Ends ends(wire);
      ends.link->delay([there = there_s, back = back_s](Time, bool to_robot) {
        return from_seconds(to_robot ? there : back);
      });
      ASSERT_NO_THROW(connect(*ends.link)) << there_s;
      EXPECT_NEAR(ends.counts().round_trip_s, there_s + back_s, 0.1);
      const std::vector<std::string> remarks =
          ends.ask([](PioneerClient& client) { return client.take_remarks(); });
      EXPECT_THAT(remarks, testing::Contains(HasSubstr("the link is slow")));
      ends.enable();
      ends.drive({0.4, 0.2}, std::chrono::seconds(4));
      ends.drive({}, std::chrono::seconds(3));
      EXPECT_EQ(ends.state(), State::kReady) << ends.fault();
      EXPECT_GT(ends.robot->pose.position().norm(), 0.5);
      EXPECT_EQ(ends.robot->twist.v_mps, 0);
    }
  }
}

TEST(Timing, IsTheControllersCycleAndTheDelayThatTheLinkHasShown) {
  Ends ends;
  connect(*ends.link);
  const BaseTiming prompt = ends.link->timing();
  EXPECT_EQ(prompt.period, milliseconds(100));
  EXPECT_LT(prompt.worst_round_trip, milliseconds(100));
  int reports = 0;
  ends.link->delay([&](Time, bool to_robot) {
    return !to_robot && ++reports % 10 == 0 ? milliseconds(250) : milliseconds(0);
  });
  ends.pass(std::chrono::seconds(5));
  EXPECT_EQ(ends.link->timing().period, milliseconds(100));
  EXPECT_GT(ends.link->timing().worst_round_trip, milliseconds(240));
  EXPECT_LT(ends.link->timing().worst_round_trip, milliseconds(350));
}

TEST(Holds, BumpersStopTheRobotUntilSomebodyHasSeenIt) {
  Ends ends;
  connect(*ends.link);
  ends.enable();
  ends.drive({0.4, 0}, std::chrono::seconds(2));
  ends.robot->pressed_rad = {0.0};
  ends.drive({0.4, 0}, std::chrono::seconds(2));
  EXPECT_EQ(ends.robot->twist.v_mps, 0);
  EXPECT_THAT(ends.ask([](const PioneerClient& client) { return client.held_by(); }),
              HasSubstr("front bumper 3"));
  ends.robot->pressed_rad.clear();
  const Pose2 stood = ends.robot->pose;
  ends.drive({-0.4, 0}, std::chrono::seconds(2));
  EXPECT_EQ(ends.robot->pose, stood);  // nobody has acknowledged
  ends.link->with([](PioneerClient& client) { client.acknowledge(); });
  ends.drive({-0.4, 0}, std::chrono::seconds(2));
  EXPECT_LT(ends.robot->pose.x_m, stood.x_m - 0.2);
}

TEST(Holds, AnEmergencyStopLastsUntilTheMotorsAreEnabledAgain) {
  Ends ends;
  connect(*ends.link);
  ends.enable();
  ends.drive({0.5, 0}, std::chrono::seconds(2));
  ends.listen();
  ends.link->with([&](PioneerClient& client) { client.emergency_stop(ends.link->now()); });
  ends.pass(milliseconds(50));
  ASSERT_FALSE(ends.heard.empty());
  EXPECT_EQ(ends.heard.front().second.command, Command::kEmergencyStop);
  ends.drive({0.5, 0}, std::chrono::seconds(2));
  EXPECT_EQ(ends.robot->twist.v_mps, 0);
  ends.link->with([](PioneerClient& client) { client.acknowledge(); });
  EXPECT_THROW(ends.drive({0.5, 0}), DeviceError);
  ends.enable();
  ends.drive({0.5, 0}, std::chrono::seconds(1));
  EXPECT_GT(ends.robot->twist.v_mps, 0.3);
}

TEST(Sonar, IsKeptByItsNumber) {
  Ends ends;
  connect(*ends.link);
  EXPECT_TRUE(ends.ask([](const PioneerClient& client) { return client.sonar(); }).empty());
  ends.link->with([&](PioneerClient& client) {
    client.switch_sonar(true);
    Sip sip = *client.report();
    sip.sonar = {{0, 1234}, {7, 5000}};
    client.receive(ends.link->now() + milliseconds(50), arcos_frame(sip_payload(sip)));
    sip.sonar = {{0, 900}};
    client.receive(ends.link->now() + milliseconds(60), arcos_frame(sip_payload(sip)));
  });
  const auto heard = ends.ask([](const PioneerClient& client) { return client.sonar(); });
  ASSERT_EQ(heard.size(), 2U);
  EXPECT_DOUBLE_EQ(heard.at(0).range_m, 0.9);
  EXPECT_TRUE(std::isinf(heard.at(7).range_m));
  EXPECT_LT(heard.at(7).stamp, heard.at(0).stamp);
}

TEST(Limits, AreTheBodysAndTheControllersWhicheverIsLower) {
  Body slow = quick();
  slow.max_speed_mps = 0.3;
  auto made = std::make_unique<RollingRobot>(quick());
  RollingRobot* robot = made.get();
  StandInLink link(std::move(made), quick(), {}, slow, Wire::kMemory);
  connect(link);
  link.with([&](PioneerClient& client) { client.enable(link.now()); });
  for (int i = 0; i < 60; ++i) {
    link.with([&](PioneerClient& client) { client.drive(link.now(), {1.5, 0}, kValid); });
    link.work(link.now() + kNavigator, [](const PioneerClient&) { return false; });
  }
  EXPECT_NEAR(robot->twist.v_mps, 0.3, 1e-9);
}

}  // namespace
}  // namespace panoptes::hw
