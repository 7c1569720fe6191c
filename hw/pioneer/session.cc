// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/session.h"

#include "core/base/error.h"

namespace panoptes::hw {
namespace {

constexpr Duration kConnectWithin = std::chrono::seconds(15);
constexpr Duration kSettlesWithin = std::chrono::seconds(5);

}  // namespace

BaseTiming PioneerSession::timing() {
  BaseTiming timing;
  with([&](const PioneerClient& client) { timing = {client.cycle(), client.latency()}; });
  return timing;
}

void PioneerSession::wait(Time deadline, const std::function<bool()>& done) {
  work(deadline, [&](const PioneerClient& client) {
    return client.state() == PioneerClient::State::kRefused || client.has_poses() || done();
  });
}

BaseReports PioneerSession::take_reports() {
  BaseReports reports;
  with([&](PioneerClient& client) {
    reports.poses = client.take_poses();
    reports.commanded = client.take_commanded();
    reports.held_up = client.holds_up();
    if (client.state() == PioneerClient::State::kRefused) {
      reports.error = client.fault();
    }
  });
  return reports;
}

Health PioneerSession::health() {
  Health health;
  with([&](const PioneerClient& client) {
    const Sip& report = *client.report();
    health.bumper_pressed = report.front_bumpers != 0 || report.rear_bumpers != 0;
    health.motors_enabled = (report.flags & kFlagMotorsOn) != 0;
    health.held_by = client.held_by();
  });
  return health;
}

void PioneerSession::drive(const Twist2& command_body, Duration valid_for) {
  with([&](PioneerClient& client) {
    const bool stands = command_body.v_mps == 0 && command_body.w_radps == 0;
    if (!enabled_ && stands && client.state() == PioneerClient::State::kReady) {
      return;  // whoever only watches does not switch the motors on
    }
    if (!enabled_) {
      client.enable(now());
      enabled_ = true;
    }
    client.drive(now(), command_body, valid_for);
  });
}

void PioneerSession::stop() {
  with([&](PioneerClient& client) { client.stop(now()); });
}

void PioneerSession::emergency_stop() {
  with([&](PioneerClient& client) { client.emergency_stop(now()); });
}

void PioneerSession::acknowledge() {
  with([&](PioneerClient& client) {
    if (client.enabled()) {
      client.acknowledge();
    } else if (enabled_) {
      client.enable(now());
    }
  });
}

std::map<std::string, double> PioneerSession::figures() {
  std::map<std::string, double> figures;
  with([&](const PioneerClient& client) {
    const LinkCounts counts = client.counts();
    figures = {{"reports", static_cast<double>(counts.reports)},
               {"rejected_checksum", static_cast<double>(counts.rejected_checksum)},
               {"rejected_implausible", static_cast<double>(counts.rejected_implausible)},
               {"rejected_malformed", static_cast<double>(counts.rejected_malformed)},
               {"skipped_bytes", static_cast<double>(counts.skipped_bytes)},
               {"resyncs", static_cast<double>(counts.resyncs)},
               {"commands", static_cast<double>(counts.commands)},
               {"expired", static_cast<double>(counts.expired)},
               {"longest_silence_s", counts.longest_silence_s},
               {"round_trip_s", counts.round_trip_s},
               {"battery_v", client.report() ? client.report()->battery_v() : 0}};
  });
  return figures;
}

void connect(PioneerSession& session) {
  session.with([&](PioneerClient& client) { client.connect(session.now()); });
  session.work(session.now() + kConnectWithin, [](const PioneerClient& client) {
    return client.state() != PioneerClient::State::kConnecting;
  });
  session.work(session.now() + kSettlesWithin, [](const PioneerClient& client) {
    return client.state() != PioneerClient::State::kReady || client.settled();
  });
  session.with([](PioneerClient& client) {
    if (client.state() != PioneerClient::State::kReady) {
      throw DeviceError(client.fault());
    }
  });
}

}  // namespace panoptes::hw
