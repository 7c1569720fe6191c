// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/client.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/text.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;

// A robot that was left at a high baud by a program that died is the common cause of silence; the
// first is what controllers wake up with, the second what most programs go to.
constexpr std::array kRates = {9600, 38400, 115200, 57600, 19200};
constexpr int kWantedBaud = 38400;
constexpr int kWantedHostBaud = 2;  // the argument that asks for it
constexpr int kTries = 2;           // at a baud: the first may end what was begun before us

// All tries at all rates take 2 s at first, then, where answers may come late, 4.5 s.
constexpr Duration kEchoWithin = milliseconds(200);
constexpr Duration kLateEchoWithin = milliseconds(450);
constexpr Duration kSyncWithin = milliseconds(400);
constexpr Duration kDrainFor = milliseconds(250);  // a cycle and the longest report at 9600 baud
constexpr Duration kConfigWithin = milliseconds(400);
constexpr Duration kSwitchAfter = milliseconds(60);  // HOSTBAUD is sent and heard by then
constexpr Duration kRightWithin = milliseconds(900);
constexpr Duration kConnectWithin = std::chrono::seconds(8);
constexpr Duration kLateConnectWithin = std::chrono::seconds(14);  // where right packets come
constexpr Duration kDrainAtMost = std::chrono::seconds(2);
constexpr Duration kSlowLink = milliseconds(150);  // there and back, worth telling

constexpr Duration kUsualCycle = milliseconds(100);
constexpr Duration kPace = milliseconds(5);  // closer together some commands are lost
constexpr Duration kKeepAlive = milliseconds(400);
constexpr Duration kOwnSilence = milliseconds(800);  // of ours, well within the watchdog's 2 s
constexpr Duration kRefresh = milliseconds(200);
constexpr Duration kLongestValid = milliseconds(500);
constexpr Duration kZeroAfter = milliseconds(500);  // without a report
constexpr Duration kLeastApart = milliseconds(1);   // two reports
constexpr Duration kLostAfter = milliseconds(850);  // without a byte: said within 1 s
// Bytes come, but no right report: of long ones on a bad cable some 30 in a row may be damaged.
constexpr Duration kUselessAfter = std::chrono::seconds(3);
constexpr Duration kMotorsWithin = milliseconds(500);

constexpr double kHalfCount = 0.01;  // limits are told in whole counts, of 50 deg/s and more
constexpr int kNothingHeard = 5000;  // as the controller says it
constexpr std::size_t kVelocities_bytes = 18;  // forward and turning
constexpr double kBitsPerByte = 10;            // with start and stop

int whole(double value, double most) {
  return static_cast<int>(std::lround(std::clamp(value, -most, most)));
}

}  // namespace

PioneerClient::PioneerClient(std::string device, bool serial, const Body& body)
    : device_(std::move(device)), serial_(serial), body_(body), command_monitor_(body) {}

void PioneerClient::go(Step step, Time now, Duration lasts) {
  step_ = step;
  deadline_ = now + lasts;
}

void PioneerClient::send(Bytes frame) { outbox_.push_back({std::nullopt, std::move(frame)}); }

void PioneerClient::connect(Time now) {
  state_ = State::kConnecting;
  fault_.clear();
  begun_ = now;
  next_send_ = now;
  last_sent_.reset();
  outbox_.clear();
  reader_.clear();
  rate_ = 0;
  all_tried_ = false;
  round_trip_ = {};
  bytes_heard_ = 0;
  right_heard_ = false;
  supervised_ = doubted_ = stops_ = false;
  command_monitor_ = CommandMonitor(body_);
  names_ = {};
  config_.reset();
  report_.reset();
  sonar_.clear();
  enabled_ = false;
  held_by_.clear();
  wanted_ = {};
  commanded_.reset();
  expires_.reset();
  most_ = {};
  asked_ = now;
  synchronise(now, serial_ ? std::optional(kRates[rate_]) : std::nullopt);
}

