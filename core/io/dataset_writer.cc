// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/dataset_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/geometry_fields.h"
#include "core/io/dataset_table.h"
#include "core/io/digits.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

// With a point before the exponent: without one Python's yaml takes 1e-04 for text.
std::string yaml_number(double number) {
  std::string text = shortest(number);
  const auto exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return text;
}

std::string listed(const std::vector<double>& numbers) {
  std::vector<std::string> texts;
  for (const double number : numbers) {
    texts.push_back(yaml_number(number));
  }
  return fmt::format("[{}]", joined(texts));
}

/// The lens in the words of EuRoC and Kalibr.
struct LensWords {
  const char* model;
  std::vector<double> coefficients;
};

LensWords words_of(const Distortion& distortion) {
  if (const auto* brown = std::get_if<BrownConrady>(&distortion)) {
    std::vector<double> all{brown->k1, brown->k2, brown->p1, brown->p2};
    if (brown->k3 != 0) {
      all.push_back(brown->k3);
    }
    return {"radial-tangential", all};
  }
  if (const auto* bent = std::get_if<Equidistant>(&distortion)) {
    return {"equidistant", {bent->k1, bent->k2, bent->k3, bent->k4}};
  }
  return {"radial-tangential", {0, 0, 0, 0}};
}

std::string camera_yaml(const RigCamera& camera) {
  const Intrinsics& lens = camera.intrinsics;
  const Mat3 R = camera.T_body_camera.rotation.toRotationMatrix();
  const Vec3& t = camera.T_body_camera.translation;
  std::vector<double> T;
  for (int row = 0; row < 3; ++row) {
    T.insert(T.end(), {R(row, 0), R(row, 1), R(row, 2), t[row]});
  }
  T.insert(T.end(), {0, 0, 0, 1});
  const LensWords words = words_of(lens.distortion);
  std::string roles;
  for (const std::string& role : camera.roles) {
    roles += " " + role;
  }
  return "# As believed. Body: on the floor between the wheels, x forward, y left, z up.\n"
         "sensor_type: camera\n"
         "comment: \"" +
         (roles.empty() ? "no role" : "roles:" + roles) +
         "\"\n"
         "T_BS:  # p_body = T_BS * p_camera\n"
         "  cols: 4\n"
         "  rows: 4\n"
         "  data: " +
         listed(T) + "\nrate_hz: " + yaml_number(camera.rate_hz) + "\nresolution: [" +
         std::to_string(lens.width_px) + ", " + std::to_string(lens.height_px) +
         "]\n"
         "camera_model: pinhole\n"
         "intrinsics: " +
         listed({lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px}) +
         "  # fu, fv, cu, cv\n"
         "distortion_model: " +
         words.model + "\ndistortion_coefficients: " + listed(words.coefficients) + "\n";
}

// The folder, and one inside.
const fs::path& made(const fs::path& folder, const char* inside) {
  make_folder(folder / inside);
  return folder;
}

// A camera that has taken no picture for so many of its periods lacks one.
constexpr double kLate_periods = 0.99;

}  // namespace

void make_folder(const fs::path& folder) {
  std::error_code fault;
  fs::create_directories(folder, fault);
  if (fault) {
    throw IoError(folder.string() + ": cannot be made: " + fault.message());
  }
}

PictureFolder::PictureFolder(fs::path folder, Kind kind)
    : folder_(std::move(folder)), kind_(kind), rows_(made(folder_, "data") / "data.csv") {
  rows_.append("#timestamp [ns],filename\n");
}

void PictureFolder::add(Time stamp, const cv::Mat& picture) {
  // Half of a noisy picture's bits are noise: looking for repeats in them costs twice the time and
  // saves nothing.
  const std::vector<int> how{cv::IMWRITE_PNG_STRATEGY, kind_ == Kind::kNoisy
                                                           ? cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY
                                                           : cv::IMWRITE_PNG_STRATEGY_RLE};
  std::vector<unsigned char> png;
  PANOPTES_CHECK(cv::imencode(".png", picture, png, how), "a picture becomes a PNG");
  const std::string name = std::to_string(stamp.time_since_epoch().count()) + ".png";
  const fs::path file = folder_ / "data" / name;
  try {
    GrowingFile(file).append({reinterpret_cast<const char*>(png.data()), png.size()});
  } catch (const IoError&) {
    std::error_code ignored;
    fs::remove(file, ignored);
    throw;
  }
  rows_.append(dataset_row(stamp, name));
}

cv::Mat millimetres(const cv::Mat& depth_m) {
  constexpr double kMost_mm = 65535;
  cv::Mat out(depth_m.size(), CV_16UC1);
  for (int row = 0; row < depth_m.rows; ++row) {
    const auto* from = depth_m.ptr<float>(row);
    auto* to = out.ptr<std::uint16_t>(row);
    for (int column = 0; column < depth_m.cols; ++column) {
      const double mm = std::isfinite(from[column]) ? std::round(1000.0 * from[column]) : 0;
      to[column] = static_cast<std::uint16_t>(std::clamp(mm, 0.0, kMost_mm));
    }
  }
  return out;
}

