// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/calib/joint_of_rig.h"
#include "core/calib/map_verdict.h"
#include "core/camera/lens_parameters.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr double kMostReprojection_px = 0.8;
constexpr double kMostLeftOut = 0.15;  // as a share
constexpr int kFewestToSettle = 60;    // points of a map that is worth anything
constexpr double kMostLost = 0.05;     // of the drive, as a share
constexpr double kMostSigmas = 4;
// A rig file is off by a hand's breadth and a look, unless it is of another rig.
constexpr double kMostOff_rad = deg_to_rad(15);
constexpr double kMostOff_m = 0.15;
constexpr double kTurnedRound_rad = deg_to_rad(120);
constexpr double kMostMissing = 0.1;  // of the instants or of the pictures, as a share

/// Turned by half a turn about its optical axis, or as a camera looks whose pictures are mirrored
/// left to right: a level drive through the world that is mirrored in the floor shows the same.
bool is_upside_down(const Pose3& found, const Pose3& believed) {
  const Mat3 R = believed.rotation.toRotationMatrix();
  const Mat3 turned = R * Vec3(-1, -1, 1).asDiagonal();
  const Mat3 mirrored = Vec3(1, 1, -1).asDiagonal() * R * Vec3(-1, 1, 1).asDiagonal();
  const auto is_near = [&found](const Mat3& other) {
    return found.rotation.angularDistance(Eigen::Quaterniond(other)) < kMostOff_rad;
  };
  return is_near(turned) || is_near(mirrored);
}

double lost_share(const MonoMap& map) {
  return map.frames.size() > 1
             ? map.lost_s / to_seconds(map.frames.back().stamp - map.frames.front().stamp)
             : 0;
}

/// To what share of itself the metre is known: by the camera that stands farthest from the first.
double metre_share(const RigCalibration& calibration) {
  const RigBundleState& state = calibration.bundle.state;
  double far_m = 0;
  double share = 1;
  for (std::size_t c = 1; c < state.T_body_camera.size(); ++c) {
    const Vec3 t = (state.T_body_camera.front().inverse() * state.T_body_camera[c]).translation;
    if (t.norm() > far_m) {
      far_m = t.norm();
      const Mat3 known = calibration.bundle.known.relative(state, 0, c).bottomRightCorner<3, 3>();
      share = std::sqrt(std::max(0.0, t.normalized().dot(known * t.normalized()))) / far_m;
    }
  }
  return share;
}

double turn_between(const Pose3& a, const Pose3& b) {
  return a.rotation.angularDistance(b.rotation);
}

/// Cameras whose pictures end before the others'.
void doubt_short_recordings(const std::vector<MappedCamera>& cameras, Judged& judged) {
  std::optional<Time> last;
  for (const MappedCamera& camera : cameras) {
    if (!camera.map.frames.empty()) {
      last = std::max(last.value_or(Time::min()), camera.map.frames.back().stamp);
    }
  }
  for (const MappedCamera& camera : cameras) {
    const std::vector<MonoMap::Frame>& frames = camera.map.frames;
    constexpr double kHardlyAny = 0.02;
    const double early_s = frames.empty() ? 0 : to_seconds(*last - frames.back().stamp);
    if (!frames.empty() && early_s > kHardlyAny * to_seconds(*last - frames.front().stamp)) {
      judged.doubt(
          Verdict::kGood,
          fmt::format("{}: its pictures end {:.1f} s before those of others: its recording "
                      "is cut short",
                      camera.name, early_s));
    }
  }
}

}  // namespace

