// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/csv.h"

#include <gmock/gmock.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using Csv = ScratchTest;
using testing::ElementsAre;

TEST_F(Csv, ReadsBackWhatItWrote) {
  const auto path = folder_ / "t.csv";
  CsvWriter csv(path, {"stamp_s", "x_m", "n", "why"});
  csv << time_at(0.1) << 0.1 << 3 << "a, \"b\"\nc";
  csv.end_row();
  csv << time_at(2) << -1e-9 << -1;
  csv.skip();
  csv.end_row();
  EXPECT_FALSE(std::filesystem::exists(path));
  csv.finish();
  EXPECT_EQ(read_file(path), "stamp_s,x_m,n,why\n0.1,0.1,3,\"a, \"\"b\"\"\nc\"\n2,-1e-09,-1,\n");
  const CsvTable table = read_csv(path);
  EXPECT_THAT(table.columns, ElementsAre("stamp_s", "x_m", "n", "why"));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_THAT(table.rows[0], ElementsAre("0.1", "0.1", "3", "a, \"b\"\nc"));
  EXPECT_THAT(table.rows[1], ElementsAre("2", "-1e-09", "-1", ""));
  EXPECT_EQ(table.column("n"), 2U);
  EXPECT_THROW(table.column("m"), IoError);
}

TEST_F(Csv, RefusesARowOfTheWrongLength) {
  CsvWriter csv(folder_ / "t.csv", {"a", "b"});
  csv << 1;
  EXPECT_THROW(csv.end_row(), CheckError);
  write_file(folder_ / "bad.csv", "a,b\n1,2\n3\n");
  try {
    read_csv(folder_ / "bad.csv");
    FAIL() << "no error";
  } catch (const IoError& e) {
    EXPECT_EQ(e.what(), (folder_ / "bad.csv").string() + ": row 2 has 1 fields, the header 2");
  }
}

TEST_F(Csv, TakesOtherPeoplesLineEndings) {
  write_file(folder_ / "t.csv", "a,b\r\n1,2");
  EXPECT_THAT(read_csv(folder_ / "t.csv").rows[0], ElementsAre("1", "2"));
}

}  // namespace
}  // namespace panoptes
