// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "hw/base.h"
#include "hw/pioneer/command_monitor.h"
#include "hw/pioneer/model.h"
#include "hw/pioneer/odometer.h"
#include "hw/pioneer/packet.h"
#include "hw/pioneer/report.h"
#include "hw/pioneer/report_clock.h"

namespace panoptes::hw {

/// What one of the ring's sonars has heard last.
struct SonarRange {
  Time stamp;          ///< of the report
  double range_m = 0;  ///< infinite where nothing came back
};

/// How the link is doing, for the health figures.
struct LinkCounts {
  std::size_t reports = 0;               ///< right and believed
  std::size_t rejected_checksum = 0;     ///< headers that no right frame followed
  std::size_t rejected_implausible = 0;  ///< right by the checksum, but the robot cannot be there
  std::size_t rejected_malformed = 0;    ///< right by the checksum, but of no known form
  std::size_t skipped_bytes = 0;         ///< in no frame
  std::size_t resyncs = 0;               ///< right frames after skipped bytes
  std::size_t commands = 0;              ///< frames sent
  std::size_t expired = 0;               ///< velocities that nobody renewed
  double longest_silence_s = 0;          ///< between two believed reports
  double round_trip_s = 0;               ///< from a question to its answer, while connecting
};

/// One end of the link to a Pioneer's controller: the conversation, without a line, a thread or a
/// clock of its own. It is told what arrives and when, and says what is to be sent and when it
/// wants to be asked again. From any state of the robot (idle, in the middle of an old session at
/// another baud, in the middle of a packet) it finds the baud, synchronises, opens, asks for the
/// configuration and, on a serial line, goes to 38400 baud. A controller whose watchdog has stopped
/// the robot goes back to the last velocity by itself when it hears anything, and SYNC0 is PULSE to
/// one in an old session: STOP goes, twice, before every SYNC0, first after any silence of ours,
/// and instead of PULSE while nothing is to move.
class PioneerClient {
 public:
  enum class State {
    kConnecting,
    kReady,   ///< reports come
    kRefused  ///< no Pioneer there, it was lost, or it does not obey: see fault()
  };

  /// `device` names the line in messages. `serial`: it has a baud, which is searched. Limits of
  /// speed and acceleration are the body's.
  PioneerClient(std::string device, bool serial, const Body& body);

  struct Transmission {
    std::optional<int> baud;  ///< first change the line to it
    Bytes bytes;
  };

  /// Begins, or begins anew after kRefused: a new epoch, motors off until enable().
  void connect(Time now);

  /// Bytes that have arrived together at `now`.
  void receive(Time now, std::span<const std::uint8_t> bytes);

  /// What is to be sent now. Ask again at next_poll(), and after receive() and every command.
  std::vector<Transmission> poll(Time now);
  Time next_poll() const;

  State state() const { return state_; }

  /// Whether it is known when reports leave the robot; before that poses may be a tenth of a second
  /// late where the link holds bytes up.
  bool settled() const { return clock_.settled(); }

  /// Whether reports are held up on this link now and then.
  bool holds_up() const { return clock_.holds_up(); }

  /// The nominal time from one report to the next.
  Duration cycle() const { return clock_.cycle(); }

  /// From a command to the report of its effect: commands are held up as reports are.
  Duration latency() const { return round_trip_ + clock_.longest_hold(); }

  const std::string& fault() const { return fault_; }  ///< names the device and the cure

  /// Commands. A velocity is rounded to whole mm/s and deg/s, held within the body's limits, and
  /// zero is sent when it has not been renewed for `valid_for` or half a second. Throws DeviceError
  /// when the motors are not enabled.
  void enable(Time now);
  void disable(Time now);
  void drive(Time now, const Twist2& command_body, Duration valid_for);
  void switch_sonar(bool on);
  void stop(Time now);            ///< decelerates
  void emergency_stop(Time now);  ///< regardless of deceleration; nothing moves until enable()
  void close(Time now);           ///< ends the session; the last that is sent
  void leave(Time now);  ///< stops, switches the motors off and closes, where a session may be open
  void lose(const std::string& fault);  ///< the line itself has failed
  bool enabled() const { return enabled_; }

