// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/keyframe_bundle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include <ceres/ceres.h>

#include "core/calib/pose_block.h"
#include "core/calib/reprojection_cost.h"
#include "core/calib/rig_costs.h"
#include "core/calib/schur_bundle.h"
#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

// Of the map's points, in a keyframe that they hold.
constexpr std::size_t kFewestShown = 8;
constexpr double kLeastNoise_px = 0.02;  // no better are points seen, however well a few agree

struct PointSeenIn {
  std::size_t keyframe = 0;
  std::size_t point = 0;
  Vec2 px = Vec2::Zero();
  bool believed = true;
};

/// All that is adjusted, as the solver holds it.
struct Bundle {
  Eigen::VectorXd lens;
  std::vector<PoseBlock> T_camera_map;
  std::vector<bool> is_held;  ///< of the poses: by as many points as hold one
  std::vector<std::array<double, 3>> p_map;
  std::vector<PointSeenIn> seen;
};

std::optional<Vec2> off_px(const Bundle& bundle, const Intrinsics& lens, const PointSeenIn& o) {
  const Vec3 p = from_block(bundle.T_camera_map[o.keyframe].data()) *
                 Vec3(Eigen::Map<const Vec3>(bundle.p_map[o.point].data()));
  return can_draw(lens, p) ? std::optional<Vec2>(lens.project(p) - o.px) : std::nullopt;
}

