// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/rig_sweep.h"

#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "apps/place/drives.h"
#include "apps/place/sweep_report.h"
#include "core/base/error.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class RigSweeps : public ScratchTest {
 protected:
  PlacementStudy study(const std::string& more) {
    const std::string file = path("study.yaml");
    std::ofstream(file) << "rig: " << PANOPTES_SOURCE_DIR << "/scenes/rigs/front-back-floor.yaml\n"
                        << "parameters:\n"
                           "  tilt_deg: {set: [\"cameras.floor.tilt_deg={}\"], range: [10, 60], "
                           "step: 10}\n"
                           "  at: {set: [\"cameras.floor.at_m={}\"], values: [\"[0.2, 0, 0.6]\", "
                           "\"[0.1, 0, 0.1]\"]}\n"
                        << more;
    return read_placement_study(file);
  }
  static RigSweep swept(const PlacementStudy& of, int jobs = 1) {
    return sweep_rigs(of, jobs, [](double) {});
  }
  std::string fault(const std::string& more) {
    try {
      swept(study(more));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "taken";
  }
};

TEST_F(RigSweeps, RefuseWhatCannotBeAndRankTheRest) {
  const PlacementStudy of = study("require: [\"blind.ahead_m <= 0.4\"]\n");
  const RigSweep sweep = swept(of);
  ASSERT_EQ(sweep.rigs.size(), 12U);
  ASSERT_EQ(sweep.ranked.size(), 6U);  // the other place is inside of the hull
  for (const SweptRig& rig : sweep.rigs) {
    EXPECT_EQ(rig.refused.empty(), rig.point.values[0] == "[0.2, 0, 0.6]");
    EXPECT_TRUE(rig.refused.empty() || rig.refused.find("inside the robot") != std::string::npos);
  }
  // Good ones before those that break a line, the Pareto set before others.
  const auto group = [&](std::size_t k) {
    const SweptRig& rig = sweep.rigs[sweep.ranked[k]];
    return rig.pareto ? 0 : rig.good() ? 1 : 2;
  };
  for (std::size_t k = 1; k < sweep.ranked.size(); ++k) {
    EXPECT_LE(group(k - 1), group(k));
  }
  EXPECT_EQ(group(0), 0);
  EXPECT_EQ(group(5), 2);  // 10 degrees see nothing near by
  // None of the Pareto set is beaten, whatever is good and not in it is.
  const auto beats = [&](const SweptRig& a, const SweptRig& b) {
    const double more = *a.scores[sweep.objectives[0]] - *b.scores[sweep.objectives[0]];
    const double nearer = *b.scores[sweep.objectives[1]] - *a.scores[sweep.objectives[1]];
    return more >= 0 && nearer >= 0 && (more > 0 || nearer > 0);
  };
  for (const SweptRig& rig : sweep.rigs) {
    if (rig.good()) {
      EXPECT_EQ(rig.pareto,
                std::none_of(sweep.rigs.begin(), sweep.rigs.end(), [&](const SweptRig& other) {
                  return other.good() && beats(other, rig);
                }));
    }
  }
}

TEST_F(RigSweeps, WeighWhatARigCostsAgainstWhatItSees) {
  const PlacementStudy of = study(
      "  lens: {choices: {dear: {set: [\"cameras.floor.fov_deg=80\"], price: 90},\n"
      "                   cheap: {set: [\"cameras.floor.fov_deg=80\"], price: 20},\n"
      "                   narrow: {set: [\"cameras.floor.fov_deg=40\"]}}}\n"
      "camera_price: 300\nobjectives: [floor.mapped_m2, price]\n");
  const RigSweep sweep = swept(of);
  EXPECT_EQ(sweep.names.back().key, "price");
  for (const SweptRig& rig : sweep.rigs) {
    if (!rig.refused.empty()) {
      continue;
    }
    const std::string& lens = rig.point.values[1];
    EXPECT_EQ(*rig.scores.back(), 3 * 300 + (lens == "dear" ? 90 : lens == "cheap" ? 20 : 0));
    EXPECT_FALSE(lens == "dear" && rig.pareto) << "sees no more than the cheap one";
  }
  EXPECT_EQ(sweep.rigs[sweep.ranked[0]].point.values[1], "cheap");
  EXPECT_EQ(swept(study("")).names.size() + 1, sweep.names.size()) << "where nothing is priced";
}

