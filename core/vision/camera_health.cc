// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/camera_health.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/vision/grey.h"

namespace panoptes {
namespace {

constexpr int kCells = 40;         // across a picture
constexpr int kNoiseApart_px = 3;  // farther than a mosaic's interpolation reaches

bool same_bits(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) {
    return false;
  }
  if (a.data == b.data) {
    return true;
  }
  for (int row = 0; row < a.rows; ++row) {
    if (std::memcmp(a.ptr(row), b.ptr(row), a.elemSize() * static_cast<std::size_t>(a.cols)) != 0) {
      return false;
    }
  }
  return true;
}

// By the median difference of pixels a little apart, which edges hardly move.
double noise_sigma_grey(const cv::Mat& grey) {
  std::array<int, 256> count{};
  int total = 0;
  for (int v = 0; v < grey.rows; v += 4) {
    const auto* row = grey.ptr<std::uint8_t>(v);
    for (int u = kNoiseApart_px; u < grey.cols; u += 2) {
      ++count[static_cast<std::size_t>(std::abs(row[u] - row[u - kNoiseApart_px]))];
      ++total;
    }
  }
  int below = 0;
  for (std::size_t difference = 0; difference < count.size(); ++difference) {
    if (2 * (below + count[difference]) >= total) {
      const double within = count[difference] == 0 ? 0 : (0.5 * total - below) / count[difference];
      constexpr double kMedianOfDifference = 0.954;  // of a normal value's, in its sigma
      return std::max(0.0, static_cast<double>(difference) - 0.5 + within) / kMedianOfDifference;
    }
    below += count[difference];
  }
  return 0;
}

// Cells that differ from the line between their neighbours by more than noise does.
cv::Mat structure(const CameraHealthOptions& options, const cv::Mat& grey, int cell_px) {
  const cv::Size cells(std::max(3, grey.cols / cell_px), std::max(3, grey.rows / cell_px));
  cv::Mat mean;
  cv::Mat few;
  grey.convertTo(few, CV_32F);
  cv::resize(few, mean, cells, 0, 0, cv::INTER_AREA);
  const double noise_of_mean = noise_sigma_grey(grey) / cell_px;
  const auto least = static_cast<float>(
      std::max(options.min_contrast_grey, options.noise_sigmas * std::sqrt(6.0) * noise_of_mean));
  cv::Mat shows = cv::Mat::zeros(cells, CV_8UC1);
  for (int v = 1; v + 1 < cells.height; ++v) {
    for (int u = 1; u + 1 < cells.width; ++u) {
      const float here = 2 * mean.at<float>(v, u);
      const float across = mean.at<float>(v, u - 1) + mean.at<float>(v, u + 1);
      const float down = mean.at<float>(v - 1, u) + mean.at<float>(v + 1, u);
      if (std::abs(here - across) > least || std::abs(here - down) > least) {
        shows.at<std::uint8_t>(v, u) = 255;
      }
    }
  }
  return shows;
}

double share_of(const cv::Mat& picture, int low, int high) {
  cv::Mat within;
  cv::inRange(picture.reshape(1), cv::Scalar(low), cv::Scalar(high), within);
  return static_cast<double>(cv::countNonZero(within)) / static_cast<double>(within.total());
}

}  // namespace

