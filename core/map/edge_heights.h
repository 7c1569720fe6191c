// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/map/floor_projection.h"
#include "core/map/upright_points.h"

namespace panoptes {

/// Tells how high over the floor the edges lie where its colour ends or begins again along a ray.
/// Seen from other places, an edge at height z is not where the floor would be: its line of sight
/// meets the floor at h / (h - z) of its distance from the foot of the camera, whose height is h.
/// Of the heights that would do, that one counts which the pictures of the last metre agree on
/// (space sweep, Collins 1996). Corners are not needed: the skirting board of a plain wall has
/// none. Edges along the motion say nothing, nor does a turn on the spot.
class EdgeHeights {
 public:
  explicit EdgeHeights(std::shared_ptr<const FloorProjection> projection);

  struct Found {
    std::vector<UprightPoint> upright;  ///< edges surely over the floor
    std::vector<Vec2> marks_odom;       ///< far ends of what is painted on it
  };

  /// `floor`: of each sample of the scan, above 0 where it has the floor's colour. The edges of a
  /// picture are looked at little by little, in the following calls as well.
  Found add(const std::vector<std::int8_t>& floor, const Pose2& T_odom_body);

 private:
  struct Edge {
    float range_m = 0;  // from the foot to where the line of sight meets the floor
    float sigma_m = 0;
    bool floor_ends = false;  // or begins again
  };
  struct View {
    Pose2 T_odom_view;
    Vec2 foot_odom = Vec2::Zero();
    std::vector<Edge> edges;          // ray by ray, the nearest first
    std::vector<std::int32_t> begin;  // of each ray's edges, and the end
    std::vector<float> far_m;         // of what each ray shows
  };
  struct Since {  // an earlier view, seen from the last one
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
    double vector = 0;       // and its part of the normal equation
  };
  struct Height {
    UprightPoint point;
    double sigma_m = 0;
  };
  struct Flat {
    Vec2 p_odom = Vec2::Zero();
    int view = 0;
  };

  View look(const std::vector<std::int8_t>& floor, const Pose2& T_odom_body) const;
  void relate();
  Fit fit(const Edge& edge, const Vec2& direction, double slide) const;
  std::optional<Height> height_of(const Edge& edge, const Vec2& direction) const;
  bool is_supported(const Vec2& p_odom) const;

  std::shared_ptr<const FloorProjection> projection_;
  std::vector<double> slides_;    // z / (h - z) of the heights that are tried
  std::vector<Vec2> directions_;  // of the rays, in view
  std::deque<View> views_;        // of the last stretch
  std::vector<Since> since_;      // all but the last of them
  int next_ray_ = 0;
  int rays_left_ = 0;  // of the last view
  int view_ = 0;
  std::deque<Flat> flat_;  // found of late
};

}  // namespace panoptes
