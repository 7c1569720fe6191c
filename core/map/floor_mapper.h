// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/map/edge_heights.h"
#include "core/map/floor_colour.h"
#include "core/map/floor_parallax.h"
#include "core/map/floor_projection.h"
#include "core/map/floor_stereo.h"
#include "core/map/upright_faces.h"
#include "core/map/upright_points.h"

namespace panoptes {

struct FloorMapperOptions {
  FloorColourOptions colour;
  bool parallax = true;  ///< learn other floors by their motion; off: the thesis's own
  bool upright = true;   ///< what stands up by its motion ends the floor
  bool faces = true;     ///< and what reaches over the horizon
  bool stereo = false;   ///< and what two cameras see at other places than floor would be
  FloorParallaxOptions parallax_check;
  double obstacle_height_m = 0.02;  ///< what is lower than this may pass for a stain
  double foot_depth_m = 0.04;       ///< how far behind its foot an obstacle is taken to reach
  double trusted_m = 0.1;  ///< depth of the floor ahead that is taken to be floor at the start
  double start_far_m =
      20;  ///< one colour from the robot to beyond this is the face of an object, no floor
  double learn_to_m = 1.5;     ///< floor farther from the camera's foot is too coarse to learn from
  double learn_every_s = 0.2;  ///< by the camera's rate, whole pictures: three at 15 Hz
};
void bind(Fields& f, FloorMapperOptions& o);

/// What one picture says of the floor. Evidence is in eighths of a nat of ln P(free)/P(occupied):
/// positive is free (thesis Eq. 6.2), 0 says nothing.
struct FloorReading {
  cv::Mat log_ratio;  ///< CV_32F, nats, the whole picture; 0 outside the mapped part
  std::shared_ptr<const FloorProjection> projection;
  std::vector<std::int8_t> evidence;  ///< the projection's body-frame raster, row-major along x
  std::vector<UprightPoint> upright_odom;  ///< found since the last reading
  std::vector<Vec2> painted_odom;  ///< places in what is of another colour and proved to be painted
  bool sees_floor = false;         ///< the patch ahead has looked like one floor
  std::string fault;               ///< why not
  double free_ahead_m =
      0;           ///< from the body's front, straight ahead, to the first obstacle or far edge
  int floors = 0;  ///< Gaussians that vote
  bool learned_new_floor = false;  ///< by its motion, in this picture
};

/// Free space from a floor camera (thesis 6.3.4): homography and a mixture of floor colours learned
/// as the robot goes, beginning with the floor just ahead. A second floor is learned once its
/// texture has moved as only the floor can (plane and parallax, Irani and Anandan 1996).
class FloorMapper {
 public:
  /// `second_camera`: another one that sees the same floor from another height; it is not asked
  /// where it does not.
  FloorMapper(const FloorMapperOptions& options, const RigCamera& floor_camera, const Body& body,
              const RigCamera* second_camera = nullptr);

  struct SecondPicture {
    cv::Mat bgr;
    Pose2 T_odom_body;  ///< when it was taken
  };

  /// `may_learn`: false after a bump or a stall, so that what touches the bumper is not learned.
  /// `second_picture`: of the second camera, taken at about the same time.
  FloorReading read(const cv::Mat& bgr, const Pose2& T_odom_body, bool may_learn,
                    const SecondPicture* second_picture = nullptr);

  const std::shared_ptr<const FloorProjection>& projection() const { return projection_; }
  const FloorColour& colour() const { return colour_; }

 private:
  void learn_at_start(const cv::Mat& bgr);
  bool reaches_horizon(const cv::Mat& bgr);
  void rate(const cv::Mat& bgr);
  void find_upright(const Pose2& T_odom_body);
  void find_faces(const Pose2& T_odom_body, const SecondPicture& second_picture);
  void join_upright(const std::vector<UprightPoint>& found);
  void hide(const Vec2& from_foot, double sigma_m);
  template <class OfRay>
  void between(const Vec2& from_foot_a, const Vec2& from_foot_b, OfRay&& of_ray) const;
  void hide_between(const Vec2& from_foot_a, const Vec2& from_foot_b, double sigma_m);
  int row_at(double range_m) const;
  double ray_at(const Vec2& from_foot_view) const;
  void measure_across();
  bool is_line(std::size_t ray, std::size_t row, std::size_t end) const;
  void note_edges(const cv::Mat& bgr, const Pose2& T_odom_body,
                  const SecondPicture* second_picture);
  void find_stereo(const cv::Mat& bgr, const Pose2& T_odom_body,
                   const SecondPicture& second_picture);
  void find_marks(const Pose2& T_odom_body);
  bool is_mark(std::size_t ray, std::size_t end) const;
  void scan();
  void learn(const cv::Mat& bgr);

  FloorMapperOptions options_;
  int learn_every_;  // pictures
  double learn_every_s_;
  std::shared_ptr<const FloorProjection> projection_;
  FloorColour colour_;
  std::optional<FloorParallax> parallax_;
  std::optional<UprightPoints> upright_;
  std::optional<EdgeHeights> edges_;
  std::optional<UprightFaces> faces_;
  std::optional<FloorStereo> stereo_;
  std::optional<Pose2> T_odom_stereo_;             // where its last pictures were taken
  std::optional<Levels> levels_;                   // of the second camera's last picture
  std::vector<Vec2> marks_odom_;                   // ends of what is painted on the floor
  std::vector<std::vector<float>> mark_ranges_m_;  // of those along each ray
  std::vector<std::int32_t> painted_;              // samples before the marks in the scan
  bool sees_floor_ = false;
  std::string fault_;
  int frame_ = 0;
  double body_radius_m_;
  std::vector<std::int32_t> trusted_;  // pixels of the floor just ahead
  std::vector<int> min_run_;         // samples an obstacle covers at least, by the row it starts in
  std::vector<int> foot_run_;        // samples its foot covers
  std::int32_t first_pixel_ = 0;     // of the rows of the picture that are mapped
  int ahead_ray_ = 0;                // the ray nearest to straight ahead
  std::vector<std::int8_t> rated_;   // picture: colour's log ratio, eighths of a nat
  std::vector<std::int8_t> ratio_;   // scan: the same
  std::vector<std::int8_t> smooth_;  // scan: mean of 3 x 3
  std::vector<std::int16_t> across_;   // scan: neighbouring rays that show no floor
  std::vector<std::int8_t> evidence_;  // scan
  std::vector<std::int16_t> hidden_;   // per ray: row from which something hides the floor,
  std::vector<std::uint8_t> stands_;   // and whether it stands on this very ray
  std::vector<std::int16_t> face_;     // per ray: row from which floor's colour is an upright face,
  std::vector<std::uint8_t> face_ends_;  // and whether its foot shows there
  struct Join {
    UprightPoint a;
    UprightPoint b;
  };
  std::vector<Join> joins_;  // of upright points that no robot passes between
  std::vector<UprightPoint> joined_new_;
  std::vector<std::int16_t>
      first_;  // per ray: row of the first obstacle, `rows` when there is none
};

}  // namespace panoptes
