// SPDX-License-Identifier: BSD-3-Clause
#include "hw/standin/wire_server.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <poll.h>

namespace panoptes::hw {
namespace {

constexpr Duration kLongestWait = std::chrono::milliseconds(100);  // to see who has come or gone
constexpr Duration kOutOfDate = std::chrono::milliseconds(100);    // the next report is there
constexpr Duration kCatchUp = std::chrono::seconds(1);
constexpr int kBitsOfByte = 10;

}  // namespace

WireServer::WireServer(StandInController& controller,
                       std::vector<std::unique_ptr<Endpoint>> endpoints)
    : controller_(controller),
      endpoints_(std::move(endpoints)),
      started_(std::chrono::steady_clock::now() - controller.now().time_since_epoch()),
      start_unix_ns_(
          std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch() -
                                               controller.now().time_since_epoch())
              .count()) {}

Time WireServer::wall() const { return Time(std::chrono::steady_clock::now() - started_); }

void WireServer::wait() const {
  const Time now = wall();
  Time until = std::min(now + kLongestWait, controller_.next_report());
  until = due_.empty() ? until : std::min(until, due_.front().at);
  std::vector<pollfd> waited;
  for (const auto& endpoint : endpoints_) {
    waited.push_back({endpoint->fd(), POLLIN, 0});
  }
  const Duration left = std::max(Duration(0), until - now);
  const timespec longest{0, static_cast<long>(left.count())};  // kLongestWait is under a second
  ::ppoll(waited.data(), waited.size(), &longest, nullptr);
}

Bytes WireServer::hear() {
  if (client_ && !endpoints_[*client_]->connected()) {
    client_.reset();
  }
  Bytes heard;
  for (std::size_t i = 0; i < endpoints_.size(); ++i) {
    Endpoint& endpoint = *endpoints_[i];
    Bytes bytes = endpoint.read();
    if (!client_ && (endpoint.connected() || !bytes.empty())) {
      client_ = i;
    }
    if (client_ == i) {
      heard = std::move(bytes);
      if (const std::optional<int> baud = endpoint.client_baud()) {
        heard = misread(heard, *baud, controller_.baud());
      }
    }
  }
  return heard;
}

// A serial line holds a packet back until its last bit is through.
void WireServer::collect() {
  const bool serial = client_ && endpoints_[*client_]->client_baud();
  for (Sent& sent : controller_.take_sent()) {
    const Duration through = std::chrono::nanoseconds(std::chrono::seconds(1)) *
                             static_cast<std::int64_t>(kBitsOfByte * sent.bytes.size()) /
                             controller_.baud();
    due_.push_back({sent.at + (serial ? through : Duration(0)), std::move(sent.bytes)});
  }
}

void WireServer::deliver() {
  const Time now = wall();
  for (; !due_.empty() && due_.front().at <= now; due_.pop_front()) {
    if (!client_ || due_.front().at + kOutOfDate < now) {
      continue;
    }
    Endpoint& endpoint = *endpoints_[*client_];
    const int baud = endpoint.client_baud().value_or(controller_.baud());
    endpoint.write(misread(due_.front().bytes, controller_.baud(), baud));
  }
}

void WireServer::turn(const std::function<bool()>& each_second) {
  wait();
  const Bytes heard = hear();
  const Time now = wall();
  while (controller_.now() + kCatchUp < now) {
    controller_.advance(controller_.now() + kCatchUp);
    controller_.take_sent();  // out of date
    if (!each_second()) {
      return;
    }
  }
  controller_.receive(now, heard);
  collect();
  deliver();
}

}  // namespace panoptes::hw
