// SPDX-License-Identifier: BSD-3-Clause
#include "hw/replay/truth_files.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <opencv2/imgcodecs.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/config/geometry_fields.h"
#include "core/io/dataset_table.h"
#include "core/io/dataset_writer.h"
#include "core/io/file.h"

namespace panoptes::hw {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTruth = "mav0/truth0";
constexpr std::string_view kEstimate = "mav0/state_groundtruth_estimate0";

/// Where a layer lies.
struct LayerPlace {
  double cell_m = 0;
  Vec2 origin_m = Vec2::Zero();
  int columns = 0;
  int rows = 0;
};
void bind(Fields& f, LayerPlace& o) {
  constexpr double kMost_cells = 1e5;  // 1 km of 1 cm
  constexpr double kFinest_m = 1e-3;
  f("cell_m", o.cell_m, between(0, 1));
  f("origin_m", o.origin_m);
  f.require(o.origin_m.cwiseAbs().maxCoeff() <= kFarthest_m, "origin_m",
            "must be within 1000 km of 0");
  f("columns", o.columns, between(0, kMost_cells));
  f("rows", o.rows, between(0, kMost_cells));
  f.require(o.columns == 0 || o.rows == 0 || o.cell_m >= kFinest_m, "cell_m",
            "must be at least 0.001 where there are cells");
  constexpr double kMost = 1e9;  // a byte each
  f.require(static_cast<double>(o.columns) * o.rows <= kMost, "rows", "too many cells");
}

struct LayerPlaces {
  LayerPlace floor;
  LayerPlace body;
  LayerPlace seen;
};
void bind(Fields& f, LayerPlaces& o) {
  f.needed("floor", o.floor);
  f.needed("body", o.body);
  f.needed("seen", o.seen);
}

LayerPlace place_of(const TruthLayer& layer) {
  return {layer.cell_m, layer.origin, layer.columns, layer.rows};
}

TruthLayer empty_layer(const LayerPlace& place) {
  TruthLayer layer{place.cell_m, place.origin_m, place.columns, place.rows, {}};
  layer.cells.resize(layer.size());
  return layer;
}

// A layer without cells leaves no picture.
void write_layer(const fs::path& file, const TruthLayer& layer) {
  if (layer.cells.empty()) {
    return;
  }
  cv::Mat picture(layer.rows, layer.columns, CV_8UC1);
  for (int row = 0; row < layer.rows; ++row) {
    auto* pixels = picture.ptr<std::uint8_t>(layer.rows - 1 - row);
    const auto* cells = &layer(0, row);
    std::transform(cells, cells + layer.columns, pixels,
                   [](std::uint8_t cell) { return cell != 0 ? 255 : 0; });
  }
  std::vector<unsigned char> png;
  PANOPTES_CHECK(cv::imencode(".png", picture, png), "a layer becomes a PNG");
  write_file(file, {reinterpret_cast<const char*>(png.data()), png.size()});
}

std::string there(const fs::path& file, const std::optional<std::string>& text) {
  if (!text) {
    throw ConfigError(file.string() + ": is not there");
  }
  return *text;
}

TruthLayer read_layer(const fs::path& file, const LayerPlace& place) {
  TruthLayer layer = empty_layer(place);
  const std::optional<std::string> found = read_part(file);
  if (!found && layer.cells.empty()) {
    return layer;
  }
  const std::string bytes = there(file, found);
  cv::Mat picture;
  try {
    if (!bytes.empty()) {
      picture = cv::imdecode(
          cv::Mat(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data())),
          cv::IMREAD_GRAYSCALE);
    }
  } catch (const cv::Exception&) {  // said below
    picture.release();
  }
  if (picture.cols != place.columns || picture.rows != place.rows) {
    throw ConfigError(file.string() + ": must be a picture of " + std::to_string(place.columns) +
                      " x " + std::to_string(place.rows) + " pixels, as layers.yaml says");
  }
  for (int row = 0; row < layer.rows; ++row) {
    const auto* pixels = picture.ptr<std::uint8_t>(layer.rows - 1 - row);
    auto* cells = &layer(0, row);
    std::transform(pixels, pixels + layer.columns, cells,
                   [](std::uint8_t grey) { return static_cast<std::uint8_t>(grey > 127 ? 1 : 0); });
  }
  return layer;
}

