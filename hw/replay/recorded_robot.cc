// SPDX-License-Identifier: BSD-3-Clause
#include "hw/replay/recorded_robot.h"

#include <algorithm>
#include <bit>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/data_files.h"

namespace panoptes::hw {
namespace {

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace

void bind(Fields& f, RecordedOptions& o) {
  f.require(f.writing() || f.present("dataset"), "dataset", "missing; it must name a folder");
  if (f.writing()) {
    std::string written = o.dataset.empty() ? o.dataset : portable_path(o.dataset);
    f("dataset", written);
    return;
  }
  f("dataset", o.dataset);
  o.mention = f.where("dataset");
  if (!o.dataset.empty()) {
    // what `--set` says is relative to where the program was called
    o.dataset = resolve_path(o.dataset, o.mention.starts_with("--set") ? "" : f.file());
    try {
      o.believed = read_beliefs(o.dataset);
    } catch (const ConfigError& error) {
      f.require(false, "dataset", error.what());
    }
  }
}

Rig recorded_rig(const RecordedOptions& options, const Dataset& dataset, Rig believed) {
  const std::string where = options.mention + (options.mention.empty() ? "" : ": ");
  for (auto& [name, camera] : believed.cameras) {
    if (std::find(dataset.cameras.begin(), dataset.cameras.end(), name) == dataset.cameras.end()) {
      throw ConfigError(where + "platform.dataset: has no pictures of the rig's camera " + name +
                        "; it has " + joined(dataset.cameras));
    }
    if (!camera.floor || camera.floor->H_body_px || !camera.floor->marks.empty()) {
      continue;
    }
    const RigCamera* surveyed = nullptr;
    if (dataset.believed.rig) {
      const auto same_name = dataset.believed.rig->cameras.find(name);
      surveyed = same_name == dataset.believed.rig->cameras.end() ? nullptr : &same_name->second;
    }
    if (surveyed == nullptr || !surveyed->floor ||
        (surveyed->floor->marks.empty() && !surveyed->floor->H_body_px)) {
      throw ConfigError(where + "platform.dataset: its rig.yaml has no surveyed marks for " + name +
                        "; give rig.cameras." + name + ".floor.marks or .homography");
    }
    camera.floor->marks = surveyed->floor->marks;
    camera.floor->H_body_px = surveyed->floor->H_body_px;
  }
  return believed;
}

/// Reads the pictures of the observations in order, at most a few ahead of who takes them.
class RecordedRobot::Pictures {
 public:
  using Set = std::map<std::string, Picture>;

  explicit Pictures(const Dataset& dataset) : dataset_(dataset), thread_([this] { read_all(); }) {}

  ~Pictures() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  Pictures(const Pictures&) = delete;
  Pictures& operator=(const Pictures&) = delete;

  /// Those of the next observation. Throws what reading them threw.
  Set take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !ready_.empty() || fault_; });
    if (ready_.empty()) {
      std::rethrow_exception(fault_);
    }
    Set set = std::move(ready_.front());
    ready_.pop_front();
    lock.unlock();
    changed_.notify_all();
    return set;
  }

 private:
  void read_all() {
    constexpr std::size_t kAhead = 4;
    try {
      for (const RecordedObservation& seen : dataset_.observations) {
        Set set;
        for (const auto& [name, picture] : seen.pictures) {
          set.emplace(name, Picture{picture.stamp, read_picture(dataset_, picture)});
        }
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return ready_.size() < kAhead || stopped_; });
        if (stopped_) {
          return;
        }
        ready_.push_back(std::move(set));
        lock.unlock();
        changed_.notify_all();
      }
    } catch (...) {  // for who takes them
      const std::lock_guard lock(mutex_);
      fault_ = std::current_exception();
      changed_.notify_all();
    }
  }

  const Dataset& dataset_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Set> ready_;
  std::exception_ptr fault_;
  bool stopped_ = false;
  std::thread thread_;  // last: it uses the rest
};

RecordedRobot::RecordedRobot(Dataset dataset, const Rig& rig, std::optional<RecordedTruth> truth)
    : dataset_(std::move(dataset)), truth_(std::move(truth)), timing_(recorded_timing(dataset_)) {
  if (truth_) {
    truth_->cut_to_fit(dataset_);
  }
  for (RecordedObservation& seen : dataset_.observations) {
    std::erase_if(seen.pictures,
                  [&rig](const auto& picture) { return !rig.cameras.contains(picture.first); });
  }
  pictures_ = std::make_unique<Pictures>(dataset_);
}

RecordedRobot::~RecordedRobot() = default;

Observation RecordedRobot::observe(Time deadline) {
  Observation seen;
  const RecordedObservation* next = ended() ? nullptr : &dataset_.observations[next_];
  if (next == nullptr || (!next->pictures.empty() && next->stamp > std::max(deadline, now_))) {
    now_ = std::max(deadline, now_);
    seen.stamp = now_;
  } else {
    seen.pictures = pictures_->take();
    seen.stamp = next->stamp;
    now_ = next->now;
    odometry_ = next->odometry;
    health_ = next->health;
    ++next_;
  }
  seen.odometry = odometry_;
  seen.health = health_;
  return seen;
}

void RecordedRobot::drive(const Twist2& command_body, Duration valid_for) {
  const std::vector<RecordedCommand>& commands = dataset_.commands;
  while (next_command_ < commands.size() && commands[next_command_].stamp < now_) {
    ++next_command_;
  }
  const bool cut_short = next_command_ == commands.size() && ended() && !commands.empty();
  if (diverged_ || cut_short) {  // of the last observation the answer may not have been recorded
    return;
  }
  const bool as_recorded =
      next_command_ < commands.size() && commands[next_command_].stamp == now_ &&
      same(commands[next_command_].command_body.v_mps, command_body.v_mps) &&
      same(commands[next_command_].command_body.w_radps, command_body.w_radps) &&
      commands[next_command_].valid_for == valid_for;
  if (!as_recorded) {
    diverged_ = now_;
  }
  ++next_command_;
}

std::optional<Twist2> RecordedRobot::recorded_command() const {
  const auto told =
      std::find_if(dataset_.commands.begin() + static_cast<std::ptrdiff_t>(next_command_),
                   dataset_.commands.end(),
                   [this](const RecordedCommand& command) { return command.stamp >= now_; });
  const bool now = told != dataset_.commands.end() && told->stamp == now_;
  return now ? std::optional<Twist2>(told->command_body) : std::nullopt;
}

std::optional<Truth> RecordedRobot::truth() const {
  return truth_ ? std::optional<Truth>(truth_->after(next_)) : std::nullopt;
}

Duration RecordedRobot::length() const {
  return dataset_.observations.back().now.time_since_epoch();
}

}  // namespace panoptes::hw
