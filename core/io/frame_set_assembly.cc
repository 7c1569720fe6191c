// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/frame_set_assembly.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/geometry/arc.h"
#include "core/io/dataset_rows.h"
#include "core/io/dataset_table.h"
#include "core/io/gaps.h"

namespace panoptes {
namespace {

using Pictures = std::vector<RecordedPicture>;
using Cameras = std::map<std::string, Pictures>;

Duration period_of(const Pictures& pictures) {
  std::vector<Time> stamps;
  for (const RecordedPicture& picture : pictures) {
    stamps.push_back(picture.stamp);
  }
  return median_period(stamps);
}

// The camera with the most pictures a second; of those alike the one with the most of all.
Cameras::const_iterator fastest(const Cameras& cameras) {
  const auto rank = [](const Pictures& pictures) {
    const Duration period = period_of(pictures);
    return std::pair(period.count() > 0 ? period : Duration::max(), -std::ssize(pictures));
  };
  return std::min_element(cameras.begin(), cameras.end(), [&](const auto& a, const auto& b) {
    return rank(a.second) < rank(b.second);
  });
}

// Sets at the pictures of `leader`; of the other cameras' pictures those that no set takes are
// left in `cameras`.
std::vector<RecordedObservation> led_by(const std::string& leader, Duration most_apart,
                                        Cameras& cameras) {
  std::vector<RecordedObservation> sets;
  auto leading = cameras.extract(leader);
  for (RecordedPicture& picture : leading.mapped()) {
    RecordedObservation set;
    set.stamp = set.now = picture.stamp;
    set.pictures.emplace(leader, std::move(picture));
    sets.push_back(std::move(set));
  }
  for (auto& [name, pictures] : cameras) {
    Pictures left;
    for (RecordedPicture& picture : pictures) {
      auto near = std::lower_bound(
          sets.begin(), sets.end(), picture.stamp,
          [](const RecordedObservation& set, Time stamp) { return set.stamp < stamp; });
      if (near == sets.end() || (near != sets.begin() && picture.stamp - std::prev(near)->stamp <
                                                             near->stamp - picture.stamp)) {
        --near;
      }
      const Duration apart = std::chrono::abs(picture.stamp - near->stamp);
      const auto taken = near->pictures.find(name);
      if (apart > most_apart) {
        left.push_back(std::move(picture));
      } else if (taken == near->pictures.end()) {
        near->pictures.emplace(name, std::move(picture));
      } else {
        if (apart < std::chrono::abs(taken->second.stamp - near->stamp)) {
          std::swap(taken->second, picture);
        }
        left.push_back(std::move(picture));
      }
    }
    pictures = std::move(left);
  }
  return sets;
}

}  // namespace

std::vector<RecordedObservation> assemble_frame_sets(Cameras cameras) {
  std::vector<RecordedObservation> sets;
  std::erase_if(cameras, [](const auto& camera) { return camera.second.empty(); });
  const Duration most_apart =
      cameras.empty() ? Duration{} : period_of(fastest(cameras)->second) / 2;
  while (!cameras.empty()) {
    std::vector<RecordedObservation> more = led_by(fastest(cameras)->first, most_apart, cameras);
    std::move(more.begin(), more.end(), std::back_inserter(sets));
    std::erase_if(cameras, [](const auto& camera) { return camera.second.empty(); });
  }
  std::stable_sort(sets.begin(), sets.end(),
                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  Time now = sets.empty() ? Time{} : sets.front().stamp;
  for (RecordedObservation& set : sets) {
    for (const auto& [name, picture] : set.pictures) {
      now = std::max(now, picture.stamp);
    }
    set.now = now;
  }
  return sets;
}

Odometry odometry_at(const std::vector<StampedOdometry>& rows, Time stamp) {
  const auto next =
      std::lower_bound(rows.begin(), rows.end(), stamp,
                       [](const StampedOdometry& row, Time t) { return row.stamp < t; });
  PANOPTES_CHECK(next != rows.end() && (next != rows.begin() || next->stamp == stamp),
                 "the instant lies within the rows");
  if (next->stamp == stamp) {
    return next->odometry;
  }
  const StampedOdometry& before = *std::prev(next);
  const double share = to_seconds(stamp - before.stamp) / to_seconds(next->stamp - before.stamp);
  const Twist2& from = before.odometry.twist_body;
  const Twist2& to = next->odometry.twist_body;
  Odometry between;
  between.T_odom_body = on_arc(before.odometry.T_odom_body, next->odometry.T_odom_body, share);
  between.twist_body = {from.v_mps + share * (to.v_mps - from.v_mps),
                        from.w_radps + share * (to.w_radps - from.w_radps)};
  return between;
}

void add_velocities(std::vector<StampedOdometry>& rows) {
  constexpr Duration kAbout = std::chrono::milliseconds(50);  // stamps may be a few ms off
  std::size_t from = 0;
  std::size_t to = 0;
  if (rows.size() < 2) {
    return;
  }
  for (StampedOdometry& row : rows) {
    while (to + 1 < rows.size() && rows[to].stamp < row.stamp + kAbout) {
      ++to;
    }
    while (rows[from + 1].stamp <= row.stamp - kAbout) {
      ++from;
    }
    const Pose2 motion = rows[from].odometry.T_odom_body.inverse() * rows[to].odometry.T_odom_body;
    const double time_s = to_seconds(rows[to].stamp - rows[from].stamp);
    const Vec2 ahead = Pose2{0, 0, -motion.theta_rad / 2} * motion.position();
    row.odometry.twist_body = {ahead.x() / time_s, motion.theta_rad / time_s};
  }
}

std::vector<StampedOdometry> recorded_odometry(const std::string& folder, const DatasetText& text,
                                               TableBy by) {
  const std::optional<std::string> found = text(std::string(kOdometryFile));
  if (!found) {
    throw ConfigError(in_folder(folder, kOdometryFile) + ": is missing");
  }
  const DatasetTable table(in_folder(folder, kOdometryFile), *found,
                           by == TableBy::kPanoptes ? 6 : 4, by);
  if (table.columns() != 4 && table.columns() != 6) {
    throw ConfigError(table.place(0) + ": has " + std::to_string(table.columns()) +
                      " fields, must have 4 or 6: #timestamp [ns], x [m], y [m], theta [rad], and "
                      "v [m/s], w [rad/s] where they are known");
  }
  std::vector<StampedOdometry> rows;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const StampedOdometry here{table.stamp(row, 0), odometry_row(table, row)};
    if (!rows.empty()) {
      if (here.stamp <= rows.back().stamp) {
        throw table.fault(row, "is not after the row before; rows must be in the order of time");
      }
      check_speed(table, row, rows.back().odometry, here.odometry, here.stamp - rows.back().stamp);
    }
    rows.push_back(here);
  }
  if (rows.empty()) {
    throw ConfigError(table.file() + ": holds no row");
  }
  if (table.columns() == 4) {
    add_velocities(rows);
  }
  return rows;
}

namespace {

// Without pictures and without a word of the wheels; in a long pause less often.
constexpr Duration kLongestWait = std::chrono::milliseconds(500);
constexpr int kMostWaits = 100;

Cameras read_cameras(const Dataset& dataset, const Rig& rig, const DatasetText& text) {
  Cameras cameras;
  const auto is_used = [&rig](const std::string& name) { return rig.cameras.contains(name); };
  const bool all = std::none_of(dataset.cameras.begin(), dataset.cameras.end(), is_used);
  for (const std::string& name : dataset.cameras) {
    if (!all && !is_used(name)) {
      continue;
    }
    const std::optional<std::string> found = text(data_csv(name));
    if (!found) {
      throw no_pictures(dataset.folder, name);
    }
    const DatasetTable table(in_folder(dataset.folder, data_csv(name)), *found, 2,
                             TableBy::kOthers);
    cameras.emplace(name, picture_rows(table, name));
  }
  return cameras;
}

const std::string& mention(const RecordedObservation& set) {
  return set.pictures.begin()->second.mention;
}

// Leaves out the sets that odometry does not reach.
void keep_covered(std::vector<RecordedObservation>& sets, const std::vector<StampedOdometry>& rows,
                  Dataset& dataset) {
  const std::string file = in_folder(dataset.folder, kOdometryFile);
  if (sets.empty()) {
    throw ConfigError(in_folder(dataset.folder, "mav0") + ": has no picture of " +
                      joined(dataset.cameras));
  }
  const std::size_t all = sets.size();
  const Time first = sets.front().stamp;
  const Time last = sets.back().stamp;
  std::erase_if(sets, [&](const RecordedObservation& set) {
    return set.stamp < rows.front().stamp || set.stamp > rows.back().stamp;
  });
  const std::size_t left_out = all - sets.size();
  if (2 * left_out >= all) {
    throw ConfigError(fmt::format(
        "{}: goes from {} to {} ns, the pictures from {} to {} ns; it must reach from the first to "
        "the last, by the same clock",
        file, rows.front().stamp.time_since_epoch().count(),
        rows.back().stamp.time_since_epoch().count(), first.time_since_epoch().count(),
        last.time_since_epoch().count()));
  }
  if (left_out > 0) {
    dataset.warnings.push_back(fmt::format(
        "{}: begins {:.2f} s after the first pictures and ends {:.2f} s before the last; {} of {} "
        "frame sets are left out",
        file, std::max(0.0, to_seconds(rows.front().stamp - first)),
        std::max(0.0, to_seconds(last - rows.back().stamp)), left_out, all));
  }
}

}  // namespace

void assemble_observations(Dataset& dataset, const Rig& rig, const DatasetText& text) {
  const std::vector<StampedOdometry> rows =
      recorded_odometry(dataset.folder, text, TableBy::kOthers);
  std::vector<RecordedObservation> sets = assemble_frame_sets(read_cameras(dataset, rig, text));
  keep_covered(sets, rows, dataset);
  dataset.epoch = sets.front().stamp.time_since_epoch();
  const Pose2 T_first_odom = odometry_at(rows, sets.front().stamp).T_odom_body.inverse();
  const auto add = [&](RecordedObservation seen) {
    seen.odometry = odometry_at(rows, seen.stamp);
    seen.odometry.T_odom_body = T_first_odom * seen.odometry.T_odom_body;
    seen.stamp -= dataset.epoch;
    seen.now -= dataset.epoch;
    for (auto& [name, picture] : seen.pictures) {
      picture.stamp -= dataset.epoch;
    }
    dataset.observations.push_back(std::move(seen));
  };
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const Time next = i + 1 < sets.size() ? sets[i + 1].stamp : sets[i].stamp;
    const Time now = sets[i].now;
    if (next - sets[i].stamp > kLongestGap) {
      throw ConfigError(mention(sets[i + 1]) +
                        ": is over an hour after the picture before; that is no single drive: cut "
                        "the dataset there, or mend the stamp");
    }
    add(std::move(sets[i]));
    const Duration longest_wait = std::max(kLongestWait, (next - now) / kMostWaits);
    for (Time wait = now + longest_wait; wait < next; wait += longest_wait) {
      RecordedObservation seen;
      seen.stamp = seen.now = wait;
      add(std::move(seen));
    }
  }
  for (const StampedOdometry& row : rows) {
    dataset.odometry_rows.push_back(row.stamp - dataset.epoch);
  }
}

}  // namespace panoptes