GrowingFile table(const fs::path& file, std::string_view header) {
  make_folder(file.parent_path());
  GrowingFile made(file);
  made.append(header);
  return made;
}

// As EuRoC has it: position, attitude and velocity; gyroscopes and accelerometers have no bias, for
// there are none.
std::string estimate_row(const TruePose& pose) {
  const Eigen::AngleAxisd turned(pose.T_scene_body.theta_rad, Vec3::UnitZ());
  const Eigen::Quaterniond q = turned * Eigen::AngleAxisd(pose.pitch_rad, Vec3::UnitY()) *
                               Eigen::AngleAxisd(pose.roll_rad, Vec3::UnitX());
  const Vec3 v = turned * Vec3(pose.twist_body.v_mps, 0, 0);
  return dataset_row(pose.stamp, pose.T_scene_body.x_m, pose.T_scene_body.y_m, pose.heave_m, q.w(),
                     q.x(), q.y(), q.z(), v.x(), v.y(), v.z(), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
}

std::int64_t count(std::size_t n) { return static_cast<std::int64_t>(n); }

DatasetTable read_table(const fs::path& file, std::size_t columns) {
  return {file.string(), there(file, read_part(file)), columns};
}

}  // namespace

TruthWriter::TruthWriter(const fs::path& folder, const Truth& truth)
    : seen_(truth.seen),
      data_csv_(table(folder / kTruth / "data.csv",
                      "#timestamp [ns], path [m], poses, contacts, seen\n")),
      poses_csv_(table(folder / kTruth / "poses.csv",
                       "#timestamp [ns], x [m], y [m], theta [rad], v [m/s], w [rad/s], clearance "
                       "[m], pitch [rad], roll [rad], heave [m]\n")),
      contacts_csv_(table(folder / kTruth / "contacts.csv",
                          "#timestamp [ns], x [m], y [m], moving, object\n")),
      seen_csv_(table(folder / kTruth / "seen.csv", "#timestamp [ns], row, column, count\n")),
      estimate_csv_(table(
          folder / kEstimate / "data.csv",
          "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
          "q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad "
          "s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m "
          "s^-2], b_a_RS_S_z [m s^-2]\n")) {
  write_file(folder / kEstimate / "sensor.yaml",
             "sensor_type: ground_truth\ncomment: \"the body in scene, exactly\"\n");
  write_file(folder / kTruth / "layers.yaml",
             write_settings(
                 LayerPlaces{place_of(truth.floor), place_of(truth.body), place_of(truth.seen)}));
  write_file(folder / kTruth / "platform.yaml",
             write_settings(TruePlatform{truth.rig, truth.wheels}));
  write_layer(folder / kTruth / "floor.png", truth.floor);
  write_layer(folder / kTruth / "body.png", truth.body);
  std::fill(seen_.cells.begin(), seen_.cells.end(), std::uint8_t{0});
}

void TruthWriter::add(Time observation, const Truth& news) {
  std::string rows;
  std::string estimates;
  for (const TruePose& pose : news.poses) {
    const Pose2& T = pose.T_scene_body;
    rows += dataset_row(pose.stamp, T.x_m, T.y_m, T.theta_rad, pose.twist_body.v_mps,
                        pose.twist_body.w_radps, pose.clearance_m, pose.pitch_rad, pose.roll_rad,
                        pose.heave_m);
    estimates += estimate_row(pose);
  }
  if (!rows.empty()) {
    poses_csv_.append(rows);
    estimate_csv_.append(estimates);
  }
  for (const TrueContact& contact : news.contacts) {
    contacts_csv_.append(dataset_row(contact.stamp, contact.p_scene.x(), contact.p_scene.y(),
                                     std::int64_t{contact.while_moving ? 1 : 0}, contact.object));
  }
  add_seen(observation, news.seen);
  poses_ += news.poses.size();
  contacts_ += news.contacts.size();
  data_csv_.append(
      dataset_row(observation, news.path_m, count(poses_), count(contacts_), count(seen_runs_)));
}

