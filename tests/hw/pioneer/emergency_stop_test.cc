// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/emergency_stop.h"

#include <array>
#include <optional>

#include <gmock/gmock.h>
#include <unistd.h>

#include "hw/pioneer/packet.h"

namespace panoptes::hw {
namespace {

class Pipe {
 public:
  Pipe() { EXPECT_EQ(::pipe(ends_.data()), 0); }
  ~Pipe() {
    ::close(ends_[0]);
    ::close(ends_[1]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int into() const { return ends_[1]; }

  /// What has been written, and an end of it.
  Bytes out() {
    const std::uint8_t end = 0;
    EXPECT_EQ(::write(ends_[1], &end, 1), 1);
    Bytes bytes(100);
    bytes.resize(static_cast<std::size_t>(::read(ends_[0], bytes.data(), bytes.size())));
    bytes.pop_back();
    return bytes;
  }

 private:
  std::array<int, 2> ends_{};
};

TEST(EmergencyStop, SendsStopThriceToEveryRegisteredLine) {
  Bytes stops;
  for (int i = 0; i < 3; ++i) {
    const Bytes stop = command_frame(Command::kStop);
    stops.insert(stops.end(), stop.begin(), stop.end());
  }
  Pipe serial;
  Pipe tcp;
  std::optional<EmergencyStopRegistration> of_serial(std::in_place, serial.into(), true);
  const EmergencyStopRegistration of_tcp(tcp.into(), false);
  stop_registered_robots();
  EXPECT_EQ(serial.out(), stops);
  EXPECT_EQ(tcp.out(), stops);
  of_serial.reset();
  stop_registered_robots();
  EXPECT_THAT(serial.out(), testing::IsEmpty());
  EXPECT_EQ(tcp.out(), stops);
}

}  // namespace
}  // namespace panoptes::hw
