// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/study_table.h"

#include <gmock/gmock.h>

#include "core/io/csv.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// Two missions, two rigs; a rung for both rigs and one for the first alone: six cells.
Study small_study() {
  Study study;
  study.missions.resize(2);
  study.missions[0].name = "office";
  study.missions[1].name = "home";
  study.rigs.resize(2);
  study.rigs[0].name = "axis";
  study.rigs[1].name = "edges";
  study.rungs.resize(2);
  study.rungs[0].name = "none";
  study.rungs[1].name = "lens";
  study.rungs[1].rigs = {"axis"};
  return study;
}

StudyRun run_of(std::size_t cell, std::uint64_t seed, double error_m,
                const std::vector<std::string>& faults = {}) {
  return {cell,
          seed,
          true,
          faults.empty(),
          faults,
          FigureRows().row({{"run_s", 240},
                            {"cpu_s", 100.0 * static_cast<double>(seed)},
                            {"timing_ms.step.mean", 10},
                            {"trajectory.ate_rmse_m", error_m},
                            {"trajectory.odometry_ate_rmse_m", 10 * error_m}})};
}

TEST(FigureRows, KeepTheNamesOfAllRunsOnce) {
  FigureRows rows;
  const FigureRow first = rows.row({{"b", 1}, {"a", 2}});
  const FigureRow same = rows.row({{"b", 3}, {"a", 4}});
  const FigureRow other = rows.row({{"a", 5}, {"c", 6}});
  EXPECT_EQ(&first.names(), &same.names());
  EXPECT_EQ(first.find("a"), 2);
  EXPECT_EQ(same.find("b"), 3);
  EXPECT_EQ(other.find("b"), std::nullopt);
  EXPECT_TRUE(FigureRow().empty());
  EXPECT_EQ(FigureRow().find("a"), std::nullopt);
  FigureNameUnion all;
  for (const FigureRow& row : {FigureRow(), first, same, other}) {
    all.add(row);
  }
  EXPECT_EQ(all.names(), (std::vector<std::string>{"b", "a", "c"}));
}

TEST(StudyTable, ShowsTheFigureThatAStudyAsksForAndTheWorstCameraOfIt) {
  Study study = small_study();
  study.missions.resize(1);
  study.rungs.resize(1);
  study.figure = "cameras.*.rotation_error_deg";
  const auto run = [](std::size_t cell, double left_deg, double right_deg) {
    StudyRun one = run_of(cell, 1, 0.01);
    one.figures = FigureRows().row({{"cameras.left.rotation_error_deg", left_deg},
                                    {"cameras.right.rotation_error_deg", right_deg},
                                    {"cameras.right.translation_error_m", 9},
                                    {"trajectory.odometry_ate_rmse_m", 9}});
    return one;
  };
  const std::vector<StudyRun> runs{run(0, 0.0123, 0.00012), run(1, 0.01, 1.5)};
  EXPECT_EQ(study_tables(study, runs),
            "| rig | none |\n"
            "| --- | --- |\n"
            "| axis | 0.0123 |\n"
            "| edges | 1.5 |\n");
  EXPECT_THAT(study_page(study, runs),
              testing::StartsWith("`cameras.*.rotation_error_deg`, of seed 1. Bold:"));
}

/// office: none axis, none edges, lens axis; home likewise.
std::vector<StudyRun> six_cells() {
  return {
      run_of(0, 1, 0.011), run_of(0, 2, 0.024), run_of(1, 1, 0.5, {"loops.false == 0, it is 1"}),
      run_of(1, 2, 0.3),   run_of(2, 1, 0.04),  run_of(3, 1, 0.05),
      run_of(4, 1, 0.06),  run_of(5, 1, 0.07)};
}

TEST(StudyTable, ShowsTheWorstOfTheSeedsAndWhichCellsBreakALimit) {
  EXPECT_EQ(study_tables(small_study(), six_cells()),
            "| rig | mission | none |\n"
            "| --- | --- | --- |\n"
            "| axis | office | 2.4 |\n"
            "| axis | home | 5.0 |\n"
            "| edges | office | **50.0** |\n"
            "| edges | home | 6.0 |\n"
            "\n"
            "| rig | mission | lens |\n"
            "| --- | --- | --- |\n"
            "| axis | office | 4.0 |\n"
            "| axis | home | 7.0 |\n");
}

TEST(StudyTable, OfOneMissionDoesNotNameIt) {
  Study study = small_study();
  study.missions.pop_back();
  study.rungs[1].rigs.clear();
  EXPECT_THAT(study_tables(study, {run_of(0, 1, 0.01)}),
              HasSubstr("| rig | none | lens |\n| --- | --- | --- |\n| axis | 1.0 | - |\n"));
}

TEST(StudyTable, ShowsWhatIsLeftToDoAndWhatBrokeOff) {
  std::vector<StudyRun> runs = six_cells();
  runs[1] = {0, 2, false, false, {}, {}};
  runs[4] = {2, 1, false, false, {}, {}};
  runs[7] = {5, 1, true, false, {"exit status 3: no world"}, {}};
  const std::string page = study_page(small_study(), runs);
  EXPECT_THAT(page, HasSubstr("| axis | office | 1.1 ... |\n"));
  EXPECT_THAT(page, HasSubstr("| axis | office | ... |\n| axis | home | **-** |\n"));
  EXPECT_THAT(page, HasSubstr("Three dots: there are runs left to do."));
  EXPECT_THAT(page, HasSubstr("- home, axis, lens, seed 1: exit status 3: no world\n"));
}

TEST(StudyTable, IsToldInWords) {
  const std::string page = study_page(small_study(), six_cells());
  EXPECT_THAT(page, testing::StartsWith(
                        "Rms error of position in cm (`trajectory.ate_rmse_m`), the worst of the "
                        "seeds 1, 2. By the wheels alone it is 11.0 to 500.0. Bold: a limit is "
                        "broken, or a run did not come to a good end.\n\n| rig |"));
  EXPECT_THAT(page, HasSubstr("\nNot held:\n\n- office, edges, none, seed 1: loops.false == 0, it "
                              "is 1\n"));
  std::vector<StudyRun> held = six_cells();
  held.erase(held.begin() + 2);
  EXPECT_THAT(study_page(small_study(), held), Not(HasSubstr("Not held")));
  EXPECT_THAT(study_page(small_study(), {run_of(0, 7, 0.01)}), HasSubstr(", of seed 7. "));
}

class StudyCsv : public ScratchTest {};

TEST_F(StudyCsv, HasARowARunWithoutWhatDependsOnTheComputer) {
  std::vector<StudyRun> runs = six_cells();
  runs[3].done = false;
  write_study_csv(folder_ / "study.csv", small_study(), runs);
  const CsvTable table = read_csv(folder_ / "study.csv");
  EXPECT_THAT(table.columns,
              ElementsAre("mission", "rig", "rung", "seed", "verdict", "faults", "run_s",
                          "trajectory.ate_rmse_m", "trajectory.odometry_ate_rmse_m"));
  ASSERT_EQ(table.rows.size(), 7U);
  EXPECT_THAT(table.rows[2], ElementsAre("office", "edges", "none", "1", "fail",
                                         "loops.false == 0, it is 1", "240", "0.5", "5"));
}

}  // namespace
}  // namespace panoptes
