// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/rig_scores.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/eval/statistics.h"
#include "core/plan/reaction.h"

namespace panoptes {
namespace {

constexpr int kHeadings = 72;  // of blind distances around
constexpr int kOpposite = PanoramaSight::kHeadings / 2;

/// How often the robot decides: with the slowest of the cameras that its floor is seen by.
double period_s(const RigSight& sight, CameraSet watching) {
  double slowest_s = 0;
  for (std::size_t i = 0; i < sight.cameras().size(); ++i) {
    const double rate_hz = sight.cameras()[i].camera().rate_hz;
    if ((watching & camera_bit(i)) != 0 && rate_hz > 0) {
      slowest_s = std::max(slowest_s, 1 / rate_hz);
    }
  }
  return slowest_s;
}

/// By what share it fell.
double lost(double before, double after) { return before > 0 ? 1 - after / before : 0.0; }

struct Seen {
  const RigSight& sight;
  CameraSet all = 0;
  CameraSet watching = 0;  // whose floor decides: with the role floor, else all
  bool mapped = false;     // and whether what they map, or see
  double reach_m = 0;

  std::optional<double> ahead_m(CameraSet cameras) const {
    return first_seen_m(sight, cameras & watching, mapped, 0, reach_m);
  }
};

void add_floor(const RigScoreOptions& options, const Seen& seen, const FloorSight& floor,
               RigScores& out) {
  const double radius_m = seen.sight.body().radius_m;
  const auto cells = std::count(floor.floor.begin(), floor.floor.end(), 1);
  out.floor_reach_m2 = static_cast<double>(cells) * floor.cell_m * floor.cell_m;
  out.floor_seen_m2 = area_m2(floor, floor.seen, seen.all);
  if (seen.mapped) {
    out.floor_mapped_m2 = area_m2(floor, floor.mapped, seen.all);
  }
  double from_m = 0;
  for (const double to_m : options.distances_m) {
    ScoresAt at;
    at.sampling = sampling_at(seen.sight, seen.watching, seen.mapped, to_m);
    at.ring_seen_share = ring_share(floor, floor.seen, seen.all, radius_m, from_m, to_m);
    if (seen.mapped) {
      at.ring_mapped_share = ring_share(floor, floor.mapped, seen.all, radius_m, from_m, to_m);
      at.smallest_obstacle_m = smallest_obstacle_m(seen.sight, to_m, options.obstacle_px);
    }
    out.at.push_back(at);
    from_m = to_m;
  }
}

void add_blindness(const RigScoreOptions& options, const Seen& seen, RigScores& out) {
  const Body& body = seen.sight.body();
  out.blind_ahead_m = seen.ahead_m(seen.all);
  out.blind_over_width_m =
      first_seen_over_width_m(seen.sight, seen.watching, seen.mapped, seen.reach_m);
  out.far_m = last_seen_m(seen.sight, seen.watching, seen.mapped, seen.reach_m);
  std::vector<double> around_m;
  int unseen = 0;
  for (int k = 0; k < kHeadings; ++k) {
    const double heading = 2 * std::numbers::pi * k / kHeadings;
    const auto first_m = first_seen_m(seen.sight, seen.all, false, heading, seen.reach_m);
    around_m.push_back(first_m.value_or(seen.reach_m - body.radius_m));
    unseen += first_m ? 0 : 1;
  }
  out.unseen_headings_share = static_cast<double>(unseen) / kHeadings;
  out.blind_around_median_m = quantile(around_m, 0.5);
  // What a picture just missed is in the next one, and is decided on within a period.
  out.reaction_s = options.latency_s + 2 * period_s(seen.sight, seen.watching);
  out.stopping_m = stopping_distance_m(body.max_speed_mps, out.reaction_s, body.max_accel_mps2);
  if (out.blind_ahead_m) {
    out.margin_m = out.stopping_m - *out.blind_ahead_m;
  }
  if (out.far_m) {
    out.safe_speed_mps = std::min(
        body.max_speed_mps, speed_that_stops_mps(*out.far_m, out.reaction_s, body.max_accel_mps2));
  }
  for (const double height_m : {0.0, body.hull_height_m, body.height_m}) {
    out.blind_spots.push_back(blind_spot(seen.sight, height_m, options.around_m, seen.reach_m));
  }
}

struct Known {
  FloorSight floor;
  PanoramaSight panorama;
  MotionInformation driving;
};

CameraLoss loss_without(std::size_t camera, const Seen& seen, const Known& known,
                        const RigScores& whole) {
  const CameraSet left = seen.all & ~camera_bit(camera);
  CameraLoss loss;
  loss.camera = seen.sight.names()[camera];
  loss.floor_seen = lost(whole.floor_seen_m2, area_m2(known.floor, known.floor.seen, left));
  if (whole.floor_mapped_m2) {
    loss.floor_mapped =
        lost(*whole.floor_mapped_m2, area_m2(known.floor, known.floor.mapped, left));
  }
  const CameraSet loop = left & seen.sight.loop_cameras();
  if (whole.panorama_share) {
    loss.panorama = lost(*whole.panorama_share, common_share(known.panorama, loop, 0));
    loss.opposite = lost(*whole.opposite_share, common_share(known.panorama, loop, kOpposite));
  }
  loss.blind_ahead_m = seen.ahead_m(left);
  const MotionSigma driving = motion_sigma(known.driving.of(left));
  if (driving.heading_rad && whole.driving.heading_rad) {
    loss.heading_sigma = *driving.heading_rad / *whole.driving.heading_rad;
  }
  return loss;
}

std::string cm(double length_m) { return fmt::format("{:.0f}cm", 100 * length_m); }

}  // namespace

double CameraLoss::worst() const {
  return std::max(
      {floor_seen, floor_mapped.value_or(0), panorama.value_or(0), opposite.value_or(0)});
}

void bind(Fields& f, RigScoreOptions& o) {
  f("reach_m", o.floor.reach_m, between(0.5, 20));
  f("cell_m", o.floor.cell_m, between(0.01, 0.5));
  f("distances_m", o.distances_m, between(0.01, 20));
  f.require(!o.distances_m.empty() && std::is_sorted(o.distances_m.begin(), o.distances_m.end()),
            "distances_m", "must be one or more, in ascending order");
  f("latency_s", o.latency_s, between(0, 5));
  f("obstacle_px", o.obstacle_px, between(1, 100));
  f("around_m", o.around_m, between(0.1, 20));
  f("room_m", o.motion.room_m, between(1, 100));
  f("features", o.motion.features, between(1, 10000));
  f("feature_sigma_px", o.motion.feature_sigma_px, between(0.01, 10));
  f.word("bus", o.bus.kind,
         {{std::string(name(BusKind::kFireWire800)), BusKind::kFireWire800},
          {std::string(name(BusKind::kFireWire400)), BusKind::kFireWire400},
          {std::string(name(BusKind::kGigabitEthernet)), BusKind::kGigabitEthernet}});
  f("fixed_modes", o.bus.fixed_modes);
  f("dma_contexts", o.bus.dma_contexts, between(1, 64));
  f("bits_per_px", o.bits_per_px, between(1, 48));
}

RigScores score_rig(const RigScoreOptions& options, const Rig& rig, const Body& body) {
  const RigSight sight(rig, body);
  RigScores out;
  out.cameras = sight.names();
  Seen seen{sight, 0, sight.floor_cameras(), sight.floor_cameras() != 0, options.floor.reach_m};
  for (std::size_t i = 0; i < sight.cameras().size(); ++i) {
    const CameraSight& camera = sight.cameras()[i];
    seen.all |= camera_bit(i);
    out.hull_share.push_back(camera.hull_share());
    const Intrinsics& lens = camera.camera().intrinsics;
    out.pixel_rate_mpx_per_s += 1e-6 * lens.width_px * lens.height_px * camera.camera().rate_hz;
  }
  seen.watching = seen.mapped ? seen.watching : seen.all;

  Known known{floor_sight(options.floor, sight), panorama_sight(sight),
              motion_information(options.motion, sight, {options.motion.drive_m, 0, 0})};
  add_floor(options, seen, known.floor, out);
  add_blindness(options, seen, out);
  out.overlap = overlap_sight(sight);
  if (sight.loop_cameras() != 0) {
    const CameraSet loop = sight.loop_cameras();
    out.panorama_share = common_share(known.panorama, loop, 0);
    out.opposite_share = common_share(known.panorama, loop, kOpposite);
    double sum = 0;
    for (int turned = 0; turned < PanoramaSight::kHeadings; ++turned) {
      sum += common_share(known.panorama, loop, turned);
    }
    out.any_heading_share = sum / PanoramaSight::kHeadings;
  }
  out.driving = motion_sigma(known.driving.of(seen.all));
  out.turning = motion_sigma(
      motion_information(options.motion, sight, {0, 0, options.motion.turn_rad}).of(seen.all));
  for (std::size_t i = 0; i < sight.cameras().size(); ++i) {
    out.losses.push_back(loss_without(i, seen, known, out));
  }
  out.bus = bus_load(options.bus, streams_of(rig, options.bits_per_px));
  out.table_mbit_per_s = pixel_mbit_per_s(streams_of(rig, 24));
  return out;
}

std::vector<NamedScore> named_scores(const RigScores& scores) {
  std::vector<NamedScore> all;
  const auto add = [&all](std::string key, std::string what, std::string unit, double scale,
                          int digits, Better better, std::optional<double> value) {
    all.push_back({std::move(key), std::move(what), std::move(unit), scale, digits, better, value});
  };
  using enum Better;
  constexpr double kPercent = 100;
  constexpr double kCentimetres = 100;
  constexpr double kMillimetres = 1000;
  const auto metres = [&](const char* key, const char* what, Better better,
                          std::optional<double> value) {
    add(key, what, "m", 1, 2, better, value);
  };
  const auto share = [&](std::string key, std::string what, Better better,
                         std::optional<double> value) {
    add(std::move(key), std::move(what), "%", kPercent, 1, better, value);
  };
  add("cameras", "cameras", "", 1, 0, kLower, static_cast<double>(scores.cameras.size()));
  add("pixel_rate_mpx_per_s", "pixels to work on", "Mpx/s", 1, 2, kLower,
      scores.pixel_rate_mpx_per_s);
  add("floor.seen_m2", "floor seen within reach", "m2", 1, 2, kHigher, scores.floor_seen_m2);
  share("floor.seen_share", "of all floor there", kHigher,
        scores.floor_seen_m2 / scores.floor_reach_m2);
  add("floor.mapped_m2", "floor mapped", "m2", 1, 2, kHigher, scores.floor_mapped_m2);
  for (std::size_t i = 0; i < scores.at.size(); ++i) {
    const ScoresAt& at = scores.at[i];
    const std::string to = cm(at.sampling.distance_m);
    const std::string from = i > 0 ? cm(scores.at[i - 1].sampling.distance_m) : "0cm";
    share("floor.seen_share_to_" + to, "floor seen, " + from + " to " + to + " from the body",
          kHigher, at.ring_seen_share);
    share("floor.mapped_share_to_" + to, "floor mapped, " + from + " to " + to, kHigher,
          at.ring_mapped_share);
  }
  for (const ScoresAt& at : scores.at) {
    const std::string to = cm(at.sampling.distance_m);
    add("sampling_m.median_at_" + to, "a pixel covers at " + to + ", median", "mm", kMillimetres, 1,
        kLower, at.sampling.median_m);
    add("sampling_m.worst_at_" + to, "a pixel covers at " + to + ", worst", "mm", kMillimetres, 1,
        kLower, at.sampling.worst_m);
  }
  for (const ScoresAt& at : scores.at) {
    const std::string to = cm(at.sampling.distance_m);
    add("obstacle_m.at_" + to, "smallest obstacle mapped at " + to, "cm", kCentimetres, 1, kLower,
        at.smallest_obstacle_m);
  }
  metres("blind.ahead_m", "blind ahead of the bumper", kLower, scores.blind_ahead_m);
  metres("blind.over_width_m", "blind ahead, over the body's width", kLower,
         scores.blind_over_width_m);
  metres("blind.around_median_m", "blind around the body, median", kLower,
         scores.blind_around_median_m);
  share("blind.unseen_headings_share", "headings without any floor seen", kLower,
        scores.unseen_headings_share);
  metres("sight.far_m", "floor ahead without a gap to", kHigher, scores.far_m);
  add("stopping.reaction_s", "reaction", "s", 1, 2, kLower, scores.reaction_s);
  metres("stopping.distance_m", "stopping distance at full speed", kLower, scores.stopping_m);
  metres("stopping.margin_m", "stopping distance less blind ahead", kHigher, scores.margin_m);
  add("stopping.safe_speed_mps", "speed that stops within sight", "m/s", 1, 2, kHigher,
      scores.safe_speed_mps);
  for (const BlindSpot& spot : scores.blind_spots) {
    share("blind_spot.share_at_" + cm(spot.height_m),
          "not seen around, " + cm(spot.height_m) + " above the floor", kLower, spot.share);
    metres(("blind_spot.ahead_m_at_" + cm(spot.height_m)).c_str(),
           ("blind ahead, " + cm(spot.height_m) + " above the floor").c_str(), kLower,
           spot.ahead_m);
  }
  share("overlap.seen_share", "of all directions seen", kHigher, scores.overlap.seen_share);
  share("overlap.twice_share", "of all directions seen by two cameras", kNeither,
        scores.overlap.twice_share);
  share("panorama.seen_share", "panorama seen for loops", kHigher, scores.panorama_share);
  share("panorama.opposite_share", "panorama in common with the opposite heading", kHigher,
        scores.opposite_share);
  share("panorama.any_heading_share", "panorama in common, mean of all headings", kHigher,
        scores.any_heading_share);
  const auto motion = [&](const std::string& of, const MotionSigma& sigma) {
    const auto degrees = [](std::optional<double> rad) {
      return rad ? std::optional(rad_to_deg(*rad)) : std::nullopt;
    };
    add("odometry." + of + ".ahead_m", of + ": sigma ahead", "mm", kMillimetres, 2, kLower,
        sigma.ahead_m);
    add("odometry." + of + ".aside_m", of + ": sigma aside", "mm", kMillimetres, 2, kLower,
        sigma.aside_m);
    add("odometry." + of + ".heading_deg", of + ": sigma of the heading", "deg", 1, 4, kLower,
        degrees(sigma.heading_rad));
  };
  motion("driving", scores.driving);
  motion("turning", scores.turning);
  const auto worst = [&scores](auto&& of) {
    double most = 0;
    for (const CameraLoss& loss : scores.losses) {
      most = std::max(most, of(loss));
    }
    return most;
  };
  share("loss.floor_seen", "floor seen lost with one camera", kLower,
        worst([](const CameraLoss& loss) { return loss.floor_seen; }));
  if (scores.floor_mapped_m2) {
    share("loss.floor_mapped", "floor mapped lost with one camera", kLower,
          worst([](const CameraLoss& loss) { return loss.floor_mapped.value_or(0); }));
  } else {
    share("loss.floor_mapped", "floor mapped lost with one camera", kLower, std::nullopt);
  }
  const auto of_panorama = [&](auto&& of) {
    return scores.panorama_share ? std::optional(worst(of)) : std::nullopt;
  };
  share("loss.panorama", "panorama lost with one camera", kLower,
        of_panorama([](const CameraLoss& loss) { return loss.panorama.value_or(0); }));
  share("loss.opposite", "opposite heading lost with one camera", kLower,
        of_panorama([](const CameraLoss& loss) { return loss.opposite.value_or(0); }));
  add("bus.table_3_1_mbit_per_s", "24-bit pixels as in Table 3.1 (800 fit)", "Mbit/s", 1, 1, kLower,
      scores.table_mbit_per_s);
  share("bus.load_share", "of what the bus carries", kLower, scores.bus.load / scores.bus.allowed);
  add("bus.fits", "the bus carries it (1 yes, 0 no)", "", 1, 0, kHigher, scores.bus.fits() ? 1 : 0);
  return all;
}

}  // namespace panoptes