// What is SYNC0 to an idle robot is PULSE to one in an old session: STOP goes before. Twice, for
// one may be lost.
void PioneerClient::synchronise(Time now, std::optional<int> baud) {
  attempt_ = 1;
  outbox_.push_back({baud, command_frame(Command::kStop)});
  send(command_frame(Command::kStop));
  send(command_frame(Command::kPulse));
  go(Step::kSearch, now, echo_within());
}

void PioneerClient::try_next_baud(Time now) {
  rate_ = (rate_ + 1) % kRates.size();
  all_tried_ = all_tried_ || rate_ == 0;
  asked_ = serial_ ? now : asked_;
  synchronise(now, serial_ ? std::optional(kRates[rate_]) : std::nullopt);
}

Duration PioneerClient::echo_within() const {
  return within(all_tried_ ? kLateEchoWithin : kEchoWithin);
}

Duration PioneerClient::within(Duration usual) const { return usual + 2 * round_trip_; }

Time PioneerClient::give_up_at() const {
  return begun_ + (right_heard_ ? kLateConnectWithin : kConnectWithin);
}

void PioneerClient::refuse(const std::string& fault) {
  const bool was_open = state_ == State::kReady;
  state_ = State::kRefused;
  fault_ = fault;
  outbox_.clear();
  enabled_ = false;
  expires_.reset();
  wanted_ = {};
  deadline_ = Time::max();
  if (was_open) {  // whoever still hears it stops
    send(command_frame(Command::kStop));
    stops_ = true;
  }
}

void PioneerClient::lose(const std::string& fault) {
  if (state_ != State::kRefused) {
    refuse(fault);
  }
}

void PioneerClient::on_deadline(Time now) {
  switch (step_) {
    case Step::kSearch:
      if (attempt_ < kTries) {
        const int next = attempt_ + 1;
        synchronise(now, std::nullopt);
        attempt_ = next;
      } else {
        try_next_baud(now);
      }
      return;
    case Step::kDrain:
    case Step::kSync1:
    case Step::kSync2:
      asked_ = now;
      synchronise(now, std::nullopt);
      return;
    case Step::kConfig:
      if (attempt_ < kTries) {
        ++attempt_;
        send(command_frame(Command::kConfig, 1));
        go(Step::kConfig, now, within(kConfigWithin));
      } else {
        remarks_.push_back(device_ +
                           ": the robot does not tell its configuration; its own limits and its "
                           "watchdog are not known");
        opened(now);
      }
      return;
    case Step::kFaster:
      baud_before_ = baud_;
      outbox_.push_back({kWantedBaud, command_frame(Command::kStop)});
      go(Step::kConfirm, now, within(kRightWithin));
      return;
    case Step::kConfirm:
      outbox_.push_back({baud_before_, command_frame(Command::kStop)});
      go(Step::kFallBack, now, within(kRightWithin));
      return;
    case Step::kFallBack:
      try_next_baud(now);
      return;
    case Step::kSession:
      deadline_ = Time::max();
      return;
  }
}

// The configuration is there, or will not come.
void PioneerClient::opened(Time now) {
  if (config_) {
    const auto limit = [&](double& most, double told, const char* what, const char* unit) {
      if (told > 0 && told < (1 - kHalfCount) * most) {
        remarks_.push_back(
            fmt::format("{}: the robot's own limit of {} is {:.3g} {}, below the "
                        "{:.3g} of the mission's robot; it is kept",
                        device_, what, told, unit, most));
        most = told;
      }
    };
    limit(body_.max_speed_mps, 1e-3 * config_->top_speed_mmps, "speed", "m/s");
    limit(body_.max_turn_radps, deg_to_rad(config_->top_turn_degps), "turning", "rad/s");
    if (config_->watchdog_ms == 0) {
      remarks_.push_back(device_ +
                         ": the robot's own watchdog is off: it will not stop by itself when the "
                         "cable is pulled; set it with the maker's configuration tool");
    }
  }
  if (serial_ && baud_ < kWantedBaud) {
    send(command_frame(Command::kHostBaud, kWantedHostBaud));
    go(Step::kFaster, now, kSwitchAfter + round_trip_);
  } else {
    in_session(now);
  }
}

