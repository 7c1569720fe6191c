// SPDX-License-Identifier: BSD-3-Clause
#include "apps/serve/served_run.h"

#include <nlohmann/json.hpp>

#include "apps/process/stage_clock.h"
#include "apps/report/recorder.h"
#include "apps/run/loop.h"
#include "core/base/utf8.h"
#include "core/eval/drive.h"
#include "core/io/file.h"

namespace panoptes {

ServedRun::ServedRun(const std::filesystem::path& folder, const ExploreMission& mission,
                     std::int64_t start_unix_ns, const Truth& first)
    : folder_(folder), info_(run_info("serve", mission)), files_(folder, start_unix_ns, first) {
  info_.start_unix_ns = start_unix_ns;
  known_.poses = first.poses;
  known_.contacts = first.contacts;
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

void ServedRun::write_metrics(const std::string& outcome, Time now,
                              const std::string& fault) const {
  nlohmann::ordered_json metrics{{"schema", "panoptes.metrics/1"}, {"command", info_.command},
                                 {"version", info_.version},       {"seed", info_.seed},
                                 {"mission", info_.mission},       {"outcome", outcome}};
  if (outcome == "completed") {
    metrics["end_reason"] = "duration";
  }
  if (!fault.empty()) {
    metrics["fault"] = as_utf8(fault);
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
