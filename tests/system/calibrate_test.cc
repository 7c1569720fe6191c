// SPDX-License-Identifier: BSD-3-Clause
// Lenses by boards, maps of cameras and rigs, as a user calls for them.
#include <cmath>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>
#include <sys/file.h>
#include <unistd.h>

#include "core/camera/mounting.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/io/picture.h"
#include "core/io/tum.h"
#include "tests/support/board_pictures.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Calibrate : public SystemTest {
 protected:
  // `count` pictures of a board in folder_/pictures/name, and one without.
  void photograph(const std::string& name, const Intrinsics& lens, int count) {
    const std::filesystem::path folder = folder_ / "work/pictures" / name;
    std::filesystem::create_directories(folder);
    const Board board;
    const BoardPainter painter(board, lens);
    Rng rng(8);
    int i = 0;
    for (const Pose3& T_camera_board : board_poses(board, lens, {}, count, rng)) {
      cv::imwrite(folder / (std::to_string(i++) + ".png"), painter.draw(T_camera_board, {}, rng));
    }
    cv::imwrite(folder / "wall.png", cv::Mat(lens.height_px, lens.width_px, CV_8U, cv::Scalar(90)));
  }

  Said calibrate(const std::vector<std::string>& more) {
    std::vector<std::string> words{"calibrate", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return panoptes(words);
  }
};

const Intrinsics kFront =
    lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.26, 0.07, 0.0005, -0.0004, 0});
const Intrinsics kUp = lens_of_view(640, 480, deg_to_rad(185), Equidistant{-0.01, 0.002, 0, 0});

TEST_F(Calibrate, EachCamerasLensIsTold) {
  photograph("front", kFront, 24);
  photograph("up", kUp, 24);
  const Said said = calibrate({"pictures", "--board", "9x6x0.025", "--out", "run"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("front: "));
  EXPECT_THAT(said.out, HasSubstr("the board in 24 of 25 pictures"));
  const auto m = metrics("run");
  EXPECT_EQ(m["outcome"], "completed");
  for (const auto& [name, lens] :
       std::map<std::string, Intrinsics>{{"front", kFront}, {"up", kUp}}) {
    const auto& told = m["cameras"][name];
    EXPECT_NE(told["verdict"], "failed");
    constexpr double kThousandth = 0.001;
    EXPECT_NEAR(told["intrinsics"]["fx_px"], lens.fx_px, kThousandth * lens.fx_px);
    EXPECT_NEAR(told["intrinsics"]["cx_px"], lens.cx_px, 0.5);
    EXPECT_LT(told["corner_noise_px"], 0.06);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "work/run" / ("boards_" + name + ".png")));
  }
  EXPECT_EQ(m["cameras"]["up"]["intrinsics"]["model"], "equidistant");
  EXPECT_THAT(read_file(folder_ / "work/run/lenses.yaml"), HasSubstr("intrinsics_px: ["));
  EXPECT_THAT(read_file(folder_ / "work/run/boards.csv"), HasSubstr("front,wall.png,not seen,"));

  // the same for any number of threads
  calibrate({"pictures", "--board", "9x6x0.025", "--out", "again", "--threads", "1"});
  EXPECT_EQ(comparable(folder_ / "work/run"), comparable(folder_ / "work/again"));
}

TEST_F(Calibrate, ARigGetsTheLens) {
  photograph("front", kFront, 24);
  write("rig.yaml",
        "cameras:\n  front: {roles: [loop_front], size_px: [640, 480], fov_deg: 75, at_m: [0.2, 0, "
        "0.3]}\n");
  const Said said =
      calibrate({"pictures/front", "--board", "9x6x0.025", "--rig", "rig.yaml", "--out", "run"});
  EXPECT_EQ(said.status, 0) << said.err;
  const Rig rig = read_settings<Rig>(folder_ / "work/run/rig_calibrated.yaml");
  constexpr double kThousandth = 0.001;
  EXPECT_NEAR(rig.cameras.at("front").intrinsics.fx_px, kFront.fx_px, kThousandth * kFront.fx_px);
  EXPECT_LT(rig.cameras.at("front").sigma.focal_ratio, kThousandth);
  EXPECT_EQ(rig.cameras.at("front").T_body_camera.translation.x(), 0.2);

  write("other.yaml",
        "cameras:\n  left: {size_px: [640, 480], fov_deg: 75, at_m: [0.2, 0, 0.3]}\n");
  const Said other = calibrate(
      {"pictures/front", "--board", "9x6x0.025", "--rig", "other.yaml", "--out", "other"});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, HasSubstr("other.yaml: has no camera front"));
  write("small.yaml",
        "cameras:\n  front: {size_px: [320, 240], fov_deg: 75, at_m: [0.2, 0, 0.3]}\n");
  const Said small = calibrate(
      {"pictures/front", "--board", "9x6x0.025", "--rig", "small.yaml", "--out", "small"});
  EXPECT_EQ(small.status, 2);
  EXPECT_THAT(small.err, HasSubstr("small.yaml: says that front has pictures of 320 x 240 pixels"));
}