void PioneerClient::in_session(Time now) {
  // At another baud reports take another time, and one was lost.
  clock_ = ReportClock(config_ && config_->sip_cycle_ms > 0 ? milliseconds(config_->sip_cycle_ms)
                                                            : kUsualCycle);
  step_ = Step::kSession;
  deadline_ = Time::max();
  last_report_ = now;
  last_bytes_ = now;
}

Duration PioneerClient::on_line(std::size_t bytes) const {
  return baud_ == 0 ? Duration::zero()
                    : from_seconds(static_cast<double>(bytes) * kBitsPerByte / baud_);
}

void PioneerClient::receive(Time now, std::span<const std::uint8_t> bytes) {
  bytes_heard_ += bytes.size();
  last_bytes_ = bytes.empty() ? last_bytes_ : now;
  for (const PacketReader::Packet& packet : reader_.read(bytes)) {
    constexpr std::size_t kFrame_bytes = 5;  // around a payload
    const std::size_t begin = packet.end - packet.payload.size() - kFrame_bytes;
    on_packet(now, now - on_line(reader_.bytes() - begin), packet.payload);
  }
}

void PioneerClient::on_packet(Time now, Time arrival, const Bytes& payload) {
  right_heard_ = true;
  const std::uint8_t type = payload.front();
  const bool is_report = type == kSipStopped || type == kSipMoving;
  switch (step_) {
    case Step::kSearch:
    case Step::kSync1:
    case Step::kSync2:
      if (is_report) {  // of an old session
        send(command_frame(Command::kClose));
        asked_ = now;
        go(Step::kDrain, now, kDrainFor);
      } else if (step_ == Step::kSearch && type == 0) {
        round_trip_ = now - asked_;
        asked_ = now;
        send(command_frame(Command::kOpen));
        go(Step::kSync1, now, within(kSyncWithin));
      } else if (step_ == Step::kSync1 && type == 1) {
        round_trip_ = now - asked_;
        send(command_frame(Command::kClose));
        go(Step::kSync2, now, within(kSyncWithin));
      } else if (step_ == Step::kSync2 && type == 2) {
        if (payload.size() == 1) {
          refuse(device_ +
                 ": sends back what is sent to it: not an ARCOS robot (a loop in the cable, a "
                 "modem?); connect the robot's HOST port");
          return;
        }
        const auto names = read_names(payload);
        if (!names) {
          return;
        }
        names_ = *names;
        model_ = find_model(names_.subclass);
        if (model_ == nullptr) {
          refuse(fmt::format(
              "{}: the robot '{}' is of the unknown subclass '{}', and what its counts mean is "
              "not guessed; known are {}; enter it in hw/pioneer/model.cc",
              device_, names_.name, names_.subclass, joined(known_models())));
          return;
        }
        clock_ = ReportClock();
        if (odometer_) {
          odometer_->restart(*model_);
        } else {
          odometer_.emplace(*model_);
        }
        send(command_frame(Command::kOpen, 1));
        send(command_frame(Command::kStop));
        send(command_frame(Command::kConfig, 1));
        attempt_ = 1;
        last_report_ = now;
        if (round_trip_ >= kSlowLink) {
          remarks_.push_back(
              fmt::format("{}: the link is slow: an answer takes {:.2f} s; the robot hears what it "
                          "is told, STOP as well, that much later, and is seen where it was",
                          device_, to_seconds(round_trip_)));
        }
        go(Step::kConfig, now, within(kConfigWithin));
      }
      return;
    case Step::kDrain:
      if (is_report && now - asked_ < kDrainAtMost) {  // still on their way
        go(Step::kDrain, now, kDrainFor);
      }
      return;
    case Step::kConfig:
      if (type == kConfigPacket) {
        config_ = read_config(payload);
        if (config_) {
          opened(now);
        } else {
          ++counts_.rejected_malformed;
        }
        return;
      }
      break;
    case Step::kConfirm:
    case Step::kFallBack:
      in_session(now);
      break;
    case Step::kFaster:
    case Step::kSession:
      break;
  }
  if (!is_report || state_ == State::kRefused) {
    return;
  }
  if (const auto sip = read_sip(payload)) {
    on_report(now, arrival, *sip);
  } else {
    ++counts_.rejected_malformed;
  }
}

