// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/explorer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace panoptes {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// Cells that may turn out to be floor for the robot: not occupied, as far from what is as the
/// planner keeps, and joined to where the robot is by others of the kind. Row-major.
std::vector<std::uint8_t> possibly_traversable_cells(const SearchOptions& search,
                                                     const DrivableGrid& grid, const Body& body,
                                                     const CostField& field) {
  const OccupancyMap& map = grid.clearance.map;
  if (map.cells.empty()) {
    return {};
  }
  const auto reached = [&](std::size_t cell) { return std::isfinite(field.cost_m[cell]); };
  const double occupied_m = body.radius_m + from_afar(search).margin_m;
  cv::Mat1b open(map.rows, map.columns);
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    open.data[i] = reached(i) || grid.clearance.to_occupied_m[i] >= occupied_m ? 1 : 0;
  }
  cv::Mat1i label;
  const int labels = cv::connectedComponents(open, label, 4, CV_32S);
  const int* const of = label[0];  // of each cell: labels are continuous
  std::vector<std::uint8_t> joined(static_cast<std::size_t>(labels), 0);
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    if (reached(i)) {
      joined[static_cast<std::size_t>(of[i])] = 1;
    }
  }
  std::vector<std::uint8_t> possibly_traversable(map.cells.size());
  std::transform(of, of + possibly_traversable.size(), possibly_traversable.begin(),
                 [&](int label_of) { return joined[static_cast<std::size_t>(label_of)]; });
  return possibly_traversable;
}

/// Whether a line of sight ends here. Cells beside an occupied one hide too, so that no line slips
/// through a slanting row of them.
bool hides(const ClearanceMap& map, std::size_t cell) {
  return map.to_occupied_m[cell] < 1.2 * map.map.cell_m;
}

constexpr double kRayStep = 0.5;  // cells, along a line of sight: none passes between two of a row

/// The cell's place on a grid through the map's origin, which stays when the map grows.
using FixedCell = std::pair<int, int>;
FixedCell fixed_cell(const OccupancyMap& map, const Vec2& p_map) {
  return {static_cast<int>(std::floor(p_map.x() / map.cell_m)),
          static_cast<int>(std::floor(p_map.y() / map.cell_m))};
}

/// What a cell is to a line of sight. What hides may be doubtful: no obstacle, but another floor.
enum class Sight : std::uint8_t { kClear, kHides, kDoubtful, kDoubtfulStill, kUnknown, kWanted };

// An obstacle this far from all that is known to stand is doubtful until it has been in view so
// often from so near by a robot that drove, for a floor is told by its motion. Where a look from
// there has been in vain, one more from nearer by is worth it: the robot drives at it then. Seen
// so, it counts for a strip of unknown floor: what is as wide as the robot is just worth a look.
constexpr double kDoubtful_m = 0.3;
constexpr double kNear_m = 1.4;
constexpr double kNearer_m = 0.8;
constexpr int kNearLooks = 3;
constexpr double kDrove_m = 0.1;
constexpr double kDoubtfulStrip_m = 0.1;

bool is_doubtful(Sight sight) {
  return sight == Sight::kDoubtful || sight == Sight::kDoubtfulStill;
}

bool ends_sight(Sight sight) { return sight == Sight::kHides || is_doubtful(sight); }

bool is_wanted(Sight sight) { return sight == Sight::kWanted || is_doubtful(sight); }

bool is_worth_a_look(Sight sight, double range_m) {
  return (sight == Sight::kDoubtful && range_m <= kNear_m) ||
         (sight == Sight::kDoubtfulStill && range_m <= kNearer_m);
}

/// A cell on a line of sight from the centre of another.
struct RayCell {
  int columns = 0;
  int rows = 0;
  double length_m = 0;  ///< of the line in it
  double area_m2 = 0;   ///< of the line's sector in it, where the camera sees floor at all
  double range_m = 0;   ///< to where the line enters it
};
struct Ray {
  Vec2 direction = Vec2::Zero();
  std::vector<RayCell> cells;
};