std::string depth_comment(const Intrinsics& lens) {
  return std::string("16 bit, millimetres along ") +
         (std::holds_alternative<Equidistant>(lens.distortion) ? "each pixel's ray"
                                                               : "the camera's axis") +
         "; 0: nothing is there; 65535: 65.535 m or farther";
}

std::string things_csv(const std::vector<std::string>& things) {
  std::string rows = "#number, thing\n0,nothing\n";
  for (std::size_t i = 0; i < things.size(); ++i) {
    rows += dataset_row(static_cast<std::int64_t>(i + 1), things[i]);
  }
  return rows;
}

DatasetWriter::DatasetWriter(fs::path folder, const RecordingInfo& info, const Rig& rig,
                             const Body& robot)
    : folder_(std::move(folder)), rig_(rig.cameras) {
  const fs::path mav = folder_ / "mav0";
  for (const char* name : {"odom0", "cmd0"}) {
    make_folder(mav / name);
  }
  write_file(folder_ / "recording.yaml", write_settings(info));
  write_file(folder_ / "rig.yaml", write_settings(rig));
  write_file(folder_ / "robot.yaml", write_settings(robot));
  write_file(mav / "body.yaml",
             "comment: \"on the floor between the wheels, x forward, y left, z up\"\n");
  write_file(mav / "odom0" / "sensor.yaml",
             "sensor_type: odometry\ncomment: \"what the wheels say, in odom: the body at the "
             "first observation\"\n");
  write_file(mav / "cmd0" / "sensor.yaml",
             "sensor_type: command\ncomment: \"velocity of the body that was asked for\"\n");
  for (const auto& [name, camera] : rig.cameras) {
    cameras_.emplace(name, PictureFolder(mav / name, PictureFolder::Kind::kNoisy));
    write_file(mav / name / "sensor.yaml", camera_yaml(camera));
  }
  events_.emplace(mav / "events.csv");
  events_->append("#timestamp [ns], event, subject, value\n");
  commands_.emplace(mav / "cmd0" / "data.csv");
  commands_->append("#timestamp [ns], v [m/s], w [rad/s], valid_for [ns]\n");
  odometry_.emplace(mav / "odom0" / "data.csv");
  odometry_->append("#timestamp [ns], x [m], y [m], theta [rad], v [m/s], w [rad/s]\n");
}

void DatasetWriter::add(const Observation& seen, Time now) {
  for (const auto& [name, picture] : seen.pictures) {
    const auto camera = cameras_.find(name);
    PANOPTES_CHECK(camera != cameras_.end(), "a picture is one of the rig's cameras'");
    camera->second.add(picture.stamp, picture.bgr);
  }
  add_events(seen, now);
  const Pose2& T = seen.odometry.T_odom_body;
  const Twist2& twist = seen.odometry.twist_body;
  odometry_->append(dataset_row(seen.stamp, T.x_m, T.y_m, T.theta_rad, twist.v_mps, twist.w_radps));
}

void DatasetWriter::add(const RecordedCommand& command) {
  commands_->append(dataset_row(command.stamp, command.command_body.v_mps,
                                command.command_body.w_radps,
                                std::int64_t{command.valid_for.count()}));
}

void DatasetWriter::add_event(Time stamp, std::string_view kind, std::string_view subject,
                              std::string_view value) {
  events_->append(dataset_row(stamp, kind, subject, value));
}

// What the tables of cameras and odometry do not say by themselves.
void DatasetWriter::add_events(const Observation& seen, Time now) {
  std::string rows;
  const auto number = [](Time t) { return std::to_string(t.time_since_epoch().count()); };
  if (seen.pictures.empty()) {
    rows += dataset_row(seen.stamp, "deadline", "", "");
  }
  if (now != seen.stamp) {
    rows += dataset_row(seen.stamp, "now", "", number(now));
  }
  if (seen.health.bumper_pressed != health_.bumper_pressed) {
    rows += dataset_row(seen.stamp, "bumper", "", seen.health.bumper_pressed ? "1" : "0");
  }
  if (seen.health.motors_enabled != health_.motors_enabled) {
    rows += dataset_row(seen.stamp, "motors", "", seen.health.motors_enabled ? "1" : "0");
  }
  health_ = seen.health;
  for (const auto& [name, picture] : seen.pictures) {
    if (picture.stamp != seen.stamp) {
      rows += dataset_row(seen.stamp, "picture", name, number(picture.stamp));
    }
    last_picture_[name] = picture.stamp;
  }
  for (const auto& [name, camera] : rig_) {
    if (seen.pictures.empty() || seen.pictures.contains(name)) {
      continue;
    }
    const auto last = last_picture_.find(name);
    if (last == last_picture_.end() ||
        to_seconds(seen.stamp - last->second) * camera.rate_hz > kLate_periods) {
      rows += dataset_row(seen.stamp, "missing", name, "");
      last_picture_[name] = seen.stamp;
    }
  }
  if (!rows.empty()) {
    events_->append(rows);
  }
}

}  // namespace panoptes
