// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/explore/explorer.h"
#include "core/nav/driver.h"
#include "core/plan/clearance.h"

namespace panoptes::test {

/// A flat world on 2 cm cells: what stands in it, all known.
struct GridWorld {
  ClearanceMap truth;

  double gap_m(const Vec2& p,
               double radius_m) const;  ///< from a disc's outline to the nearest thing
};

/// An office of 10 x 10 m in the manner of the thesis's Fig. 6.8: cupboards along the walls, blocks
/// of desks left and right of a corridor with aisles of 0.88 to 1.6 m, chairs pushed in.
GridWorld make_office(Rng rng);

/// Two rooms of 3.5 x 4 m and a wall between them, 10 to 30 cm thick, with one gap as wide as asked
/// somewhere in it, anywhere between cells of any map.
GridWorld make_two_rooms(double gap_m, Rng rng);

/// A place for the start, with `gap_m` of room around the disc.
Pose2 draw_start(const GridWorld& world, double radius_m, double gap_m, Rng rng);

struct GridRobotNoise {
  double drift = 0;        ///< of the odometry, a share of each motion (sigma), and of each turn
  double map_pose_m = 0;   ///< wandering error of the pose in the map (sigma)
  double range_share = 0;  ///< of the range at which the foot of a thing is seen (sigma)
};

/// A disc with wheels in a GridWorld, a floor camera without pictures, and the maps made of it: the
/// local one in odom, which forgets after five keyframes, and the one of everything.
class GridRobot {
 public:
  GridRobot(const GridWorld& world, const Body& body, const FloorWedge& wedge,
            const GridRobotNoise& noise, const Pose2& T_world_body, Rng rng);

  /// Drives one frame of 1/15 s by the command given one frame ago, then looks.
  void step(const Twist2& command_body);

  const OccupancyMap& local_odom() const { return local_odom_.map; }
  const OccupancyMap& map() const { return map_.map; }
  Pose2 T_odom_body() const { return T_odom_body_; }
  Pose2 T_map_odom() const { return T_map_odom_; }
  Pose2 T_world_body() const { return T_world_body_; }
  Twist2 twist() const { return twist_; }
  bool bumper() const { return bumper_; }
  int contacts() const { return contacts_; }
  double path_m() const { return path_m_; }
  double least_gap_m() const { return least_gap_m_; }
  Time now() const { return now_; }
  double coverage() const;  ///< of the floor that the disc can reach

 private:
  struct Grid {
    OccupancyMap map;
    std::vector<int> votes;     // above 0 free, below 0 occupied
    std::vector<int> keyframe;  // when last seen
  };

  void look();
  void vote(Grid& grid, const Vec2& p, int votes) const;
  void assume_free(Grid& grid, const Pose2& T);
  void forget();

  const GridWorld& world_;
  Body body_;
  FloorWedge wedge_;
  GridRobotNoise noise_;
  Rng rng_;
  Pose2 T_world_body_;
  Pose2 T_world_map_;
  Pose2 T_odom_body_;
  Pose2 T_map_odom_;
  Pose2 map_error_;
  Twist2 twist_;
  Twist2 pending_;
  Time now_;
  long frame_ = 0;
  Grid local_odom_;
  Grid map_;
  int keyframe_ = 0;
  Pose2 keyframe_odom_;
  bool bumper_ = false;
  int contacts_ = 0;
  double path_m_ = 0;
  double least_gap_m_ = 1e9;
  std::vector<std::pair<int, int>> reachable_;
};

struct GridRun {
  std::vector<std::pair<double, double>> coverage;  ///< time in seconds, share; every second
  int contacts = 0;
  int recoveries = 0;
  int given_up = 0;
  double least_gap_m = 0;
  double path_m = 0;
  std::optional<double> done_s;   ///< when no frontier was left
  std::vector<std::string> said;  ///< every change of the driver's mind, with time and place

  double coverage_at(double s) const;
  std::optional<double> when(double share) const;
};

/// Explores with explorer and driver in closed loop until nothing is left or time is out.
GridRun explore_world(const GridWorld& world, const Pose2& start, const ExploreOptions& explore,
                      const DriverOptions& drive, const GridRobotNoise& noise, double duration_s,
                      Rng rng);

}  // namespace panoptes::test