/// The same for each place that is looked from: rays of a full turn, the first half a sector off
/// the x axis.
std::vector<Ray> rays_about(int count, const FloorWedge& wedge, double cell_m) {
  const double step_m = kRayStep * cell_m;
  const double sector_rad = kTwoPi / count;
  std::vector<Ray> rays(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    const double angle = sector_rad * (k + 0.5);
    Ray& ray = rays[static_cast<std::size_t>(k)];
    ray.direction = {std::cos(angle), std::sin(angle)};
    // What hides the floor may stand nearer than the floor that is seen.
    for (double r = cell_m; r < wedge.far_m - cell_m; r += step_m) {
      const int columns = static_cast<int>(std::floor(0.5 + r * ray.direction.x() / cell_m));
      const int rows = static_cast<int>(std::floor(0.5 + r * ray.direction.y() / cell_m));
      if (ray.cells.empty() || ray.cells.back().columns != columns ||
          ray.cells.back().rows != rows) {
        ray.cells.push_back({columns, rows, 0, 0, r});
      }
      ray.cells.back().length_m += step_m;
      ray.cells.back().area_m2 += r >= wedge.near_m ? r * sector_rad * step_m : 0;
    }
  }
  return rays;
}

/// Wanted floor, in square metres, along each ray about a cell; `counts` says which cells count.
template <class Counts>
void cast_rays(double unknown_depth_m, const OccupancyMap& map, const std::vector<Sight>& sights,
               const std::vector<Ray>& rays, int cell, const Counts& counts,
               std::vector<double>& gains_m2) {
  const int column = cell % map.columns;
  const int row = cell / map.columns;
  const double sector_rad = kTwoPi / static_cast<double>(rays.size());
  for (std::size_t k = 0; k < rays.size(); ++k) {
    double gain = 0;
    double unknown_m = 0;
    for (const RayCell& at : rays[k].cells) {
      if (!map.contains(column + at.columns, row + at.rows)) {
        break;
      }
      const auto seen = static_cast<std::size_t>(cell + at.rows * map.columns + at.columns);
      const Sight sight = sights[seen];
      if (sight == Sight::kClear) {
        continue;
      }
      if (is_worth_a_look(sight, at.range_m) && counts(seen)) {
        gain += at.range_m * sector_rad * kDoubtfulStrip_m;
      }
      unknown_m += at.length_m;
      if (ends_sight(sight) || unknown_m > unknown_depth_m) {
        break;
      }
      gain += sight == Sight::kWanted && counts(seen) ? at.area_m2 : 0;
    }
    gains_m2[k] = gain;
  }
}

/// How much wanted floor may come into view from a place: what lies in a square of the camera's
/// range about it.
class WantedAbout {
 public:
  WantedAbout(const OccupancyMap& map, const std::vector<Sight>& sights,
              const std::vector<Ray>& rays)
      : map_(map) {
    const double sector_rad = kTwoPi / static_cast<double>(rays.size());
    std::map<FixedCell, std::pair<double, double>> counted;  // by all rays: as floor, as doubtful
    for (const Ray& ray : rays) {
      for (const RayCell& at : ray.cells) {
        range_ = std::max({range_, std::abs(at.columns), std::abs(at.rows)});
        auto& [floor_m2, doubtful_m2] = counted[{at.columns, at.rows}];
        floor_m2 += at.area_m2;
        doubtful_m2 += at.range_m * sector_rad * kDoubtfulStrip_m;
        most_of_cell_m2_ = std::max({most_of_cell_m2_, floor_m2, doubtful_m2});
      }
    }
    cv::Mat1b wanted(map.rows, map.columns);
    std::transform(sights.begin(), sights.end(), wanted.data,
                   [](Sight sight) { return static_cast<std::uint8_t>(is_wanted(sight) ? 1 : 0); });
    if (!wanted.empty()) {
      cv::integral(wanted, sums_, CV_32S);
    }
  }

  double at_most_m2(int column, int row) const {
    const int low = std::max(0, row - range_);
    const int end = std::min(map_.rows, row + range_ + 1);
    const int left = std::max(0, column - range_);
    const int right = std::min(map_.columns, column + range_ + 1);
    return most_of_cell_m2_ *
           (sums_(end, right) - sums_(low, right) - sums_(end, left) + sums_(low, left));
  }

 private:
  const OccupancyMap& map_;
  int range_ = 0;  // cells
  double most_of_cell_m2_ = 0;
  cv::Mat1i sums_;
};

/// The direction of a path after its first or before its last half metre.
double heading_of(const std::vector<Vec2>& path, bool at_end) {
  if (path.size() < 2) {
    return 0;
  }
  constexpr double kBase_m = 0.5;
  const Vec2 from = at_end ? path.back() : path.front();
  Vec2 other = from;
  for (std::size_t i = 1; i < path.size(); ++i) {
    other = at_end ? path[path.size() - 1 - i] : path[i];
    if ((other - from).norm() >= kBase_m) {
      break;
    }
  }
  const Vec2 d = at_end ? Vec2(from - other) : Vec2(other - from);
  return std::atan2(d.y(), d.x());
}

