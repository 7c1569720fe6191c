// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "apps/study/study.h"
#include "core/config/fields.h"
#include "core/eval/rig_scores.h"
#include "core/geometry/body.h"

namespace panoptes {

/// One way that a rig can be built: settings of it, and what that costs.
struct PlacementChoice {
  StudySettings settings;
  double price = 0;  ///< in whatever money the study counts
};
/// {set, price}
void bind(Fields& f, PlacementChoice& o);

/// Something about a rig that is tried in several ways: settings of the rig with `{}` where the
/// value stands, and the values, one after another or from a range; or choices by name, each with
/// settings of its own (a lens, one camera more, another role).
struct PlacementParameter {
  StudySettings set;
  std::vector<std::string> values;
  std::vector<std::string> value_places;
  std::optional<Vec2> range;
  double step = 0;  ///< of the range, on a grid
  std::map<std::string, PlacementChoice> choices;
};
void bind(Fields& f, PlacementParameter& o);

/// Every value with every other.
struct GridSweep {
  static constexpr std::string_view kName = "grid";
};
void bind(Fields& f, GridSweep& o);

/// Values drawn evenly, each by itself.
struct RandomSweep {
  static constexpr std::string_view kName = "random";
  int rigs = 1000;
  std::uint64_t seed = 1;
};
void bind(Fields& f, RandomSweep& o);

/// A search for the Pareto set of the objectives: NSGA-II (Deb et al. 2002), which breeds rigs from
/// those that did best, a generation after another. It costs a chosen number of rigs, however many
/// ways there are.
struct Nsga2Sweep {
  static constexpr std::string_view kName = "nsga2";
  int rigs = 2000;      ///< at most; one that was tried before costs nothing
  int population = 40;  ///< of a generation; a multiple of 4
  std::uint64_t seed = 1;
};
void bind(Fields& f, Nsga2Sweep& o);

/// How the best rigs are driven, to see what they do to navigation: a study of runs.
struct PlacementDrives {
  std::string against;  ///< file of its first rig; empty: that of the placement study
  std::vector<StudyMission> missions;
  StudySettings settings;  ///< of every run
  int best = 3;            ///< rigs, beside that one
  std::vector<StudyRung>
      rungs;  ///< what else they are tried under; none: as calibrating leaves them
  std::vector<std::string> against_first;
  std::vector<std::string> against_first_places;
  /// By which they are ranked, as those of a study.
  std::vector<StudyScore> scores{{{}, "map.coverage"}, {"checkpoints.error_mean_m", {}}};
  std::optional<StudyHalving> halving;
};
void bind(Fields& f, PlacementDrives& o);

/// Where cameras may go: a rig to begin with, what is varied about it, what is good enough, and
/// what is to be as good as can be.
struct PlacementStudy {
  std::string file;
  std::string rig;  ///< its file
  Body robot;
  RigScoreOptions scores;
  std::map<std::string, PlacementParameter> parameters;
  std::optional<double> camera_price;  ///< of each camera that a rig has
  std::variant<GridSweep, RandomSweep, Nsga2Sweep> sweep;
  std::vector<std::string> require;  ///< lines about scores
  std::vector<std::string> require_places;
  std::vector<std::string> objectives{"floor.mapped_m2", "blind.ahead_m"};  ///< scores
  std::vector<std::string> objective_places;
  std::optional<PlacementDrives> drive;
};
void bind(Fields& f, PlacementStudy& o);

/// Throws ConfigError with every fault of the file. Whether rigs can be made of its settings, and
/// its scores are known, is for whoever scores them to say.
PlacementStudy read_placement_study(const std::string& file);

/// One rig that is to be tried.
struct PlacementPoint {
  std::vector<std::string> values;  ///< of the parameters, in order of their names
  StudySettings settings;           ///< of the rig
  double price = 0;                 ///< of what was chosen, without cameras
};

/// Whether anything is said of what a rig costs: its score `price`.
bool has_prices(const PlacementStudy& study);

inline constexpr std::size_t kMostPlacementPoints = 200'000;

/// A parameter as a number: any in its range, or a whole one that counts its values.
struct PlacementAxis {
  double low = 0;
  double high = 0;
  bool is_whole = true;
};
/// Of each parameter, in order of their names.
std::vector<PlacementAxis> axes_of(const PlacementStudy& study);

/// The rig where each parameter is at a number of its axis.
PlacementPoint point_at(const PlacementStudy& study, const std::vector<double>& numbers);

/// All rigs of a grid or of those that are drawn, in an order that is always the same. Throws
/// ConfigError where they are more than kMostPlacementPoints. What a search tries, only the search
/// knows.
std::vector<PlacementPoint> points_of(const PlacementStudy& study);

}  // namespace panoptes
