// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "core/base/time.h"
#include "hw/pioneer/packet.h"

namespace panoptes::hw {

/// What a base's address says: `serial:/dev/ttyUSB0`, `tcp:host:8101`.
struct LineAddress {
  bool serial = true;
  std::string path;  ///< of the port, or the host
  std::string port;  ///< of TCP

  /// Why it is no address, with the cure; empty when it is one.
  static std::string fault(const std::string& address);
  static LineAddress parse(const std::string& address);  ///< of one without fault
};

/// The bytes to a robot: a serial port at 8N1 without flow control, which nobody else may open at
/// the same time, or a TCP connection. Reading and writing never wait.
class Line {
 public:
  /// Throws DeviceError with the address and the cure: no such port, no permission, port in use, a
  /// host that is not known, refuses or does not answer within `at_most`.
  Line(const std::string& address, Duration at_most);
  ~Line();
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  const std::string& address() const { return address_; }
  bool serial() const { return serial_; }
  int fd() const { return fd_; }  ///< for poll()

  /// After all that was written is sent.
  void set_baud(int baud);

  /// What has arrived. Throws DeviceError when the cable is out or the peer has gone.
  Bytes read();
  /// As much as the line takes at once; a line that takes nothing is as good as one that is cut,
  /// and the robot's silence tells.
  void write(std::span<const std::uint8_t> bytes);

 private:
  std::string address_;
  bool serial_ = true;
  int fd_ = -1;
};

}  // namespace panoptes::hw