double rms_px(const Bundle& bundle, const Intrinsics& lens) {
  double sum = 0;
  int count = 0;
  for (const PointSeenIn& o : bundle.seen) {
    if (const auto off = o.believed ? off_px(bundle, lens, o) : std::nullopt) {
      sum += off->squaredNorm();
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

/// Of an observation, each way, by the median of all.
double noise_px(const Bundle& bundle, const Intrinsics& lens) {
  std::vector<double> squares;
  for (const PointSeenIn& o : bundle.seen) {
    if (const auto off = off_px(bundle, lens, o)) {
      squares.push_back(off->squaredNorm());
    }
  }
  return squares.empty() ? 0 : sigma_by_median(squares);
}

bool solve(const KeyframeBundleOptions& options, const Intrinsics& lens, const CameraSigmas& known,
           double sigma_px, Loss loss, Bundle& bundle) {
  ceres::Problem problem;
  auto order = std::make_shared<ceres::ParameterBlockOrdering>();
  std::vector<PoseBlock*> held;
  for (std::size_t i = 0; i < bundle.T_camera_map.size(); ++i) {
    if (!bundle.is_held[i]) {
      continue;
    }
    PoseBlock& block = bundle.T_camera_map[i];
    add_pose(problem, block);
    order->AddElementToGroup(block.data(), 1);
    held.push_back(&block);
  }
  if (!keep_gauge(problem, held)) {
    return false;
  }
  for (const PointSeenIn& o : bundle.seen) {
    if (o.believed) {
      problem.AddResidualBlock(reprojection_cost(lens, o.px, sigma_px), made(loss),
                               bundle.lens.data(), bundle.T_camera_map[o.keyframe].data(),
                               bundle.p_map[o.point].data());
    }
  }
  for (std::array<double, 3>& p : bundle.p_map) {
    if (problem.HasParameterBlock(p.data())) {
      order->AddElementToGroup(p.data(), 0);
    }
  }
  if (problem.HasParameterBlock(bundle.lens.data())) {
    order->AddElementToGroup(bundle.lens.data(), 2);  // within a group, addresses order
    if (options.adjust_lens) {
      problem.AddResidualBlock(lens_known_cost(lens, known), nullptr, bundle.lens.data());
    } else {
      problem.SetParameterBlockConstant(bundle.lens.data());
    }
  }
  return solve_by_schur(problem, order, {.iterations = options.iterations});
}

}  // namespace

std::vector<int> keyframes(const KeyframeChoice& options, const MonoMap& map) {
  const int count = static_cast<int>(map.frames.size());
  std::vector<int> chosen;
  if (options.every > 0) {
    for (int i = 0; i < count; i += options.every) {
      chosen.push_back(i);
    }
    return chosen;
  }
  std::vector<std::map<int, Vec2>> shown(map.frames.size());  // by the points' numbers
  for (const MonoMap::Point& point : map.points) {
    for (const MonoMap::Seen& seen : point.seen) {
      shown[static_cast<std::size_t>(seen.frame)][point.number] = seen.px;
    }
  }
  for (int i = 0; i < count; ++i) {
    const auto& here = shown[static_cast<std::size_t>(i)];
    if (map.frames[static_cast<std::size_t>(i)].lost || here.size() < kFewestShown) {
      continue;
    }
    if (chosen.empty()) {
      chosen.push_back(i);
      continue;
    }
    const auto& before = shown[static_cast<std::size_t>(chosen.back())];
    std::vector<double> moved_px;
    for (const auto& [number, px] : before) {
      if (const auto found = here.find(number); found != here.end()) {
        moved_px.push_back((found->second - px).norm());
      }
    }
    std::sort(moved_px.begin(), moved_px.end());
    if (static_cast<double>(moved_px.size()) <
            options.shared * static_cast<double>(before.size()) ||
        moved_px[moved_px.size() / 2] > options.parallax_px) {
      chosen.push_back(i);
    }
  }
  const auto most = static_cast<std::size_t>(options.most);
  if (chosen.size() > most) {
    std::vector<int> fewer;
    for (std::size_t i = 0; i < most; ++i) {
      fewer.push_back(chosen[i * chosen.size() / most]);
    }
    return fewer;
  }
  return chosen;
}

AdjustedMap adjust_map(const KeyframeBundleOptions& options, const Intrinsics& lens,
                       const CameraSigmas& known, const MonoMap& map) {
  return adjust_map(options, lens, known, map, keyframes(options.keyframes, map));
}

AdjustedMap adjust_map(const KeyframeBundleOptions& options, const Intrinsics& lens,
                       const CameraSigmas& known, const MonoMap& map,
                       const std::vector<int>& keyframes) {
  AdjustedMap out;
  out.keyframes = keyframes;
  out.lens = lens;
  Bundle bundle;
  KeyframeBundleOptions how = options;
  how.adjust_lens = options.adjust_lens && known.focal_ratio > 0 && known.centre_px > 0;
  const Intrinsics before_lens = how.adjust_lens ? map.lens : lens;
  bundle.lens = lens_parameters(before_lens);
  std::map<int, std::size_t> at;  // of frames
  for (const int frame : out.keyframes) {
    at[frame] = bundle.T_camera_map.size();
    bundle.T_camera_map.push_back(
        to_block(map.frames[static_cast<std::size_t>(frame)].T_map_camera.inverse()));
  }
  for (const MonoMap::Point& point : map.points) {
    std::vector<PointSeenIn> seen;
    for (const MonoMap::Seen& each : point.seen) {
      if (const auto keyframe = at.find(each.frame); keyframe != at.end()) {
        seen.push_back({keyframe->second, bundle.p_map.size(), each.px, true});
      }
    }
    if (seen.size() >= 2) {
      bundle.seen.insert(bundle.seen.end(), seen.begin(), seen.end());
      bundle.p_map.push_back({point.p_map.x(), point.p_map.y(), point.p_map.z()});
      out.points.push_back({point.number, point.p_map, 0});
    }
  }
  if (bundle.T_camera_map.size() < 2 || bundle.p_map.empty()) {
    return out;
  }
  bundle.is_held.assign(bundle.T_camera_map.size(), true);
  for (PointSeenIn& o : bundle.seen) {
    o.believed = off_px(bundle, before_lens, o).has_value();  // not behind the camera to begin with
  }
  const Bundle before = bundle;
  // What is far off pulls no more than what is near, then hardly at all.
  for (const Loss loss : {Loss::kHuber, Loss::kCauchy}) {
    const double sigma_px = noise_px(bundle, with_parameters(lens, bundle.lens));
    solve(how, lens, known, std::max(kLeastNoise_px, sigma_px), loss, bundle);
  }
  // What is believed is judged twice: the second time without what the first left out.
  constexpr int kJudged = 2;
  for (int i = 0; i < kJudged; ++i) {
    const Intrinsics adjusted = with_parameters(lens, bundle.lens);
    const double sigma_px = std::max(kLeastNoise_px, noise_px(bundle, adjusted));
    std::vector<std::size_t> believed(bundle.is_held.size(), 0);
    for (PointSeenIn& o : bundle.seen) {
      const std::optional<Vec2> off = off_px(bundle, adjusted, o);
      o.believed = off && off->norm() < options.inlier_sigma * std::sqrt(2.0) * sigma_px;
      believed[o.keyframe] += o.believed ? 1 : 0;
    }
    for (std::size_t k = 0; k < believed.size(); ++k) {
      bundle.is_held[k] = believed[k] >= kFewestShown;
    }
    out.observations = 0;
    for (PointSeenIn& o : bundle.seen) {
      o.believed = o.believed && bundle.is_held[o.keyframe];
      out.observations += o.believed ? 1 : 0;
    }
    out.converged = solve(how, lens, known, sigma_px, Loss::kSquare, bundle);
  }
  out.left_out = static_cast<int>(bundle.seen.size()) - out.observations;
  out.lens = with_parameters(lens, bundle.lens);
  out.rms_after_px = rms_px(bundle, out.lens);
  Bundle as_before = before;
  as_before.seen = bundle.seen;
  out.rms_before_px = rms_px(as_before, before_lens);
  std::vector<int> held;
  for (std::size_t i = 0; i < bundle.T_camera_map.size(); ++i) {
    if (bundle.is_held[i]) {
      held.push_back(out.keyframes[i]);
      out.T_map_camera.push_back(from_block(bundle.T_camera_map[i].data()).inverse());
    }
  }
  out.keyframes = held;
  for (std::size_t i = 0; i < bundle.p_map.size(); ++i) {
    out.points[i].p_map = Eigen::Map<const Vec3>(bundle.p_map[i].data());
  }
  for (const PointSeenIn& o : bundle.seen) {
    out.points[o.point].observations += o.believed ? 1 : 0;
  }
  return out;
}

}  // namespace panoptes
