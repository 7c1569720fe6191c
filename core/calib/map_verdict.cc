// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/map_verdict.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace panoptes {
namespace {

constexpr std::size_t kFewestPoints = 20;
constexpr double kMostReprojection_px = 0.8;
constexpr double kMostLeftOut = 0.15;  // as a share: some are always seen wrong
constexpr double kMostSigmas = 3;      // of a lens, from what is known of it

std::string lost_in_words(const MonoMap& map) {
  const std::vector<LostSpan> spans = lost_spans(map);
  if (map.frames.back().lost) {
    return fmt::format("it is lost at the end, from {:.1f} s on; {:.1f} s in all",
                       spans.back().from_s, map.lost_s);
  }
  const LostSpan& longest = *std::max_element(
      spans.begin(), spans.end(),
      [](const LostSpan& a, const LostSpan& b) { return a.to_s - a.from_s < b.to_s - b.from_s; });
  const std::string when = fmt::format("from {:.1f} to {:.1f} s", longest.from_s, longest.to_s);
  return spans.size() == 1 ? fmt::format("it was lost for {:.1f} s: {}", map.lost_s, when)
                           : fmt::format("it was lost for {:.1f} s, {} times, longest {}",
                                         map.lost_s, spans.size(), when);
}

}  // namespace

Judged judge_map(const MonoMap& map, const AdjustedMap& adjusted, const RigCamera& believed) {
  Judged judged;
  if (map.points.size() < kFewestPoints) {
    judged.doubt(
        Verdict::kFailed,
        fmt::format(
            "only {} points are mapped, fewer than {}: there is too little to see, the camera "
            "never moves from its place, or pictures come too rarely to follow what they "
            "show",
            map.points.size(), kFewestPoints));
  }
  if (!map.frames.empty() && map.frames.back().lost) {
    judged.doubt(Verdict::kFailed, lost_in_words(map));
  } else if (map.lost_s > 0) {
    judged.doubt(Verdict::kPoor, lost_in_words(map));
  }
  if (!adjusted.T_map_camera.empty()) {
    const int seen = adjusted.observations + adjusted.left_out;
    if (adjusted.left_out > kMostLeftOut * seen) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("its keyframes contradict one another: {} of {} observations are left out",
                      adjusted.left_out, seen));
    }
    if (!adjusted.converged) {
      judged.doubt(Verdict::kPoor, "the adjustment of its keyframes did not converge");
    }
    if (adjusted.rms_after_px > kMostReprojection_px) {
      judged.doubt(Verdict::kPoor,
                   fmt::format("its keyframes do not agree: {:.2f} px of reprojection are "
                               "left, more than {:g}",
                               adjusted.rms_after_px, kMostReprojection_px));
    }
    // The noise of places is learned from the run, so that a wrong lens shows here alone.
    const Intrinsics& lens = believed.intrinsics;
    const double focal_off = adjusted.lens.fx_px / lens.fx_px - 1;
    const double centre_off_px = std::max(std::abs(adjusted.lens.cx_px - lens.cx_px),
                                          std::abs(adjusted.lens.cy_px - lens.cy_px));
    if (std::abs(focal_off) > kMostSigmas * believed.sigma.focal_ratio ||
        centre_off_px > kMostSigmas * believed.sigma.centre_px) {
      judged.doubt(
          Verdict::kPoor,
          fmt::format("the pictures are of another lens: focal length {:+.2f} %, centre off by "
                      "{:.1f} px; calibrate it by a board, or say in the rig how badly it is "
                      "known",
                      100 * focal_off, centre_off_px));
    }
  }
  if (adjusted.T_map_camera.empty() && map.points.size() >= kFewestPoints) {
    judged.doubt(Verdict::kFailed, "no keyframes hold together: nothing is adjusted");
  }
  if (!map.start_is_known && !map.closed && map.points.size() >= kFewestPoints) {
    judged.doubt(
        Verdict::kPoor,
        "its first pictures did not tell how far things are: its beginning may be bent; begin "
        "with a drive past things near and far, or use --odometry");
  }
  if (!map.closed && map.points.size() >= kFewestPoints) {
    judged.doubt(
        Verdict::kPoor,
        "it never saw again, after a whole turn, what it saw before: drive one that turns by more "
        "than 360 degrees");
  }
  return judged;
}

}  // namespace panoptes
