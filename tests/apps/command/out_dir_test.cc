// SPDX-License-Identifier: BSD-3-Clause
#include "apps/command/out_dir.h"

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

class OutDirTest : public ScratchTest {
 protected:
  std::string fault(const fs::path& path) const {
    try {
      OutDir out(path);
      out.keep();
      return "none";
    } catch (const ConfigError& error) {
      return error.what();
    }
  }
};

TEST_F(OutDirTest, IsMadeAndStaysOnceThereIsSomethingToKeep) {
  const fs::path path = folder_ / "new" / "run";
  {
    OutDir out(path);
    write_file(path / "a", "a");
    out.keep();
  }
  EXPECT_EQ(read_file(path / "a"), "a");
}

TEST_F(OutDirTest, LeavesNoTraceOfWhatWasRefused) {
  {
    const OutDir out(folder_ / "new" / "run" / "");
    fs::create_directories(folder_ / "new" / "run" / "mav0");
    write_file(folder_ / "new" / "run" / "mav0" / "a", "a");
  }
  EXPECT_FALSE(fs::exists(folder_ / "new"));
  fs::create_directories(folder_ / "there");
  {
    const OutDir out(folder_ / "there");
    write_file(folder_ / "there" / "a", "a");
  }
  EXPECT_TRUE(fs::is_empty(folder_ / "there"));  // it was the user's
}

TEST_F(OutDirTest, IsRefusedWhereSomethingElseIs) {
  write_file(folder_ / "note.txt", "mine");
  EXPECT_EQ(fault(folder_),
            folder_.string() + ": is not empty; remove it or name another folder with --out");
  EXPECT_EQ(fault(folder_ / "note.txt"),
            (folder_ / "note.txt").string() + ": is not a folder; name another with --out");
  EXPECT_THAT(fault(folder_ / "note.txt" / "run"), testing::HasSubstr("cannot be made: "));
  EXPECT_EQ(read_file(folder_ / "note.txt"), "mine");
}

TEST_F(OutDirTest, BelongsToOneCommandAtATime) {
  const fs::path path = folder_ / "run";
  {
    const OutDir out(path);
    EXPECT_EQ(fault(path), path.string() +
                               ": another panoptes is writing there; name another folder with "
                               "--out");
    EXPECT_TRUE(fs::is_empty(path));  // the lock leaves nothing in it
  }
  EXPECT_EQ(fault(path), "none");
}

}  // namespace
}  // namespace panoptes