// Poses that nobody has seen yet left a cycle before this report at the latest.
Time PioneerClient::put_right(const ReportClock::Departure& left) {
  if (poses_.empty()) {
    return left.stamp;
  }
  Time by = left.left - clock_.cycle();
  for (std::size_t i = poses_.size(); i-- > 0 && poses_[i].stamp > by; by -= clock_.cycle()) {
    poses_[i].stamp = std::max(by, seen_ + static_cast<Duration::rep>(i + 1) * kLeastApart);
  }
  return std::max(left.left, poses_.back().stamp + kLeastApart);
}

void PioneerClient::on_report(Time now, Time arrival, const Sip& sip) {
  ReportClock::Departure left = clock_.departure(arrival, odometer_->elapsed(sip));
  left.stamp = put_right(left);
  const Time stamp = left.stamp;
  if (odometer_->add(stamp, sip, most_, left.apart, left.gap) ==
      PioneerOdometer::Verdict::kImplausible) {
    ++counts_.rejected_implausible;
    return;
  }
  clock_.take(arrival, left);
  command_monitor_.allow(latency());
  ++counts_.reports;
  counts_.longest_silence_s = std::max(counts_.longest_silence_s, to_seconds(now - last_report_));
  last_report_ = now;
  const Velocity commanded = commanded_.value_or(Velocity{});
  most_ = {1e-3 * std::abs(commanded.v_mmps), deg_to_rad(std::abs(commanded.w_degps))};
  pose_ = {stamp, odometer_->T_odom_body(), odometer_->twist_body(), odometer_->epoch()};
  poses_.push_back(*pose_);
  for (const SonarReading& reading : sip.sonar) {
    sonar_[reading.index] = {stamp, reading.range >= kNothingHeard
                                        ? std::numeric_limits<double>::infinity()
                                        : model_->range_m * reading.range};
  }
  const Sip before = report_.value_or(Sip{});
  report_ = sip;
  if (step_ == Step::kSession && state_ != State::kReady) {
    state_ = State::kReady;
    if (sip.battery_v() < kLowBattery_v) {
      remarks_.push_back(
          fmt::format("{}: the battery is at {:.1f} V: below {} V the controller misbehaves; "
                      "charge it before it drives",
                      device_, sip.battery_v(), kLowBattery_v));
    }
  }

  const auto segments = [](unsigned bits) {
    std::vector<std::string> numbers;
    for (int k = 0; k < 7; ++k) {
      if ((bits >> k & 1) != 0) {
        numbers.push_back(std::to_string(k + 1));
      }
    }
    return joined(numbers);
  };
  const bool has_front = !config_ || config_->front_bumpers > 0;
  const bool has_rear = !config_ || config_->rear_bumpers > 0;
  if (const unsigned hit = sip.front_bumpers & ~before.front_bumpers; hit != 0 && has_front) {
    hold(now, "front bumper " + segments(hit));
  }
  if (const unsigned hit = sip.rear_bumpers & ~before.rear_bumpers; hit != 0 && has_rear) {
    hold(now, "rear bumper " + segments(hit));
  }
  if ((sip.left_stalled && !before.left_stalled) || (sip.right_stalled && !before.right_stalled)) {
    hold(now, sip.left_stalled && sip.right_stalled ? "both wheels stalled"
              : sip.left_stalled                    ? "left wheel stalled"
                                                    : "right wheel stalled");
  }
  if ((sip.flags & ~before.flags & kFlagStopButton) != 0) {
    hold(now, "STOP button");
  }
  if (enabled_ && (sip.flags & kFlagMotorsOn) == 0 && now - enabled_at_ >= within(kMotorsWithin)) {
    hold(now, "the motors are off");
    enabled_ = false;
  }
  watch(now, *pose_, sip);
}