/// Where the target is, or the cell at the edge that is nearest to it: beyond all is unknown.
struct TargetCell {
  std::optional<int> cell;  ///< none where something stands there
  double beyond_m = 0;
};

TargetCell cell_of(const ExploreTarget& target, const DrivableGrid& hopeful) {
  const OccupancyMap& map = hopeful.clearance.map;
  const int column = map.column(target.p_map);
  const int row = map.row(target.p_map);
  if (map.contains(column, row)) {
    return {nearest_drivable(hopeful, target.p_map, target.tolerance_m), 0};
  }
  const int edge_column = std::clamp(column, 0, map.columns - 1);
  const int edge_row = std::clamp(row, 0, map.rows - 1);
  return {static_cast<int>(map.index(edge_column, edge_row)),
          (map.centre(edge_column, edge_row) - target.p_map).norm()};
}

Vec2 centre_of(const OccupancyMap& map, int cell) {
  return map.centre(cell % map.columns, cell / map.columns);
}

}  // namespace

void bind(Fields& f, DirectedOptions& o) {
  f("spacing_m", o.spacing_m, positive);
  f("rays", o.rays, between(8, 720));
  f("unknown_depth_m", o.unknown_depth_m, positive);
  f("pace_mps", o.pace_mps, positive);
  f("turn_pace_radps", o.turn_pace_radps, positive);
  f("fixed_cost_s", o.fixed_cost_s, not_negative);
  f("hysteresis", o.hysteresis, at_least(1));
  f.renamed("settle_s", "fixed_cost_s");
  f.renamed("loyalty", "hysteresis");
}

void bind(Fields& f, RandomOptions& o) {
  f("window_m", o.window_m, positive);
  f("area_m", o.area_m, positive);
  f("patience_s", o.patience_s, positive);
}

void bind(Fields& f, ExploreOptions& o) {
  f.choice("method", o.method);
  f.removed("search", "is the driver's now: driver.search");
  f("min_information_gain", o.min_information_gain, positive);
  f("blacklist_m", o.blacklist_m, not_negative);
  f("blacklist_s", o.blacklist_s, positive);
  f.renamed("least_gain", "min_information_gain");
}

Explorer::Explorer(const ExploreOptions& options, const Body& body, const FloorWedge& wedge,
                   Rng rng)
    : options_(options),
      body_(body),
      wedge_(wedge),
      rng_(rng),
      given_up_(options.blacklist_m, options.blacklist_s) {}

void Explorer::abandon(Time now, const OccupancyMap& map, std::span<const Pose2> T_map_keyframes) {
  if (goal_) {
    given_up_.add(
        now, goal_->pose_map, [&map](const Vec2& p) { return map.at(p); }, T_map_keyframes);
    goal_.reset();
  }
}

void Explorer::reached() {
  if (goal_ && goal_->heading_matters) {
    looked_ = goal_place_;
    ++looks_;
    looked_back_.reset();
  }
  goal_.reset();
}

void Explorer::follow(std::span<const Pose2> T_map_keyframes) {
  if (goal_) {
    goal_place_->follow(T_map_keyframes);
    goal_->pose_map = goal_place_->T_map_place();
  }
  for (InVain& cell : looked_in_vain_) {
    cell.place.follow(T_map_keyframes);
  }
  if (looked_) {
    looked_->follow(T_map_keyframes);
  }
  if (area_) {
    area_->follow(T_map_keyframes);
  }
}

// What a look for the best view knows.
struct Explorer::Views {
  const DirectedOptions& o;
  const DrivableGrid& grid;
  CostField field;
  std::vector<Ray> rays;
  std::vector<Sight> sights;  // of each cell
  double least_m2 = 0;        // of unknown floor that is worth a look
  Pose2 T_map_body;
  std::vector<std::uint8_t> looked_in_vain;  // of each cell
  // With a target: metres to it from each cell if unknown floor is free, infinite where there is no
  // way; whether only such floor counts that is nearer to it than the place.
  std::vector<float> to_target_m;
  bool only_nearer = false;
};