void TruthWriter::add_seen(Time observation, const TruthLayer& seen) {
  PANOPTES_CHECK(seen.cells.size() == seen_.cells.size(), "the layer of what is seen stays as big");
  std::string rows;
  const auto width = static_cast<std::size_t>(seen.columns);
  for (int row = 0; row < seen.rows; ++row) {
    const auto* now = seen.cells.data() + static_cast<std::size_t>(row) * width;
    auto* before = seen_.cells.data() + static_cast<std::size_t>(row) * width;
    if (std::equal(now, now + width, before)) {
      continue;
    }
    for (std::size_t column = 0; column < width;) {
      if (now[column] == before[column]) {
        ++column;
        continue;
      }
      const std::size_t first = column;
      while (column < width && now[column] != before[column]) {
        before[column] = now[column];
        ++column;
      }
      rows += dataset_row(observation, std::int64_t{row}, count(first), count(column - first));
      ++seen_runs_;
    }
  }
  if (!rows.empty()) {
    seen_csv_.append(rows);
  }
}

std::optional<RecordedTruth> RecordedTruth::read(const fs::path& dataset, Duration epoch) {
  const fs::path folder = dataset / kTruth;
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return std::nullopt;
  }
  RecordedTruth out;
  const auto places = read_settings<LayerPlaces>((folder / "layers.yaml").string());
  out.all_.floor = read_layer(folder / "floor.png", places.floor);
  out.all_.body = read_layer(folder / "body.png", places.body);
  out.all_.seen = empty_layer(places.seen);

  if (fs::exists(folder / "platform.yaml", error)) {  // recordings of before have none
    auto platform = read_settings<TruePlatform>((folder / "platform.yaml").string());
    out.all_.rig = std::move(platform.rig);
    out.all_.wheels = platform.wheels;
  }
  const DatasetTable poses = read_table(folder / "poses.csv", 10);
  for (std::size_t row = 0; row < poses.size(); ++row) {
    TruePose pose;
    pose.stamp = poses.stamp(row, 0) - epoch;
    pose.T_scene_body = {poses.bounded(row, 1, kFarthest_m), poses.bounded(row, 2, kFarthest_m),
                         poses.bounded(row, 3, kMostTurned_rad)};
    pose.twist_body = {poses.bounded(row, 4, kFastest_mps), poses.bounded(row, 5, kFastest_radps)};
    pose.clearance_m = poses.number(row, 6);  // infinite in a world without a thing
    pose.pitch_rad = poses.finite(row, 7);
    pose.roll_rad = poses.finite(row, 8);
    pose.heave_m = poses.finite(row, 9);
    out.all_.poses.push_back(pose);
  }
  const DatasetTable contacts = read_table(folder / "contacts.csv", 5);
  for (std::size_t row = 0; row < contacts.size(); ++row) {
    out.all_.contacts.push_back(
        {contacts.stamp(row, 0) - epoch,
         {contacts.bounded(row, 1, kFarthest_m), contacts.bounded(row, 2, kFarthest_m)},
         contacts.text(row, 4),
         contacts.whole(row, 3) != 0});
  }
  const DatasetTable seen = read_table(folder / "seen.csv", 4);
  for (std::size_t row = 0; row < seen.size(); ++row) {
    const std::int64_t of_row = seen.whole(row, 1);
    const std::int64_t column = seen.whole(row, 2);
    const std::int64_t cells = seen.whole(row, 3);
    if (of_row < 0 || of_row >= places.seen.rows || column < 0 || cells < 1 ||
        column > places.seen.columns || cells > places.seen.columns - column) {
      throw seen.fault(row, "lies outside of the layer that layers.yaml describes");
    }
    out.seen_runs_.push_back({static_cast<std::size_t>(of_row * places.seen.columns + column),
                              static_cast<std::size_t>(cells)});
  }
  const DatasetTable data = read_table(folder / "data.csv", 5);
  out.file_ = data.file();
  Known before;
  Known with_pose;  // the last that brought a pose; a deadline's stamp may be later than the next's
  for (std::size_t row = 0; row < data.size(); ++row) {
    const auto count_of = [&](std::size_t column, std::size_t least, const DatasetTable& of) {
      const std::int64_t n = data.whole(row, column);
      if (n < 0 || static_cast<std::size_t>(n) < least) {
        throw data.fault(row, "must count the rows of " + of.file() + ", never fewer than before");
      }
      return static_cast<std::size_t>(n);
    };
    const Known known{data.stamp(row, 0) - epoch,
                      data.place(row),
                      data.finite(row, 1),
                      count_of(2, before.poses, poses),
                      count_of(3, before.contacts, contacts),
                      count_of(4, before.seen_runs, seen)};
    const auto check_last = [&known, epoch](std::size_t rows, const DatasetTable& of) {
      if (rows > 0 && of.stamp(rows - 1, 0) - epoch > known.stamp) {
        throw of.fault(rows - 1, "is later than the observation that knows of it (" +
                                     known.mention + "); rows before it are missing");
      }
    };
    if (known.poses <= poses.size() && known.contacts <= contacts.size() &&
        known.seen_runs <= seen.size()) {
      check_last(known.poses, poses);
      check_last(known.seen_runs, seen);
      if (row > 0 && known.poses > before.poses &&
          poses.stamp(known.poses - 1, 0) - epoch <= with_pose.stamp) {
        throw poses.fault(known.poses - 1, "is of an instant before the observation it is of (" +
                                               known.mention + "); both must be by one clock");
      }
      out.known_.push_back(known);
    }
    if (known.poses > before.poses) {
      with_pose = known;
    }
    before = known;
  }
  return out;
}

