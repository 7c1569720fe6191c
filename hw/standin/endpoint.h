// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "hw/pioneer/packet.h"

namespace panoptes::hw {

/// Where a client comes to. Nothing here blocks. What is written while nobody is there, or cannot
/// be taken at once, is lost as on a wire.
class Endpoint {
 public:
  virtual ~Endpoint() = default;

  virtual const std::string& name() const = 0;  ///< as a client writes it: `tcp:127.0.0.1:8101`
  virtual Bytes read() = 0;                     ///< what has arrived; lets clients in and out
  virtual void write(std::span<const std::uint8_t> bytes) = 0;
  virtual bool connected() const = 0;

  /// To wait for bytes or a client by poll(); -1 where nothing can be waited for, and read() is to
  /// be asked now and then.
  virtual int fd() const = 0;

  /// At which the client sends and listens; empty where the link has none.
  virtual std::optional<int> client_baud() const { return std::nullopt; }

 protected:
  Endpoint() = default;
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;
};

/// A pseudo-terminal in place of a serial port. A client is there as long as it is held open.
class PtyEndpoint final : public Endpoint {
 public:
  /// `link`, unless empty, is a path that leads to it while it lives; one that was left behind is
  /// taken over. Throws DeviceError.
  explicit PtyEndpoint(std::string link = {});
  ~PtyEndpoint() override;

  const std::string& name() const override { return name_; }  ///< `serial:/dev/pts/4`
  Bytes read() override;
  void write(std::span<const std::uint8_t> bytes) override;
  bool connected() const override;
  int fd() const override { return connected() ? master_ : -1; }
  std::optional<int> client_baud() const override;

 private:
  int master_ = -1;
  std::string link_;
  std::string name_;
};

/// A TCP port. One client at a time: another is sent away.
class TcpEndpoint final : public Endpoint {
 public:
  /// Port 0 is any free one. Throws DeviceError.
  TcpEndpoint(const std::string& host, int port);
  ~TcpEndpoint() override;

  const std::string& name() const override { return name_; }
  Bytes read() override;
  void write(std::span<const std::uint8_t> bytes) override;
  bool connected() const override { return client_ >= 0; }
  int fd() const override { return connected() ? client_ : listener_; }
  int port() const { return port_; }

 private:
  void greet();
  void part();

  int listener_ = -1;
  int client_ = -1;
  int port_ = 0;
  std::string name_;
};

/// What a serial port that is set to one speed makes of bytes sent at another: it waits for the
/// line to fall and samples the middle of every bit where it expects it.
Bytes misread(std::span<const std::uint8_t> bytes, int sent_baud, int read_baud);

}  // namespace panoptes::hw