// All that a view counts is struck off: the rays that it counts along are looked along as well.
void Explorer::strike_off(const Views& views, const Pose2& T_map_looked,
                          std::span<const Pose2> T_map_keyframes) {
  const DrivableGrid& grid = views.grid;
  const OccupancyMap& map = grid.clearance.map;
  const double step_rad = kRayStep * map.cell_m / wedge_.far_m;
  std::vector<Vec2> rays;
  for (double a = -0.5 * wedge_.width_rad; a <= 0.5 * wedge_.width_rad; a += step_rad) {
    rays.push_back(T_map_looked.rotation() * Vec2(std::cos(a), std::sin(a)));
  }
  const Vec2 ahead = T_map_looked.rotation().col(0);
  for (const Ray& ray : views.rays) {
    if (ray.direction.dot(ahead) >= std::cos(0.5 * wedge_.width_rad)) {
      rays.push_back(ray.direction);
    }
  }
  std::map<FixedCell, Vec2> seen;
  for (const Vec2& ray : rays) {
    for (double r = map.cell_m; r < wedge_.far_m; r += kRayStep * map.cell_m) {
      const Vec2 p = T_map_looked.position() + r * ray;
      const int column = grid.clearance.column(p);
      const int row = grid.clearance.row(p);
      const Sight sight = map.contains(column, row)
                              ? views.sights[grid.clearance.index(column, row)]
                              : Sight::kHides;
      if (sight == Sight::kWanted || is_worth_a_look(sight, r)) {
        const Vec2 centre = map.centre(column, row);
        seen.emplace(fixed_cell(map, centre), centre);
      }
      if (ends_sight(sight)) {
        break;
      }
    }
  }
  std::map<FixedCell, std::size_t> before;
  for (std::size_t i = 0; i < looked_in_vain_.size(); ++i) {
    before.emplace(fixed_cell(map, looked_in_vain_[i].place.p_map()), i);
  }
  for (const auto& [cell, centre] : seen) {
    if (const auto again = before.find(cell); again != before.end()) {
      InVain& before_now = looked_in_vain_[again->second];
      before_now.times += before_now.look != looks_ ? 1 : 0;
      before_now.look = looks_;
    } else {
      looked_in_vain_.push_back(
          {AnchoredPose({centre.x(), centre.y(), 0}, T_map_keyframes), 1, looks_});
    }
  }
}

ExploreChoice Explorer::choose(Time now, const DrivableGrid& grid, const Pose2& T_map_body,
                               std::span<const Pose2> T_map_keyframes,
                               const std::vector<Vec2>* standing_map,
                               const std::optional<ExploreTarget>& target) {
  follow(T_map_keyframes);
  // All grids that are asked at one time count what that look did not show: each hopes for more
  // than another one does.
  if (looked_back_ && *looked_back_ != now) {
    looked_.reset();
  }
  looked_back_ = now;
  const auto known = [&map = grid.clearance.map](const Vec2& p) { return map.at(p); };
  given_up_.update(now, known, T_map_keyframes);
  ExploreChoice choice = std::holds_alternative<DirectedOptions>(options_.method)
                             ? choose_directed(std::get<DirectedOptions>(options_.method), grid,
                                               T_map_body, T_map_keyframes, standing_map, target)
                             : choose_random(std::get<RandomOptions>(options_.method), now, grid,
                                             T_map_body, T_map_keyframes);
  if (choice.goal) {  // else the present one stays, for a grid that has a way to it
    const bool kept = goal_ && goal_->pose_map == choice.goal->pose_map;
    goal_ = choice.goal;
    if (!kept) {
      goal_place_.emplace(goal_->pose_map, T_map_keyframes);
    }
  }
  return choice;
}

struct Explorer::View {
  ExploreGoal goal;
  double worth = 0;  // gain for the time
};

struct Explorer::Place {
  int cell;
  double cost_m;      // to it, and on to a target
  double most_worth;  // at most, of any view from it
};

Explorer::Views Explorer::views(const DirectedOptions& o, const DrivableGrid& grid,
                                const Pose2& T_map_body, std::span<const Pose2> T_map_keyframes,
                                const std::vector<Vec2>* standing_map) {
  Views views{o,  grid, flood(options_.search, grid, T_map_body.position()), {}, {}, 0, T_map_body,
              {}, {}};
  views.looked_in_vain.assign(grid.clearance.map.cells.size(), 0);
  const std::vector<std::uint8_t> possibly_traversable =
      possibly_traversable_cells(options_.search, grid, body_, views.field);
  views.sights.resize(grid.clearance.map.cells.size());
  for (std::size_t i = 0; i < views.sights.size(); ++i) {
    if (hides(grid.clearance, i)) {
      views.sights[i] = Sight::kHides;
    } else if (grid.clearance.map.cells[i] == Cell::kUnknown) {
      views.sights[i] = possibly_traversable[i] != 0 ? Sight::kWanted : Sight::kUnknown;
    }
  }
  views.rays = rays_about(o.rays, wedge_, grid.clearance.map.cell_m);
  if (standing_map != nullptr) {
    mark_doubtful(views, T_map_keyframes, *standing_map);
  }
  if (looked_) {
    strike_off(views, looked_->T_map_place(), T_map_keyframes);
  }
  constexpr int kVain = 2;
  for (const auto& [place, times, look] : looked_in_vain_) {
    const Vec2 p = place.p_map();
    const int column = grid.clearance.column(p);
    const int row = grid.clearance.row(p);
    if (!grid.clearance.map.contains(column, row)) {
      continue;
    }
    Sight& sight = views.sights[grid.clearance.index(column, row)];
    if (times >= kVain) {
      views.looked_in_vain[grid.clearance.index(column, row)] = 1;
    }
    if (sight == Sight::kWanted && times >= kVain) {
      sight = Sight::kUnknown;
    } else if (sight == Sight::kDoubtful) {
      sight = times >= kVain ? Sight::kHides : Sight::kDoubtfulStill;
    }
  }
  views.least_m2 =
      options_.min_information_gain * std::numbers::pi * body_.radius_m * body_.radius_m;
  return views;
}

