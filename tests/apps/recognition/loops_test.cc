// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/io/csv.h"
#include "core/io/file.h"
#include "tests/support/run_here.h"
#include "tests/support/scratch.h"
#include "tests/support/wall_pictures.h"

namespace panoptes {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr int kLap = 16;

class Loops : public ScratchTest {
 protected:
  // Two laps, named so that the order of letters is not that of numbers.
  void write_laps() {
    std::filesystem::create_directories(folder_ / "p");
    for (int i = 0; i < 2 * kLap; ++i) {
      cv::imwrite(path("p/" + std::to_string(i + 1) + ".jpg"),
                  wall_picture(i % kLap * kWallStep_px, Rng(1).fork(std::to_string(i))));
    }
  }
  Said loops(std::vector<std::string> words) {
    words.insert(words.begin(), "loops");
    words.insert(words.end(), {"--out", path("out")});
    return run_here(std::move(words));
  }
  json metrics() const { return json::parse(read_file(folder_ / "out/metrics.json")); }
};

TEST_F(Loops, FindsTheSecondLapInOrderOfNumbers) {
  write_laps();
  std::string pairs = "picture,earlier\n";
  for (int i = 0; i < kLap; ++i) {
    pairs += std::to_string(i + kLap) + "," + std::to_string(i + 1) + ".jpg\n";
  }
  write_file(path("pairs.csv"), pairs);
  const Said said = loops({path("p"), "--truth", path("pairs.csv")});
  EXPECT_EQ(said.status, 0) << said.err;
  const json m = metrics();
  EXPECT_EQ(m["schema"], "panoptes.metrics/1");
  EXPECT_EQ(m["command"], "loops");
  EXPECT_EQ(m["pictures"], 2 * kLap);
  EXPECT_EQ(m["truth"]["revisits"], kLap);
  EXPECT_EQ(m["truth"]["precision"], 1);
  EXPECT_GE(m["truth"]["recall"], 0.9);
  EXPECT_GT(m["timing_cpu_ms"]["query"], 0);
  const CsvTable table = read_csv(folder_ / "out/loops.csv");
  ASSERT_EQ(table.rows.size(), static_cast<std::size_t>(2 * kLap));
  EXPECT_EQ(table.rows[9][table.column("picture")], "10.jpg");
  EXPECT_GT(std::filesystem::file_size(path("out/loops.png")), 1000U);
}

TEST_F(Loops, LeavesOutAndNamesPicturesThatShowNothing) {
  write_laps();
  cv::imwrite(path("p/10b.png"), cv::Mat(240, 320, CV_8U, cv::Scalar(180)));
  cv::imwrite(path("p/20b.png"), cv::Mat(240, 320, CV_8U, cv::Scalar(255)));
  std::string pairs = "picture,earlier\n";
  for (int i = 1; i <= kLap; ++i) {
    pairs += std::to_string(i + kLap) + ".jpg," + std::to_string(i) + ".jpg\n";
  }
  write_file(path("pairs.csv"), pairs);
  const Said said = loops({path("p"), "--truth", path("pairs.csv")});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.err,
              HasSubstr("2 of 34 pictures show nothing and are left out: 10b.png (blank), "
                        "20b.png (over-exposed)\n"));
  const json m = metrics();
  EXPECT_EQ(m["showing_nothing"]["blank"], 1);
  EXPECT_EQ(m["showing_nothing"]["over-exposed"], 1);
  EXPECT_EQ(m["showing_nothing"]["blurred"], 0);
  EXPECT_GE(m["truth"]["recall"], 0.9);
  EXPECT_EQ(m["truth"]["wrong"], 0);
  const CsvTable table = read_csv(folder_ / "out/loops.csv");
  EXPECT_EQ(table.rows[10][table.column("verdict")], "shows nothing: blank");
}

TEST_F(Loops, TakesATruthOfPixelsAndCountsNoGreyOnes) {
  write_laps();
  cv::Mat truth(2 * kLap, 2 * kLap, CV_8U, cv::Scalar(0));
  for (int i = 0; i < kLap; ++i) {
    truth.at<std::uint8_t>(i + kLap, i) = i % 2 == 0 ? 255 : 100;  // the lower half alone
  }
  cv::imwrite(path("truth.png"), truth);
  const Said said = loops({path("p"), "--truth", path("truth.png"), "--quiet"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_EQ(metrics()["truth"]["revisits"], kLap / 2);
  EXPECT_EQ(metrics()["truth"]["wrong"], 0);
  EXPECT_GE(metrics()["truth"]["not_counted"], kLap / 2 - 1);
}

TEST_F(Loops, RefusesWhatItCannotUseWithStatus2AndWritesNothing) {
  write_laps();
  const auto refused = [&](std::vector<std::string> words, const std::string& what) {
    const Said said = loops(std::move(words));
    EXPECT_EQ(said.status, 2) << what;
    EXPECT_THAT(said.err, HasSubstr(what));
    EXPECT_FALSE(std::filesystem::exists(path("out")));
    return said.err;
  };
  refused({path("no")}, path("no") + ": no such picture or folder");
  refused({path("p"), path("no")}, path("no") + ": no such picture or folder");
  refused({path("p/1.jpg")}, path("p/1.jpg") + ": is one picture; give all that the camera took");
  std::filesystem::create_directories(folder_ / "empty");
  refused({path("empty")}, path("empty") + ": holds no pictures; name a folder of PNG or JPEG");
  write_file(path("bad.png"), "no picture");
  refused({path("p"), path("bad.png")}, path("bad.png") + ": is not a picture");
  cv::imwrite(path("z.png"), cv::Mat(100, 100, CV_8U, cv::Scalar(9)));
  refused({path("p"), path("z.png")}, "z.png: is 100 x 100 pixels and others are 320 x 240");
  cv::imwrite(path("a.png"), cv::Mat(20, 20, CV_8U, cv::Scalar(9)));
  refused({path("a.png"), path("p")}, path("a.png") + ": is 20 x 20 pixels; 48 are needed");
  refused({path("p"), "--truth", path("none.csv")}, path("none.csv") + ": no such file");
  refused({path("p"), "--truth", path("z.png")},
          path("z.png") + ": is 100 x 100 pixels and there are 32 pictures");
  write_file(path("t.csv"), "picture,earlier\n20,99\n7.jpg,x.jpg\n");
  const std::string err = refused({path("p"), "--truth", path("t.csv")},
                                  path("t.csv") + ":2: earlier: 99 is no picture");
  EXPECT_THAT(err, HasSubstr(path("t.csv") + ":3: earlier: x.jpg is no picture"));
  write_file(path("t.csv"), "a,b\n1,2\n");
  refused({path("p"), "--truth", path("t.csv")},
          "give a table that begins with the line picture,earlier");
}

}  // namespace
}  // namespace panoptes
