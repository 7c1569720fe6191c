// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/config/fields.h"
#include "core/explore/given_up.h"
#include "core/geometry/body.h"
#include "core/graph/anchored_pose.h"
#include "core/plan/path_search.h"

namespace panoptes {

/// The floor that the robot sees from where it stands: a sector about its heading, distances from
/// the middle of the body.
struct FloorWedge {
  double width_rad = deg_to_rad(80);
  double near_m = 0.45;
  double far_m = 3.25;
};

/// Goes where most unknown floor comes into view for the time it takes to get there.
struct DirectedOptions {
  static constexpr std::string_view kName = "directed";
  double spacing_m = 0.2;        ///< between candidate places
  int rays = 48;                 ///< around a place
  double unknown_depth_m = 1.5;  ///< a ray is believed this far into the unknown
  double pace_mps = 0.4;         ///< what driving to a goal is reckoned at
  double turn_pace_radps = 1.0;  ///< what turning is reckoned at
  double fixed_cost_s =
      2.0;  ///< added to the cost of every path, so that near places do not win by being near alone
  double hysteresis = 1.3;  ///< another goal must be this many times better
};
void bind(Fields& f, DirectedOptions& o);

/// The thesis's method: a point drawn from a square around the robot, from farther away after too
/// long in the same area.
struct RandomOptions {
  static constexpr std::string_view kName = "random";
  double window_m = 3.0;
  double area_m = 1.5;  ///< within this of where it was, it counts as the same area
  double patience_s = 30;
};
void bind(Fields& f, RandomOptions& o);

struct ExploreOptions {
  std::variant<DirectedOptions, RandomOptions> method;
  SearchOptions search;  ///< the driver's: what is passable is one thing
  double min_information_gain =
      0.25;  ///< of the robot's own area: less unknown floor in view is not worth a drive
  double blacklist_m = 0.3;  ///< around a goal given up
  double blacklist_s = 30;   ///< at least, doubled every time it is given up again
};
void bind(Fields& f, ExploreOptions& o);

/// Where a way is looked for, in `map`. It may lie outside all that is known.
struct ExploreTarget {
  Vec2 p_map = Vec2::Zero();
  double tolerance_m = 0.1;  ///< where it cannot be stood on, so near to it is as good
};

/// What the map says of a target, with unknown floor and doubtful obstacles taken as passable.
enum class TargetOutlook {
  kOpen,
  kObstructed,  ///< something stands there
  kNoWay        ///< no way leads there from the robot, which has room where it stands
};

struct ExploreGoal {
  Pose2 pose_map;
  bool heading_matters = false;    ///< turn to the pose's heading on arrival
  double information_gain_m2 = 0;  ///< unknown floor expected to come into view
  double cost_s = 0;               ///< time reckoned to get there
};

struct ExploreChoice {
  std::optional<ExploreGoal> goal;
  bool frontier_reachable = false;  ///< somewhere reachable shows unknown floor worth going for
  std::string reason;
};

/// Chooses the next place to look from. Remembers the present goal (to keep it while it is about as
/// good as any; also where one grid has no way to any, for the next), goals given up and what it
/// looked for in vain, all held by the keyframes nearest to them. Ask every second or two and after
/// every relaxation: the map may have moved, and the goal is judged anew each time. About 10 ms for
/// 12 x 12 m.
class Explorer {
 public:
  Explorer(const ExploreOptions& options, const Body& body, const FloorWedge& wedge, Rng rng);

  /// `grid` is what the robot will be driven by, with unknown cells around it as far as the camera
  /// sees, since what may come into view there counts. `standing_map` is what has been found to
  /// stand by its motion: an obstacle far from all of it may be another floor, seen from afar, and
  /// is worth a look from near by. Nothing is where nobody looks for what stands.
  /// With a target only unknown floor counts that the way there may lead over, and that place is
  /// the best from which the target is reached soonest if all unknown floor is free.
  ExploreChoice choose(Time now, const DrivableGrid& grid, const Pose2& T_map_body,
                       std::span<const Pose2> T_map_keyframes = {},
                       const std::vector<Vec2>* standing_map = nullptr,
                       const std::optional<ExploreTarget>& target = std::nullopt);

  /// `grid` and `standing_map` as above.
  TargetOutlook outlook(const ExploreTarget& target, const DrivableGrid& grid,
                        const Pose2& T_map_body, std::span<const Pose2> T_map_keyframes = {},
                        const std::vector<Vec2>* standing_map = nullptr);

  /// How far beyond the known map the camera sees.
  double border_m() const { return wedge_.far_m; }

  /// The present goal could not be reached: leave its surroundings alone for a while, and until the
  /// map there has changed.
  void abandon(Time now, const OccupancyMap& map, std::span<const Pose2> T_map_keyframes = {});

  /// The present goal has been reached; the next choice owes it nothing. What should have come into
  /// view there and did not, twice, is not counted again.
  void reached();

 private:
  struct InVain {  // a cell that did not come into view
    AnchoredPose place;
    int times;
    int look;  ///< the last one of them
  };

  ExploreChoice choose_directed(const DirectedOptions& o, const DrivableGrid& grid,
                                const Pose2& T_map_body, std::span<const Pose2> T_map_keyframes,
                                const std::vector<Vec2>* standing_map,
                                const std::optional<ExploreTarget>& target);
  struct Views;
  struct View;   // from a place at a heading
  struct Place;  // to look from
  Views views(const DirectedOptions& o, const DrivableGrid& grid, const Pose2& T_map_body,
              std::span<const Pose2> T_map_keyframes, const std::vector<Vec2>* standing_map);
  DrivableGrid hopeful(const Views& views) const;
  void look_for_way(Views& views, const ExploreTarget& target) const;
  double worth(const Views& views, int cell, double gain_m2, double cost_s) const;
  std::optional<View> best(const Views& views, bool& some_abandoned) const;
  void mark_doubtful(Views& views, std::span<const Pose2> T_map_keyframes,
                     const std::vector<Vec2>& standing_map) const;
  std::optional<View> best_view(const Views& views, int cell,
                                std::optional<double> only_heading) const;
  std::vector<Place> places_to_look_from(const Views& views, bool& some_abandoned) const;
  std::optional<View> present_view(const Views& views) const;
  ExploreChoice choose_random(const RandomOptions& o, Time now, const DrivableGrid& grid,
                              const Pose2& T_map_body, std::span<const Pose2> T_map_keyframes);
  void strike_off(const Views& views, const Pose2& T_map_looked,
                  std::span<const Pose2> T_map_keyframes);
  void follow(std::span<const Pose2> T_map_keyframes);

  ExploreOptions options_;
  Body body_;
  FloorWedge wedge_;
  Rng rng_;
  std::optional<ExploreGoal> goal_;
  std::optional<AnchoredPose> goal_place_;
  GivenUp given_up_;
  std::optional<AnchoredPose> looked_;  // from here, since the last choice
  int looks_ = 0;
  std::optional<Time> looked_back_;  // when that was first counted, by one grid or another
  std::vector<InVain> looked_in_vain_;
  std::optional<AnchoredPose> area_;  // where the thesis's method has been staying
  Time area_since_;
};

}  // namespace panoptes