// The velocity that it reports against the command in force.
void PioneerClient::watch(Time now, const WheelPose& pose, const Sip& sip) {
  if (!supervised_ || state_ != State::kReady || (sip.flags & kFlagMotorsOn) == 0) {
    command_monitor_.forget();
    return;
  }
  const bool disobeys = command_monitor_.disobeys(pose.stamp, pose.twist_body);
  doubted_ = command_monitor_.doubtful();
  if (!disobeys) {
    return;
  }
  const Velocity commanded = commanded_.value_or(Velocity{});
  command_zero(now);
  refuse(fmt::format(
      "{}: the robot does not do what it is told: it goes {:.2f} m/s and {:.0f} deg/s where it was "
      "told {:.2f} and {:.0f}; it does not hear, or its controller fails; it is told to stop again "
      "and again: press its STOP button",
      device_, pose.twist_body.v_mps, rad_to_deg(pose.twist_body.w_radps), 1e-3 * commanded.v_mmps,
      static_cast<double>(commanded.w_degps)));
}

void PioneerClient::hold(Time now, const std::string& by) {
  held_by_ += (held_by_.empty() ? "" : ", ") + by;
  command_zero(now);
}

void PioneerClient::acknowledge() { held_by_.clear(); }

void PioneerClient::command_zero(Time now) {
  wanted_ = {};
  expires_.reset();
  refresh_ = false;
  command_monitor_.commanded(now, {});
  if (state_ != State::kRefused) {
    send(command_frame(Command::kStop));
    commanded_ = Velocity{};
  }
}

void PioneerClient::command_wanted(Time now) {
  send(command_frame(Command::kVelocity, wanted_.v_mmps));
  send(command_frame(Command::kTurnVelocity, wanted_.w_degps));
  commanded_ = wanted_;
  commanded_at_ = now;
  command_monitor_.commanded(now, {1e-3 * wanted_.v_mmps, deg_to_rad(wanted_.w_degps)});
  // It goes there when the second of the two frames is there.
  const Duration under_way = kPace + on_line(kVelocities_bytes);
  commanded_twists_.push_back(
      {now + under_way, {1e-3 * wanted_.v_mmps, deg_to_rad(wanted_.w_degps)}});
  most_.v_mps = std::max(most_.v_mps, 1e-3 * std::abs(wanted_.v_mmps));
  most_.w_radps = std::max(most_.w_radps, deg_to_rad(std::abs(wanted_.w_degps)));
}

void PioneerClient::enable(Time now) {
  if (state_ != State::kReady) {
    throw DeviceError(fault_.empty() ? device_ + ": not connected yet" : fault_);
  }
  held_by_.clear();
  command_zero(now);
  supervised_ = true;
  send(command_frame(Command::kEnable, 1));
  const int v_mmps = whole(1e3 * body_.max_speed_mps, 0x7FFF);
  const int a_mmps2 = whole(1e3 * body_.max_accel_mps2, 0x7FFF);
  const int w_degps = whole(rad_to_deg(body_.max_turn_radps), 0x7FFF);
  const int a_degps2 = whole(rad_to_deg(body_.max_turn_accel_radps2), 0x7FFF);
  send(command_frame(Command::kSetMaxSpeed, v_mmps));
  send(command_frame(Command::kSetAcceleration, a_mmps2));
  send(command_frame(Command::kSetAcceleration, -a_mmps2));
  send(command_frame(Command::kSetMaxTurn, w_degps));
  send(command_frame(Command::kSetTurnAcceleration, a_degps2));
  send(command_frame(Command::kSetTurnAcceleration, -a_degps2));
  enabled_ = true;
  enabled_at_ = now;
}

void PioneerClient::disable(Time now) {
  command_zero(now);
  if (state_ != State::kRefused) {
    send(command_frame(Command::kEnable, 0));
  }
  enabled_ = false;
}

void PioneerClient::leave(Time now) {
  if (state_ == State::kReady || stops_) {
    send(command_frame(Command::kStop));
    send(command_frame(Command::kEnable, 0));
    close(now);
  }
}

