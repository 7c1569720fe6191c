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

TEST_F(Csv, SaysWhichFieldIsNoNumber) {
  const CsvTable table = parse_csv("t.csv", "stamp_s,n,what\n0.25,3,\"a\nb\"\nx,1e300,\n");
  EXPECT_EQ(table.stamp(0, 0), time_at(0.25));
  EXPECT_EQ(table.number(0, 0), 0.25);
  EXPECT_EQ(table.whole(0, 1), 3);
  const auto message = [](const auto& read) -> std::string {
    try {
      read();
    } catch (const IoError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_EQ(message([&] { table.stamp(1, 0); }),
            "t.csv:4: stamp_s must be an instant in seconds, got 'x'");
  EXPECT_EQ(message([&] { table.number(1, 2); }), "t.csv:4: what must be a number, got ''");
  EXPECT_EQ(message([&] { table.whole(1, 1); }), "t.csv:4: n must be a whole number, got '1e300'");
  EXPECT_EQ(message([&] { table.whole(0, 0); }),
            "t.csv:2: stamp_s must be a whole number, got '0.25'");
}

TEST_F(Csv, WritesARowForATableThatGrowsOtherwise) {
  EXPECT_EQ(csv_row({"0.5", "a, \"b\"", ""}), "0.5,\"a, \"\"b\"\"\",\n");
}

TEST_F(Csv, TakesOtherPeoplesLineEndings) {
  write_file(folder_ / "t.csv", "a,b\r\n1,2");
  EXPECT_THAT(read_csv(folder_ / "t.csv").rows[0], ElementsAre("1", "2"));
}

}  // namespace
}  // namespace panoptes
