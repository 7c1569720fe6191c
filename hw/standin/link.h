// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>

#include "core/base/time.h"
#include "core/geometry/body.h"
#include "hw/pioneer/line.h"
#include "hw/pioneer/session.h"
#include "hw/robot.h"
#include "hw/standin/controller.h"
#include "hw/standin/endpoint.h"

namespace panoptes::hw {

/// A client and a stand-in's controller in one process, joined by a wire, in the simulated robot's
/// time: it takes as long as the computer needs, and comes out the same every time. Bytes take as
/// long as their baud says, and are misread where the two ends' differ.
class StandInLink final : public PioneerSession {
 public:
  enum class Wire {
    kMemory,
    kPty,  ///< every byte goes through the kernel's terminal,
    kTcp   ///< or through a connection on the loopback
  };

  /// `robot` and what it is served as; `believed` is the client's idea of the body. `pictures` is
  /// given every observation of the robot that has some.
  StandInLink(std::unique_ptr<Robot> robot, const Body& body, const StandInOptions& options,
              const Body& believed, Wire wire,
              std::function<void(const Observation&)> pictures = {});
  ~StandInLink() override;

  Time now() const override { return now_; }
  void wake() override {}  ///< work() asks after every step, in which alone anything comes to be
  void work(Time deadline, const std::function<bool(const PioneerClient&)>& done) override;
  void with(const std::function<void(PioneerClient&)>& act) override;

  const Robot& robot() const { return *robot_; }
  StandInController& controller() { return controller_; }

  /// What becomes of bytes on their way; `to_robot` or from it. None arrive: the cable is out.
  using Damage = std::function<Bytes(Bytes bytes, bool to_robot)>;
  void damage(Damage damage) { damage_ = std::move(damage); }

  /// How long bytes that leave at `at` are held up on their way; they arrive in order all the same.
  using Delay = std::function<Duration(Time at, bool to_robot)>;
  void delay(Delay delay) { delay_ = std::move(delay); }

 private:
  struct Flight {
    Time arrival;
    int baud = 0;  // of the sender; 0 where there is none
    Bytes bytes;   // as damaged
  };

  void step(Time until);
  void send_to_robot();
  void send_to_client();
  void arrive();
  void launch(bool to_robot, Time at, int baud, Bytes bytes);
  Bytes land(bool at_robot, const Flight& flight);

  std::unique_ptr<Robot> robot_;
  StandInController controller_;
  std::unique_ptr<Endpoint> endpoint_;  // null in memory, as
  std::unique_ptr<Line> line_;
  PioneerClient client_;
  Damage damage_;
  Delay delay_;
  Time now_;
  std::deque<Flight> to_robot_;
  std::deque<Flight> to_client_;
  Bytes at_robot_;  // handed on by the kernel before their time
  Bytes at_client_;
};

}  // namespace panoptes::hw