void PioneerClient::close(Time) {
  stops_ = false;
  if (serial_ && baud_ != kRates.front()) {
    send(command_frame(Command::kHostBaud, 0));
    outbox_.push_back({kRates.front(), command_frame(Command::kClose, 1)});
  } else {
    send(command_frame(Command::kClose, 1));
  }
  state_ = State::kRefused;
  fault_ = device_ + ": closed";
  enabled_ = false;
  deadline_ = Time::max();
}

void PioneerClient::drive(Time now, const Twist2& command_body, Duration valid_for) {
  if (state_ == State::kRefused) {
    throw DeviceError(fault_);
  }
  if (!held_by_.empty()) {
    return;
  }
  if (!enabled_) {
    throw DeviceError(device_ + ": told to move while the motors are off; enable them first");
  }
  wanted_ = {whole(1e3 * command_body.v_mps, 1e3 * body_.max_speed_mps),
             whole(rad_to_deg(command_body.w_radps), rad_to_deg(body_.max_turn_radps))};
  expires_ = now + std::min(valid_for, kLongestValid);
  refresh_ = true;
}

void PioneerClient::switch_sonar(bool on) {
  if (state_ != State::kReady) {
    throw DeviceError(fault_.empty() ? device_ + ": not connected yet" : fault_);
  }
  send(command_frame(Command::kSonar, on ? 1 : 0));
  sonar_.clear();
}

void PioneerClient::stop(Time now) { command_zero(now); }

void PioneerClient::emergency_stop(Time now) {
  outbox_.clear();
  command_zero(now);
  outbox_.push_front({std::nullopt, command_frame(Command::kEmergencyStop)});
  next_send_ = std::min(next_send_, now);
  enabled_ = false;
  held_by_ = "emergency stop";
}

std::vector<PioneerClient::Transmission> PioneerClient::poll(Time now) {
  if (state_ == State::kConnecting && now >= give_up_at()) {
    refuse(device_ + ": " +
           (bytes_heard_ == 0 ? std::string("nothing answers") + (serial_ ? " at any baud" : "") +
                                    "; is the robot switched on, and the cable in its HOST port?" +
                                    (serial_ ? " Or another program holds the port and takes the "
                                               "answers: sudo fuser -v " +
                                                   device_.substr(device_.find(':') + 1)
                                             : "")
            : right_heard_ ? "packets come, but no session can be opened; switch the robot off and "
                             "on again"
                           : std::to_string(bytes_heard_) +
                                 " bytes came and no right packet among them: not an ARCOS robot; "
                                 "is it the right port?"));
  }
  while (state_ != State::kRefused && now >= deadline_) {
    on_deadline(now);
  }
  const bool in_session = state_ == State::kReady;
  const Duration unheard = now - last_report_;
  if (in_session && unheard >= kLostAfter && now - last_bytes_ >= kLostAfter) {
    refuse(
        fmt::format("{}: no report from the robot for {:.2f} s: it is switched off or its cable "
                    "is out; it was told to stop, and its own watchdog stops it",
                    device_, to_seconds(unheard)));
  } else if (in_session && unheard >= kUselessAfter) {
    refuse(
        fmt::format("{}: bytes come, but no right report among them for {:.1f} s: a bad cable, "
                    "or somebody has set the robot to another baud; it was told to stop, and "
                    "its own watchdog stops it",
                    device_, to_seconds(unheard)));
  } else if (in_session && unheard >= kZeroAfter && (wanted_.v_mmps != 0 || wanted_.w_degps != 0)) {
    command_zero(now);
  }
  if (in_session && last_sent_ && now - *last_sent_ >= kOwnSilence) {
    // Nobody let us speak for so long that the robot may have stopped and would start again.
    outbox_.clear();
    command_zero(now);
  }
  if (expires_ && now >= *expires_) {
    expires_.reset();
    refresh_ = false;
    if (wanted_.v_mmps != 0 || wanted_.w_degps != 0) {
      ++counts_.expired;
      wanted_ = {};
    }
  }
  if (in_session && enabled_ && outbox_.empty()) {
    // One frame may be lost: zero is said until the wheels stand.
    const bool stands = wanted_.v_mmps == 0 && wanted_.w_degps == 0;
    refresh_ = refresh_ || (stands && moves());
    const bool news = !commanded_ || commanded_->v_mmps != wanted_.v_mmps ||
                      commanded_->w_degps != wanted_.w_degps;
    if (news || (doubted_ && (stands || refresh_)) ||
        (refresh_ && now - commanded_at_ >= kRefresh)) {
      command_wanted(now);
    }
    refresh_ = doubted_ = false;
  }
  if (in_session && outbox_.empty() && doubted_) {
    send(command_frame(Command::kStop));
    doubted_ = false;
  }
  if (state_ == State::kRefused && stops_ && outbox_.empty() && now - *last_sent_ >= kRefresh) {
    send(command_frame(Command::kStop));
  }
  const bool rests = wanted_.v_mmps == 0 && wanted_.w_degps == 0;
  if (in_session && rests && outbox_.empty() && last_sent_ && now - *last_sent_ >= kKeepAlive) {
    // Never PULSE: what the robot has heard last may be an earlier command than the last one said.
    send(command_frame(Command::kStop));
  }
  std::vector<Transmission> out;
  while (!outbox_.empty() && now >= next_send_) {
    Transmission next = std::move(outbox_.front());
    outbox_.pop_front();
    if (next.baud && *next.baud != baud_) {
      baud_ = *next.baud;
      reader_.clear();
    } else {
      next.baud.reset();
    }
    const bool switches = next.bytes[3] == static_cast<std::uint8_t>(Command::kHostBaud);
    next_send_ = now + (switches ? kSwitchAfter : std::max(kPace, on_line(next.bytes.size())));
    last_sent_ = now;
    ++counts_.commands;
    out.push_back(std::move(next));
  }
  return out;
}

