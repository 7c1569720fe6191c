// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/base.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "core/base/error.h"
#include "hw/pioneer/emergency_stop.h"
#include "hw/pioneer/line.h"

namespace panoptes::hw {
namespace {

using Clock = std::chrono::steady_clock;

constexpr Duration kTcpWithin = std::chrono::seconds(3);
constexpr Duration kAtLeastEvery = std::chrono::milliseconds(100);
constexpr Duration kFarewell = std::chrono::milliseconds(200);  // four frames, and another baud

}  // namespace

class PioneerBase::Worker {
 public:
  Worker(const std::string& address, const Body& body)
      : line_(address, kTcpWithin), client_(address, line_.serial(), body), begun_(Clock::now()) {
    if (pipe2(wake_, O_NONBLOCK | O_CLOEXEC) != 0) {
      throw DeviceError(address + ": no pipe can be made; too many files are open");
    }
    thread_ = std::thread([this] { serve(); });
  }

  ~Worker() {
    {
      const std::lock_guard lock(mutex_);
      client_.leave(now());
    }
    wake();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kFarewell, [&] { return client_.next_poll() == Time::max(); });
    done_ = true;
    lock.unlock();
    wake();
    thread_.join();
    ::close(wake_[0]);
    ::close(wake_[1]);
  }

  Time now() const { return Time(Clock::now() - begun_); }
  std::int64_t start_unix_ns() const { return start_unix_ns_; }

  void work(Time deadline, const std::function<bool(const PioneerClient&)>& done) {
    std::unique_lock lock(mutex_);
    const auto until = begun_ + deadline.time_since_epoch();
    changed_.wait_until(lock, until, [&] { return thrown_ || done(client_); });
    throw_what_was_thrown();
  }

  // Whoever waits has either not asked yet, or sleeps.
  void wake_waiting() {
    { const std::lock_guard lock(mutex_); }
    changed_.notify_all();
  }

  void with(const std::function<void(PioneerClient&)>& act) {
    {
      const std::lock_guard lock(mutex_);
      throw_what_was_thrown();
      act(client_);
    }
    wake();
  }

 private:
  void wake() const {
    const char nothing = 0;
    [[maybe_unused]] const auto written =
        write(wake_[1], &nothing, 1);  // a full pipe wakes as well
  }

  // On the thread: to whoever asks first, once.
  void throw_what_was_thrown() {
    if (thrown_) {
      std::rethrow_exception(std::exchange(thrown_, nullptr));
    }
  }

  void carry() {
    const Bytes bytes = line_.read();
    if (!bytes.empty() && !failed_) {
      client_.receive(now(), bytes);
    }
    for (const PioneerClient::Transmission& next : client_.poll(now())) {
      if (next.baud) {
        line_.set_baud(*next.baud);
      }
      line_.write(next.bytes);
    }
  }

  void serve() {
    std::unique_lock lock(mutex_);
    bool whole = true;  // the line
    while (!done_) {
      if (whole) {
        try {
          carry();
        } catch (const DeviceError& error) {
          whole = false;
          client_.lose(error.what());
        } catch (...) {  // no memory, or a bug: the line is whole, and the robot is told to stop
          thrown_ = std::current_exception();
          failed_ = true;  // what it was reading may be half done
          client_.lose(line_.address() + ": given up, the program itself has failed");
        }
      }
      changed_.notify_all();
      const Duration rest =
          std::clamp(client_.next_poll() - now(), Duration::zero(), kAtLeastEvery);
      lock.unlock();
      pollfd waited[2] = {{wake_[0], POLLIN, 0}, {line_.fd(), POLLIN, 0}};
      timespec at_most{0, rest.count()};
      ppoll(waited, whole ? 2 : 1, &at_most, nullptr);
      char drained[64];
      while (read(wake_[0], drained, sizeof drained) > 0) {
      }
      lock.lock();
    }
  }

  Line line_;
  EmergencyStopRegistration emergency_stop_{line_.fd(), line_.serial()};
  PioneerClient client_;
  Clock::time_point begun_;
  std::int64_t start_unix_ns_ =
      std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch())
          .count();
  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  std::exception_ptr thrown_;
  bool failed_ = false;
  int wake_[2] = {-1, -1};
  std::thread thread_;
};

PioneerBase::PioneerBase(const std::string& address, const Body& body)
    : worker_(std::make_unique<Worker>(address, body)) {}

PioneerBase::~PioneerBase() = default;

Time PioneerBase::now() const { return worker_->now(); }

std::optional<std::int64_t> PioneerBase::start_unix_ns() const { return worker_->start_unix_ns(); }

void PioneerBase::wake() { worker_->wake_waiting(); }

void PioneerBase::work(Time deadline, const std::function<bool(const PioneerClient&)>& done) {
  worker_->work(deadline, done);
}

void PioneerBase::with(const std::function<void(PioneerClient&)>& act) { worker_->with(act); }

}  // namespace panoptes::hw
