// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_pictures.h"

#include <algorithm>
#include <optional>

#include "apps/calibrate/match_picture.h"
#include "apps/calibrate/rig_picture.h"
#include "apps/calibrate/rig_reprojection_picture.h"
#include "apps/draw/pictures.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

constexpr std::size_t kKeyframesShown = 3;

}  // namespace

ViewPicture view_picture(const std::vector<MappedCamera>& cameras, const FramePicture& picture) {
  return [&cameras, &picture](const RigView& view) {
    const std::vector<MonoMap::Frame>& frames = cameras[view.camera].map.frames;
    const auto frame =
        std::lower_bound(frames.begin(), frames.end(), view.stamp,
                         [](const MonoMap::Frame& f, Time stamp) { return f.stamp < stamp; });
    return picture(view.camera, static_cast<std::size_t>(frame - frames.begin()));
  };
}

void write_seen_pictures(const std::filesystem::path& folder, const RigCalibration& calibration,
                         const ViewPicture& grey, Faults& faults) {
  const auto shown = [&](std::size_t view) { return grey(calibration.tracks.views[view]); };
  const auto write = [&](const std::string& file, const std::function<cv::Mat()>& draw) {
    faults.attempt([&] { write_file(folder / file, png(draw())); });
  };
  for (std::size_t a = 0; a < calibration.cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < calibration.cameras.size(); ++b) {
      if (const std::optional<MatchedViews> views = best_matched_views(calibration, a, b)) {
        write("matches_" + calibration.cameras[a] + "_" + calibration.cameras[b] + ".png", [&] {
          return draw_matches(calibration, *views, shown(views->first), shown(views->second));
        });
      }
    }
  }
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const std::vector<std::size_t> views = telling_views(calibration, c, kKeyframesShown);
    if (views.empty()) {
      continue;
    }
    write("reprojection_rig_" + calibration.cameras[c] + ".png", [&] {
      std::vector<ShownView> pictures;
      for (const std::size_t view : views) {
        pictures.push_back({view, shown(view)});
      }
      return draw_rig_reprojection(calibration, calibration.wheels, c, pictures);
    });
  }
}

void write_rig_pictures(const std::filesystem::path& folder, const RigCalibration& calibration,
                        const Rig& believed, Verdict verdict, const ViewPicture& grey,
                        Faults& faults) {
  faults.attempt(
      [&] { write_file(folder / "rig.png", png(draw_rig(calibration, believed, verdict))); });
  write_seen_pictures(folder, calibration, grey, faults);
}

}  // namespace panoptes
