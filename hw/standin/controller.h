// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "hw/pioneer/model.h"
#include "hw/pioneer/packet.h"
#include "hw/pioneer/report.h"
#include "hw/robot.h"

namespace panoptes::hw {

/// What a controller announces, and how it is set up when it is switched on.
struct StandInOptions {
  std::string name = "Panoptes";
  std::string class_name = "Pioneer";
  std::string subclass = "p3dx-sh";  ///< its units are those of this model
  int counter_bits = 16;             ///< of the position counters: 12, 15 or 16
  int sip_cycle_ms = 100;
  int watchdog_ms = 2000;  ///< without a right packet for so long the robot stops
  int host_baud = 9600;
  int front_bumpers = 5;  ///< segments
  int rear_bumpers = 5;
};
void bind(Fields& f, StandInOptions& o);

/// A packet on its way to the client.
struct Sent {
  Time at;  ///< when its transmission begins
  Bytes bytes;
};

/// A Pioneer's controller around any robot, whose wheels, clock and bumpers are its own: it answers
/// a client's bytes as ARCOS does, with its unkind habits: velocities are dead while the motors are
/// off, and a robot that its watchdog stopped goes on by itself when the client is heard again. It
/// reads no clock and does no I/O; the robot's time moves in advance() alone.
class StandInController {
 public:
  /// `robot` outlives it; `pictures` is given every observation that has some.
  StandInController(Robot& robot, const Body& body, const StandInOptions& options,
                    std::function<void(const Observation&)> pictures = {});

  /// Moves the robot on and lets everything that is due until then happen.
  void advance(Time until);

  /// Bytes that arrive at `now`, up to which it is advanced; any bytes at all.
  void receive(Time now, std::span<const std::uint8_t> bytes);

  /// What has been sent since the last time, in order; the last may begin after now().
  std::vector<Sent> take_sent();

  int baud() const { return state_.baud; }  ///< of the host port, as the client has set it
  bool open() const { return state_.link == Link::kOpen; }  ///< a client has opened a session
  Time now() const { return now_; }
  Time next_report() const;  ///< the far future while none is sent

 private:
  enum class Link { kIdle, kSync0, kSync1, kSync2, kOpen };
  struct Limits {
    double speed_mps = 0;
    double accel_mps2 = 0;
    double decel_mps2 = 0;
    double turn_radps = 0;
    double turn_accel_radps2 = 0;
    double turn_decel_radps2 = 0;
  };
  /// All that a reset puts back.
  struct State {
    Link link = Link::kIdle;
    int baud = 0;
    bool motors_on = false;
    bool emergency_stall = true;
    int bump_stall = 0;
    bool encoders = false;  ///< a stream of them
    Limits limits;
    Twist2 wanted;  ///< where no goal takes its place
    std::optional<double> goal_travelled_m;
    std::optional<double> goal_heading_rad;  ///< in odom
    Twist2 command;                          ///< to the robot, on its way to what is wanted
    bool bumper_holds = false;
  };

  void observe(Time until);
  void control();
  void report();
  void send(const Bytes& payload);
  void obey(const CommandPacket& packet);
  bool synchronise(const CommandPacket& packet);
  void move(Command command, int argument);
  void set_limit(Command command, int argument);
  void let_go();  ///< nothing is wanted any more, and the motors no longer push
  void reset();
  Twist2 wanted() const;
  bool pressed_towards(double speed_mps) const;
  Limits own_limits() const;
  Sip sip() const;
  Bytes encoders() const;
  ControllerConfig config() const;

  Robot& robot_;
  Body body_;
  StandInOptions options_;
  const PioneerModel& model_;
  std::function<void(const Observation&)> pictures_;
  Time now_;
  PacketReader reader_;
  State state_;
  Time heard_;  ///< the last right packet
  Time next_control_;
  Time next_sip_;
  Time line_free_;  ///< what is sent earlier has to wait
  std::vector<Sent> sent_;

  Odometry odometry_;
  Health health_;
  Pose2 T_odom_origin_;
  double travelled_m_ = 0;  ///< forward less backward
  double turned_rad_ = 0;
  double reported_travelled_m_ = 0;
  Time reported_;
};

}  // namespace panoptes::hw
