// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_by_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <utility>

#include <Eigen/Eigenvalues>
#include <ceres/ceres.h>

#include "core/base/median.h"
#include "core/calib/pose_block.h"
#include "core/calib/reprojection_cost.h"
#include "core/calib/rig_costs.h"
#include "core/calib/schur_bundle.h"
#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

// Pictures of one instant are less apart: half of the time between two, of 15 a second.
constexpr Duration kMostApart = std::chrono::milliseconds(35);
constexpr double kLeastNoise_px = 0.02;

/// Classes of points of several maps that are one.
class Joined {
 public:
  explicit Joined(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t root(std::size_t i) const {
    while (parent_[i] != i) {
      i = parent_[i];
    }
    return i;
  }
  /// The lower one stays the root.
  void join(std::size_t i, std::size_t k) {
    const auto [low, high] = std::minmax({root(i), root(k)});
    parent_[high] = low;
  }

 private:
  std::vector<std::size_t> parent_;
};

Pose3 mean_pose(const std::vector<Pose3>& poses) {
  Eigen::Matrix4d outer = Eigen::Matrix4d::Zero();
  std::array<std::vector<double>, 3> axes;
  for (const Pose3& T : poses) {
    outer += T.rotation.coeffs() * T.rotation.coeffs().transpose();
    for (int i = 0; i < 3; ++i) {
      axes[static_cast<std::size_t>(i)].push_back(T.translation[i]);
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solved(outer);
  return {Eigen::Quaterniond(Eigen::Vector4d(solved.eigenvectors().col(3))),
          Vec3(median(axes[0]), median(axes[1]), median(axes[2]))};
}

/// The joint adjustment (4.3.6).
class JointBundle {
 public:
  JointBundle(const KeyframeBundleOptions& options, RigByMaps& out) : options_(options), out_(out) {
    for (const Pose3& T : out.state.T_start_body) {
      T_body_start_.push_back(to_block(T.inverse()));
    }
    for (const Pose3& T : out.state.T_body_camera) {
      T_camera_body_.push_back(to_block(T.inverse()));
    }
    for (const Intrinsics& lens : out.state.lenses) {
      lens_.push_back(lens_parameters(lens));
    }
    for (const Vec3& p : out.state.points_start) {
      const Eigen::Vector4d h = p.homogeneous().normalized();
      p_start_.push_back({h[0], h[1], h[2], h[3]});
    }
    for (RigSeen& seen : out.tracks.seen) {
      seen.believed = off_px(seen).has_value();
    }
  }

  void run() {
    for (const Loss loss : {Loss::kHuber, Loss::kCauchy}) {
      solve(std::max(kLeastNoise_px, noise_px()), loss);
    }
    // What is believed is judged twice: the second time without what the first left out.
    constexpr int kJudged = 2;
    for (int i = 0; i < kJudged; ++i) {
      const double sigma_px = std::max(kLeastNoise_px, noise_px());
      for (RigSeen& seen : out_.tracks.seen) {
        const std::optional<Vec2> off = off_px(seen);
        seen.believed = off && off->norm() < options_.inlier_sigma * std::sqrt(2.0) * sigma_px;
      }
      out_.converged = solve(sigma_px, Loss::kSquare);
    }
    out_.rms_after_px = rms_px();
    store();
    count();
  }

 private:
  Vec3 point(std::size_t i) const {
    return Eigen::Map<const Eigen::Vector4d>(p_start_[i].data()).hnormalized();
  }

  std::optional<Vec2> off_px(const RigSeen& seen) const {
    const RigView& view = out_.tracks.views[seen.view];
    const Pose3 T = from_block(T_camera_body_[view.camera].data()) *
                    from_block(T_body_start_[view.instant].data());
    const Vec3 p = T * point(seen.point);
    const Intrinsics& lens = out_.state.lenses[view.camera];
    return p.allFinite() && can_draw(lens, p) ? std::optional<Vec2>(lens.project(p) - seen.px)
                                              : std::nullopt;
  }

  double noise_px() const {
    std::vector<double> squares;
    for (const RigSeen& seen : out_.tracks.seen) {
      if (const auto off = off_px(seen)) {
        squares.push_back(off->squaredNorm());
      }
    }
    return squares.empty() ? 0 : sigma_by_median(std::move(squares));
  }

  double rms_px() const {
    double sum = 0;
    int count = 0;
    for (const RigSeen& seen : out_.tracks.seen) {
      if (const auto off = seen.believed ? off_px(seen) : std::nullopt) {
        sum += off->squaredNorm();
        ++count;
      }
    }
    return count > 0 ? std::sqrt(sum / count) : 0;
  }

  bool solve(double sigma_px, Loss loss) {
    ceres::Problem problem;
    auto order = std::make_shared<ceres::ParameterBlockOrdering>();
    double clock_s = 0;
    std::array<double, kWheelErrors> wheels{};
    problem.AddParameterBlock(&clock_s, 1);
    problem.AddParameterBlock(wheels.data(), kWheelErrors);
    ceres::Manifold* of_points = nullptr;
    std::set<std::size_t> instants;
    std::set<std::size_t> cameras;
    for (const RigSeen& seen : out_.tracks.seen) {
      if (!seen.believed) {
        continue;
      }
      const RigView& view = out_.tracks.views[seen.view];
      double* p_start = p_start_[seen.point].data();
      if (!problem.HasParameterBlock(p_start)) {
        of_points = of_points != nullptr ? of_points : new ceres::SphereManifold<4>;
        problem.AddParameterBlock(p_start, 4, of_points);
      }
      if (instants.insert(view.instant).second) {
        add_pose(problem, T_body_start_[view.instant]);
      }
      if (cameras.insert(view.camera).second) {
        add_pose(problem, T_camera_body_[view.camera]);
        problem.AddParameterBlock(lens_[view.camera].data(),
                                  static_cast<int>(lens_[view.camera].size()));
        problem.SetParameterBlockConstant(lens_[view.camera].data());
      }
      problem.AddResidualBlock(
          rig_reprojection_cost(out_.state.lenses[view.camera], seen.px, sigma_px, {}), made(loss),
          lens_[view.camera].data(), T_camera_body_[view.camera].data(),
          T_body_start_[view.instant].data(), &clock_s, wheels.data(), p_start);
    }
    if (instants.size() < 2) {
      return false;
    }
    problem.SetParameterBlockConstant(&clock_s);
    problem.SetParameterBlockConstant(wheels.data());
    if (cameras.contains(0)) {
      problem.SetParameterBlockConstant(T_camera_body_.front().data());
    }
    std::vector<PoseBlock*> poses;
    for (const std::size_t i : instants) {
      poses.push_back(&T_body_start_[i]);
    }
    if (!keep_gauge(problem, poses)) {
      return false;
    }
    for (std::array<double, 4>& p : p_start_) {
      if (problem.HasParameterBlock(p.data())) {
        order->AddElementToGroup(p.data(), 0);
      }
    }
    for (const std::size_t i : instants) {
      order->AddElementToGroup(T_body_start_[i].data(), 1);
    }
    for (const std::size_t c : cameras) {
      order->AddElementToGroup(T_camera_body_[c].data(), 2);
      order->AddElementToGroup(lens_[c].data(), 2);
    }
    order->AddElementToGroup(&clock_s, 2);
    order->AddElementToGroup(wheels.data(), 2);
    return solve_by_schur(problem, order, {.iterations = options_.iterations});
  }

  void store() {
    for (std::size_t i = 0; i < T_body_start_.size(); ++i) {
      out_.state.T_start_body[i] = from_block(T_body_start_[i].data()).inverse();
    }
    for (std::size_t c = 0; c < T_camera_body_.size(); ++c) {
      out_.state.T_body_camera[c] = from_block(T_camera_body_[c].data()).inverse();
    }
    for (std::size_t i = 0; i < p_start_.size(); ++i) {
      out_.state.points_start[i] = point(i);
    }
  }

  void count() {
    for (const RigSeen& seen : out_.tracks.seen) {
      (seen.believed ? out_.observations : out_.left_out) += 1;
      out_.observations_other += seen.believed && !seen.own ? 1 : 0;
    }
    RigByMaps as_before = out_;
    as_before.state = out_.before;
    out_.rms_before_px = JointBundle(options_, as_before).rms_of(out_.tracks.seen);
  }

  double rms_of(const std::vector<RigSeen>& believed) {
    out_.tracks.seen = believed;
    return rms_px();
  }

  const KeyframeBundleOptions& options_;
  RigByMaps& out_;
  std::vector<PoseBlock> T_body_start_;
  std::vector<PoseBlock> T_camera_body_;
  std::vector<Eigen::VectorXd> lens_;
  std::vector<std::array<double, 4>> p_start_;
};

class ByMaps {
 public:
  ByMaps(const RigByMapsOptions& options, const std::vector<MappedCamera>& cameras,
         const FramePicture& picture)
      : options_(options), cameras_(cameras), picture_(picture) {
    for (const MappedCamera& camera : cameras) {
      out_.cameras.push_back(camera.name);
    }
  }

  RigByMaps run(const Rng& rng, const std::function<void(double)>& progress) {
    choose_instants();
    adjust_each([&](double done) { progress(0.3 * done); });
    align(rng, [&](double done) { progress(0.3 + 0.3 * done); });
    out_.shared.assign(cameras_.size(), 0);
    look_along();
    if (out_.is_told()) {
      place();
      gather();
      out_.before = out_.state;
      JointBundle(options_.bundle, out_).run();
    }
    progress(1);
    return std::move(out_);
  }

 private:
  Time taken(std::size_t c, std::size_t frame) const {
    return cameras_[c].map.frames[frame].stamp - from_seconds(cameras_[c].believed.clock_offset_s);
  }

  /// The frame that a camera took nearest to an instant.
  std::optional<std::size_t> frame_near(std::size_t c, Time instant) const {
    std::optional<std::size_t> nearest;
    for (std::size_t frame = 0; frame < cameras_[c].map.frames.size(); ++frame) {
      if (!nearest || std::chrono::abs(taken(c, frame) - instant) <
                          std::chrono::abs(taken(c, *nearest) - instant)) {
        nearest = frame;
      }
    }
    return nearest;
  }

  /// Pictures of the first camera, evenly, and what the others took then.
  void choose_instants() {
    std::vector<std::vector<Duration>> apart(cameras_.size());
    std::optional<Time> before;
    const Duration every = from_seconds(options_.every_s);
    for (std::size_t frame = 0; frame < cameras_.front().map.frames.size(); ++frame) {
      const Time instant = taken(0, frame);
      if (before && instant - *before < every - kMostApart) {
        continue;
      }
      before = instant;
      out_.tracks.instants.push_back(instant);
      frames_.emplace_back();
      for (std::size_t c = 0; c < cameras_.size(); ++c) {
        const std::optional<std::size_t> at = frame_near(c, instant);
        const Duration off = at ? std::chrono::abs(taken(c, *at) - instant) : Duration::max();
        apart[c].push_back(off);
        frames_.back().push_back(
            off <= kMostApart && !cameras_[c].map.frames[*at].lost ? at : std::nullopt);
      }
    }
    for (const std::vector<Duration>& of : apart) {
      out_.apart.push_back(of.empty() ? Duration::zero() : median(of));
    }
  }

  void adjust_each(const std::function<void(double)>& progress) {
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      std::vector<int> keyframes;
      for (const auto& frames : frames_) {
        if (frames[c]) {
          keyframes.push_back(static_cast<int>(*frames[c]));
        }
      }
      KeyframeBundleOptions how = options_.bundle;
      how.adjust_lens = false;
      const RigCamera& believed = cameras_[c].believed;
      out_.maps.push_back(
          adjust_map(how, believed.intrinsics, believed.sigma, cameras_[c].map, keyframes));
      if (out_.maps.back().T_map_camera.empty()) {  // it does not hold together
        out_.maps.back() = {};
      }
      at_frame_.emplace_back();
      for (std::size_t i = 0; i < out_.maps[c].T_map_camera.size(); ++i) {
        at_frame_[c][static_cast<std::size_t>(out_.maps[c].keyframes[i])] =
            out_.maps[c].T_map_camera[i];
      }
      progress(static_cast<double>(c + 1) / static_cast<double>(cameras_.size()));
    }
  }

  void align(const Rng& rng, const std::function<void(double)>& progress) {
    const std::size_t count = cameras_.size();
    for (std::size_t c = 0; c < count; ++c) {
      described_.push_back(described_points(
          options_.features, cameras_[c].map, out_.maps[c],
          [&](int frame) { return picture_(c, static_cast<std::size_t>(frame)); }));
      out_.described.push_back(described_.back().size());
      progress(static_cast<double>(c + 1) / static_cast<double>(count + 1));
    }
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = a + 1; b < count; ++b) {
        out_.alignments.push_back(align_maps(LooksOptions::of(options_.features),
                                             options_.similarity, a, b, described_, rng));
      }
    }
    const auto join = options_.joined == MapsJoined::kChain ? chained : checked_by_cycles;
    out_.aligned = join(count, out_.alignments, out_.cameras);
  }

