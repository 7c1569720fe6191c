// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/map/floor_projection.h"
#include "core/map/second_view.h"
#include "core/map/upright_points.h"

namespace panoptes {

/// Tells how high over the floor the edges lie where its colour ends or begins again along a ray.
/// Seen from other places, an edge at height z is not where the floor would be: its line of sight
/// meets the floor at h / (h - z) of its distance from the foot of the camera, whose height is h.
/// Of the heights that would do, that one counts which the pictures of the last metre agree on
/// (space sweep, Collins 1996). Corners are not needed: the skirting board of a plain wall has
/// none. Edges along the motion say nothing by it, nor does a turn on the spot. Where another
/// camera sees the same floor from another height, edges that the motion leaves open are compared
/// with what that one shows: so lines that are painted along the way are found. How that one is
/// mounted is known as well as the rig file says, and is learned from edges that prove to lie on
/// the floor.
class EdgeHeights {
 public:
  explicit EdgeHeights(std::shared_ptr<const FloorProjection> projection,
                       std::optional<SecondView> second = std::nullopt);

  struct Found {
    std::vector<UprightPoint> upright;  ///< edges surely over the floor
    std::vector<Vec2> marks_odom;       ///< far ends of what is painted on it
  };

  /// What the second view shows.
  struct Second {
    std::vector<std::int8_t> floor;  ///< of each of its samples
    Pose2 T_odom_body;               ///< when its picture was taken
  };

  /// Whether the robot has gone far enough for another picture to be compared.
  bool is_due(const Pose2& T_odom_body) const;

  /// `floor`: of each sample of the scan, above 0 where it has the floor's colour; `second` is of
  /// the same instant, and looked at only where a picture is due. The edges of a picture are looked
  /// at little by little, in the following calls as well.
  Found add(const std::vector<std::int8_t>& floor, const Pose2& T_odom_body,
            const std::optional<Second>& second = std::nullopt);

  const std::optional<SecondView>& second() const { return second_; }

 private:
  struct Edge {
    float range_m = 0;  // from the foot to where the line of sight meets the floor
    float sigma_m = 0;
    bool floor_ends = false;  // or begins again
  };
  struct View {
    double height_m = 0;  // of the camera
    bool second = false;  // or the floor camera's
    int instant = 0;      // pictures that were taken together have the same
    Pose2 T_odom_view;
    Vec2 foot_odom = Vec2::Zero();
    std::vector<Edge> edges;          // ray by ray, the nearest first
    std::vector<std::int32_t> begin;  // of each ray's edges, and the end
    std::vector<float> near_m;        // of what each ray shows, from
    std::vector<float> far_m;         // and to
  };
  struct Since {  // an earlier view, seen from the last one of the floor camera
    const View* view = nullptr;
    Mat2 R_then_now = Mat2::Identity();
    Vec2 foot_then = Vec2::Zero();  // of now
    double variance_m2 = 0;         // of what the wheels do not know
  };
  struct Fit {
    double score = 0;        // nats: what is seen as it should be, clipped for each view
    int seen = 0;            // views that should show the edge,
    int agree = 0;           // and do
    double information = 0;  // on the slide,
    double vector = 0;       // its part of the normal equation,
    Eigen::Vector4d lean =
        Eigen::Vector4d::Zero();  // and how that depends on the second view's error
    Fit& operator+=(const Fit& other);
  };
  // Of the second view: its mounting, see SecondView::range_error(), and by how many of its pixels
  // what is no floor looks longer, at either end. It also looks so to the floor camera, whose
  // pixels are of another size.
  struct Error {
    Eigen::Vector4d mean = Eigen::Vector4d::Zero();
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  };
  struct Height {
    UprightPoint point;
    double sigma_m = 0;
    bool by_second = false;
  };
  struct Flat {
    Vec2 p_odom = Vec2::Zero();
    int view = 0;
  };

  struct Samples {  // of a camera
    const std::vector<std::int32_t>& pixel;
    const std::vector<float>& depth_m;
    Vec2 foot_view;
    double height_m;
  };
  struct Seen {  // of an edge, at some height, in another view
    std::size_t ray = 0;
    double direction_rad = 0;
    double range_m = 0;
    double by_slide = 0;
  };

  View look(const Samples& samples, const std::vector<std::int8_t>& floor,
            const Pose2& T_odom_body) const;
  void take(const std::vector<std::int8_t>& floor, const Pose2& T_odom_body,
            const std::optional<Second>& second);
  Since since(const View& view) const;
  std::optional<Seen> seen(const Since& since, const Vec2& sight, double slide) const;
  static const Edge* nearest(const View& view, const Edge& edge, const Seen& at);
  Fit fit(const std::vector<Since>& views, const Edge& edge, const Vec2& direction,
          double slide) const;
  std::optional<Height> settle(const Edge& edge, const Vec2& direction,
                               const std::vector<Fit>& fits, bool second) const;
  bool is_surely_flat(const Fit& fit) const;
  std::optional<Height> height_of(const Edge& edge, const Vec2& direction, bool ask_second);
  Eigen::Vector4d error_by(const View& view, const Seen& at, const Edge& edge,
                           const Edge& found) const;
  void learn(const Edge& edge, const Vec2& direction);
  bool is_supported(const Vec2& p_odom) const;

  std::shared_ptr<const FloorProjection> projection_;
  std::optional<SecondView> second_;
  Error error_;                      // of it
  std::vector<double> slides_;       // z / (h - z) of the heights that are tried
  std::vector<Vec2> directions_;     // of the rays, in view
  std::deque<View> views_;           // of the last stretch, the floor camera's
  std::deque<View> second_views_;    // and the second ones'
  std::vector<Since> since_;         // from the last view of the floor camera: its others,
  std::vector<Since> second_since_;  // and these
  int next_ray_ = 0;
  int rays_left_ = 0;  // of the last view
  int view_ = 0;
  std::deque<Flat> flat_;  // found of late
};

}  // namespace panoptes
