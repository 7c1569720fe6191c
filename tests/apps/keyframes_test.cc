// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/keyframes.h"

#include <cstdint>
#include <cstring>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "core/io/csv.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

// A picture's points on a diagonal, a quarter of a pixel off; each descriptor holds its number.
LocalFeatures points(int count) {
  LocalFeatures features;
  features.descriptors = cv::Mat(count, 32, CV_8U);
  for (int i = 0; i < count; ++i) {
    features.px.emplace_back(static_cast<float>(i) + 0.25F, static_cast<float>(i) + 0.5F);
    features.descriptors.row(i).setTo(i % 256);
  }
  return features;
}

KeptKeyframe keyframe(int number) {
  KeptKeyframe made;
  made.stamp = time_at(number);
  made.T_map_keyframe = {1.5, -2, deg_to_rad(90)};
  made.place.signature.cumulative[7] = 0.25F;
  made.place.features = {points(3), points(1000)};
  GridCrop grid;
  grid.cell_m = 0.01;
  grid.first_row = -1;
  grid.rows = {{2, 4, 0}, {0, 0, 2}, {5, 6, 2}};
  grid.cells = {10, -20, 100};
  made.grid = std::make_shared<const GridCrop>(grid);
  return made;
}

int number_16(const std::string& bytes, std::size_t at) {
  return static_cast<std::uint8_t>(bytes[at]) + 256 * static_cast<std::uint8_t>(bytes[at + 1]);
}

class Keyframes : public ScratchTest {};

TEST_F(Keyframes, LieAsDescribed) {
  write_keyframes(folder_, {keyframe(0), keyframe(1)});
  const auto folder = folder_ / "keyframes";
  const CsvTable table = read_csv(folder / "keyframes.csv");
  ASSERT_EQ(table.rows.size(), 2U);
  const auto& row = table.rows[1];
  EXPECT_THAT(std::vector<std::string>(row.begin(), row.begin() + 10),
              testing::ElementsAre("1", "1", "1.5", "-2", "90", "3", "240", "0.01", "2", "-1"));

  const std::string signatures = read_file(folder / "signatures.bin");
  ASSERT_EQ(signatures.size(), 2U * 256 * 4);
  float share = 0;
  std::memcpy(&share, signatures.data() + 4 * (256 + 7), 4);
  EXPECT_EQ(share, 0.25F);

  const std::string features = read_file(folder / "features.bin");
  ASSERT_EQ(features.size(), 2U * (3 + 240) * 36);
  EXPECT_EQ(number_16(features, 36), 10);      // the second point's x: 1.25 pixels
  EXPECT_EQ(number_16(features, 36 + 2), 12);  // and y: 1.5
  EXPECT_EQ(features.substr(36 + 4, 32), std::string(32, 1));
  EXPECT_EQ(number_16(features, features.size() - 36), 8 * (239 * 1000 / 240) + 2);  // of all sizes

  const std::string maps = read_file(folder / "maps.bin");
  const auto bytes = static_cast<std::size_t>(std::stoi(row[10]));
  ASSERT_EQ(maps.size(), 2 * bytes);
  const cv::Mat picture =
      cv::imdecode(std::vector<char>(maps.begin() + bytes, maps.end()), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.size(), cv::Size(4, 3));
  const cv::Mat expected =
      (cv::Mat_<std::uint8_t>(3, 4) << 128, 128, 128, 228, 128, 128, 128, 128, 138, 108, 128, 128);
  EXPECT_EQ(cv::norm(picture, expected, cv::NORM_INF), 0);
}

TEST_F(Keyframes, OfNoFloorSeenAndNoPointsFoundAreKeptToo) {
  KeptKeyframe bare = keyframe(0);
  bare.place.features = {};
  bare.grid = std::make_shared<const GridCrop>();
  write_keyframes(folder_, {bare});
  EXPECT_TRUE(read_file(folder_ / "keyframes" / "features.bin").empty());
  EXPECT_EQ(read_csv(folder_ / "keyframes" / "keyframes.csv").rows.size(), 1U);
}

}  // namespace
}  // namespace panoptes