TEST_F(RigSweeps, AreTheSameBytesForAnyNumberOfJobs) {
  const PlacementStudy of = study("sweep: {kind: random, rigs: 40, seed: 2}\n");
  write_sweep_csv(path("one.csv"), of, swept(of, 1));
  write_sweep_csv(path("three.csv"), of, swept(of, 3));
  const std::string one = read_file(path("one.csv"));
  EXPECT_EQ(one, read_file(path("three.csv")));
  const CsvTable table = read_csv(path("one.csv"));
  EXPECT_EQ(table.rows.size(), 40U);
  EXPECT_EQ(table.columns[5], "at");
}

TEST_F(RigSweeps, KeepWhatWasTriedUntilTheyAreStopped) {
  for (const char* sweep :
       {"{kind: random, rigs: 130, seed: 2}", "{kind: nsga2, rigs: 130, population: 16}"}) {
    const PlacementStudy of = study(std::string("sweep: ") + sweep + "\n");
    int asked = 0;
    const RigSweep cut = sweep_rigs(
        of, 1, [](double) {}, [&asked] { return ++asked == 2; });
    const RigSweep whole = swept(of);
    EXPECT_TRUE(cut.cut_short);
    EXPECT_FALSE(whole.cut_short);
    ASSERT_GT(cut.rigs.size(), 0U);
    ASSERT_LT(cut.rigs.size(), whole.rigs.size());
    EXPECT_FALSE(cut.ranked.empty());
    for (std::size_t i = 0; i < cut.rigs.size(); ++i) {
      EXPECT_EQ(cut.rigs[i].point.values, whole.rigs[i].point.values);
      EXPECT_EQ(cut.rigs[i].scores, whole.rigs[i].scores);
    }
  }
}

TEST_F(RigSweeps, TellHowWellRigsCanBeCalibratedWhereThatIsAsked) {
  const std::string wanted = "calibratability.rotation_deg";
  EXPECT_FALSE(asks_calibratability(study("")));
  const RigSweep sweep = swept(study("sweep: {kind: random, rigs: 3, seed: 2}\nobjectives: [" +
                                     wanted + "]\nrequire: [calibratability.position_m < 1]\n"));
  EXPECT_EQ(sweep.names[sweep.objectives[0]].key, wanted);
  ASSERT_FALSE(sweep.ranked.empty());
  const std::optional<double> best_deg = sweep.rigs[sweep.ranked[0]].scores[sweep.objectives[0]];
  EXPECT_GT(best_deg.value_or(0), 0.001);
  EXPECT_LT(best_deg.value_or(9), 0.2);
}

TEST_F(RigSweeps, BredFromTheBestComeAsFarAsAllOfAFineGrid) {
  const std::string parameters =
      "  height_m: {set: [\"cameras.floor.at_m=[0.2, 0, {}]\"], range: [0.3, 0.6], step: 0.1}\n"
      "  lens_deg: {set: [\"cameras.floor.fov_deg={}\"], range: [40, 80], step: 4}\n";
  const auto with = [&](const std::string& sweep) {
    return study(parameters + "require: [\"blind.ahead_m <= 0.4\"]\nsweep: " + sweep + "\n");
  };
  const PlacementStudy of = with("{kind: nsga2, rigs: 120, population: 16}");
  const RigSweep bred = swept(of);
  std::set<std::vector<std::string>> ways;
  for (const SweptRig& rig : bred.rigs) {
    EXPECT_TRUE(ways.insert(rig.point.values).second) << "is tried twice";
  }
  EXPECT_LE(bred.rigs.size(), 120U);
  const RigSweep all = swept(with("grid"), 2);
  ASSERT_GT(all.rigs.size(), 3 * bred.rigs.size());
  const SweptRig& best = bred.rigs[bred.ranked.front()];
  ASSERT_TRUE(best.good());
  const std::size_t first = bred.objectives[0];
  EXPECT_GE(*best.scores[first], 0.98 * *all.rigs[all.ranked.front()].scores[first]);

  write_sweep_csv(path("one.csv"), of, bred);
  write_sweep_csv(path("three.csv"), of, swept(of, 3));
  EXPECT_EQ(read_file(path("one.csv")), read_file(path("three.csv")));
}

