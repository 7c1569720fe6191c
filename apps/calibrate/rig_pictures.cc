// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_pictures.h"

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

void write_rig_pictures(const std::filesystem::path& folder, const RigPictures& pictures,
                        Faults& faults) {
  const RigCalibration& calibration = pictures.calibration;
  const auto grey = [&pictures](std::size_t view) {
    return pictures.grey(pictures.calibration.tracks.views[view]);
  };
  const auto write = [&](const std::string& file, const std::function<cv::Mat()>& draw) {
    faults.attempt([&] { write_file(folder / file, png(draw())); });
  };
  write("rig.png", [&] { return draw_rig(calibration, pictures.believed); });
  for (std::size_t a = 0; a < calibration.cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < calibration.cameras.size(); ++b) {
      if (const std::optional<MatchedViews> views = best_matched_views(calibration, a, b)) {
        write("matches_" + calibration.cameras[a] + "_" + calibration.cameras[b] + ".png", [&] {
          return draw_matches(calibration, *views, grey(views->first), grey(views->second));
        });
      }
    }
  }
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    write("reprojection_rig_" + calibration.cameras[c] + ".png", [&] {
      std::vector<ShownView> shown;
      for (const std::size_t view : telling_views(calibration, c, kKeyframesShown)) {
        shown.push_back({view, grey(view)});
      }
      return draw_rig_reprojection(calibration, pictures.calibration.wheels, c, shown);
    });
  }
}

}  // namespace panoptes
