// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_files.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/stage_metrics.h"
#include "core/config/fields.h"
#include "core/io/file.h"
#include "core/io/rig_export.h"
#include "hw/replay/truth_files.h"

namespace panoptes {

std::optional<Rig> true_rig(const std::filesystem::path& dataset) {
  const std::optional<hw::RecordedTruth> recorded = hw::RecordedTruth::read(dataset);
  if (!recorded || recorded->observations() == 0) {
    return std::nullopt;
  }
  return recorded->after(recorded->observations()).rig;
}

void write_rig(const std::filesystem::path& out, const Rig& rig,
               const std::vector<std::string>& cameras, Verdict verdict) {
  const std::string by =
      fmt::format("# panoptes {}, calibrate: {}\n", PANOPTES_VERSION, name(verdict));
  write_file(out / "rig_calibrated.yaml", by + write_settings(rig));
  write_file(out / "camchain.yaml", by + kalibr_camchain(rig, cameras));
  write_file(out / "rig.urdf", urdf_of(rig, cameras));
  std::filesystem::create_directory(out / "camera_info");
  for (const std::string& camera : cameras) {
    write_file(out / "camera_info" / (camera + ".yaml"),
               ros_camera_info(camera, rig.cameras.at(camera).intrinsics));
  }
}

int write_judged(const std::filesystem::path& out, nlohmann::ordered_json figures,
                 const Judged& judged, Faults& faults) {
  figures["verdict"] = name(judged.verdict);
  figures["warnings"] = judged.reasons;
  if (judged.verdict == Verdict::kFailed || !faults.none()) {
    figures["outcome"] = "failed";
  }
  write_metrics(out, std::move(figures), faults);
  return !faults.none() ? faults.status() : judged.verdict == Verdict::kFailed ? 1 : 0;
}

}  // namespace panoptes