TEST_F(RigSweeps, BredNeedTwoObjectivesAndWholePairsOfParents) {
  EXPECT_THAT(fault("sweep: nsga2\nobjectives: [floor.mapped_m2]\n"), HasSubstr("name two"));
  EXPECT_THAT(fault("sweep: {kind: nsga2, population: 30}\n"),
              HasSubstr("population: must be a multiple of 4"));
  EXPECT_THAT(fault("sweep: {kind: nsga2, rigs: 12, population: 16}\n"),
              HasSubstr("population: must be no more than the rigs"));
}

TEST_F(RigSweeps, LeaveTheBestRigAsAFileThatScoresTheSame) {
  const PlacementStudy of = study("");
  const RigSweep sweep = swept(of);
  write_file(path("best.yaml"), best_rig_file(of, sweep));
  EXPECT_THAT(read_file(path("best.yaml")), HasSubstr("# cameras.floor.tilt_deg="));
  const auto again =
      named_scores(score_rig(of.scores, read_settings<Rig>(path("best.yaml")), of.robot));
  const SweptRig& best = sweep.rigs[sweep.ranked.front()];
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].value, best.scores[i]) << again[i].key;
  }
}

TEST_F(RigSweeps, PromoteRigsThatLieFarApartOnTheFront) {
  RigSweep sweep;
  sweep.names = {{"a", "", "", 1, 0, Better::kLower, {}}, {"b", "", "", 1, 0, Better::kHigher, {}}};
  sweep.objectives = {0, 1};
  // Of the front two at its ends, two close together in its middle; then one behind it.
  for (const auto& [a, b] :
       {std::pair{1.0, 100.0}, {2.0, 290.0}, {2.1, 300.0}, {4.0, 500.0}, {5.0, 400.0}}) {
    SweptRig rig;
    rig.scores = {a, b};
    rig.pareto = a != 5;
    sweep.ranked.push_back(sweep.rigs.size());
    sweep.rigs.push_back(rig);
  }
  EXPECT_THAT(promoted_rigs(sweep, 1), ElementsAre(0));
  EXPECT_THAT(promoted_rigs(sweep, 3), ElementsAre(0, 3, 2));
  EXPECT_THAT(promoted_rigs(sweep, 9), ElementsAre(0, 3, 2, 1, 4));
  sweep.rigs[3].scores[1].reset();  // what it does not have is as far away as can be
  EXPECT_THAT(promoted_rigs(sweep, 3), ElementsAre(0, 3, 2));
}

TEST_F(RigSweeps, LeaveAStudyThatDrivesTheBest) {
  std::ofstream(path("m.yaml")) << "drive: none\n";
  const PlacementStudy of = study(
      "drive:\n  missions: [{name: here, mission: m.yaml, set: [\"until.duration_s=9\"]}]\n"
      "  set: [\"a={b: 1}\"]\n  best: 2\n  against_first: [\"map.coverage >= -0.01\"]\n"
      "  halving: {seeds: 3, least: exploration.t90_s}\n"
      "  rungs: [{name: calibrated}, {name: 2 degrees, set: [\"e=2\"]}]\n");
  const RigSweep sweep = swept(of);
  int told = 0;
  write_drives(folder_ / "out", of, sweep, [&](double) { ++told; });
  EXPECT_EQ(told, 3);
  const Study drives = read_study((folder_ / "out" / "drives.yaml").string());
  ASSERT_EQ(drives.rigs.size(), 3U);
  EXPECT_EQ(drives.rigs[0].name, "front-back-floor");
  EXPECT_EQ(drives.rigs[1].name, "rig-" + std::to_string(sweep.ranked[0] + 1));
  EXPECT_EQ(drives.rungs[0].settings.set[0], "platform.mounting_error={as_known: true}");
  EXPECT_EQ(drives.missions[0].settings.set[0], "until.duration_s=9");
  EXPECT_EQ(drives.settings.set[0], "a={b: 1}");
  EXPECT_EQ(drives.against_first[0].line, "map.coverage >= -0.01");
  ASSERT_EQ(drives.rungs.size(), 2U);
  EXPECT_EQ(drives.rungs[1].name, "2 degrees");
  EXPECT_EQ(drives.rungs[1].settings.set[1], "e=2");
  ASSERT_EQ(drives.scores.size(), 2U);
  EXPECT_EQ(drives.scores[0].most, "map.coverage");
  EXPECT_EQ(drives.scores[1].least, "checkpoints.error_mean_m");
  EXPECT_EQ(drives.halving->seeds, 3);
  EXPECT_EQ(drives.halving->score.least, "exploration.t90_s");
  EXPECT_EQ(read_settings<Rig>(drives.rigs[0].file).cameras.size(), 3U);
  const Rig best = read_settings<Rig>(drives.rigs[1].file);
  const Rig wanted = rig_of(of, sweep.rigs[sweep.ranked[0]].point);
  EXPECT_TRUE(best.cameras.at("floor").T_body_camera.rotation.isApprox(
      wanted.cameras.at("floor").T_body_camera.rotation));
  EXPECT_LT(best.cameras.at("floor").sigma.rotation_rad.maxCoeff(), deg_to_rad(0.1))
      << "as a programmed motion leaves it";
  EXPECT_TRUE(best.covariance.has_value());
}