// Where the robot may hope to drive: wherever nothing is known to stand.
DrivableGrid Explorer::hopeful(const Views& views) const {
  const ClearanceMap& known = views.grid.clearance;
  const SearchOptions search = from_afar(options_.search);
  DrivableGrid hopeful = views.grid;
  if (std::any_of(views.sights.begin(), views.sights.end(), is_doubtful)) {
    OccupancyMap map = known.map;
    for (std::size_t i = 0; i < map.cells.size(); ++i) {
      if (is_doubtful(views.sights[i])) {
        map.cells[i] = Cell::kUnknown;
      }
    }
    hopeful.clearance = clearance_map(std::move(map), known.cap_m);
  }
  hopeful.through_unknown = true;
  hopeful.near.reset();
  const auto occupied_m = static_cast<float>(body_.radius_m + search.margin_m);
  for (std::size_t i = 0; i < hopeful.clearance_m.size(); ++i) {
    hopeful.clearance_m[i] =
        std::max(hopeful.clearance_m[i], hopeful.clearance.to_occupied_m[i] - occupied_m);
  }
  return hopeful;
}

TargetOutlook Explorer::outlook(const ExploreTarget& target, const DrivableGrid& grid,
                                const Pose2& T_map_body, std::span<const Pose2> T_map_keyframes,
                                const std::vector<Vec2>* standing_map) {
  follow(T_map_keyframes);
  if (grid.clearance.map.cells.empty()) {
    return TargetOutlook::kOpen;
  }
  const auto* directed = std::get_if<DirectedOptions>(&options_.method);
  const DirectedOptions defaults;
  const Views views = this->views(directed != nullptr ? *directed : defaults, grid, T_map_body,
                                  T_map_keyframes, standing_map);
  const DrivableGrid hopeful = this->hopeful(views);
  const TargetCell at = cell_of(target, hopeful);
  if (!at.cell) {
    return TargetOutlook::kObstructed;
  }
  const Vec2 here = T_map_body.position();
  if (!hopeful.drivable(hopeful.clearance.column(here), hopeful.clearance.row(here))) {
    return TargetOutlook::kOpen;  // what stands so close says nothing of the way
  }
  const CostField field = flood(options_.search, hopeful, here);
  return std::isfinite(field.cost_m[static_cast<std::size_t>(*at.cell)]) ? TargetOutlook::kOpen
                                                                         : TargetOutlook::kNoWay;
}

// How far it is to the target from everywhere, and of unknown floor only that which a way there may
// lead over: what is joined to the target without crossing floor that the robot can reach. Ways
// over what has been looked at in vain come last.
void Explorer::look_for_way(Views& views, const ExploreTarget& target) const {
  DrivableGrid hopeful = this->hopeful(views);
  const OccupancyMap& map = hopeful.clearance.map;
  const TargetCell at = cell_of(target, hopeful);
  constexpr float kNoWay = std::numeric_limits<float>::infinity();
  views.to_target_m.assign(map.cells.size(), kNoWay);
  if (!at.cell) {
    return;
  }
  const auto reached = [&](std::size_t i) { return std::isfinite(views.field.cost_m[i]); };
  const auto target_cell = static_cast<std::size_t>(*at.cell);
  cv::Mat1b unreached(map.rows, map.columns);
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const bool open = hopeful.clearance_m[i] >= 0 || is_wanted(views.sights[i]);
    unreached.data[i] = open && !reached(i) ? 1 : 0;
    if (views.looked_in_vain[i] != 0 && !reached(i)) {
      hopeful.clearance_m[i] = std::min(hopeful.clearance_m[i], 0.0F);
    }
  }
  const CostField field = flood(options_.search, hopeful, centre_of(map, *at.cell));
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    views.to_target_m[i] = field.cost_m[i] + static_cast<float>(at.beyond_m);
  }
  if (reached(target_cell)) {
    return;
  }
  cv::Mat1i label;
  cv::connectedComponents(unreached, label, 8, CV_32S);
  const int* const of = label[0];
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    if (views.sights[i] == Sight::kWanted && of[i] != of[target_cell]) {
      views.sights[i] = Sight::kUnknown;
    }
  }
}

