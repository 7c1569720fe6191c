// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/run_app.h"
#include "core/io/csv.h"
#include "core/io/file.h"
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
      cv::imwrite(file("p/" + std::to_string(i + 1) + ".jpg"),
                  wall_picture(i % kLap * kWallStep_px, Rng(1).fork(std::to_string(i))));
    }
  }
  int loops(std::vector<std::string> words) {
    words.insert(words.begin(), {"panoptes", "loops"});
    words.insert(words.end(), {"--out", file("out")});
    std::vector<const char*> argv;
    for (const std::string& word : words) {
      argv.push_back(word.c_str());
    }
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status = run_app(static_cast<int>(argv.size()), argv.data());
    out_ = testing::internal::GetCapturedStdout();
    err_ = testing::internal::GetCapturedStderr();
    return status;
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  json metrics() const { return json::parse(read_file(folder_ / "out/metrics.json")); }

  std::string out_;
  std::string err_;
};

TEST_F(Loops, FindsTheSecondLapInOrderOfNumbers) {
  write_laps();
  std::string pairs = "picture,earlier\n";
  for (int i = 0; i < kLap; ++i) {
    pairs += std::to_string(i + kLap) + "," + std::to_string(i + 1) + ".jpg\n";
  }
  write_file(file("pairs.csv"), pairs);
  EXPECT_EQ(loops({file("p"), "--truth", file("pairs.csv")}), 0) << err_;
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
  EXPECT_GT(std::filesystem::file_size(file("out/loops.png")), 1000U);
}

TEST_F(Loops, TakesATruthOfPixelsAndCountsNoGreyOnes) {
  write_laps();
  cv::Mat truth(2 * kLap, 2 * kLap, CV_8U, cv::Scalar(0));
  for (int i = 0; i < kLap; ++i) {
    truth.at<std::uint8_t>(i + kLap, i) = i % 2 == 0 ? 255 : 100;  // the lower half alone
  }
  cv::imwrite(file("truth.png"), truth);
  EXPECT_EQ(loops({file("p"), "--truth", file("truth.png"), "--quiet"}), 0) << err_;
  EXPECT_EQ(metrics()["truth"]["revisits"], kLap / 2);
  EXPECT_EQ(metrics()["truth"]["wrong"], 0);
  EXPECT_GE(metrics()["truth"]["not_counted"], kLap / 2 - 1);
}

TEST_F(Loops, RefusesWhatItCannotUseWithStatus2AndWritesNothing) {
  write_laps();
  const auto refused = [&](std::vector<std::string> words, const std::string& what) {
    EXPECT_EQ(loops(std::move(words)), 2) << what;
    EXPECT_THAT(err_, HasSubstr(what));
    EXPECT_FALSE(std::filesystem::exists(file("out")));
  };
  refused({file("no")}, file("no") + ": no such picture or folder");
  refused({file("p"), file("no")}, file("no") + ": no such picture or folder");
  refused({file("p/1.jpg")}, file("p/1.jpg") + ": is one picture; give all that the camera took");
  std::filesystem::create_directories(folder_ / "empty");
  refused({file("empty")}, file("empty") + ": holds no pictures; name a folder of PNG or JPEG");
  write_file(file("bad.png"), "no picture");
  refused({file("p"), file("bad.png")}, file("bad.png") + ": is not a picture");
  cv::imwrite(file("z.png"), cv::Mat(100, 100, CV_8U, cv::Scalar(9)));
  refused({file("p"), file("z.png")}, "z.png: is 100 x 100 pixels and others are 320 x 240");
  cv::imwrite(file("a.png"), cv::Mat(20, 20, CV_8U, cv::Scalar(9)));
  refused({file("a.png"), file("p")}, file("a.png") + ": is 20 x 20 pixels; 48 are needed");
  refused({file("p"), "--truth", file("none.csv")}, file("none.csv") + ": no such file");
  refused({file("p"), "--truth", file("z.png")},
          file("z.png") + ": is 100 x 100 pixels and there are 32 pictures");
  write_file(file("t.csv"), "picture,earlier\n20,99\n7.jpg,x.jpg\n");
  refused({file("p"), "--truth", file("t.csv")}, file("t.csv") + ":2: earlier: 99 is no picture");
  EXPECT_THAT(err_, HasSubstr(file("t.csv") + ":3: earlier: x.jpg is no picture"));
  write_file(file("t.csv"), "a,b\n1,2\n");
  refused({file("p"), "--truth", file("t.csv")},
          "give a table that begins with the line picture,earlier");
}

}  // namespace
}  // namespace panoptes
