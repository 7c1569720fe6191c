// SPDX-License-Identifier: BSD-3-Clause
// What COLMAP needs to calibrate the rig of a recording that holds its truth:
//   rig_snapshots RECORDING OUT [--snapshots N] [--first I]
// N snapshots (16) are chosen among the slowest tenth of the drive's instants by farthest-point
// sampling, beginning with the Ith of them (0): a quarter of a turn counts as far as a metre. Of
// each camera the picture is taken that was truly nearest, by its true clock.
//   OUT/images/CAMERA/NN.png  the pictures; those of one snapshot share their names
//   OUT/lists/CAMERA.txt      their names
//   OUT/cameras.txt           a line a camera: its name, COLMAP's model and parameters, as believed
//   OUT/rig.json              which pictures were taken together, for rig_bundle_adjuster
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/eval/truth.h"
#include "core/io/dataset.h"
#include "core/io/file.h"
#include "hw/replay/truth_files.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path recording;
  fs::path out;
  std::size_t snapshots = 16;
  std::size_t first = 0;
};

Arguments arguments(int argc, char** argv) {
  Arguments args;
  std::vector<std::string> folders;
  for (int i = 1; i < argc; ++i) {
    const std::string_view flag = argv[i];
    const auto number = [&] {
      const int value = i + 1 < argc ? std::atoi(argv[++i]) : -1;
      if (value < 0) {
        throw ConfigError("rig_snapshots: no number after " + std::string(flag));
      }
      return static_cast<std::size_t>(value);
    };
    if (flag == "--snapshots") {
      args.snapshots = number();
    } else if (flag == "--first") {
      args.first = number();
    } else {
      folders.emplace_back(flag);
    }
  }
  if (folders.size() != 2 || args.snapshots < 2) {
    throw ConfigError("rig_snapshots RECORDING OUT [--snapshots N] [--first I], two at least");
  }
  args.recording = folders[0];
  args.out = folders[1];
  return args;
}

/// The pictures of one instant, by their cameras.
struct Snapshot {
  TruePose body;
  std::map<std::string, RecordedPicture> pictures;
};

/// Of every true pose at which each camera has a picture within half a period.
std::vector<Snapshot> snapshots_of(const fs::path& recording, const Truth& truth,
                                   const Rig& believed) {
  std::vector<Snapshot> snapshots;
  for (const TruePose& pose : truth.poses) {
    snapshots.push_back({pose, {}});
  }
  for (const auto& [name, camera] : believed.cameras) {
    const std::vector<RecordedPicture> pictures = recorded_pictures(recording, name);
    const Duration late = from_seconds(truth.rig->cameras.at(name).clock_offset_s);
    const Duration within = from_seconds(0.5 / camera.rate_hz);
    for (Snapshot& snapshot : snapshots) {
      const auto off = [&](const RecordedPicture& picture) {
        return std::chrono::abs(picture.stamp - late - snapshot.body.stamp);
      };
      const auto nearest = std::ranges::min_element(pictures, {}, off);
      if (nearest != pictures.end() && off(*nearest) < within) {
        snapshot.pictures[name] = *nearest;
      }
    }
  }
  std::erase_if(snapshots, [&](const Snapshot& snapshot) {
    return snapshot.pictures.size() < believed.cameras.size();
  });
  return snapshots;
}

/// How fast pictures move, of points about 2 m away.
double pace(const TruePose& pose) {
  constexpr double kAway_m = 2;
  return std::abs(pose.twist_body.w_radps) + std::abs(pose.twist_body.v_mps) / kAway_m;
}

double apart(const TruePose& a, const TruePose& b) {
  constexpr double kMetrePerRad = 2 / std::numbers::pi;
  const Pose2 off = a.T_scene_body.inverse() * b.T_scene_body;
  return off.position().norm() + kMetrePerRad * std::abs(off.theta_rad);
}