// Of what hides, that which may be another floor.
void Explorer::mark_doubtful(Views& views, std::span<const Pose2> T_map_keyframes,
                             const std::vector<Vec2>& standing_map) const {
  const OccupancyMap& map = views.grid.clearance.map;
  std::vector<std::uint8_t> stands(map.cells.size(), 0);
  for (const Vec2& p : standing_map) {
    if (map.contains(map.column(p), map.row(p))) {
      stands[map.index(map.column(p), map.row(p))] = 1;
    }
  }
  const std::vector<float> to_standing_m =
      distance_m(stands, map.columns, map.rows, map.cell_m, 2 * kDoubtful_m);
  // How many keyframes had it in view from near by. Rays are so far apart there that each stands
  // for the cells beside it.
  std::vector<std::uint8_t> looks(map.cells.size(), 0);
  std::vector<int> looked_by(map.cells.size(), -1);
  const int beside =
      static_cast<int>(std::ceil(0.5 * kNear_m * kTwoPi / views.o.rays / map.cell_m));
  for (std::size_t k = 0; k < T_map_keyframes.size(); ++k) {
    const Pose2& T = T_map_keyframes[k];
    if (k == 0 || (T.position() - T_map_keyframes[k - 1].position()).norm() < kDrove_m) {
      continue;
    }
    const int column = map.column(T.position());
    const int row = map.row(T.position());
    const Vec2 ahead = T.rotation().col(0);
    for (const Ray& ray : views.rays) {
      if (ray.direction.dot(ahead) < std::cos(0.5 * wedge_.width_rad)) {
        continue;
      }
      for (const RayCell& at : ray.cells) {
        const int to_column = column + at.columns;
        const int to_row = row + at.rows;
        if (!map.contains(to_column, to_row) || at.range_m > kNear_m) {
          break;
        }
        if (views.sights[map.index(to_column, to_row)] != Sight::kHides) {
          continue;
        }
        for (int r = std::max(0, to_row - beside); r <= std::min(map.rows - 1, to_row + beside);
             ++r) {
          for (int i = std::max(0, to_column - beside);
               i <= std::min(map.columns - 1, to_column + beside); ++i) {
            if (looked_by[map.index(i, r)] != static_cast<int>(k)) {
              looked_by[map.index(i, r)] = static_cast<int>(k);
              looks[map.index(i, r)] =
                  static_cast<std::uint8_t>(std::min(kNearLooks, looks[map.index(i, r)] + 1));
            }
          }
        }
        break;
      }
    }
  }
  for (std::size_t i = 0; i < views.sights.size(); ++i) {
    if (views.sights[i] == Sight::kHides && to_standing_m[i] > kDoubtful_m &&
        looks[i] < kNearLooks) {
      views.sights[i] = Sight::kDoubtful;
    }
  }
}

// Unknown floor in view for the time it takes. With a target the time counts until that is reached,
// and the floor only as far as it shows where the way goes on: as much as the robot covers shows
// half of it.
double Explorer::worth(const Views& views, int cell, double gain_m2, double cost_s) const {
  const DirectedOptions& o = views.o;
  if (views.to_target_m.empty()) {
    return gain_m2 / (cost_s + o.fixed_cost_s);
  }
  const double half_m2 = std::numbers::pi * body_.radius_m * body_.radius_m;
  const double to_target_s = views.to_target_m[static_cast<std::size_t>(cell)] / o.pace_mps;
  return gain_m2 / (gain_m2 + half_m2) / (cost_s + o.fixed_cost_s + to_target_s);
}

