// SPDX-License-Identifier: BSD-3-Clause
#include "apps/evaluate/given_truth.h"

#include <algorithm>
#include <ctime>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "apps/serve/served_truth.h"
#include "core/base/error.h"
#include "core/eval/loops.h"
#include "core/eval/trajectory.h"
#include "core/io/tum.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

struct Span {
  Time from;
  Time to;
};

// An instant of a clock that began at `start_unix_ns`, as people write it.
std::string utc(std::int64_t start_unix_ns, Time stamp) {
  const auto ms = std::chrono::floor<std::chrono::milliseconds>(Duration(start_unix_ns) +
                                                                stamp.time_since_epoch());
  const auto s = std::chrono::floor<std::chrono::seconds>(ms);
  return fmt::format("{:%Y-%m-%d %H:%M:%S}.{:03d}", fmt::gmtime(std::time_t(s.count())),
                     (ms - s).count());
}

std::string spelt(std::int64_t start_unix_ns, const Span& span) {
  return utc(start_unix_ns, span.from) + " to " + utc(start_unix_ns, span.to) + " UTC";
}

GivenTruth read_trajectory(const fs::path& tum) {
  GivenTruth given;
  given.known.touches_known = false;
  const fs::path metrics = tum.parent_path() / "metrics.json";
  std::error_code ignored;
  if (fs::exists(metrics, ignored)) {
    given.start_unix_ns = start_unix_ns_of(metrics).value_or(0);
  }
  try {
    for (const TumPose& pose : read_tum(tum)) {
      TruePose known;
      known.stamp = pose.stamp;
      known.T_scene_body = floor_pose(pose);
      given.known.truth.poses.push_back(known);
    }
  } catch (const IoError& error) {
    throw ConfigError(error.what());
  }
  return given;
}

// What was true at an instant that it knows of: between two poses.
TruePose true_at(const std::vector<TruePose>& poses, Time stamp) {
  auto near = std::lower_bound(poses.begin(), poses.end(), stamp,
                               [](const TruePose& pose, Time t) { return pose.stamp < t; });
  if (near == poses.end() ||
      (near != poses.begin() && stamp - std::prev(near)->stamp < near->stamp - stamp)) {
    --near;
  }
  TruePose at = *near;
  at.stamp = stamp;
  at.T_scene_body = true_pose_at(poses, stamp);
  return at;
}

// Between poses farther apart than this a robot that speeds up by 0.6 m/s^2 may be 2 cm off the
// straight line.
constexpr Duration kLongestGap = std::chrono::milliseconds(500);

int keyframes_in_gaps(const FinishedRun& run, const std::vector<TruePose>& poses) {
  return static_cast<int>(std::count_if(
      run.result.keyframes.begin(), run.result.keyframes.end(), [&](const KeyframePose& keyframe) {
        const auto next =
            std::lower_bound(poses.begin(), poses.end(), keyframe.stamp,
                             [](const TruePose& pose, Time t) { return pose.stamp < t; });
        return next != poses.begin() && next != poses.end() && next->stamp != keyframe.stamp &&
               next->stamp - std::prev(next)->stamp > kLongestGap;
      }));
}

}  // namespace

GivenTruth read_given_truth(const fs::path& truth) {
  std::error_code ignored;
  GivenTruth given;
  if (fs::is_directory(truth, ignored)) {
    ServedTruth served = read_served_truth(truth);
    given.known.truth = std::move(served.truth);
    given.start_unix_ns = served.start_unix_ns;
  } else if (truth.extension() == ".tum") {
    given = read_trajectory(truth);
  } else {
    throw ConfigError(truth.string() +
                      (fs::exists(truth, ignored)
                           ? ": is no truth; give a folder that panoptes serve has written, or a "
                             "trajectory that ends in .tum"
                           : ": is not there"));
  }
  given.name = truth.string();
  if (given.known.truth.poses.empty()) {
    throw ConfigError(given.name + ": holds no whole pose");
  }
  return given;
}

RunTruth truth_during(const FinishedRun& run, const std::string& run_name, const GivenTruth& given,
                      std::vector<std::string>& warnings) {
  if (!run.info.start_unix_ns) {
    throw ConfigError(run_name +
                      "/metrics.json: start_unix_ns: missing; the run's clock cannot be matched "
                      "with the truth's: give a run of a robot that is real or served");
  }
  RunTruth during = given.known;
  Truth& truth = during.truth;
  const Duration ahead(given.start_unix_ns - *run.info.start_unix_ns);
  for (TruePose& pose : truth.poses) {
    pose.stamp += ahead;
  }
  for (TrueContact& contact : truth.contacts) {
    contact.stamp += ahead;
  }
  const std::vector<TruePose> all = std::exchange(truth.poses, {});
  const Span known{all.front().stamp, all.back().stamp};
  const Time first = run.frames.front().stamp;
  const Span needed{first,
                    run.result.keyframes.empty() ? first : run.result.keyframes.back().stamp};
  constexpr Duration kRounded = std::chrono::milliseconds(1);  // stamps that others have written
  if (needed.from < known.from - kRounded || needed.to > known.to + kRounded) {
    const std::int64_t start = *run.info.start_unix_ns;
    throw ConfigError(fmt::format(
        "{}: tells of {}, but {} needs it from {}; give the truth of that time, or one whose "
        "start_unix_ns is by the same clock",
        given.name, spelt(start, known), run_name, spelt(start, needed)));
  }
  const Time last = std::max(needed.to, std::min(run.last_step, known.to));
  truth.poses.push_back(true_at(all, first));
  for (const TruePose& pose : all) {
    if (pose.stamp > first && pose.stamp < last) {
      truth.poses.push_back(pose);
    }
  }
  if (last > first) {
    truth.poses.push_back(true_at(all, last));
  }
  std::erase_if(truth.contacts, [&](const TrueContact& contact) {
    return contact.stamp < first || contact.stamp > run.last_step;
  });
  std::vector<Pose2> trajectory;
  for (const TruePose& pose : truth.poses) {
    trajectory.push_back(pose.T_scene_body);
  }
  truth.path_m = path_lengths_m(trajectory).back();
  if (run.last_step - last > kLongestGap) {
    warnings.push_back(fmt::format("{}: ends {:.1f} s before the run; nothing is known of the rest",
                                   given.name, to_seconds(run.last_step - last)));
  }
  if (const int in_gaps = keyframes_in_gaps(run, all); in_gaps > 0) {
    warnings.push_back(
        fmt::format("{}: has no pose for more than {} s around {} of {} keyframes; their true "
                    "poses are interpolated",
                    given.name, to_seconds(kLongestGap), in_gaps, run.result.keyframes.size()));
  }
  return during;
}

}  // namespace panoptes