  /// Where a camera is at an instant, in its own map.
  std::optional<Pose3> in_map(std::size_t c, std::size_t instant) const {
    const std::optional<std::size_t> frame = frames_[instant][c];
    const auto found = frame ? at_frame_[c].find(*frame) : at_frame_[c].end();
    return found != at_frame_[c].end() ? std::optional(found->second) : std::nullopt;
  }

  void look_along() {
    double far = 0;  // of the first camera from where it begins
    for (const Pose3& T : out_.maps.front().T_map_camera) {
      far = std::max(far,
                     (T.translation - out_.maps.front().T_map_camera.front().translation).norm());
    }
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      std::vector<Pose3> T_first_camera;
      for (std::size_t i = 0; i < frames_.size() && out_.aligned.S_first_map[c]; ++i) {
        const std::optional<Pose3> first = in_map(0, i);
        const std::optional<Pose3> here = in_map(c, i);
        if (first && here) {
          T_first_camera.push_back(first->inverse() * (*out_.aligned.S_first_map[c] * *here));
        }
      }
      out_.seen_along.emplace_back();
      if (T_first_camera.empty()) {
        out_.aligned.S_first_map[c].reset();
        continue;
      }
      SeenAlong along{mean_pose(T_first_camera), 0, 0, static_cast<int>(T_first_camera.size())};
      for (const Pose3& T : T_first_camera) {
        const double turn_rad = T.rotation.angularDistance(along.T_first_camera.rotation);
        const double shift = (T.translation - along.T_first_camera.translation).norm();
        along.turn_off_rad += turn_rad * turn_rad / along.instants;
        along.shift_off += shift * shift / along.instants;
      }
      along.turn_off_rad = std::sqrt(along.turn_off_rad);
      along.shift_off = std::sqrt(along.shift_off) / std::max(far, 1e-9);
      out_.seen_along.back() = along;
    }
  }

  bool is_aligned(std::size_t c) const { return out_.aligned.S_first_map[c].has_value(); }

  void place() {
    RigBundleState& state = out_.state;
    const Pose3 T_body_first = cameras_.front().believed.T_body_camera.inverse();
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      state.T_body_camera.push_back(is_aligned(c)
                                        ? out_.seen_along[c]->T_first_camera
                                        : T_body_first * cameras_[c].believed.T_body_camera);
      state.lenses.push_back(cameras_[c].believed.intrinsics);
      state.clock_offset_s.push_back(cameras_[c].believed.clock_offset_s);
    }
    state.T_body_camera.front() = Pose3();
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      Pose3 T_start_body = i > 0 ? state.T_start_body.back() : Pose3();
      for (std::size_t c = 0; c < cameras_.size(); ++c) {
        const std::optional<Pose3> here = is_aligned(c) ? in_map(c, i) : std::nullopt;
        if (here) {
          T_start_body = *out_.aligned.S_first_map[c] * *here * state.T_body_camera[c].inverse();
          break;
        }
      }
      state.T_start_body.push_back(T_start_body);
    }
  }

  /// All points and all that keyframes show of them; those that two maps have are one.
  void gather() {
    std::vector<std::size_t> begin{0};
    for (const AdjustedMap& map : out_.maps) {
      begin.push_back(begin.back() + map.points.size());
    }
    const std::vector<std::size_t> root = roots(begin);
    std::vector<std::optional<std::size_t>> at(begin.back());  // of the joint map, by root
    std::vector<int> members;
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      if (!is_aligned(c)) {
        continue;
      }
      std::vector<std::optional<std::size_t>> view_of_frame(cameras_[c].map.frames.size());
      for (std::size_t i = 0; i < frames_.size(); ++i) {
        if (in_map(c, i)) {
          view_of_frame[*frames_[i][c]] = out_.tracks.views.size();
          out_.tracks.views.push_back({c, i, cameras_[c].map.frames[*frames_[i][c]].stamp});
        }
      }
      auto of_map = cameras_[c].map.points.begin();
      for (std::size_t k = 0; k < out_.maps[c].points.size(); ++k) {
        const AdjustedMap::Point& point = out_.maps[c].points[k];
        of_map = std::find_if(of_map, cameras_[c].map.points.end(),
                              [&](const auto& each) { return each.number == point.number; });
        if (point.observations < 2) {
          continue;
        }
        std::optional<std::size_t>& joint = at[root[begin[c] + k]];
        const Vec3 p_start = *out_.aligned.S_first_map[c] * point.p_map;
        if (!joint) {
          joint = out_.state.points_start.size();
          out_.state.points_start.push_back(p_start);
          out_.map_of_point.push_back(static_cast<int>(c));
          members.push_back(1);
        } else {
          Vec3& mean = out_.state.points_start[*joint];
          mean += (p_start - mean) / ++members[*joint];
          ++out_.shared[c];
          if (members[*joint] == 2) {
            ++out_.shared[static_cast<std::size_t>(out_.map_of_point[*joint])];
          }
        }
        const bool is_own = out_.map_of_point[*joint] == static_cast<int>(c);
        for (const MonoMap::Seen& seen : of_map->seen) {
          if (const auto view = view_of_frame[static_cast<std::size_t>(seen.frame)]) {
            out_.tracks.seen.push_back({*view, *joint, seen.px, is_own, true});
          }
        }
      }
    }
  }

  /// Of each point of each map the first of those that are the same one.
  std::vector<std::size_t> roots(const std::vector<std::size_t>& begin) const {
    Joined joined(begin.back());
    std::map<std::size_t, std::set<std::size_t>> maps_of;  // by root
    const auto maps_at = [&](std::size_t root, std::size_t map) -> std::set<std::size_t>& {
      return maps_of.try_emplace(root, std::set<std::size_t>{map}).first->second;
    };
    for (std::size_t i = 0; i < out_.alignments.size(); ++i) {
      const MapAlignment& alignment = out_.alignments[i];
      for (const std::size_t pair : alignment.agreed.agree) {
        if (!out_.aligned.is_believed[i]) {
          break;
        }
        const auto& [of_a, of_b] = alignment.alike[pair];
        const std::size_t a = joined.root(begin[alignment.a] + described_[alignment.a][of_a].point);
        const std::size_t b = joined.root(begin[alignment.b] + described_[alignment.b][of_b].point);
        std::set<std::size_t> both = maps_at(a, alignment.a);
        const std::set<std::size_t>& with = maps_at(b, alignment.b);
        const std::size_t apart = both.size() + with.size();
        both.insert(with.begin(), with.end());
        // One camera does not map a point twice: pairs that say so contradict one another.
        if (a != b && both.size() == apart) {
          joined.join(a, b);
          maps_of[joined.root(a)] = both;
        }
      }
    }
    std::vector<std::size_t> root(begin.back());
    for (std::size_t i = 0; i < root.size(); ++i) {
      root[i] = joined.root(i);
    }
    return root;
  }

  const RigByMapsOptions& options_;
  const std::vector<MappedCamera>& cameras_;
  const FramePicture& picture_;
  std::vector<std::vector<std::optional<std::size_t>>> frames_;  // by instant and camera
  std::vector<std::map<std::size_t, Pose3>> at_frame_;           // by camera, adjusted
  std::vector<std::vector<DescribedPoint>> described_;           // by camera
  RigByMaps out_;
};

}  // namespace