Judged judge_rig(const std::vector<MappedCamera>& cameras, const RigCalibration& calibration) {
  Judged judged;
  const RigBundle& bundle = calibration.bundle;
  const RigBundleState& state = bundle.state;
  // What a map alone leaves in doubt, other cameras that see its points settle, or contradict
  // below.
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (const std::string& why = calibration.by_others[c]; !why.empty()) {
      const bool is_told = calibration.shared[c] >= kFewestToSettle;
      judged.doubt(
          is_told && cameras[c].adjusted.T_map_camera.empty() ? Verdict::kGood : Verdict::kPoor,
          fmt::format("{}: {}; how it is mounted is told by {} points of other cameras' maps that "
                      "are found in its pictures{}",
                      cameras[c].name, why, calibration.shared[c],
                      is_told ? "" : fmt::format(", fewer than {}", kFewestToSettle)));
      continue;
    }
    const Judged of_map = judge_map(cameras[c].map, cameras[c].adjusted, cameras[c].believed);
    const bool is_settled = of_map.verdict == Verdict::kPoor &&
                            calibration.shared[c] >= kFewestToSettle &&
                            lost_share(cameras[c].map) < kMostLost;
    for (const std::string& reason : of_map.reasons) {
      judged.doubt(is_settled ? Verdict::kGood : std::min(of_map.verdict, Verdict::kPoor),
                   cameras[c].name + ": its own map: " + reason +
                       (is_settled ? "; judged below, by all cameras together" : ""));
    }
  }
  doubt_short_recordings(cameras, judged);
  if (!bundle.converged) {
    judged.doubt(Verdict::kPoor, "the adjustment of all cameras together did not converge");
  }
  if (bundle.rms_after_px > kMostReprojection_px) {
    judged.doubt(Verdict::kPoor,
                 fmt::format("the cameras do not agree: {:.2f} px of reprojection are left, "
                             "more than {:g}",
                             bundle.rms_after_px, kMostReprojection_px));
  }
  std::size_t all_turned = 0;
  std::vector<int> seen(cameras.size(), 0);
  std::vector<int> left_out(cameras.size(), 0);
  for (const RigSeen& each : calibration.tracks.seen) {
    const std::size_t c = calibration.tracks.views[each.view].camera;
    ++seen[c];
    left_out[c] += each.believed ? 0 : 1;
  }
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const MappedCamera& camera = cameras[c];
    if (cameras.size() > 1 && calibration.by_others[c].empty() &&
        calibration.shared[c] < kFewestShared) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: shares {} points with other cameras, fewer than {}: how much higher "
                      "it stands than they do is not seen; drive a motion that turns it to "
                      "where they have looked",
                      camera.name, calibration.shared[c], kFewestShared));
    }
    if (left_out[c] > kMostLeftOut * seen[c]) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: contradicts the others: {} of {} observations are left out (at most "
                      "{:.0f} %)",
                      camera.name, left_out[c], seen[c], 100 * kMostLeftOut));
    }
    const Intrinsics& lens = camera.believed.intrinsics;
    const double focal_off = state.lenses[c].fx_px / lens.fx_px - 1;
    const double centre_off_px = std::max(std::abs(state.lenses[c].cx_px - lens.cx_px),
                                          std::abs(state.lenses[c].cy_px - lens.cy_px));
    if (std::abs(focal_off) > kMostSigmas * camera.believed.sigma.focal_ratio ||
        centre_off_px > kMostSigmas * camera.believed.sigma.centre_px) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: its pictures are of another lens: focal length {:+.2f} %, centre off "
                      "by {:.1f} px, known to {:g} % and {:g} px; calibrate it by a board, or "
                      "say in the rig how badly it is known",
                      camera.name, 100 * focal_off, centre_off_px,
                      100 * camera.believed.sigma.focal_ratio, camera.believed.sigma.centre_px));
    }
    // A level floor hardly shows it, and what it is told to be stays where it was believed: that it
    // has to move at all tells.
    const double ratio_off =
        (state.lenses[c].fy_px / state.lenses[c].fx_px) / (lens.fy_px / lens.fx_px) - 1;
    const Eigen::MatrixXd before =
        covariance_before({camera.name}, {camera.believed}, calibration.known_together);
    constexpr Eigen::Index fx = 6;  // its row
    const double ratio_sigma =
        std::sqrt(before(fx, fx) + before(fx + 1, fx + 1) - 2 * before(fx, fx + 1)) / lens.fx_px;
    if (std::abs(ratio_off) > kMostSigmas * ratio_sigma) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: its pictures are of another lens: the ratio of its focal lengths is not "
                      "fy / fx = {:.4f}, as the rig file has it; calibrate it by a board",
                      camera.name, lens.fy_px / lens.fx_px));
    }
    const Eigen::VectorXd bent_before = lens_parameters(lens);
    const Eigen::VectorXd bent = lens_parameters(state.lenses[c]);
    const std::vector<std::string> names = lens_parameter_names(lens);
    for (Eigen::Index i = 4; i < bent.size(); ++i) {
      const double sigma = std::sqrt(before(fx + i, fx + i));
      if (std::abs(bent[i] - bent_before[i]) > kMostSigmas * sigma) {
        judged.doubt(
            Verdict::kPoor,
            fmt::format("{}: its pictures are of another lens: its distortion {} is {:.4f}, where "
                        "the rig file says {:.4f}, known to {:g}; calibrate it by a board, or say "
                        "in the rig how badly it is known",
                        camera.name, names[static_cast<std::size_t>(i)], bent[i], bent_before[i],
                        sigma));
        break;
      }
    }
    const Pose3& found = state.T_body_camera[c];
    const double turn_rad = turn_between(found, camera.believed.T_body_camera);
    const double shift_m = (found.translation - camera.believed.T_body_camera.translation).norm();
    const CameraSigmas& sigma = camera.believed.sigma;
    all_turned += turn_rad > kTurnedRound_rad ? 1 : 0;
    if (turn_rad > std::max(kMostOff_rad, kMostSigmas * sigma.rotation_rad.norm()) ||
        shift_m > std::max(kMostOff_m, kMostSigmas * sigma.position_m.norm())) {
      std::string like;
      for (std::size_t other = 0; other < cameras.size(); ++other) {
        if (other != c &&
            turn_between(found, cameras[other].believed.T_body_camera) < turn_rad / 4) {
          like = fmt::format("; it looks as {} is said to: are their pictures swapped?",
                             cameras[other].name);
        }
      }
      if (is_upside_down(found, camera.believed.T_body_camera)) {
        like =
            "; it looks upside down: is it mounted so, or are its pictures mirrored or turned by "
            "their driver?";
      }
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: is mounted {:.0f} degrees and {:.2f} m off what the rig file says, "
                      "another rig's{}",
                      camera.name, rad_to_deg(turn_rad), shift_m, like));
    }
    const std::optional<PlanarHandEye>& alone = calibration.hand_eye[c];
    // Without wheels, which yaw the body has is not told: what counts is how cameras stand to the
    // first.
    const std::optional<PlanarHandEye>& first = calibration.hand_eye.front();
    const double contradicts_rad =
        !alone              ? 0
        : bundle.has_wheels ? turn_between(found, alone->T_body_camera)
        : first             ? turn_between(state.T_body_camera.front().inverse() * found,
                                           first->T_body_camera.inverse() * alone->T_body_camera)
                            : 0;
    constexpr double kLeast_rad = deg_to_rad(1);
    if (alone && contradicts_rad > std::max(kLeast_rad, kMostSigmas * alone->yaw_sigma_rad)) {
      judged.doubt(Verdict::kPoor,
                   fmt::format("{}: its own path{} has it {:.1f} degrees elsewhere than "
                               "all cameras together",
                               camera.name, bundle.has_wheels ? " beside the wheels'" : "",
                               rad_to_deg(contradicts_rad)));
    }
    const double late_s = state.clock_offset_s[c] - camera.believed.clock_offset_s;
    if (std::abs(late_s) > kMostSigmas * sigma.clock_s) {
      judged.doubt(Verdict::kPoor,
                   fmt::format("{}: its clock is {:.0f} ms off what the rig file says, "
                               "which has it known to {:g} ms",
                               camera.name, 1000 * late_s, 1000 * sigma.clock_s));
    }
  }
  if (cameras.size() > 1 && all_turned == cameras.size()) {
    judged.doubt(Verdict::kPoor,
                 "all cameras look the other way than the rig file says: does the odometry count x "
                 "ahead and turns to the left as positive?");
  }
  if (!bundle.has_wheels) {
    judged.doubt(
        Verdict::kGood,
        fmt::format("no odometry: how cameras are turned to one another and in which directions "
                    "they stand is told; all lengths are by how far apart the rig file has them, "
                    "to {:.1f} %, and where the body is, with its yaw, is as the rig file has it",
                    100 * metre_share(calibration)));
    return judged;
  }
  const std::array<std::string, kWheelErrors> off{
      fmt::format("the way by {:+.1f} %", 100 * state.wheel_errors[kWayError]),
      fmt::format("the turn by {:+.1f} %", 100 * state.wheel_errors[kTurnError]),
      fmt::format("the turn by {:+.1f} degrees a metre",
                  rad_to_deg(state.wheel_errors[kTurnPerMetre]))};
  for (int i = 0; i < kWheelErrors; ++i) {
    if (std::abs(state.wheel_errors[i]) > kMostSigmas * calibration.wheels_known.sigma[i]) {
      judged.doubt(
          Verdict::kPoor,
          "wheels and pictures contradict one another: " + off[static_cast<std::size_t>(i)] +
              " off what the wheels say; the robot file is of another robot, a wheel slips, or "
              "lenses are others than the rig file says");
    }
  }
  for (std::size_t c = 0; c < cameras.size() && calibration.wheels; ++c) {
    constexpr double kHardlyAny = 0.01;  // before the odometry begins, and after it ends
    const std::vector<MonoMap::Frame>& frames = cameras[c].map.frames;
    const auto late = from_seconds(state.clock_offset_s[c]);
    const auto outside = std::count_if(frames.begin(), frames.end(), [&](const auto& frame) {
      return !calibration.wheels(frame.stamp - late);
    });
    const double share = static_cast<double>(outside) / std::max<double>(1, frames.size());
    if (share > kHardlyAny) {
      judged.doubt(
          share > kMostMissing ? Verdict::kPoor : Verdict::kGood,
          fmt::format("{}: the wheels say nothing of {} of its {} pictures, which are left out: "
                      "the odometry has gaps, or is cut short",
                      cameras[c].name, outside, frames.size()));
    }
  }
  const auto instants = static_cast<double>(calibration.tracks.instants.size());
  if (bundle.without_wheels > kMostMissing * instants) {
    judged.doubt(Verdict::kPoor,
                 fmt::format("the wheels say nothing of {} of {} of its stretches",
                             bundle.without_wheels, calibration.tracks.instants.size()));
  }
  return judged;
}

Rig believed_after(Rig found, const Rig& before, const Judged& judged) {
  found.doubts.clear();
  if (judged.verdict == Verdict::kGood) {
    return found;
  }
  for (auto& [name, camera] : found.cameras) {
    camera.sigma = before.cameras.at(name).sigma;
  }
  found.covariance.reset();
  found.doubts = judged.doubts;
  return found;
}

}  // namespace panoptes
