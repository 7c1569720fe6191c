// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/calib/mono_filter.h"
#include "core/calib/mono_start.h"
#include "core/calib/salient_features.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

struct MonoSlamOptions {
  MonoFilterOptions filter;
  FeatureMethod features = FeatureMethod::kSift;
  int columns = 6;  ///< of the grid: a cell without a point of the map gets one
  int rows = 4;
  double search_sigmas = 3;        ///< how far a point is sought
  double least_correlation = 0.8;  ///< of what is taken for it
  double match_sigma_px = 0.15;    ///< of where it is found, each way, until the run has shown it
  double place_sigma_px = 0.1;     ///< what the noise of pictures may leave of a new point's place
  /// The motion between pictures is told, and with it the metre and which way a start goes.
  bool motion_is_told = false;
};

/// A point that was looked for in a picture.
struct PointSought {
  int point = 0;
  PointExpected expected;
  std::optional<Vec2> found_px;
  bool inlier = false;
};

struct MonoSlamStep {
  Pose3 T_map_camera;
  std::vector<PointSought> sought;
  std::vector<PointMatch> added;  ///< where they are first seen
  double squared_sigmas = 0;      ///< see FilterUpdate
  int dof = 0;
  double match_sigma_px = 0;  ///< of where points are found, as learned so far
  bool begins_anew = false;   ///< the start contradicted itself: what was mapped is forgotten
  /// It was held by points once, is not now, and nothing else leads it: nothing is mapped.
  bool lost = false;
  bool closes = false;                ///< a point was found again after more than half a turn
  std::vector<StartBelieved> retold;  ///< of the pictures just before, where the start is mended
};

/// A point of the map as pictures show it.
struct MappedPoint {
  SalientFeature feature;  ///< where it was first seen
  cv::Mat descriptor;
  int found = 0;
  int sought = 0;
};

/// MonoSLAM (Davison 2003; thesis 4.3.2) on one camera's pictures, as its lens draws them: points
/// are sought as patches in the ellipses that the filter expects them in, and found anew as the
/// most salient feature of each cell of a grid that holds none. While next to no depth is known,
/// the pictures since the start are adjusted together, again and again (MonoStart); a start that
/// contradicts itself all the same begins anew, at that picture. A camera that is lost maps
/// nothing, and is found again by the looks of its points. Where the motion is told, a camera that
/// has nothing to see, or sees what is not mapped yet, is led by that, for as long as it is so well
/// known where it is that points would still be sought; one that does not find what it ought to see
/// is lost all the same, until points hold it.
class MonoSlam {
 public:
  MonoSlam(const MonoSlamOptions& options, const Intrinsics& lens);

  /// The next picture (grey, of the lens's size), not before the one before it. Of a motion that is
  /// told where `motion_is_told` does not announce it, the turn alone counts: over a gap between
  /// pictures.
  MonoSlamStep step(const cv::Mat& grey, Time stamp,
                    const std::optional<MotionTold>& told = std::nullopt);

  const MonoFilter& filter() const { return filter_; }
  /// Its first pictures told depths, or the motion between pictures is told.
  bool start_is_known() const { return start_is_known_; }
  /// By the points' numbers.
  const std::map<int, MappedPoint>& points() const { return points_; }

 private:
  struct Tracked {
    cv::Mat source;  // the picture around it where it was first seen
    Vec2 offset_px = Vec2::Zero();
    Pose3 T_map_first;
    Eigen::Matrix<double, 3, 2> direction_by_px;
    Vec3 turned_rad = Vec3::Zero();  // by the camera, when it was last found
  };
  std::optional<Mat2> source_by_px(const Tracked& tracked, int number) const;
  std::optional<PointSought> seek(const cv::Mat& grey, int number) const;
  void grow(const cv::Mat& grey, MonoSlamStep& step);
  bool add(const cv::Mat& grey, const SalientFeature& feature, MonoSlamStep& step);
  std::optional<Tracked> tracked_at(const cv::Mat& grey, const SalientFeature& feature) const;
  FilterUpdate take_in(const std::vector<PointMatch>& matches);
  bool is_led(const cv::Mat& grey, const MonoSlamStep& step) const;
  bool shows_something(const cv::Mat& grey) const;
  bool would_be_sought() const;
  void forget_the_bad();
  void mind_the_start(MonoSlamStep& step);
  void begin_anew(MonoSlamStep& step);
  void find_again(const cv::Mat& grey);

  MonoSlamOptions options_;
  Intrinsics lens_;
  MonoFilter filter_;
  std::map<int, MappedPoint> points_;
  std::map<int, Tracked> tracked_;
  std::optional<Time> before_;
  int pictures_ = 0;
  std::vector<int> try_cell_from_;  // the number of the picture
  Vec3 turned_rad_ = Vec3::Zero();  // since the start, in map: its turns added up
  double noise_grey_ = 0;
  int lost_pictures_ = 0;  // since it was held
  bool is_blind_ = false;  // it was held, and is not now
  int from_before_ = 0;    // points of lower numbers are: they have not held it since it was blind
  bool was_held_ = false;  // by as many points as hold a camera
  bool start_is_known_ = false;
  std::optional<MonoStart> start_;  // until depths are known
  double agreeing_ = 1;             // share of the matches, lately
  double match_sigma_px_;
};

}  // namespace panoptes