  /// What holds the robot: a bumper, a stalled wheel, the STOP button. Empty when nothing does.
  /// While it is not acknowledged velocities are zero.
  const std::string& held_by() const { return held_by_; }
  void acknowledge();

  // What the robot says
  const std::optional<WheelPose>& pose() const { return pose_; }  ///< of the last believed report
  bool has_poses() const { return !poses_.empty(); }              ///< that nobody has taken
  std::vector<WheelPose> take_poses();                            ///< since it was asked last
  std::vector<CommandedTwist> take_commanded();                   ///< since it was asked last
  const std::map<int, SonarRange>& sonar() const { return sonar_; }  ///< by the sonar's number
  const std::optional<Sip>& report() const { return report_; }
  const ControllerNames& names() const { return names_; }
  const std::optional<ControllerConfig>& config() const { return config_; }
  int baud() const { return baud_; }
  LinkCounts counts() const;
  std::vector<std::string> take_remarks();  ///< what the user ought to know, once each

 private:
  enum class Step {
    kSearch,  // SYNC0 at one baud after the other
    kDrain,   // an old session was closed
    kSync1,
    kSync2,
    kConfig,   // opened; waits for the configuration
    kFaster,   // asked for 38400 baud; the line is still the old one
    kConfirm,  // waits for anything right at the new baud
    kFallBack,
    kSession
  };

  void go(Step step, Time now, Duration lasts);
  void on_deadline(Time now);
  void synchronise(Time now, std::optional<int> baud);
  void try_next_baud(Time now);
  Duration echo_within() const;
  Duration within(Duration usual) const;  // longer where answers take long
  Time give_up_at() const;
  void on_packet(Time now, Time arrival, const Bytes& payload);
  void on_report(Time now, Time arrival, const Sip& sip);
  Time put_right(const ReportClock::Departure& left);
  void opened(Time now);
  void in_session(Time now);
  void refuse(const std::string& fault);
  void hold(Time now, const std::string& by);
  void watch(Time now, const WheelPose& pose, const Sip& sip);
  void send(Bytes frame);
  void command_zero(Time now);
  void command_wanted(Time now);
  bool moves() const;                         // by the last report
  Duration on_line(std::size_t bytes) const;  ///< none where the line has no baud

  std::string device_;
  bool serial_;
  Body body_;
  State state_ = State::kConnecting;
  Step step_ = Step::kSearch;
  std::string fault_;

  Time begun_;
  Time deadline_ = Time::max();  // of the step
  Time asked_;                   // what an answer is waited for
  Duration round_trip_{};        // of what was asked and answered last
  bool all_tried_ = false;       // every baud, once
  std::size_t rate_ = 0;         // index of the baud that is tried
  int attempt_ = 0;
  int baud_ = 0;
  int baud_before_ = 0;
  std::size_t bytes_heard_ = 0;
  bool right_heard_ = false;

  PacketReader reader_;
  std::deque<Transmission> outbox_;
  Time next_send_;
  std::optional<Time> last_sent_;

  ControllerNames names_;
  const PioneerModel* model_ = nullptr;
  std::optional<ControllerConfig> config_;
  std::optional<PioneerOdometer> odometer_;
  ReportClock clock_;
  std::optional<WheelPose> pose_;
  std::vector<WheelPose> poses_;
  Time seen_ = Time::min();  // the last pose that somebody took
  std::optional<Sip> report_;
  std::map<int, SonarRange> sonar_;
  Time last_report_;
  Time last_bytes_;
  LinkCounts counts_;
  std::vector<std::string> remarks_;

  bool enabled_ = false;
  Time enabled_at_;
  bool supervised_ = false;  // the motors were switched on by us
  CommandMonitor command_monitor_;
  bool doubted_ = false;  // by a report that nothing was said to yet
  bool stops_ = false;    // refused, with a robot that may still move: STOP is said again and again
  std::string held_by_;
  struct Velocity {
    int v_mmps = 0;
    int w_degps = 0;
  };
  Velocity wanted_;
  std::optional<Velocity> commanded_;  // the velocity that was sent last
  std::optional<Time> expires_;
  bool refresh_ = false;  // the command is fresh, and may be said again
  Time commanded_at_;
  std::vector<CommandedTwist> commanded_twists_;
  Twist2 most_;  // commanded since the last believed report
};

}  // namespace panoptes::hw