std::string_view name_of(CameraState state) {
  constexpr std::array<std::string_view, 7> kNames{"good", "missing",   "late",   "frozen",
                                                   "dark", "saturated", "covered"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string told(const CameraReports& cameras) {
  std::string words;
  for (const auto& [name, report] : cameras) {
    if (report.state != CameraState::kGood) {
      words += (words.empty() ? "camera " : "; camera ") + name + ": ";
      words += name_of(report.state);
    }
  }
  return words;
}

void bind(Fields& f, CameraHealthOptions& o) {
  f("missing_periods", o.missing_periods, at_least(1));
  f("jitter_periods", o.jitter_periods, between(0, 1));
  f("moved_px", o.moved_px, positive);
  f("room_m", o.room_m, positive);
  f("noise_sigmas", o.noise_sigmas, positive);
  f("min_contrast_grey", o.min_contrast_grey, between(0, 255));
  f("blank_cells", o.blank_cells, not_negative);
  f("min_cells", o.min_cells, at_least(1));
  f("dark_grey", o.dark_grey, between(0, 255));
  f("dark_share", o.dark_share, between(0, 1));
  f("white_grey", o.white_grey, between(0, 255));
  f("white_share", o.white_share, between(0, 1));
  f("going_s", o.going_s, positive);
  f("nearest_m", o.nearest_m, positive);
  f("clock_pictures", o.clock_pictures, at_least(2));
  f("good_again_s", o.good_again_s, not_negative);
}

CameraHealth::CameraHealth(const Rig& rig, const CameraHealthOptions& options) : options_(options) {
  for (const auto& [name, camera] : rig.cameras) {
    if (camera.rate_hz > 0) {
      Watched watched;
      watched.period_s = 1 / camera.rate_hz;
      watched.fx_px = camera.intrinsics.fx_px;
      watched.clock_offset_s = camera.clock_offset_s;
      watched_.emplace(name, std::move(watched));
      CameraReport& report = reports_[name];
      report.is_floor = camera.has_role("floor");
      report.is_loop = camera.is_loop();
    }
  }
}

void CameraHealth::count_missing(const Observation& seen, const Picture* picture, Watched& camera,
                                 CameraReport& report) const {
  const Time now = picture != nullptr ? picture->stamp : seen.stamp;
  const double periods = to_seconds(now - camera.since) / camera.period_s;
  // one that is there comes half a period early at most
  const int due = std::max(0, static_cast<int>(std::floor(periods - options_.jitter_periods)));
  // one that comes behind a deadline was missing only so long
  const int missed = picture != nullptr ? due : std::max(camera.missed, due);
  report.missing += missed - camera.missed;
  camera.missed = missed;
}

CameraState CameraHealth::judge(const Observation& seen, const Picture& picture, Watched& camera,
                                CameraState before) const {
  const cv::Mat grey = grey_of(picture.bgr);
  const int cell_px = std::max(1, grey.cols / kCells);
  PictureSummary now{picture.stamp, seen.odometry.T_odom_body, structure(options_, grey, cell_px),
                     0};
  now.shown = cv::countNonZero(now.shows);
  const bool is_new = !camera.last || !same_bits(camera.last->bgr, picture.bgr);
  if (is_new) {
    camera.last = picture;
    camera.T_odom_last = seen.odometry.T_odom_body;
  }

  if (now.shown <= options_.blank_cells) {
    if (cv::mean(grey)[0] < options_.dark_grey ||
        share_of(picture.bgr, 0, 0) > options_.dark_share) {
      return CameraState::kDark;
    }
    if (share_of(grey, options_.white_grey, 255) > options_.white_share) {
      return CameraState::kSaturated;
    }
  }
  const Pose2 T_last_now = camera.T_odom_last.inverse() * seen.odometry.T_odom_body;
  const bool moved =
      std::abs(T_last_now.theta_rad) * camera.fx_px > options_.moved_px ||
      T_last_now.position().norm() * camera.fx_px > options_.moved_px * options_.room_m;
  if (!is_new && moved && (now.shown > options_.blank_cells || noise_sigma_grey(grey) > 0)) {
    return CameraState::kFrozen;
  }
  while (!camera.summaries.empty() &&
         to_seconds(now.stamp - camera.summaries.front().stamp) > options_.going_s) {
    camera.summaries.pop_front();
  }
  const bool shows_something = now.shown > options_.blank_cells;
  if (shows_something) {
    camera.least_blank_rad = camera.most_blank_rad = turned_rad_;
  } else {
    camera.least_blank_rad = std::min(camera.least_blank_rad, turned_rad_);
    camera.most_blank_rad = std::max(camera.most_blank_rad, turned_rad_);
  }
  if (before == CameraState::kCovered) {
    if (now.shown < options_.min_cells) {
      camera.shows_since.reset();
      return CameraState::kCovered;
    }
    camera.shows_since = camera.shows_since.value_or(now.stamp);
    if (to_seconds(now.stamp - *camera.shows_since) < options_.good_again_s) {
      return CameraState::kCovered;
    }
  }
  camera.shows_since.reset();
  if (!shows_something) {
    if (camera.most_blank_rad - camera.least_blank_rad > std::numbers::pi) {
      return CameraState::kCovered;  // no wall is all around
    }
    for (const PictureSummary& earlier : camera.summaries) {
      const Pose2 T_earlier_now = earlier.T_odom_body.inverse() * now.T_odom_body;
      const double motion_px =
          camera.fx_px * (std::abs(T_earlier_now.theta_rad) +
                          T_earlier_now.position().norm() / options_.nearest_m);
      const int margin = 2 + static_cast<int>(std::ceil(motion_px / cell_px));
      const cv::Size size = earlier.shows.size();
      if (2 * margin >= std::min(size.width, size.height)) {
        continue;
      }
      const cv::Rect inside(margin, margin, size.width - 2 * margin, size.height - 2 * margin);
      if (cv::countNonZero(earlier.shows(inside)) >= options_.min_cells) {
        return CameraState::kCovered;  // it cannot have left the picture
      }
    }
    return CameraState::kGood;
  }
  camera.summaries.push_back(std::move(now));
  return CameraState::kGood;
}

const CameraReports& CameraHealth::check(const Observation& seen) {
  const double heading_rad = seen.odometry.T_odom_body.theta_rad;
  turned_rad_ += wrap_angle(heading_rad - heading_rad_.value_or(heading_rad));
  heading_rad_ = heading_rad;
  for (auto& [name, camera] : watched_) {
    CameraReport& report = reports_.at(name);
    if (!last_) {
      camera.since = seen.stamp;
    } else if (report.state != CameraState::kGood) {
      report.lost += std::max(Duration{}, seen.stamp - *last_);
    }
    const auto found = seen.pictures.find(name);
    const bool is_there = found != seen.pictures.end() &&
                          (!camera.last_stamp || found->second.stamp > *camera.last_stamp);
    const Picture* picture = is_there ? &found->second : nullptr;
    count_missing(seen, picture, camera, report);
    CameraState state = report.state;
    if (picture != nullptr) {
      camera.since = picture->stamp;
      camera.last_stamp = picture->stamp;
      camera.missed = 0;
      const double age_s = to_seconds(seen.stamp - picture->stamp) + camera.clock_offset_s;
      ++camera.pictures;
      camera.least_age_s = std::min(camera.least_age_s, age_s);
      camera.most_age_s = std::max(camera.most_age_s, age_s);
      const bool late = age_s > options_.missing_periods * camera.period_s;
      state = late ? CameraState::kLate : judge(seen, *picture, camera, report.state);
    } else if (to_seconds(seen.stamp - camera.since) > options_.missing_periods * camera.period_s) {
      state = CameraState::kMissing;
    }
    if (picture != nullptr) {
      report.late += state == CameraState::kLate ? 1 : 0;
      report.frozen += state == CameraState::kFrozen ? 1 : 0;
      report.dark += state == CameraState::kDark ? 1 : 0;
      report.saturated += state == CameraState::kSaturated ? 1 : 0;
      report.covered += state == CameraState::kCovered ? 1 : 0;
    }
    if ((state == CameraState::kGood) != (report.state == CameraState::kGood)) {
      report.since = seen.stamp;
    }
    report.state = state;
  }
  last_ = std::max(seen.stamp, last_.value_or(seen.stamp));  // a late set follows a deadline
  return reports_;
}

std::string CameraHealth::wrong_clock() const {
  for (const auto& [name, camera] : watched_) {
    if (camera.pictures >= options_.clock_pictures &&
        camera.least_age_s > options_.missing_periods * camera.period_s &&
        camera.most_age_s - camera.least_age_s < camera.period_s) {
      return fmt::format(
          "the stamps of {} look {:.2f} s early against the odometry's: every picture was so old "
          "when it came; see clock_offset_s in the rig file",
          name, camera.least_age_s);
    }
  }
  return "";
}

Observation CameraHealth::accepted(const Observation& seen) const {
  Observation accepted = seen;
  std::erase_if(accepted.pictures, [this](const auto& picture) {
    const auto report = reports_.find(picture.first);
    return report != reports_.end() && report->second.state != CameraState::kGood;
  });
  return accepted;
}

}  // namespace panoptes
