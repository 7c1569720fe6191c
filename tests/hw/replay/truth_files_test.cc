// SPDX-License-Identifier: BSD-3-Clause
#include "hw/replay/truth_files.h"

#include <regex>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/io/file.h"
#include "tests/hw/replay/scripted_robot.h"
#include "tests/support/scratch.h"

namespace panoptes::hw {
namespace {

namespace fs = std::filesystem;

class TruthFiles : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    ScriptedRobot robot(9);
    TruthWriter writer(folder_, *robot.truth());
    for (int i = 0; i < 9; ++i) {
      const Observation seen = robot.observe({});
      writer.add(seen.stamp, *robot.truth_since(writer.poses(), writer.contacts()));
      truths_.push_back(*robot.truth());
    }
  }

  std::string fault() const {
    try {
      RecordedTruth::read(folder_);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "none";
  }

  std::vector<Truth> truths_;
};

TEST_F(TruthFiles, GiveBackTheTruthOfEveryObservationBitForBit) {
  const auto read = RecordedTruth::read(folder_);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->observations(), truths_.size());
  for (std::size_t i = 0; i < truths_.size(); ++i) {
    SCOPED_TRACE(i);
    expect_same(read->after(i + 1), truths_[i]);
  }
  EXPECT_TRUE(read->after(0).poses.empty());
}

TEST_F(TruthFiles, OfBeforeTellNothingOfRigAndWheels) {
  const auto whole = RecordedTruth::read(folder_);
  EXPECT_EQ(whole->after(1).rig->cameras.at("front").clock_offset_s, 0.1 / 3);
  EXPECT_EQ(whole->after(1).wheels->base_m, 1.0 / 3);
  fs::remove(folder_ / "mav0/truth0/platform.yaml");
  const auto read = RecordedTruth::read(folder_);
  EXPECT_FALSE(read->after(1).rig.has_value());
  EXPECT_FALSE(read->after(1).wheels.has_value());
}

TEST_F(TruthFiles, MayBeMissing) {
  fs::remove_all(folder_ / "mav0/truth0");
  EXPECT_FALSE(RecordedTruth::read(folder_));
}

TEST_F(TruthFiles, PosesOfAnotherClockAreRefused) {  // else the last would be taken for all
  const fs::path file = folder_ / "mav0/truth0/poses.csv";
  const std::string rows = read_file(file);
  write_file(file, std::regex_replace(rows, std::regex("\n([0-9])"), "\n-9$1"));
  EXPECT_THAT(fault(), testing::EndsWith("/truth0/poses.csv:3: is of an instant before the "
                                         "observation it is of (" +
                                         (folder_ / "mav0/truth0/data.csv").string() +
                                         ":3); both must be by one clock"));
}

TEST_F(TruthFiles, FaultsAreToldWithTheirPlace) {
  const fs::path truth = folder_ / "mav0/truth0";
  const std::string seen = read_file(truth / "seen.csv");
  write_file(truth / "seen.csv", seen.substr(0, seen.find('\n') + 1) + "0,3,5,2\n");
  EXPECT_EQ(fault(), (truth / "seen.csv").string() +
                         ":2: lies outside of the layer that layers.yaml describes");
  write_file(truth / "seen.csv", seen);
  EXPECT_EQ(fault(), "none");
  const std::string poses = read_file(truth / "poses.csv");
  write_file(truth / "poses.csv",
             poses.substr(0, poses.find('\n') + 1) + "0,1e9,0,0,0,0,1,0,0,0\n");
  EXPECT_EQ(fault(),
            (truth / "poses.csv").string() + ":2: field 2 must be from -1e+06 to 1e+06, got 1e9");
  write_file(truth / "poses.csv", poses);
  const std::string layers = read_file(truth / "layers.yaml");
  write_file(truth / "layers.yaml",
             std::regex_replace(layers, std::regex("cell_m: [0-9.]+"), "cell_m: 0"));
  EXPECT_THAT(fault(), testing::HasSubstr("cell_m: must be at least 0.001 where there are cells"));
  write_file(truth / "layers.yaml", layers);
  write_file(truth / "body.png", "x");
  EXPECT_EQ(fault(), (truth / "body.png").string() +
                         ": must be a picture of 30 x 20 pixels, as layers.yaml says");
  fs::remove(truth / "body.png");
  EXPECT_EQ(fault(), (truth / "body.png").string() + ": is not there");
}

}  // namespace
}  // namespace panoptes::hw
