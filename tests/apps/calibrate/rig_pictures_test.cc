// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_pictures.h"

#include <cstddef>
#include <set>
#include <string>

#include <gmock/gmock.h>

#include "apps/calibrate/rig_picture.h"
#include "tests/support/calibrated_rig.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using ::testing::ElementsAre;

Rig believed(const CalibratedRig& rig) {
  Rig out;
  for (std::size_t c = 0; c < rig.calibration.cameras.size(); ++c) {
    out.cameras[rig.calibration.cameras[c]] = rig.driven.believed[c];
  }
  return out;
}

class RigPicturesTest : public ScratchTest {
 protected:
  std::set<std::string> drawn(const DrivenScene& scene) {
    CalibratedRig rig(scene);
    Faults faults;
    write_rig_pictures(
        folder_, rig.calibration, believed(rig), Verdict::kGood,
        [&rig](const RigView&) { return rig.blank(); }, faults);
    EXPECT_TRUE(faults.none()) << faults.text();
    std::set<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      files.insert(entry.path().filename().string());
    }
    return files;
  }
};

TEST_F(RigPicturesTest, ShowTheRigItsMatchesAndWhatAdjustmentMends) {
  EXPECT_THAT(drawn({}), ElementsAre("matches_ahead_behind.png", "reprojection_rig_ahead.png",
                                     "reprojection_rig_behind.png", "rig.png"));
}

TEST(RigPicture, GrowsWithItsLegend) {
  CalibratedRig rig({});
  const auto rows = [&rig] {
    return draw_rig(rig.calibration, believed(rig), Verdict::kGood).rows;
  };
  const int before = rows();
  rig.calibration.cameras = {"the_camera_on_the_mast_that_looks_ahead",
                             "the_camera_on_the_mast_that_looks_behind"};
  EXPECT_GT(rows(), before);
}

TEST_F(RigPicturesTest, HaveNoMatchesOfCamerasThatShareNothing) {
  DrivenScene scene;
  scene.shares = false;
  EXPECT_THAT(drawn(scene),
              ElementsAre("reprojection_rig_ahead.png", "reprojection_rig_behind.png", "rig.png"));
}

}  // namespace
}  // namespace panoptes
