// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/pose2.h"
#include "core/map/floor_projection.h"

namespace panoptes {

/// A point of something that stands up from the floor.
struct UprightPoint {
  Vec2 p_odom = Vec2::Zero();  ///< of the floor below it
  double height_m = 0;
  double sigma_m = 0;  ///< of its place, along the line from the camera
};

/// Finds what stands up by how it moves, whatever its colour: corners are followed from picture to
/// picture (Lucas and Kanade 1981; Shi and Tomasi 1994). Where the line of sight to a corner of
/// height z meets the floor slides along the path of the camera, whose height is h, by z / (h - z)
/// of its length; that of the floor's own texture stays (plane and parallax, Irani and Anandan
/// 1996). What slides otherwise moves by itself or was followed wrongly. So may what is alone:
/// a repeated pattern can be followed from one copy to the next. A point counts once others say of
/// the same place that something stands there, or eight pictures have confirmed it. Found points
/// are remembered, for the camera looks over them as it comes near, until the wheels have gone so
/// far that they no longer tell where the points are, or for twenty seconds: what can walk may have
/// left.
class UprightPoints {
 public:
  /// `rate_hz`: of the pictures.
  explicit UprightPoints(std::shared_ptr<const FloorProjection> projection, double rate_hz = 15);

  /// The next picture, of the size that the projection is of. Returns the points that are new, or
  /// taller than before.
  std::vector<UprightPoint> add(const cv::Mat& bgr, const Pose2& T_odom_body);

  /// What another way of looking found in this picture. A place on which three pictures agree
  /// is remembered like those found by add(), which returns it next.
  void suggest(const std::vector<UprightPoint>& points);

  const std::vector<UprightPoint>& points() const { return points_; }

 private:
  struct Sight {      // a line of sight
    Vec2 floor_odom;  // where it meets the floor,
    Mat2 covariance;  // and how surely, by the noise of its pixel
  };
  struct Track {
    Sight first;
    Pose2 T_odom_body;   // then,
    Vec2 foot_odom;      // and the floor under the camera
    cv::Point2f px;      // now
    Mat2 covariance_px;  // of following it
    double slide = 0;
    int id = 0;
    int confirmed = 0;      // by pictures in a row: stands up;
    double low_slide = 0;   // and all of them allow for a slide
    double high_slide = 0;  // between these
  };
  struct Sighting {  // one picture's word for a place
    UprightPoint point;
    int track = 0;
    int picture = 0;
    bool counts = false;
  };
  struct Remembered {
    double driven_m = 0;  // by the robot until it was seen last
    double turned_rad = 0;
    int picture = 0;
    double told_height_m = 0;
  };

  std::optional<Sight> sight(const cv::Point2f& px, const Mat2& covariance_px,
                             const Pose2& T_odom_view) const;
  void follow(const cv::Mat& grey, const Pose2& T_odom_body);
  bool judge(Track& track, const Sight& now, const Pose2& T_odom_body);
  void sighted(const UprightPoint& point, int track, int confirmed);
  void remember(const UprightPoint& point);
  void forget(const Vec2& robot_odom);
  void find_new(const cv::Mat& grey, const Pose2& T_odom_body);

  std::shared_ptr<const FloorProjection> projection_;
  Mat3 H_px_view_;
  std::vector<Track> tracks_;
  int last_track_ = 0;
  std::vector<Sighting> sightings_;  // of late
  std::vector<cv::Mat> pyramid_;     // of the last picture
  std::optional<Pose2> T_odom_last_;
  double driven_m_ = 0;
  double turned_rad_ = 0;
  int picture_ = 0;
  int forgotten_pictures_ = 0;
  std::vector<UprightPoint> points_;
  std::vector<UprightPoint> new_;
  std::vector<Remembered> remembered_;   // of each point
  std::vector<UprightPoint> suggested_;  // by one picture so far,
  std::vector<Remembered> suggested_at_;
};

}  // namespace panoptes