Time PioneerClient::next_poll() const {
  Time next = outbox_.empty() ? Time::max() : next_send_;
  if (state_ == State::kRefused) {
    return stops_ ? std::min(next, *last_sent_ + kRefresh) : next;
  }
  next = std::min(next, deadline_);
  if (state_ == State::kConnecting) {
    return std::min(next, give_up_at());
  }
  next = std::min(next, std::max(last_bytes_, last_report_) + kLostAfter);
  next = std::min(next, last_report_ + kUselessAfter);
  if (enabled_ && moves() && wanted_.v_mmps == 0 && wanted_.w_degps == 0) {
    next = std::min(next, commanded_at_ + kRefresh);
  }
  if (wanted_.v_mmps != 0 || wanted_.w_degps != 0) {
    next = std::min(next, last_report_ + kZeroAfter);
  }
  if (last_sent_ && wanted_.v_mmps == 0 && wanted_.w_degps == 0) {
    next = std::min(next, *last_sent_ + kKeepAlive);
  }
  if (expires_) {
    next = std::min(next, *expires_);
  }
  return next;
}

bool PioneerClient::moves() const {
  constexpr int kRest_mmps = 2;  // of a wheel that stands, by its rounding
  return report_ && (std::abs(report_->left) > kRest_mmps || std::abs(report_->right) > kRest_mmps);
}

std::vector<CommandedTwist> PioneerClient::take_commanded() {
  return std::exchange(commanded_twists_, {});
}

std::vector<WheelPose> PioneerClient::take_poses() {
  seen_ = poses_.empty() ? seen_ : poses_.back().stamp;
  return std::exchange(poses_, {});
}

std::vector<std::string> PioneerClient::take_remarks() { return std::exchange(remarks_, {}); }

LinkCounts PioneerClient::counts() const {
  LinkCounts counts = counts_;
  counts.rejected_checksum = reader_.bad_frames();
  counts.skipped_bytes = reader_.skipped_bytes();
  counts.resyncs = reader_.resyncs();
  counts.round_trip_s = to_seconds(round_trip_);
  return counts;
}

}  // namespace panoptes::hw
