// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/file.h"

#include <csignal>
#include <string>

#include <gmock/gmock.h>
#include <sys/resource.h>

#include "core/base/error.h"
#include "core/config/data_files.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using File = ScratchTest;

TEST_F(File, IsThereOnlyWhenWhole) {
  const auto path = folder_ / "a.txt";
  {
    AtomicFile file(path);
    file.append("half");
    EXPECT_FALSE(std::filesystem::exists(path));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));  // left uncommitted: nothing stays
  write_file(path, "whole");
  EXPECT_EQ(read_file(path), "whole");
  write_file(path, "newer");
  EXPECT_EQ(read_file(path), "newer");
}

TEST_F(File, ThatCannotBeCreatedNamesPathAndReason) {
  const auto path = folder_ / "missing" / "a.txt";
  try {
    write_file(path, "x");
    FAIL() << "no error";
  } catch (const IoError& e) {
    EXPECT_EQ(e.what(), path.string() + ": cannot be created: No such file or directory");
  }
}

TEST_F(File, ThatCannotBeReadNamesPathAndReasonAndWasNamedByTheUser) {
  try {
    read_file(folder_ / "a.txt");
    FAIL() << "no error";
  } catch (const ConfigError& e) {
    EXPECT_EQ(e.what(),
              (folder_ / "a.txt").string() + ": cannot be opened: No such file or directory");
  }
  try {
    read_file(folder_);
    FAIL() << "no error";
  } catch (const ConfigError& e) {
    EXPECT_EQ(e.what(), folder_.string() + ": cannot be read: Is a directory");
  }
  EXPECT_THROW(read_file(resolve_path("data:worlds/nowhere.yaml", "")), IoError);
}

TEST_F(File, ThatFailedOnceSaysTheSameAgain) {
  std::filesystem::create_directories(folder_ / "a.txt" / "in the way");
  AtomicFile file(folder_ / "a.txt");
  file.append("x");
  const std::string told = (folder_ / "a.txt").string() + ": cannot be finished: Is a directory";
  for (int i = 0; i < 2; ++i) {
    try {
      file.commit();
      FAIL() << "no error";
    } catch (const IoError& e) {
      EXPECT_EQ(e.what(), told);
    }
  }
}

TEST_F(File, LeavesTheOldOneWhenTheDiskIsFull) {
  const auto path = folder_ / "a.txt";
  write_file(path, "old");
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit tiny{4096, before.rlim_max};  // a disk that takes no more than a page
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &tiny);
  std::string message;
  try {
    write_file(path, std::string(1U << 20, 'x'));
  } catch (const IoError& e) {
    message = e.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(message, path.string() + ": cannot be written: File too large");
  EXPECT_EQ(read_file(path), "old");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.txt.part"));
}

}  // namespace
}  // namespace panoptes