bool RigByMaps::is_told() const {
  return std::count_if(seen_along.begin(), seen_along.end(),
                       [](const auto& along) { return along.has_value(); }) > 1;
}

RigByMaps calibrate_by_maps(const RigByMapsOptions& options,
                            const std::vector<MappedCamera>& cameras, const FramePicture& picture,
                            const Rng& rng, const std::function<void(double)>& progress) {
  return ByMaps(options, cameras, picture).run(rng, progress);
}

Rig rig_by_maps(const Rig& believed, const RigByMaps& found) {
  Rig rig = believed;
  double far_m = 0;
  double far = 0;
  for (std::size_t a = 0; a < found.cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < found.cameras.size(); ++b) {
      const double apart_m = (believed.cameras.at(found.cameras[a]).T_body_camera.translation -
                              believed.cameras.at(found.cameras[b]).T_body_camera.translation)
                                 .norm();
      if (found.seen_along[a] && found.seen_along[b] && apart_m > far_m) {
        far_m = apart_m;
        far = (found.state.T_body_camera[a].translation - found.state.T_body_camera[b].translation)
                  .norm();
      }
    }
  }
  const Pose3& T_body_first = believed.cameras.at(found.cameras.front()).T_body_camera;
  for (std::size_t c = 1; c < found.cameras.size(); ++c) {
    if (found.seen_along[c]) {
      Pose3 T_first_camera = found.state.T_body_camera[c];
      T_first_camera.translation *= far > 0 ? far_m / far : 0;
      rig.cameras.at(found.cameras[c]).T_body_camera = T_body_first * T_first_camera;
    }
  }
  return rig;
}

}  // namespace panoptes