RecordedTruth RecordedTruth::of_poses(const std::vector<TruePose>& poses, const std::string& file) {
  RecordedTruth out;
  out.file_ = file;
  out.touches_known_ = false;
  out.all_.poses = poses;
  double path_m = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    path_m +=
        i == 0 ? 0
               : (poses[i].T_scene_body.position() - poses[i - 1].T_scene_body.position()).norm();
    out.known_.push_back({poses[i].stamp, file, path_m, i + 1, 0, 0});
  }
  return out;
}

void RecordedTruth::cut_to_fit(Dataset& dataset) const {
  std::vector<RecordedObservation>& observations = dataset.observations;
  for (std::size_t i = 0; i < std::min(known_.size(), observations.size()); ++i) {
    if (known_[i].stamp != observations[i].stamp) {
      throw ConfigError(known_[i].mention + ": must be of the instant " +
                        std::to_string(observations[i].stamp.time_since_epoch().count()) +
                        ", as row " + std::to_string(i + 1) + " of mav0/odom0/data.csv");
    }
  }
  if (known_.empty()) {
    throw ConfigError(file_ +
                      ": holds no whole row; remove its folder to replay without the truth");
  }
  if (known_.size() < observations.size()) {
    dataset.warnings.push_back(file_ + ": the truth of the last " +
                               std::to_string(observations.size() - known_.size()) +
                               " observations is torn; they are left out");
    observations.resize(known_.size());
  }
}

Truth RecordedTruth::after(std::size_t observations) const {
  PANOPTES_CHECK(observations <= known_.size(), "the truth of every observation is known");
  const Known known = observations == 0 ? Known() : known_[observations - 1];
  Truth truth;
  truth.poses.assign(all_.poses.begin(), all_.poses.begin() + count(known.poses));
  truth.contacts.assign(all_.contacts.begin(), all_.contacts.begin() + count(known.contacts));
  truth.floor = all_.floor;
  truth.body = all_.body;
  truth.seen = all_.seen;
  truth.path_m = known.path_m;
  truth.rig = all_.rig;
  truth.wheels = all_.wheels;
  for (std::size_t i = 0; i < known.seen_runs; ++i) {
    const auto first = truth.seen.cells.begin() + count(seen_runs_[i].first);
    std::fill(first, first + count(seen_runs_[i].count), std::uint8_t{1});
  }
  return truth;
}

}  // namespace panoptes::hw
