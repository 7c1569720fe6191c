// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_by_maps_verdict.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/calib/map_verdict.h"
#include "core/calib/rig_views.h"

namespace panoptes {
namespace {

constexpr double kMostReprojection_px = 0.8;
constexpr double kMostLeftOut = 0.15;  // as a share
// Maps are bent by a degree; what is falsely aligned is off by tens.
constexpr double kMostTurnOff_rad = deg_to_rad(3);
constexpr double kMostShiftOff = 0.2;  // of how far the first camera goes
// Where the rig file is not of another rig.
constexpr double kMostOff_rad = deg_to_rad(15);
constexpr double kMostSigmas = 4;

}  // namespace

Judged judge_rig_by_maps(const std::vector<MappedCamera>& cameras, const RigByMaps& found) {
  Judged judged;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Judged of_map = judge_map(cameras[c].map, found.maps[c], cameras[c].believed);
    for (const std::string& reason : of_map.reasons) {
      judged.doubt(Verdict::kPoor, cameras[c].name + ": its own map: " + reason);
    }
    if (found.apart[c] > kSameInstant) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: its pictures are taken {:.1f} ms beside those of {}, and this method "
                      "knows nothing of that: synchronise the cameras, stand still for each "
                      "picture, or use --method guided",
                      cameras[c].name, 1000 * to_seconds(found.apart[c]), cameras.front().name));
    }
  }
  for (const AlignedMaps::Rejected& rejected : found.aligned.rejected) {
    const bool is_false = found.alignments[rejected.alignment].is_found();
    judged.doubt(is_false ? Verdict::kPoor : Verdict::kGood, rejected.why);
  }
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    if (!found.seen_along[c]) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: nothing leads from its map to that of {}: how it is mounted stays as "
                      "the rig file has it; drive a motion that turns each camera to where the "
                      "others have looked, in a room with more to see",
                      cameras[c].name, cameras.front().name));
      continue;
    }
    const SeenAlong& along = *found.seen_along[c];
    if (along.turn_off_rad > kMostTurnOff_rad || along.shift_off > kMostShiftOff) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: does not keep its place beside {} by the alignment of their maps: it "
                      "wanders by {:.1f} degrees and {:.0f} % of the way, at most {:g} and "
                      "{:.0f}: the alignment is false",
                      cameras[c].name, cameras.front().name, rad_to_deg(along.turn_off_rad),
                      100 * along.shift_off, rad_to_deg(kMostTurnOff_rad), 100 * kMostShiftOff));
    }
    const Eigen::Quaterniond believed =
        cameras.front().believed.T_body_camera.rotation.conjugate() *
        cameras[c].believed.T_body_camera.rotation;
    const double off_rad = believed.angularDistance(found.state.T_body_camera[c].rotation);
    if (off_rad >
        std::max(kMostOff_rad, kMostSigmas * cameras[c].believed.sigma.rotation_rad.norm())) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("{}: is turned {:.0f} degrees off what the rig file says of it beside {}: "
                      "the file is of another rig, or alike places were taken for one another",
                      cameras[c].name, rad_to_deg(off_rad), cameras.front().name));
    }
  }
  if (!found.is_told()) {
    judged.doubt(Verdict::kFailed, "no camera is told beside another one");
    return judged;
  }
  for (const std::size_t i : found.aligned.doubtful) {
    const MapAlignment& alignment = found.alignments[i];
    judged.doubt(
        Verdict::kGood,
        fmt::format("{} and {}: {} points say how their maps lie, and no other maps confirm it",
                    found.cameras[alignment.a], found.cameras[alignment.b],
                    alignment.agreed.agree.size()));
  }
  if (!found.converged) {
    judged.doubt(Verdict::kPoor, "the adjustment of all cameras together did not converge");
  }
  if (found.rms_after_px > kMostReprojection_px) {
    judged.doubt(Verdict::kPoor,
                 fmt::format("the cameras do not agree: {:.2f} px of reprojection are "
                             "left, more than {:g}",
                             found.rms_after_px, kMostReprojection_px));
  }
  if (found.left_out > kMostLeftOut * (found.observations + found.left_out)) {
    judged.doubt(
        Verdict::kPoor,
        fmt::format("the cameras contradict one another: {} of {} observations are left out (at "
                    "most {:.0f} %)",
                    found.left_out, found.observations + found.left_out, 100 * kMostLeftOut));
  }
  return judged;
}

}  // namespace panoptes