// The best heading to stand at in a cell.
std::optional<Explorer::View> Explorer::best_view(const Views& views, int cell,
                                                  std::optional<double> only_heading) const {
  const DirectedOptions& o = views.o;
  const OccupancyMap& map = views.grid.clearance.map;
  const std::size_t rays = views.rays.size();
  const int width = std::max(1, static_cast<int>(std::floor(wedge_.width_rad / kTwoPi * o.rays)));
  const Vec2 place = map.centre(cell % map.columns, cell / map.columns);
  std::vector<double> gains(rays);
  const double nearer_m = views.only_nearer ? views.to_target_m[static_cast<std::size_t>(cell)]
                                            : std::numeric_limits<double>::infinity();
  cast_rays(
      o.unknown_depth_m, map, views.sights, views.rays, cell,
      [&](std::size_t seen) { return !views.only_nearer || views.to_target_m[seen] < nearer_m; },
      gains);
  double all = 0;
  for (const double g : gains) {
    all += g;
  }
  if (all < views.least_m2) {
    return std::nullopt;
  }
  const std::vector<Vec2> path = path_to(views.grid, views.field, cell);
  const double drive_s = views.field.cost_m[cell] / o.pace_mps;
  double first_s = 0;
  double arrival_rad = views.T_map_body.theta_rad;
  if (path.size() > 1) {
    first_s = std::abs(wrap_angle(heading_of(path, false) - views.T_map_body.theta_rad)) /
              o.turn_pace_radps;
    arrival_rad = heading_of(path, true);
  }
  std::optional<View> found;
  double sum = 0;
  for (int k = 0; k < width; ++k) {
    sum += gains[static_cast<std::size_t>(k)];
  }
  for (std::size_t k = 0; k < rays; ++k) {
    const double heading =
        wrap_angle(kTwoPi * (static_cast<double>(k) + 0.5 * width) / static_cast<double>(rays));
    const bool tried =
        !only_heading || std::abs(wrap_angle(heading - *only_heading)) <= kTwoPi / o.rays;
    if (tried && sum >= views.least_m2) {
      const double turn_s = std::abs(wrap_angle(heading - arrival_rad)) / o.turn_pace_radps;
      const double cost_s = first_s + drive_s + turn_s;
      const double worth = this->worth(views, cell, sum, cost_s);
      if (!found || worth > found->worth) {
        found = View{{{place.x(), place.y(), heading}, true, sum, cost_s}, worth};
      }
    }
    sum += gains[(k + static_cast<std::size_t>(width)) % rays] - gains[k];
  }
  return found;
}

// Cells to look from: those that have as much unknown floor in range as is worth a look.
std::vector<Explorer::Place> Explorer::places_to_look_from(const Views& views,
                                                           bool& some_abandoned) const {
  const DrivableGrid& grid = views.grid;
  const OccupancyMap& map = grid.clearance.map;
  const WantedAbout wanted(map, views.sights, views.rays);
  const double wedge_m2 = 0.5 * wedge_.width_rad * wedge_.far_m * wedge_.far_m;
  const int stride = std::max(1, static_cast<int>(std::lround(views.o.spacing_m / map.cell_m)));
  std::vector<Place> places;
  for (int row = 0; row < map.rows; row += stride) {
    for (int column = 0; column < map.columns; column += stride) {
      const std::size_t cell = grid.clearance.index(column, row);
      if (!std::isfinite(views.field.cost_m[cell]) || grid.clearance_m[cell] < 0) {
        continue;
      }
      constexpr double kRounded = 1 + 1e-9;
      const double gain_m2 = kRounded * std::min(wedge_m2, wanted.at_most_m2(column, row));
      if (gain_m2 < views.least_m2) {
        continue;
      }
      if (given_up_.contains(map.centre(column, row))) {
        some_abandoned = true;
        continue;
      }
      const double to_target_m = views.to_target_m.empty() ? 0.0 : views.to_target_m[cell];
      if (std::isfinite(to_target_m)) {
        const int at = static_cast<int>(cell);
        const double drive_s = views.field.cost_m[cell] / views.o.pace_mps;
        places.push_back({at, views.field.cost_m[cell] + to_target_m,
                          kRounded * worth(views, at, gain_m2, drive_s)});
      }
    }
  }
  return places;
}

// The present goal, judged anew; empty where it cannot be reached any more.
std::optional<Explorer::View> Explorer::present_view(const Views& views) const {
  if (!goal_) {
    return std::nullopt;
  }
  const Pose2& pose_map = goal_->pose_map;
  const int column = views.grid.clearance.column(pose_map.position());
  const int row = views.grid.clearance.row(pose_map.position());
  if (!views.grid.drivable(column, row) || given_up_.contains(pose_map.position())) {
    return std::nullopt;
  }
  const std::size_t cell = views.grid.clearance.index(column, row);
  if (!std::isfinite(views.field.cost_m[cell])) {
    return std::nullopt;
  }
  if (!views.to_target_m.empty() && !std::isfinite(views.to_target_m[cell])) {
    return std::nullopt;
  }
  std::optional<View> kept = best_view(views, static_cast<int>(cell), pose_map.theta_rad);
  if (kept) {
    kept->goal.pose_map = pose_map;
  }
  return kept;
}

