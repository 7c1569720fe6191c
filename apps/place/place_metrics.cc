// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/place_metrics.h"

#include <nlohmann/json.hpp>

#include "apps/process/stage_clock.h"
#include "core/base/utf8.h"
#include "core/geometry/pose2.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

/// `a.b` within `a`.
void put(Json& into, const std::string& key, double value) {
  const std::size_t dot = key.find('.');
  if (dot == std::string::npos) {
    into[key] = value;
  } else {
    put(into[key.substr(0, dot)], key.substr(dot + 1), value);
  }
}

Json cameras_of(const PlacedRig& placed) {
  Json cameras = Json::object();
  for (std::size_t i = 0; i < placed.scores.cameras.size(); ++i) {
    const CameraLoss& loss = placed.scores.losses[i];
    Json lost{{"floor_seen", loss.floor_seen}};
    const auto add = [&lost](const char* key, const std::optional<double>& value) {
      if (value) {
        lost[key] = *value;
      }
    };
    add("floor_mapped", loss.floor_mapped);
    add("panorama", loss.panorama);
    add("opposite", loss.opposite);
    add("blind_ahead_m", loss.blind_ahead_m);
    add("heading_sigma_ratio", loss.heading_sigma);
    Json camera{{"hull_share", placed.scores.hull_share[i]}, {"without", lost}};
    if (placed.calibratability) {
      const CameraCalibratability& known = placed.calibratability->cameras[i];
      camera["calibratability"] = {{"rotation_deg", rad_to_deg(known.rotation_rad)},
                                   {"position_m", known.position_m},
                                   {"unobservable", known.unobservable}};
    }
    cameras[placed.scores.cameras[i]] = camera;
  }
  return cameras;
}

Json figures_of(const PlacedRig& placed) {
  Json scores = Json::object();
  for (const NamedScore& score : named_scores(placed.scores)) {
    if (score.value) {
      put(scores, score.key, *score.value);
    }
  }
  if (placed.calibratability) {
    scores["calibratability"] = {{"rotation_deg", rad_to_deg(placed.calibratability->rotation_rad)},
                                 {"position_m", placed.calibratability->position_m}};
  }
  Json sensitivity;
  if (placed.sensitivity) {
    const RigSensitivityOptions& off = placed.sensitivity->off;
    sensitivity = {{"rotation_deg", rad_to_deg(off.rotation_rad)},
                   {"position_m", off.position_m},
                   {"draws", off.draws}};
    const std::vector<NamedScore> named = named_scores(placed.scores);
    for (std::size_t i = 0; i < named.size(); ++i) {
      if (const auto& spread = placed.sensitivity->spreads[i]) {
        put(sensitivity["low"], named[i].key, spread->low);
        put(sensitivity["high"], named[i].key, spread->high);
      }
    }
  }
  Json overlaps = Json::array();
  for (const CameraOverlap& overlap : placed.scores.overlap.overlaps) {
    overlaps.push_back(
        {{"cameras", {placed.scores.cameras[overlap.a], placed.scores.cameras[overlap.b]}},
         {"share", overlap.share}});
  }
  const BusLoad& bus = placed.scores.bus;
  Json figures{{"rig", as_utf8(placed.name)},
               {"scores", scores},
               {"cameras", cameras_of(placed)},
               {"overlaps", overlaps},
               {"bus",
                {{"load", bus.load},
                 {"allowed", bus.allowed},
                 {"unit", bus.unit},
                 {"fits", bus.fits()},
                 {"faults", bus.faults}}}};
  if (!sensitivity.is_null()) {
    figures["sensitivity"] = sensitivity;
  }
  return figures;
}

}  // namespace

std::string place_metrics(const std::vector<PlacedRig>& rigs, const PlaceOptions& options,
                          const std::string& version) {
  Json placed = Json::array();
  for (const PlacedRig& rig : rigs) {
    placed.push_back(figures_of(rig));
  }
  const ProcessUse use = process_use();
  const Json metrics{{"schema", "panoptes.metrics/1"},
                     {"command", "place"},
                     {"version", version},
                     {"outcome", "completed"},
                     {"robot",
                      {{"radius_m", options.robot.radius_m},
                       {"height_m", options.robot.height_m},
                       {"hull_height_m", options.robot.hull_height_m},
                       {"max_speed_mps", options.robot.max_speed_mps},
                       {"max_accel_mps2", options.robot.max_accel_mps2}}},
                     {"rigs", placed},
                     {"wall_s", use.wall_s},
                     {"cpu_s", use.cpu_s},
                     {"peak_memory_mb", use.peak_memory_mb}};
  return metrics.dump(2) + "\n";
}

}  // namespace panoptes
