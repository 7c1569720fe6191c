// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/by_maps_stage.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/rig_figures.h"
#include "apps/calibrate/rig_files.h"
#include "apps/calibrate/rig_pictures.h"
#include "apps/calibrate/stage_cameras.h"
#include "apps/process/fault.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/calib/rig_by_maps.h"
#include "core/calib/rig_by_maps_verdict.h"
#include "core/calib/rig_verdict.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double angle_deg(const Pose3& T) {
  return rad_to_deg(T.rotation.angularDistance(Eigen::Quaterniond::Identity()));
}

Pose3 relative(const Rig& rig, const std::string& reference, const std::string& camera) {
  return rig.cameras.at(reference).T_body_camera.inverse() * rig.cameras.at(camera).T_body_camera;
}

Json camera_figures(const Rig& found, const std::optional<Rig>& truth, const std::string& reference,
                    const std::string& camera) {
  const Pose3 T = relative(found, reference, camera);
  Json figures{{"T_reference_camera", pose_figures(T)}, {"rotation_deg", angle_deg(T)}};
  if (truth && truth->cameras.contains(reference) && truth->cameras.contains(camera)) {
    const Pose3 truly = relative(*truth, reference, camera);
    figures["true_rotation_deg"] = angle_deg(truly);
    add_errors(T, truly, figures);
  }
  return figures;
}

Json alignment_figures(const RigByMaps& told) {
  Json all = Json::array();
  for (std::size_t i = 0; i < told.alignments.size(); ++i) {
    const MapAlignment& alignment = told.alignments[i];
    all.push_back(
        {{"cameras", {as_utf8(told.cameras[alignment.a]), as_utf8(told.cameras[alignment.b])}},
         {"alike", alignment.alike.size()},
         {"agree", alignment.agreed.agree.size()},
         {"by_chance", alignment.agreed.by_chance},
         {"followed", static_cast<bool>(told.aligned.is_believed[i])}});
  }
  return all;
}

Json figures_of(const RigByMaps& told, const Rig& found, const std::optional<Rig>& truth) {
  const std::string& reference = told.cameras.front();
  Json figures{{"reference", as_utf8(reference)}, {"scale_source", "rig_file"}};
  for (std::size_t c = 0; c < told.cameras.size(); ++c) {
    Json camera = Json::object();
    if (c > 0 && told.seen_along[c]) {
      camera = camera_figures(found, truth, reference, told.cameras[c]);
      camera["wanders"] = {{"rotation_deg", rad_to_deg(told.seen_along[c]->turn_off_rad)},
                           {"share_of_way", told.seen_along[c]->shift_off}};
    }
    camera["shared_points"] = told.shared[c];
    camera["described_points"] = told.described[c];
    figures["cameras"][as_utf8(told.cameras[c])] = camera;
  }
  figures["reprojection_rms_px"] = {{"before", told.rms_before_px}, {"after", told.rms_after_px}};
  figures["observations"] = told.observations;
  figures["inter_map_matches"] = told.observations_other;
  figures["left_out"] = told.left_out;
  figures["keyframes"] = told.tracks.instants.size();
  figures["points"] = told.state.points_start.size();
  return figures;
}

/// As the pictures of a rig take it: the body is the first camera, and stands while one is taken.
RigCalibration to_draw(const RigByMaps& told) {
  RigCalibration drawn;
  drawn.cameras = told.cameras;
  drawn.map_of_point = told.map_of_point;
  drawn.tracks = told.tracks;
  drawn.before = told.before;
  drawn.bundle.state = told.state;
  drawn.shared = told.shared;
  drawn.wheels = [](Time) { return std::optional<Odometry>(Odometry()); };
  return drawn;
}

void say(const RigByMaps& told, const Judged& judged, const Json& figures) {
  std::printf(
      "%s: %s by their maps; %d observations in %s, %d of them of points of other "
      "cameras' maps; reprojection %.2f px\n",
      std::string(name(judged.verdict)).c_str(), counted(told.cameras.size(), "camera").c_str(),
      told.observations, counted(told.tracks.instants.size(), "keyframe").c_str(),
      told.observations_other, told.rms_after_px);
  for (std::size_t c = 1; c < told.cameras.size(); ++c) {
    const Json& camera = figures["cameras"][as_utf8(told.cameras[c])];
    if (!told.seen_along[c]) {
      continue;
    }
    std::printf("  %s: turned by %.2f degrees from %s", told.cameras[c].c_str(),
                camera["rotation_deg"].get<double>(), told.cameras.front().c_str());
    if (camera.contains("rotation_error_deg")) {
      std::printf(", truly by %.2f; off by %.3f deg, %.1f mm",
                  camera["true_rotation_deg"].get<double>(),
                  camera["rotation_error_deg"].get<double>(),
                  1000 * camera["translation_error_m"].get<double>());
    }
    std::printf("\n");
  }
  if (told.is_told()) {
    std::printf("  no metre: lengths are as the rig file has them\n");
  }
}

}  // namespace

int calibrate_rig_by_maps(const RigStage& args, const fs::path& out,
                          const std::vector<MappedCamera>& cameras, const FramePicture& picture,
                          const std::vector<std::string>& warnings, Json figures,
                          const std::function<void(double)>& progress) {
  RigByMapsOptions options = args.by_maps;
  options.features = args.slam.features;
  const RigByMaps told = calibrate_by_maps(options, cameras, picture,
                                           Rng(args.seed).fork("inter-map matches"), progress);
  Judged judged = judge_rig_by_maps(cameras, told);
  for (const std::string& warning : warnings) {
    judged.doubt(Verdict::kGood, warning);
  }
  Faults faults;
  figures["method"] = name(args.method);
  figures["alignments"] = alignment_figures(told);
  if (told.is_told()) {
    const Rig before = whole_rig(args.dataset, args.rig);
    const Rig found = believed_after(rig_by_maps(before, told), before, judged);
    figures.update(figures_of(told, found, true_rig(args.dataset)));
    faults.attempt([&] { write_rig(out, found, told.cameras, judged.verdict); });
    write_seen_pictures(out, to_draw(told), view_picture(cameras, picture), faults);
    say(told, judged, figures);
  } else {
    std::printf("failed: no rig is told\n");
  }
  for (const std::string& reason : judged.reasons) {
    std::printf("  %s\n", reason.c_str());
  }
  return write_judged(out, std::move(figures), judged, faults);
}

}  // namespace panoptes