TEST_F(Calibrate, TooFewBoardsAreAVerdictAndNoNumber) {
  photograph("front", kFront, 3);
  const std::filesystem::path folder = folder_ / "work/pictures/front";
  std::filesystem::copy_file(folder / "0.png", folder / "0_again.png");
  const Said said = calibrate({"pictures/front", "--board", "9x6x0.025", "--out", "run"});
  EXPECT_EQ(said.status, 1);
  EXPECT_THAT(said.out,
              StartsWith("front: failed; the board in 4 of 5 pictures, 1 of them copied"));
  EXPECT_THAT(said.out, HasSubstr("3 pictures show a whole board: at least 5 are needed"));
  EXPECT_THAT(said.out, HasSubstr("a board of 10 x 7 squares has 9 x 6"));
  const auto m = metrics("run");
  EXPECT_EQ(m["outcome"], "failed");
  EXPECT_EQ(m["verdict"], "failed");
  EXPECT_FALSE(m["cameras"]["front"].contains("intrinsics"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/run/lenses.yaml"));
}

TEST_F(Calibrate, WhatIsNoBoardOrNoPictureIsRefused) {
  photograph("front", kFront, 1);
  for (const char* board : {"9x6x25", "2x2x0.1"}) {
    const Said said = calibrate({"pictures/front", "--board", board, "--out", "run"});
    EXPECT_EQ(said.status, 2);
    EXPECT_THAT(said.err,
                HasSubstr("--board " + std::string(board) +
                          ": must be COLUMNSxROWSxSQUARE, as 9x6x0.025: 3 to 100 inner corners "
                          "each way, and the side of a square in metres, at most 2 (25 mm are "
                          "0.025)"));
  }
  EXPECT_EQ(calibrate({"nothing", "--board", "9x6x0.025", "--out", "run"}).status, 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/run"));
  write("pictures/front/torn.png", "\x89PNG\r\n");
  const Said torn = calibrate({"pictures/front", "--board", "9x6x0.025", "--out", "run"});
  EXPECT_EQ(torn.status, 2);
  EXPECT_THAT(torn.err, HasSubstr("torn.png: "));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/run"));
  std::filesystem::remove(folder_ / "work/pictures/front/torn.png");
  cv::imwrite(folder_ / "work/pictures/front/small.png", cv::Mat(60, 80, CV_8U, cv::Scalar(9)));
  EXPECT_THAT(calibrate({"pictures/front", "--board", "9x6x0.025", "--out", "run"}).err,
              HasSubstr("give pictures of one camera and one size"));
}

class CalibrateMaps : public SystemTest {
 protected:
  // Six seconds of a rose.
  void record() const {
    const Said said = panoptes({"record", kScenes + "missions/record-room.yaml", "--duration", "6",
                                "--quiet", "--seed", "2", "--out", "rose"});
    ASSERT_EQ(said.status, 0) << said.out << said.err;
  }
  Said maps(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"calibrate", "rose", "--stage", "maps", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return panoptes(words);
  }
};

TEST_F(CalibrateMaps, ARigIsNotToldByADriveThatHardlyTurns) {
  record();
  const Said said = panoptes({"calibrate", "rose", "--quiet", "--out", "rig"});
  EXPECT_EQ(said.status, 1) << said.out << said.err;
  EXPECT_THAT(said.out, HasSubstr("failed: no rig is told"));
  EXPECT_THAT(said.out, HasSubstr("stage rig: ahead: it turns by"));
  const auto m = metrics("rig");
  EXPECT_EQ(m["verdict"], "failed");
  EXPECT_FALSE(m.contains("reference")) << "no number is told";
  EXPECT_TRUE(std::filesystem::exists(folder_ / "work/rig/map_behind.json"));

  // Nor by what maps of opposite walls have in common.
  for (const std::string map : {"map_ahead.json", "map_behind.json"}) {
    std::filesystem::create_directories(folder_ / "work/thesis");
    std::filesystem::copy_file(folder_ / "work/rig" / map, folder_ / "work/thesis" / map);
  }
  const Said by_maps = panoptes({"calibrate", "rose", "--method", "thesis", "--cameras",
                                 "ahead,behind", "--quiet", "--out", "thesis"});
  EXPECT_EQ(by_maps.status, 1) << by_maps.out << by_maps.err;
  EXPECT_THAT(by_maps.out, HasSubstr("failed: no rig is told"));
  EXPECT_THAT(by_maps.out, HasSubstr("the maps of ahead and behind are not aligned: "));
  EXPECT_EQ(metrics("thesis")["verdict"], "failed");
  EXPECT_FALSE(metrics("thesis").contains("reference")) << "no number is told";
  const Said alone =
      panoptes({"calibrate", "rose", "--method", "thesis", "--cameras", "ahead", "--out", "alone"});
  EXPECT_EQ(alone.status, 2);
  EXPECT_THAT(alone.err, HasSubstr("tells cameras beside one another, and ahead is the only one"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/alone"));

  // What is missing is said before anything is computed.
  EXPECT_THAT(panoptes({"calibrate", "nowhere", "--out", "gone"}).err,
              HasSubstr("nowhere: is not there; give the file of a mission, or a dataset"));
  std::filesystem::remove(pictures_in(folder_ / "work/rose/mav0/left/data").at(60));
  const Said gone = panoptes({"calibrate", "rose", "--out", "gone"});
  EXPECT_EQ(gone.status, 2);
  EXPECT_THAT(gone.err, AllOf(HasSubstr("mav0/left/data.csv:62: "), HasSubstr("is not there")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/gone"));
}

TEST_F(CalibrateMaps, EachCameraMapsWhatItPasses) {
  record();
  const Said said = maps({"--cameras", "ahead,left", "--out", "run"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("ahead: poor; "));
  EXPECT_THAT(said.out, HasSubstr("drive one that turns by more than 360 degrees"));
  const auto m = metrics("run");
  EXPECT_EQ(m["verdict"], "poor");
  for (const std::string camera : {"ahead", "left"}) {
    const auto& map = m["cameras"][camera]["map"];
    EXPECT_GT(map["features"], 20);
    EXPECT_EQ(map["lost_s"], 0);
    EXPECT_LT(map["nis"], 2);
    EXPECT_LT(map["heading_error_deg"], 1);
    EXPECT_LT(map["reprojection_rms_px"]["after"], 0.8);
    EXPECT_GT(map["adjusted"]["keyframes"], 3);
    for (const std::string& file :
         {"map_" + camera + ".png", "search_" + camera + ".png", "reprojection_" + camera + ".png",
          "points_" + camera + ".csv", "path_" + camera + ".tum"}) {
      EXPECT_TRUE(std::filesystem::exists(folder_ / "work/run" / file)) << file;
    }
    EXPECT_EQ(read_tum(folder_ / "work/run" / ("keyframes_" + camera + ".tum")).size(),
              map["adjusted"]["keyframes"]);
    constexpr double kPercent = 0.01;
    const double fx_px =
        read_settings<Rig>(folder_ / "work/rose/rig.yaml").cameras.at(camera).intrinsics.fx_px;
    EXPECT_NEAR(map["adjusted"]["lens"]["fx_px"], fx_px, kPercent * fx_px);
    const CsvTable points = read_csv(folder_ / "work/run" / ("points_" + camera + ".csv"));
    const std::size_t adjusted_x = points.column("adjusted_x_m");
    std::size_t adjusted = 0;
    for (std::size_t row = 0; row < points.rows.size(); ++row) {
      adjusted += points.rows[row][adjusted_x].empty() ? 0 : 1;
    }
    EXPECT_LE(adjusted, map["adjusted"]["points"]);
    EXPECT_GT(2 * adjusted, map["adjusted"]["points"]);
  }
  EXPECT_EQ(maps({"--cameras", "ahead,ahead", "--out", "twice"}).out,
            said.out.substr(0, said.out.find("left: ")));

  EXPECT_EQ(maps({"--cameras", "left", "--odometry", "--out", "wheels"}).status, 0);
  EXPECT_NEAR(metrics("wheels")["cameras"]["left"]["map"]["scale"].get<double>(), 1, 0.1);
  std::filesystem::remove(folder_ / "work/rose/mav0/odom0/data.csv");
  const Said without = maps({"--odometry", "--out", "none"});
  EXPECT_EQ(without.status, 2);
  EXPECT_THAT(without.err, HasSubstr("mav0/odom0/data.csv: is missing"));

  EXPECT_EQ(maps({"--out", "run"}).status, 2);  // is not empty
  const Said nobody = maps({"--cameras", "up", "--out", "none"});
  EXPECT_EQ(nobody.status, 2);
  EXPECT_THAT(nobody.err, HasSubstr("the rig has no camera up; it has ahead, "));
  write("small.yaml",
        "cameras:\n  ahead: {roles: [loop_front], size_px: [320, 240], fov_deg: 80, at_m: [0, 0, "
        "1]}\n");
  const Said small = maps({"--rig", "small.yaml", "--out", "none"});
  EXPECT_EQ(small.status, 2);
  EXPECT_THAT(small.err, HasSubstr("data.csv:2: is 640 x 480 pixels, and the lens of ahead is for "
                                   "320 x 240"));
}

TEST_F(CalibrateMaps, WhatWasMappedUntilItWasCutShortIsKept) {
  record();
  const Said said = panoptes({"calibrate", "rose", "--stage", "maps", "--quiet", "--out", "run"},
                             {{}, {}, SIGINT, "run/path_ahead.tum"});
  EXPECT_EQ(said.status, 130) << said.err;
  const auto m = metrics("run");
  EXPECT_EQ(m["outcome"], "interrupted");
  EXPECT_GT(m["cameras"]["ahead"]["map"]["features"], 20);
  EXPECT_LT(m["cameras"].size(), 4);

  const std::filesystem::path pictures = folder_ / "work/rose/mav0/left/data";
  const std::vector<std::string> files = pictures_in(pictures);
  write_file(files.at(60), "torn");
  const Said torn = maps({"--cameras", "left,ahead", "--out", "torn"});
  EXPECT_EQ(torn.status, 2);
  EXPECT_THAT(torn.err, HasSubstr("data.csv:62: "));
  const auto t = metrics("torn");
  EXPECT_EQ(t["outcome"], "failed");
  EXPECT_EQ(t["fault"].get<std::string>() + "\n", torn.err);
  EXPECT_EQ(t["cameras"]["left"]["map"]["pictures"], 60);
  EXPECT_NEAR(t["cameras"]["left"]["map"]["cut_short_s"], 4, 0.1);
  EXPECT_THAT(torn.out, HasSubstr("it is of the first "));
  EXPECT_FALSE(t["cameras"]["ahead"]["map"].contains("cut_short_s"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "work/torn/path_left.tum"));

  // What is wrong from the start leaves nothing.
  write_file(folder_ / "work/rose/mav0/left/data.csv", "#timestamp [ns],filename\n");
  const Said none = maps({"--out", "none"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, HasSubstr("rose/mav0/left/data.csv: has no pictures"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/none"));
  write("other.yaml",
        "cameras:\n  up: {roles: [loop_front], size_px: [640, 480], fov_deg: 80, at_m: [0, 0, "
        "1]}\n");
  EXPECT_THAT(maps({"--rig", "other.yaml", "--out", "none"}).err,
              HasSubstr("in mav0 there are ahead, "));
}

TEST_F(CalibrateMaps, AMissionIsRecordedAndCalibratedBy) {
  const std::string mission = kScenes + "missions/record-room.yaml";
  const auto calibrate = [&](const std::string& out, const std::string& seed,
                             const Fate& fate = {}) {
    return panoptes({"calibrate", mission, "--seed", seed, "--set", "until.duration_s=4",
                     "--cameras", "ahead", "--quiet", "--out", out},
                    fate);
  };
  const Said said = calibrate("rig", "2");
  EXPECT_EQ(said.status, 1) << said.err;
  EXPECT_THAT(said.out, HasSubstr("stage rig: ahead: it turns by"));
  const std::filesystem::path recorded = folder_ / "work/rig/recording";
  EXPECT_TRUE(std::filesystem::exists(recorded / "mav0/behind/data.csv"));
  const auto m = metrics("rig/recording");
  EXPECT_EQ(m["command"], "record");
  EXPECT_EQ(m["seed"], 2);
  EXPECT_EQ(m["outcome"], "completed");

  // As one that was interrupted before it had its results: what is recorded is not recorded again.
  const auto when = std::filesystem::last_write_time(recorded / "metrics.json");
  std::filesystem::remove(folder_ / "work/rig/metrics.json");
  const Said again = calibrate("rig", "2");
  EXPECT_THAT(said.out, testing::EndsWith(again.out));
  EXPECT_EQ(std::filesystem::last_write_time(recorded / "metrics.json"), when);

  // A map of other pictures under the same names is made anew, and a torn row is said.
  const std::filesystem::path map = folder_ / "work/rig/map_ahead.json";
  const std::string before = read_file(map);
  const std::vector<std::string> behind = pictures_in(recorded / "mav0/behind/data");
  const std::vector<std::string> ahead = pictures_in(recorded / "mav0/ahead/data");
  for (std::size_t i = 0; i < ahead.size(); ++i) {
    write_file(ahead[i], read_file(behind[i]));
  }
  std::filesystem::remove(folder_ / "work/rig/metrics.json");
  EXPECT_EQ(calibrate("rig", "2").status, 1);
  EXPECT_TRUE(read_file(map) != before);
  const std::filesystem::path rows = recorded / "mav0/ahead/data.csv";
  const std::string whole = read_file(rows);
  write_file(rows, whole + "123456,12");
  // One that told nothing is tried again in the same folder.
  EXPECT_THAT(calibrate("rig", "2").out, HasSubstr("data.csv: the last row is torn"));
  // So are pictures that are missing, and cameras.
  std::istringstream all(whole);
  std::string without;
  int row = 0;
  for (std::string line; std::getline(all, line); ++row) {
    without += row < 20 || row >= 30 ? line + "\n" : "";
  }
  write_file(rows, without);
  for (const char* camera : {"behind", "left", "right"}) {
    std::filesystem::rename(recorded / "mav0" / camera, folder_ / "work" / camera);
  }
  const Said alone = panoptes({"calibrate", "rig/recording", "--quiet", "--out", "alone"});
  EXPECT_EQ(alone.status, 1) << alone.err;
  EXPECT_THAT(alone.out, HasSubstr("ahead: 10 of "));
  EXPECT_THAT(alone.out, HasSubstr("left: is a camera of the rig, and the recording has no "));
  for (const char* camera : {"behind", "left", "right"}) {
    std::filesystem::rename(folder_ / "work" / camera, recorded / "mav0" / camera);
  }
  const Said other = calibrate("rig", "3");
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, HasSubstr("rig/recording: is of another mission, other settings"));

  const Said cut = calibrate("cut", "2", {{}, {}, SIGINT, "cut/recording/mission.yaml"});
  EXPECT_EQ(cut.status, 130);
  EXPECT_THAT(cut.err, HasSubstr("cut/recording: the drive was cut short, and no rig is calibrated "
                                 "by it; what was recorded is kept"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/cut/metrics.json"));
  // It is not removed while somebody writes there, nor where something else lies beside it.
  const std::filesystem::path kept = folder_ / "work/cut/recording";
  {
    const int folder = ::open(kept.c_str(), O_RDONLY | O_DIRECTORY);
    ASSERT_EQ(::flock(folder, LOCK_EX), 0);
    const Said beside = calibrate("cut", "2");
    EXPECT_EQ(beside.status, 2);
    EXPECT_THAT(beside.err, HasSubstr("cut/recording: another panoptes is recording there"));
    ::close(folder);
  }
  write("cut/notes.txt", "");
  EXPECT_THAT(calibrate("cut", "2").err, HasSubstr("cut: is not empty"));
  EXPECT_TRUE(std::filesystem::exists(kept / "mission.yaml"));
  std::filesystem::remove(folder_ / "work/cut/notes.txt");
  const Said after = calibrate("cut", "2");
  EXPECT_EQ(after.status, 1) << "it is recorded anew; it hardly turns";
  EXPECT_THAT(after.err, HasSubstr("cut/recording: was cut short, and is recorded anew"));
  EXPECT_THAT(after.out, HasSubstr("stage rig: ahead: it turns by"));
  const Said dataset = panoptes({"calibrate", "rig/recording", "--seed", "2", "--out", "none"});
  EXPECT_EQ(dataset.status, 2);
  EXPECT_THAT(dataset.err, HasSubstr("are of a mission that is recorded first"));
  std::filesystem::create_directories(folder_ / "work/full");
  write("full/notes.txt", "");
  EXPECT_THAT(calibrate("full", "2").err, HasSubstr("full: is not empty"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/full/recording"));
}

TEST_F(CalibrateMaps, AStudyRecordsAndCalibrates) {
  write("study.yaml", "missions:\n  - {name: rose, mission: " + kScenes +
                          "missions/record-room.yaml, command: calibrate}\n"
                          "set: [until.duration_s=4]\n"
                          "rigs: [{name: two, rig: " +
                          kScenes +
                          "rigs/two-opposed.yaml}]\n"
                          "rungs: [{name: as it is}]\n"
                          "figure: cameras.*.rotation_error_deg\n");
  EXPECT_EQ(panoptes({"check", "study.yaml"}).status, 0) << "no navigator is asked for";
  const std::vector<std::string> words{"trials", "--study", "study.yaml", "--seeds", "2",
                                       "--keep", "metrics", "--quiet",    "--out",   "out"};
  const Said said = panoptes(words);
  EXPECT_EQ(said.status, 1);
  EXPECT_THAT(said.out, HasSubstr("out/rose/two/as-it-is/2: outcome is failed"));
  const std::filesystem::path run = folder_ / "work/out/rose/two/as-it-is/2";
  EXPECT_EQ(metrics("out/rose/two/as-it-is/2")["command"], "calibrate");
  EXPECT_TRUE(std::filesystem::exists(run / "mission.yaml"));
  EXPECT_FALSE(std::filesystem::exists(run / "recording"));
  EXPECT_THAT(read_file(folder_ / "work/out/study.md"),
              StartsWith("`cameras.*.rotation_error_deg`, of seed 2."));
  // It is done, though it told no rig.
  const auto when = std::filesystem::last_write_time(run / "metrics.json");
  EXPECT_EQ(panoptes({"trials", "--quiet", "--out", "out"}).status, 1);
  EXPECT_EQ(std::filesystem::last_write_time(run / "metrics.json"), when);

  const Said dataset = panoptes({"calibrate", ".", "--inputs", "list", "--out", "none"});
  EXPECT_EQ(dataset.status, 2);
  EXPECT_THAT(dataset.err, HasSubstr("--inputs is of a mission that is recorded first"));
}

// The whole of it: the sample, and what is said to come of it.
TEST_F(CalibrateMaps, TheSampleGivesTheRigThatIsSaidToComeOfIt) {
  const Said said =
      panoptes({"calibrate", kScenes + "missions/record-sample.yaml", "--quiet", "--out", "rig"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_THAT(said.out, HasSubstr("good: 2 cameras"));
  EXPECT_THAT(said.out, HasSubstr("    not seen: its height\n"));
  const auto m = metrics("rig");
  EXPECT_EQ(m["verdict"], "good");
  EXPECT_EQ(m["reference"], "ahead");
  EXPECT_EQ(m["scale_source"], "odometry");
  const auto& left = m["cameras"]["left"];
  EXPECT_LT(left["rotation_error_deg"], 0.05);
  EXPECT_LT(left["translation_error_m"], 0.005);
  EXPECT_GT(left["shared_points"], 60);
  const auto& off = m["T_body_reference"]["error"];
  for (const std::string angle : {"roll_deg", "pitch_deg"}) {
    EXPECT_LT(std::abs(off[angle].get<double>()), 0.05) << angle;
  }
  EXPECT_LT(std::abs(off["yaw_deg"].get<double>()), 0.15);
  for (const std::string place : {"x_m", "y_m"}) {
    EXPECT_LT(std::abs(off[place].get<double>()), 0.005) << place;
  }
  for (const std::string file : {"rig.png", "matches_ahead_left.png", "reprojection_rig_left.png",
                                 "camchain.yaml", "rig.urdf", "camera_info/left.yaml"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "work/rig" / file)) << file;
  }
  const Said check = panoptes({"check", "rig/rig_calibrated.yaml"});
  EXPECT_EQ(check.status, 0) << check.out << check.err;
  const auto rig_of = [](const std::string& file) { return read_settings<Rig>(file); };
  const Rig found = rig_of(folder_ / "work/rig/rig_calibrated.yaml");
  const Rig expected = rig_of(kScenes + "samples/rig.yaml");
  ASSERT_EQ(expected.cameras.size(), 2U);
  for (const auto& [name, camera] : expected.cameras) {
    const MountingOffset by =
        mounting_offset(camera.T_body_camera, found.cameras.at(name).T_body_camera);
    EXPECT_LT(by.rotation_rad.norm(), deg_to_rad(0.01)) << name;
    EXPECT_LT(by.shift_m.norm(), 0.0005) << name;
  }

  // As the thesis does it, by the same maps: without a metre, and of clocks that are off it says
  // so.
  for (const std::string method : {"thesis", "cycles"}) {
    const std::filesystem::path out = folder_ / "work" / method;
    std::filesystem::create_directories(out);
    for (const std::string map : {"map_ahead.json", "map_left.json"}) {
      std::filesystem::copy_file(folder_ / "work/rig" / map, out / map);
    }
    const Said by_maps = panoptes({"calibrate", "rig/recording", "--method", method, "--seed", "3",
                                   "--quiet", "--out", method});
    EXPECT_EQ(by_maps.status, 0) << by_maps.err;
    EXPECT_EQ(by_maps.err, "");
    EXPECT_THAT(by_maps.out, HasSubstr("2 cameras by their maps; "));
    EXPECT_THAT(by_maps.out, HasSubstr("no metre: lengths are as the rig file has them"));
    const auto told = metrics(method);
    EXPECT_EQ(told["method"], method);
    EXPECT_EQ(told["seed"], 3);
    EXPECT_EQ(told["scale_source"], "rig_file");
    EXPECT_FALSE(told.contains("T_body_reference"));
    EXPECT_LT(told["cameras"]["left"]["rotation_error_deg"], 1);
    EXPECT_NEAR(told["cameras"]["left"]["rotation_deg"],
                told["cameras"]["left"]["true_rotation_deg"].get<double>(), 1);
    EXPECT_GT(told["alignments"][0]["agree"], 2 * told["alignments"][0]["by_chance"].get<int>());
    EXPECT_LT(told["reprojection_rms_px"]["after"], 0.8);
    for (const std::string file : {"matches_ahead_left.png", "reprojection_rig_left.png",
                                   "rig_calibrated.yaml", "camchain.yaml", "rig.urdf"}) {
      EXPECT_TRUE(std::filesystem::exists(out / file)) << file;
    }
  }

  // Without odometry, by the maps that are there.
  const std::filesystem::path work = folder_ / "work";
  std::filesystem::remove(work / "rig/recording/mav0/odom0/data.csv");
  std::filesystem::create_directories(work / "none");
  for (const std::string camera : {"ahead", "left"}) {
    std::filesystem::copy_file(work / ("rig/map_" + camera + ".json"),
                               work / ("none/map_" + camera + ".json"));
  }
  const Said without = panoptes({"calibrate", "rig/recording", "--quiet", "--out", "none"});
  EXPECT_EQ(without.status, 0) << without.err;
  EXPECT_THAT(without.out, HasSubstr("no odometry: how cameras are turned to one another"));
  EXPECT_THAT(without.out, HasSubstr("    not seen: its yaw\n"));
  const auto by_file = metrics("none");
  EXPECT_EQ(by_file["scale_source"], "rig_file");
  EXPECT_FALSE(by_file.contains("wheels"));
  EXPECT_LT(by_file["cameras"]["left"]["rotation_error_deg"], 0.05);
  EXPECT_LT(by_file["cameras"]["left"]["translation_direction_error_deg"], 0.5);
  const Said one =
      panoptes({"calibrate", "rig/recording", "--cameras", "left", "--quiet", "--out", "one"});
  EXPECT_EQ(one.status, 2);
  EXPECT_THAT(one.err, HasSubstr("mav0/odom0/data.csv: is missing, and without odometry one camera "
                                 "alone tells neither"));
}

TEST_F(CalibrateMaps, APlanTellsWhatADriveWillShowAndDrivesNothing) {
  const std::string mission = kScenes + "missions/record-room.yaml";
  const auto plan = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"calibrate", mission, "--plan", "--cameras", "ahead,behind"};
    words.insert(words.end(), more.begin(), more.end());
    return panoptes(words);
  };
  const Said rose = plan({"--out", "plan"});
  EXPECT_EQ(rose.status, 0) << rose.err;
  EXPECT_THAT(rose.out, StartsWith("plan: rose of 7"));
  EXPECT_THAT(rose.out, HasSubstr("  behind: roll 0.0"));
  EXPECT_THAT(rose.out, HasSubstr("    as ahead sees it: 0.0"));
  EXPECT_THAT(rose.out, HasSubstr("    not seen: its height\n"));
  const auto m = metrics("plan");
  EXPECT_EQ(m["stage"], "plan");
  EXPECT_EQ(m["outcome"], "completed");
  EXPECT_EQ(m["reference"], "ahead");
  EXPECT_EQ(m["T_body_reference"]["covariance"].size(), 6);
  EXPECT_EQ(m["cameras"]["behind"]["covariance"].size(), 6);
  EXPECT_GT(m["cameras"]["behind"]["shared_points"], 20);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/plan/recording"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work/plan/rig_calibrated.yaml"));
  EXPECT_EQ(plan({}).out, rose.out);
  EXPECT_NE(plan({"--room", "12x9x4"}).out, rose.out);
  EXPECT_THAT(plan({"--room", "1x1x2"}).out, HasSubstr("it would run into a wall"));

  const Said spin = plan({"--set", "drive.program=sawtooth"});
  EXPECT_EQ(spin.status, 0) << spin.err;
  EXPECT_THAT(spin.out, HasSubstr("    not seen: its yaw\n"));
  EXPECT_THAT(spin.out, HasSubstr("a turn on the spot shows no metre"));
  EXPECT_THAT(plan({"--duration", "10"}).out, HasSubstr("it ends before the program does"));
}

TEST_F(CalibrateMaps, OnlyAProgramCanBePlanned) {
  std::filesystem::create_directories(folder_ / "work/rose");
  const Said dataset = panoptes({"calibrate", "rose", "--plan"});
  EXPECT_EQ(dataset.status, 2);
  EXPECT_THAT(dataset.err, HasSubstr("--plan: rose is a folder, and a drive that is recorded needs "
                                     "no plan: give the file of a mission"));
  const Said explored = panoptes({"calibrate", kScenes + "missions/explore-room.yaml", "--plan"});
  EXPECT_EQ(explored.status, 2);
  EXPECT_THAT(explored.err, HasSubstr("drives by navigator, and only a program is known before"));
  const std::string mission = kScenes + "missions/record-room.yaml";
  const Said room = panoptes({"calibrate", mission, "--plan", "--room", "5x5"});
  EXPECT_EQ(room.status, 2);
  EXPECT_THAT(room.err, HasSubstr("--room 5x5: must be LENGTHxWIDTHxHEIGHT in metres"));
  const Said nobody = panoptes({"calibrate", mission, "--plan", "--cameras", "up"});
  EXPECT_EQ(nobody.status, 2);
  EXPECT_THAT(nobody.err, HasSubstr("the rig has no camera up"));
  const Said nowhere = panoptes({"calibrate", mission});
  EXPECT_EQ(nowhere.status, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("--out is required"));
}

TEST_F(CalibrateMaps, OneThingAtATimeIsAsked) {
  EXPECT_EQ(panoptes({"calibrate", "x", "--out", "y"}).status, 2);
  EXPECT_EQ(
      panoptes({"calibrate", "x", "--stage", "maps", "--board", "9x6x0.025", "--out", "y"}).status,
      2);
  const Said said = panoptes({"calibrate", "x", "--stage", "maps", "--out", "y"});
  EXPECT_EQ(said.status, 2);
}

}  // namespace
}  // namespace panoptes