std::vector<Snapshot> chosen(std::vector<Snapshot> from, std::size_t count, std::size_t first) {
  std::ranges::stable_sort(from, {}, [](const Snapshot& s) { return pace(s.body); });
  from.resize(std::min(from.size(), std::max(from.size() / 10, 4 * count)));
  if (from.size() < count || first >= from.size()) {
    throw ConfigError(fmt::format("only {} instants to choose {} from, or to begin with number {}",
                                  from.size(), count, first));
  }
  std::ranges::sort(from, {}, [](const Snapshot& s) { return s.body.stamp; });
  std::vector<double> free(from.size(), std::numeric_limits<double>::infinity());
  std::vector<Snapshot> taken;
  std::size_t next = first;
  while (taken.size() < count) {
    taken.push_back(from[next]);
    for (std::size_t i = 0; i < from.size(); ++i) {
      free[i] = std::min(free[i], apart(from[i].body, from[next].body));
    }
    next = static_cast<std::size_t>(std::ranges::max_element(free) - free.begin());
  }
  std::ranges::sort(taken, {}, [](const Snapshot& s) { return s.body.stamp; });
  return taken;
}

/// A lens as COLMAP names it: its origin is the corner of the first pixel, ours the middle.
std::string colmap_lens(const Intrinsics& lens) {
  const std::string pinhole =
      fmt::format("{},{},{},{}", lens.fx_px, lens.fy_px, lens.cx_px + 0.5, lens.cy_px + 0.5);
  if (const auto* bent = std::get_if<BrownConrady>(&lens.distortion)) {
    const std::string numbers =
        fmt::format("{},{},{},{},{}", pinhole, bent->k1, bent->k2, bent->p1, bent->p2);
    return bent->k3 == 0 ? "OPENCV " + numbers
                         : fmt::format("FULL_OPENCV {},{},0,0,0", numbers, bent->k3);
  }
  if (const auto* wide = std::get_if<Equidistant>(&lens.distortion)) {
    return fmt::format("OPENCV_FISHEYE {},{},{},{},{}", pinhole, wide->k1, wide->k2, wide->k3,
                       wide->k4);
  }
  return "PINHOLE " + pinhole;
}

int run(const Arguments& args) {
  const std::optional<hw::RecordedTruth> recorded = hw::RecordedTruth::read(args.recording);
  const std::optional<Rig> believed = read_beliefs(args.recording).rig;
  if (!recorded || recorded->observations() == 0 || !believed) {
    throw ConfigError(args.recording.string() + ": is no recording with its truth and its rig");
  }
  const Truth truth = recorded->after(recorded->observations());
  if (!truth.rig) {
    throw ConfigError(args.recording.string() + ": does not know its true rig");
  }
  const std::vector<Snapshot> snapshots =
      chosen(snapshots_of(args.recording, truth, *believed), args.snapshots, args.first);
  std::string cameras;
  nlohmann::ordered_json rig{{"ref_camera_id", 1}};
  fs::create_directories(args.out / "lists");
  int number = 0;
  for (const auto& [name, camera] : believed->cameras) {
    cameras += name + " " + colmap_lens(camera.intrinsics) + "\n";
    rig["cameras"].push_back({{"camera_id", ++number}, {"image_prefix", name + "/"}});
    fs::create_directories(args.out / "images" / name);
    std::string list;
    for (std::size_t i = 0; i < snapshots.size(); ++i) {
      const std::string file = fmt::format("{}/{:02}.png", name, i);
      fs::copy_file(args.recording / snapshots[i].pictures.at(name).file,
                    args.out / "images" / file, fs::copy_options::overwrite_existing);
      list += file + "\n";
    }
    write_file(args.out / "lists" / (name + ".txt"), list);
  }
  write_file(args.out / "cameras.txt", cameras);
  write_file(args.out / "rig.json", nlohmann::ordered_json::array({rig}).dump(2) + "\n");
  for (const Snapshot& snapshot : snapshots) {
    const Pose2& at = snapshot.body.T_scene_body;
    std::printf("%7.2f s  at %.2f, %.2f m, %4.0f deg\n", to_seconds(snapshot.body.stamp), at.x_m,
                at.y_m, rad_to_deg(at.theta_rad));
  }
  return 0;
}

}  // namespace
}  // namespace panoptes

int main(int argc, char** argv) {
  try {
    return panoptes::run(panoptes::arguments(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