// Those places first that may be worth most: where no other can be worth more, that is the best. Of
// equals the nearest.
std::optional<Explorer::View> Explorer::best(const Views& views, bool& some_abandoned) const {
  std::vector<Place> places = places_to_look_from(views, some_abandoned);
  const auto nearer = [](const Place& a, const Place& b) {
    return std::pair(a.cost_m, a.cell) < std::pair(b.cost_m, b.cell);
  };
  std::sort(places.begin(), places.end(), [&](const Place& a, const Place& b) {
    return a.most_worth != b.most_worth ? a.most_worth > b.most_worth : nearer(a, b);
  });
  std::optional<View> best;
  const Place* from = nullptr;
  for (const Place& place : places) {
    if (best && place.most_worth < best->worth) {
      break;
    }
    const std::optional<View> found = best_view(views, place.cell, std::nullopt);
    if (found && (!best || found->worth > best->worth ||
                  (found->worth == best->worth && nearer(place, *from)))) {
      best = found;
      from = &place;
    }
  }
  return best;
}

ExploreChoice Explorer::choose_directed(const DirectedOptions& o, const DrivableGrid& grid,
                                        const Pose2& T_map_body,
                                        std::span<const Pose2> T_map_keyframes,
                                        const std::vector<Vec2>* standing_map,
                                        const std::optional<ExploreTarget>& target) {
  ExploreChoice out;
  Views views = this->views(o, grid, T_map_body, T_map_keyframes, standing_map);
  bool some_abandoned = false;
  if (target && !grid.clearance.map.cells.empty()) {
    look_for_way(views, *target);
    views.only_nearer = true;
  }
  std::optional<View> best = this->best(views, some_abandoned);
  if (!best && views.only_nearer) {
    views.only_nearer = false;
    best = this->best(views, some_abandoned);
  }
  if (!best) {
    out.reason = some_abandoned ? "only places given up are left to look from"
                                : "no unknown floor can be seen from anywhere reachable";
    return out;
  }
  out.frontier_reachable = true;
  // The present goal is kept while nothing is clearly better.
  if (const std::optional<View> kept = present_view(views);
      kept && best->worth <= o.hysteresis * kept->worth) {
    best = kept;
  }
  out.goal = best->goal;
  out.reason = fmt::format("{:.2f} m2 of unknown floor in view after {:.1f} s",
                           best->goal.information_gain_m2, best->goal.cost_s);
  return out;
}

ExploreChoice Explorer::choose_random(const RandomOptions& o, Time now, const DrivableGrid& grid,
                                      const Pose2& T_map_body,
                                      std::span<const Pose2> T_map_keyframes) {
  ExploreChoice out;
  out.frontier_reachable = true;  // a random goal knows of no frontier: it is never done
  const OccupancyMap& map = grid.clearance.map;
  const CostField field = flood(options_.search, grid, T_map_body.position());
  const Vec2 here = T_map_body.position();
  if (!area_ || (area_->p_map() - here).norm() > o.area_m) {
    area_.emplace(T_map_body, T_map_keyframes);
    area_since_ = now;
  }
  const auto reachable = [&](const Vec2& p) {
    const int column = grid.clearance.column(p);
    const int row = grid.clearance.row(p);
    return grid.drivable(column, row) &&
           std::isfinite(field.cost_m[grid.clearance.index(column, row)]) && !given_up_.contains(p);
  };
  if (goal_ && reachable(goal_->pose_map.position())) {
    out.goal = goal_;
    out.reason = "a random goal";
    return out;
  }
  // Too long here: from outside the square, up to the whole map.
  const bool farther = to_seconds(now - area_since_) > o.patience_s;
  if (farther) {
    area_since_ = now;
  }
  constexpr int kDraws = 200;
  for (int i = 0; i < kDraws; ++i) {
    Vec2 p;
    if (farther) {
      p = map.origin + map.cell_m * Vec2(rng_.uniform(0, map.columns), rng_.uniform(0, map.rows));
      if ((p - here).cwiseAbs().maxCoeff() <= 0.5 * o.window_m) {
        continue;
      }
    } else {
      p = here + Vec2(rng_.uniform(-0.5, 0.5), rng_.uniform(-0.5, 0.5)) * o.window_m;
    }
    if (reachable(p) && (p - here).norm() > body_.radius_m) {
      out.goal = ExploreGoal{
          {p.x(), p.y(), 0},
          false,
          0,
          field.cost_m[grid.clearance.index(grid.clearance.column(p), grid.clearance.row(p))]};
      out.reason = farther ? "a random goal away from here" : "a random goal";
      return out;
    }
  }
  out.reason = "no random goal can be reached";
  return out;
}

}  // namespace panoptes
