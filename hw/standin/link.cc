// SPDX-License-Identifier: BSD-3-Clause
#include "hw/standin/link.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <poll.h>

#include "core/base/error.h"

namespace panoptes::hw {
namespace {

constexpr std::int64_t kTicksPerSecond = 120;  // those of the simulated world
constexpr Duration kConnectWithin = std::chrono::seconds(3);
constexpr int kKernelWithin_ms = 5000;
constexpr double kBitsPerByte = 10;

/// The first tick after an instant. Pictures are delivered no later than at the next.
Time next_tick(Time now) {
  const std::int64_t tick =
      static_cast<std::int64_t>(std::floor(to_seconds(now) * kTicksPerSecond + 1e-6)) + 1;
  return Time(Duration(tick * 1'000'000'000 / kTicksPerSecond));
}

std::unique_ptr<Endpoint> endpoint_of(StandInLink::Wire wire) {
  switch (wire) {
    case StandInLink::Wire::kMemory:
      return nullptr;
    case StandInLink::Wire::kPty:
      return std::make_unique<PtyEndpoint>();
    case StandInLink::Wire::kTcp:
      return std::make_unique<TcpEndpoint>("127.0.0.1", 0);
  }
  return nullptr;
}

/// As many bytes as were sent: the kernel hands them on when it likes, and together with later
/// ones.
template <class Source>
Bytes exactly(std::size_t count, Source& source, Bytes& handed_on) {
  while (handed_on.size() < count) {
    const Bytes more = source.read();
    handed_on.insert(handed_on.end(), more.begin(), more.end());
    pollfd waited{source.fd(), POLLIN, 0};
    if (more.empty() && ::poll(&waited, 1, kKernelWithin_ms) == 0) {
      throw DeviceError(
          "stand-in: bytes on the wire did not arrive within 5 s; is the machine overloaded?");
    }
  }
  const auto end = handed_on.begin() + static_cast<std::ptrdiff_t>(count);
  Bytes bytes(handed_on.begin(), end);
  handed_on.erase(handed_on.begin(), end);
  return bytes;
}

}  // namespace

StandInLink::StandInLink(std::unique_ptr<Robot> robot, const Body& body,
                         const StandInOptions& options, const Body& believed, Wire wire,
                         std::function<void(const Observation&)> pictures)
    : robot_(std::move(robot)),
      controller_(*robot_, body, options, std::move(pictures)),
      endpoint_(endpoint_of(wire)),
      line_(endpoint_ ? std::make_unique<Line>(endpoint_->name(), kConnectWithin) : nullptr),
      client_(line_ ? line_->address() : "standin", wire != Wire::kTcp, believed),
      now_(robot_->now()) {
  if (endpoint_) {
    endpoint_->read();  // lets the client in
  }
}

StandInLink::~StandInLink() = default;

void StandInLink::launch(bool to_robot, Time at, int baud, Bytes bytes) {
  const std::size_t sent = bytes.size();
  if (damage_) {
    bytes = damage_(std::move(bytes), to_robot);
  }
  if (endpoint_ && to_robot) {
    line_->write(bytes);
  } else if (endpoint_) {
    endpoint_->write(bytes);
  }
  const Duration on_line =
      baud == 0 ? Duration::zero() : from_seconds(static_cast<double>(sent) * kBitsPerByte / baud);
  std::deque<Flight>& flights = to_robot ? to_robot_ : to_client_;
  Time arrival = at + on_line + (delay_ ? delay_(at, to_robot) : Duration::zero());
  arrival = flights.empty() ? arrival : std::max(arrival, flights.back().arrival);
  flights.push_back({arrival, baud, std::move(bytes)});
}

Bytes StandInLink::land(bool at_robot, const Flight& flight) {
  if (!endpoint_) {
    return flight.bytes;
  }
  return at_robot ? exactly(flight.bytes.size(), *endpoint_, at_robot_)
                  : exactly(flight.bytes.size(), *line_, at_client_);
}

void StandInLink::arrive() {
  while (!to_robot_.empty() && to_robot_.front().arrival <= now_) {
    const Flight flight = std::move(to_robot_.front());
    to_robot_.pop_front();
    Bytes bytes = land(true, flight);
    if (flight.baud != 0) {
      bytes = misread(bytes, flight.baud, controller_.baud());
    }
    controller_.receive(now_, bytes);
    send_to_client();
  }
  while (!to_client_.empty() && to_client_.front().arrival <= now_) {
    const Flight flight = std::move(to_client_.front());
    to_client_.pop_front();
    Bytes bytes = land(false, flight);
    if (flight.baud != 0) {
      bytes = misread(bytes, flight.baud, client_.baud());
    }
    client_.receive(now_, bytes);
  }
}

void StandInLink::send_to_client() {
  for (Sent& sent : controller_.take_sent()) {
    launch(false, std::max(sent.at, now_), client_.baud() == 0 ? 0 : controller_.baud(),
           std::move(sent.bytes));
  }
}

void StandInLink::send_to_robot() {
  for (PioneerClient::Transmission& next : client_.poll(now_)) {
    if (next.baud) {
      // What is on its way at the old baud is lost at the new one, and not left in the kernel.
      for (const Flight& flight : std::exchange(to_client_, {})) {
        land(false, flight);
      }
      if (line_) {
        line_->set_baud(*next.baud);
      }
    }
    launch(true, now_, client_.baud(), std::move(next.bytes));
  }
}

void StandInLink::step(Time until) {
  Time next = std::min({until, next_tick(now_), client_.next_poll(), controller_.next_report()});
  for (const auto* flights : {&to_robot_, &to_client_}) {
    next = flights->empty() ? next : std::min(next, flights->front().arrival);
  }
  next = std::max(next, now_);
  controller_.advance(next);
  now_ = next;
  send_to_client();
  arrive();
  send_to_robot();
}

void StandInLink::work(Time deadline, const std::function<bool(const PioneerClient&)>& done) {
  while (!done(client_) && now_ < deadline) {
    step(deadline);
  }
}

void StandInLink::with(const std::function<void(PioneerClient&)>& act) {
  act(client_);
  send_to_robot();
}

}  // namespace panoptes::hw
