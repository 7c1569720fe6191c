// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/data_files.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

const std::string kSource = PANOPTES_SOURCE_DIR;

TEST(DataFiles, AreFoundInTheSourceTree) {
  EXPECT_EQ(data_root(), kSource);
  EXPECT_EQ(resolve_path("data:worlds/office.yaml", "anywhere/mission.yaml"),
            kSource + "/scenes/worlds/office.yaml");
}

TEST(DataFiles, LieBesideTheFileThatMentionsThem) {
  EXPECT_EQ(resolve_path("../rigs/a.yaml", "scenes/missions/m.yaml"), "scenes/rigs/a.yaml");
  EXPECT_EQ(resolve_path("/tmp/a.yaml", "scenes/missions/m.yaml"), "/tmp/a.yaml");
  EXPECT_EQ(resolve_path("a.yaml", ""), "a.yaml");
}

TEST(DataFiles, AreWrittenByAPortableName) {
  EXPECT_EQ(portable_path(kSource + "/scenes/missions/../README.md"), "data:README.md");
  EXPECT_EQ(portable_path(kSource + "/README.md"), kSource + "/README.md");
  EXPECT_EQ(portable_path("/nowhere/office.yaml"), "/nowhere/office.yaml");
}

}  // namespace
}  // namespace panoptes