TEST_F(RigSweeps, LeaveAStudyThatRecordsAndCalibratesTheRigsThatItDrives) {
  write_file(folder_ / "m.yaml", "");
  const PlacementStudy of =
      study("drive:\n  missions: [{name: here, mission: m.yaml}]\n  best: 2\n");
  const RigSweep sweep = swept(of);
  write_drives(folder_ / "out", of, sweep, [](double) {});
  write_calibrations(folder_ / "out", of, sweep);
  const Study drives = read_study((folder_ / "out" / "drives.yaml").string());
  const Study made = read_study((folder_ / "out" / "calibrations.yaml").string());
  ASSERT_EQ(made.rigs.size(), 2U);
  for (std::size_t i = 0; i < made.rigs.size(); ++i) {
    EXPECT_EQ(made.rigs[i].file, drives.rigs[i + 1].file);
  }
  EXPECT_TRUE(calibrates(made.missions[0].command));
  std::vector<std::string> of_rig;  // as `--set` gives them to the rig's file
  for (const std::string& set : made.rungs[0].settings.set) {
    if (set.starts_with("rig.")) {
      of_rig.push_back(set.substr(4));
    }
  }
  const Rig by_hand = read_settings<Rig>(made.rigs[0].file, of_rig);
  EXPECT_NEAR(by_hand.cameras.at("floor").sigma.rotation_rad.maxCoeff(), deg_to_rad(1), 1e-3);
}

TEST_F(RigSweeps, AreRefusedWhereTheStudyNamesWhatIsNot) {
  EXPECT_THAT(fault("require: [\"blind.ahed_m <= 1\"]\n"),
              HasSubstr("study.yaml:5:11: require: there is no score blind.ahed_m; did you mean "
                        "blind.ahead_m?"));
  EXPECT_THAT(fault("objectives: [overlap.twice_share]\n"),
              HasSubstr("objectives: neither more nor less of overlap.twice_share is better"));
  const PlacementStudy wrong = [&] {
    std::ofstream(path("wrong.yaml"))
        << "rig: " << PANOPTES_SOURCE_DIR << "/scenes/rigs/front-back-floor.yaml\n"
        << "parameters:\n  t: {set: [\"cameras.floor.tlit_deg={}\"], values: [1]}\n";
    return read_placement_study(path("wrong.yaml"));
  }();
  const std::function<void()> ways[] = {[&] { swept(wrong); },
                                        [&] { check_placement_study(wrong); }};
  for (const auto& way : ways) {
    try {
      way();
      FAIL() << "it was taken";
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), HasSubstr("wrong.yaml:3:13: cameras.floor.tlit_deg: "));
      EXPECT_THAT(error.what(), HasSubstr("did you mean tilt_deg?"));
    }
  }
  EXPECT_THROW(check_placement_study(study("objectives: [overlap.twice_share]\n")), ConfigError);
  check_placement_study(study("require: [\"bus.fits == 1\"]\n"));
}

}  // namespace
}  // namespace panoptes
