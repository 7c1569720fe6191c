// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/served_run.h"

#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/run/loop.h"
#include "apps/run/stage_clock.h"
#include "core/eval/drive.h"
#include "core/io/digits.h"
#include "core/io/file.h"

namespace panoptes {

TruthFiles::TruthFiles(const std::filesystem::path& folder, const Truth& first)
    : poses_(folder / "ground_truth.tum"),
      contacts_(folder / "contacts.csv"),
      clearance_(folder / "clearance.csv") {
  contacts_.append("stamp_s,x_m,y_m,moving,object\n");
  clearance_.append("stamp_s,clearance_m\n");
  add(first);
}

void TruthFiles::add(const Truth& news) {
  std::string poses;
  std::string clearance;
  std::string contacts;
  for (const TruePose& pose : news.poses) {
    const Pose2& T = pose.T_scene_body;
    poses +=
        fmt::format("{} {} {} 0 0 0 {} {}\n", seconds(pose.stamp), shortest(T.x_m), shortest(T.y_m),
                    shortest(std::sin(T.theta_rad / 2)), shortest(std::cos(T.theta_rad / 2)));
    clearance += fmt::format("{},{}\n", seconds(pose.stamp), shortest(pose.clearance_m));
  }
  for (const TrueContact& contact : news.contacts) {
    contacts +=
        fmt::format("{},{},{},{},\"{}\"\n", seconds(contact.stamp), shortest(contact.p_scene.x()),
                    shortest(contact.p_scene.y()), contact.while_moving ? 1 : 0, contact.object);
  }
  if (!poses.empty()) {
    poses_.append(poses);
    clearance_.append(clearance);
  }
  if (!contacts.empty()) {
    contacts_.append(contacts);
  }
}

ServedRun::ServedRun(const std::filesystem::path& folder, const ExploreMission& mission,
                     const Truth& first)
    : folder_(folder), info_(run_info("serve", mission)), files_(folder, first) {
  info_.start_unix_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                            std::chrono::system_clock::now().time_since_epoch())
                            .count();
  write_file(folder_ / "mission.yaml", mission_text(info_.version, info_.mission_yaml));
  write_metrics("interrupted", Time());
}

void ServedRun::keep(const hw::Robot& robot) {
  const Truth news =
      robot.truth_since(known_.poses.size(), known_.contacts.size()).value_or(Truth());
  files_.add(news);
  known_.poses.insert(known_.poses.end(), news.poses.begin(), news.poses.end());
  known_.contacts.insert(known_.contacts.end(), news.contacts.begin(), news.contacts.end());
  known_.path_m = news.path_m;
}

void ServedRun::write_metrics(const std::string& outcome, Time now) const {
  nlohmann::ordered_json metrics{{"schema", "panoptes.metrics/1"}, {"command", info_.command},
                                 {"version", info_.version},       {"seed", info_.seed},
                                 {"mission", info_.mission},       {"outcome", outcome}};
  if (outcome == "completed") {
    metrics["end_reason"] = "duration";
  }
  metrics["start_unix_ns"] = *info_.start_unix_ns;
  metrics["requirements"] = nlohmann::ordered_json::array();
  metrics["run_s"] = to_seconds(now);
  metrics["distance_m"] = known_.path_m;
  metrics["collisions"] = collisions(known_);
  metrics["collisions_while_stopped"] = collisions_while_stopped(known_);
  if (const auto clearance_m = min_clearance_m(known_)) {
    metrics["min_clearance_m"] = *clearance_m;
  }
  const ProcessUse use = process_use();
  metrics["wall_s"] = use.wall_s;
  metrics["cpu_s"] = use.cpu_s;
  metrics["peak_memory_mb"] = use.peak_memory_mb;
  write_file(folder_ / "metrics.json", metrics.dump(2) + "\n");
}

}  // namespace panoptes
