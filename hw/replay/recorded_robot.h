// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/io/dataset.h"
#include "hw/replay/truth_files.h"
#include "hw/robot.h"

namespace panoptes::hw {

struct RecordedOptions {
  static constexpr std::string_view kName = "recorded";
  static constexpr std::string_view kShort = "dataset";

  std::string dataset;            ///< its folder, relative to the file that says so
  std::string mention;            ///< file:line:column of what the user wrote
  RecordedBeliefs believed = {};  ///< what the dataset says of rig, robot and seed
};
void bind(Fields& f, RecordedOptions& o);

/// The rig that a recorded robot is driven with: `believed`, its cameras that map the floor with
/// the marks that were surveyed for the recording where it says nothing of them. Throws ConfigError
/// for cameras that the dataset has no pictures of, and for floors that nobody surveyed.
Rig recorded_rig(const RecordedOptions& options, const Dataset& dataset, Rig believed);

/// A recorded run behind the robots' contract: what was perceived comes again in the same order,
/// bit for bit; commands go nowhere. A deadline earlier than what was recorded next is met with the
/// odometry of the time before. Pictures are read a few frame sets ahead by a thread of its own.
class RecordedRobot final : public Robot {
 public:
  /// Pictures of cameras that `rig` does not have are left out. Throws ConfigError where the truth
  /// and the observations do not go together.
  RecordedRobot(Dataset dataset, const Rig& rig, std::optional<RecordedTruth> truth);
  ~RecordedRobot() override;

  /// After the end: odometry as it was, without pictures, at the deadline. Throws ConfigError for a
  /// picture that cannot be read.
  Observation observe(Time deadline) override;
  void drive(const Twist2& command_body, Duration valid_for) override;
  void stop() override {}
  Time now() const override { return now_; }
  std::optional<Truth> truth() const override;
  /// Whether the truth, if there is one, would tell of contacts.
  bool touches_known() const { return !truth_ || truth_->touches_known(); }
  std::optional<std::int64_t> start_unix_ns() const override {
    return panoptes::start_unix_ns(dataset_);
  }

  /// What the robot was told in the recording after what has just been observed; empty where it
  /// was told nothing.
  std::optional<Twist2> recorded_command() const;

  /// Everything that was recorded has been observed.
  bool ended() const { return next_ == dataset_.observations.size(); }
  Duration length() const;

  /// What the recording lacks because it was cut short, in words.
  const std::vector<std::string>& remarks() const { return dataset_.warnings; }

  /// From when on the robot was told something else than in the recording; empty as long as it was
  /// not.
  std::optional<Time> commands_diverged_at() const { return diverged_; }

 private:
  class Pictures;  // the thread that reads them

  Dataset dataset_;
  std::optional<RecordedTruth> truth_;
  std::size_t next_ = 0;
  std::size_t next_command_ = 0;
  Time now_{};
  Odometry odometry_;
  Health health_;
  std::optional<Time> diverged_;
  std::unique_ptr<Pictures> pictures_;
};

}  // namespace panoptes::hw
