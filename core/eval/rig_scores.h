// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/eval/bus_load.h"
#include "core/eval/floor_sight.h"
#include "core/eval/motion_information.h"
#include "core/eval/panorama.h"

namespace panoptes {

struct RigScoreOptions {
  FloorSightOptions floor;
  std::vector<double> distances_m{0.5, 1, 2, 3};  ///< from the body's edge
  /// From the instant of a picture until the wheels do what was decided on it, without the decision
  /// and without waiting for the next picture, a period each.
  double latency_s = 0.05;
  double obstacle_px = 3;  ///< that the smallest obstacle covers each way
  double around_m = 2;     ///< how far from the body's edge blind spots count
  MotionInformationOptions motion;
  BusOptions bus;
  int bits_per_px = 8;  ///< on the bus: raw, from which colours are made on the host
};
/// {reach_m, cell_m, distances_m, latency_s, obstacle_px, around_m, features, feature_sigma_px,
/// room_m, bus, fixed_modes, dma_contexts, bits_per_px}
void bind(Fields& f, RigScoreOptions& o);

/// What is left without one of the cameras, against what there was.
struct CameraLoss {
  std::string camera;
  double floor_seen = 0;  ///< shares lost, from 0 to 1
  std::optional<double> floor_mapped;
  std::optional<double> panorama;
  std::optional<double> opposite;       ///< of what a heading and the opposite one have in common
  std::optional<double> blind_ahead_m;  ///< what it is then; empty where nothing is seen ahead
  std::optional<double> heading_sigma;  ///< by what the sigma of a driven heading grows: 1 is none;
                                        ///< empty where it is not seen any more
  /// The largest of the shares.
  double worst() const;
};

/// At one distance from the body's edge.
struct ScoresAt {
  SamplingAt sampling;         ///< where floor is mapped; of a rig that maps none, where seen
  double ring_seen_share = 0;  ///< of the floor from the distance before up to this one
  std::optional<double> ring_mapped_share;
  std::optional<double> smallest_obstacle_m;
};

/// What a rig can do for a robot, by geometry alone: nothing is rendered, and nothing driven. What
/// a rig has no camera for is empty.
struct RigScores {
  std::vector<std::string> cameras;
  std::vector<double> hull_share;  ///< of each camera's picture, what shows the robot itself
  double pixel_rate_mpx_per_s = 0;

  double floor_reach_m2 = 0;  ///< all there is within reach
  double floor_seen_m2 = 0;
  std::optional<double> floor_mapped_m2;
  std::vector<ScoresAt> at;

  std::optional<double> blind_ahead_m;       ///< mapped; of a rig that maps nothing, seen
  std::optional<double> blind_over_width_m;  ///< likewise, over the body's width
  double blind_around_median_m = 0;  ///< to what is seen, all around; reach where nothing is
  double unseen_headings_share = 0;  ///< where nothing within reach is seen
  std::optional<double> far_m;       ///< to where floor ahead is mapped (seen) without a gap
  double reaction_s = 0;
  double stopping_m = 0;                 ///< at full speed
  std::optional<double> margin_m;        ///< stopping_m less blind_ahead_m
  std::optional<double> safe_speed_mps;  ///< that stops within far_m, full speed at most
  std::vector<BlindSpot> blind_spots;    ///< floor, top of the hull, top of the mast

  OverlapSight overlap;
  std::optional<double> panorama_share;     ///< seen by the loop cameras
  std::optional<double> opposite_share;     ///< in common with the opposite heading
  std::optional<double> any_heading_share;  ///< in common, mean over all headings
  MotionSigma driving;                      ///< how well pictures tell a short drive,
  MotionSigma turning;                      ///< and a turn on the spot
  std::vector<CameraLoss> losses;           ///< one camera dead each
  BusLoad bus;
  double table_mbit_per_s = 0;  ///< as Table 3.1 of the thesis has it: 24 bits a pixel
};

/// In milliseconds. The rig must have no placement_faults.
RigScores score_rig(const RigScoreOptions& options, const Rig& rig, const Body& body);

enum class Better { kHigher, kLower, kNeither };

/// One score by its dotted name, as metrics.json and studies have it.
struct NamedScore {
  std::string key;
  std::string what;  ///< in words
  std::string unit;  ///< of `value` as it is shown: `scale` of the key's unit
  double scale = 1;
  int digits = 2;
  Better better = Better::kNeither;
  std::optional<double> value;  ///< in the key's unit; empty where the rig has no such thing
};

/// All of them that are one number, always the same ones in the same order for the same options.
std::vector<NamedScore> named_scores(const RigScores& scores);

}  // namespace panoptes
