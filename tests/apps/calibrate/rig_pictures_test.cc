// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_pictures.h"

#include <set>
#include <string>

#include <gmock/gmock.h>

#include "tests/support/calibrated_rig.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using ::testing::ElementsAre;

class RigPicturesTest : public ScratchTest {
 protected:
  std::set<std::string> drawn(const DrivenScene& scene) {
    CalibratedRig rig(scene);
    Rig believed;
    for (std::size_t c = 0; c < rig.calibration.cameras.size(); ++c) {
      believed.cameras[rig.calibration.cameras[c]] = rig.driven.believed[c];
    }
    Faults faults;
    write_rig_pictures(
        folder_, rig.calibration, believed, Verdict::kGood,
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

TEST_F(RigPicturesTest, HaveNoMatchesOfCamerasThatShareNothing) {
  DrivenScene scene;
  scene.shares = false;
  EXPECT_THAT(drawn(scene),
              ElementsAre("reprojection_rig_ahead.png", "reprojection_rig_behind.png", "rig.png"));
}

}  // namespace
}  // namespace panoptes
