// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/keyframe_files.h"

#include <cstdint>
#include <cstring>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using testing::StartsWith;

constexpr const char* kCure = "; copy the whole run again or repeat it";

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

KeptKeyframe keyframe(int number, int back_points = 1000) {
  KeptKeyframe made;
  made.stamp = time_at(number);
  made.T_map_keyframe = {1.5, -2, deg_to_rad(90)};
  made.place.signature.grid = true;
  made.place.signature.cumulative.resize(signature_shares(true, 2));
  made.place.signature.cumulative[7] = 0.25F;
  made.place.features = {points(3), points(back_points)};
  GridCrop grid;
  grid.cell_m = 0.01;
  grid.first_row = -1;
  grid.rows = {{2, 4, 0}, {0, 0, 2}, {5, 6, 2}};
  grid.cells = {10, -20, 100};
  made.grid = std::make_shared<const GridCrop>(grid);
  return made;
}

KeptKeyframes kept(std::vector<KeptKeyframe> keyframes) {
  KeptKeyframes all;
  all.all = std::move(keyframes);
  return all;
}

int number_16(const std::string& bytes, std::size_t at) {
  return static_cast<std::uint8_t>(bytes[at]) + 256 * static_cast<std::uint8_t>(bytes[at + 1]);
}

std::string said_of(const KeyframeFiles& files) {
  try {
    parse_keyframes("run", files);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

class KeyframeFolder : public ScratchTest {};

TEST_F(KeyframeFolder, LiesAsDescribed) {
  write_keyframes(folder_, kept({keyframe(0), keyframe(1)}));
  const auto folder = folder_ / "keyframes";
  const CsvTable table = read_csv(folder / "keyframes.csv");
  ASSERT_EQ(table.rows.size(), 2U);
  const auto& row = table.rows[1];
  EXPECT_THAT(
      std::vector<std::string>(row.begin(), row.begin() + 11),
      testing::ElementsAre("1", "1", "1.5", "-2", "90", "grid", "3", "240", "0.01", "2", "-1"));

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
  const auto bytes = static_cast<std::size_t>(std::stoi(row[11]));
  ASSERT_EQ(maps.size(), 2 * bytes);
  const cv::Mat picture =
      cv::imdecode(std::vector<char>(maps.begin() + bytes, maps.end()), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.size(), cv::Size(4, 3));
  const cv::Mat expected =
      (cv::Mat_<std::uint8_t>(3, 4) << 128, 128, 128, 228, 128, 128, 128, 128, 138, 108, 128, 128);
  EXPECT_EQ(cv::norm(picture, expected, cv::NORM_INF), 0);
}

TEST_F(KeyframeFolder, IsReadBack) {
  KeptKeyframe mosaic = keyframe(1, 0);
  mosaic.place.signature.grid = false;
  write_keyframes(folder_, kept({keyframe(0, 100), mosaic}));
  const std::vector<KeptKeyframe> read = read_keyframes(folder_).all;
  ASSERT_EQ(read.size(), 2U);
  const KeptKeyframe wanted = keyframe(0, 100);
  EXPECT_EQ(read[0].stamp, wanted.stamp);
  EXPECT_EQ(read[0].T_map_keyframe, wanted.T_map_keyframe);
  EXPECT_EQ(read[0].place.signature.cumulative, wanted.place.signature.cumulative);
  EXPECT_TRUE(read[0].place.signature.grid);
  EXPECT_FALSE(read[1].place.signature.grid);
  for (int camera = 0; camera < 2; ++camera) {
    EXPECT_EQ(read[0].place.features[camera].px, wanted.place.features[camera].px);
    EXPECT_EQ(cv::norm(read[0].place.features[camera].descriptors,
                       wanted.place.features[camera].descriptors, cv::NORM_INF),
              0);
  }
  EXPECT_TRUE(read[1].place.features[1].px.empty());
  EXPECT_TRUE(read[1].place.features[1].descriptors.empty());
  EXPECT_EQ(read[0].grid->cell_m, wanted.grid->cell_m);
  for (int row = -3; row < 4; ++row) {
    for (int column = 0; column < 8; ++column) {
      EXPECT_EQ(read[0].grid->at(column, row), wanted.grid->at(column, row))
          << column << " " << row;
    }
  }
}

TEST_F(KeyframeFolder, KeepsAsManyPicturesAsThereAreLoopCameras) {
  KeptKeyframes three = kept({keyframe(0, 2), keyframe(1, 4)});
  three.looks.push_back("left");
  three.all[0].place.features.push_back(points(5));
  three.all[1].place.features.emplace_back();
  for (KeptKeyframe& keyframe : three.all) {
    keyframe.place.signature.cumulative.resize(signature_shares(true, 3));
  }
  write_keyframes(folder_, three);
  const KeptKeyframes read = read_keyframes(folder_);
  EXPECT_THAT(read.looks, testing::ElementsAre("front", "back", "left"));
  ASSERT_EQ(read.all.size(), 2U);
  EXPECT_EQ(read.all[0].place.features[2].px, points(5).px);
  EXPECT_TRUE(read.all[1].place.features[2].px.empty());
  EXPECT_EQ(read.all[1].place.features[1].px.size(), 4U);
  EXPECT_EQ(read_csv(folder_ / "keyframes" / "keyframes.csv").columns.size(), 14U);
}

TEST_F(KeyframeFolder, OfNoFloorSeenAndNoPointsFoundIsKeptToo) {
  KeptKeyframe bare = keyframe(0);
  bare.place.features = {{}, {}};
  bare.grid = std::make_shared<const GridCrop>();
  write_keyframes(folder_, kept({bare}));
  EXPECT_TRUE(read_file(folder_ / "keyframes" / "features.bin").empty());
  EXPECT_EQ(read_keyframes(folder_).all.size(), 1U);
}

TEST_F(KeyframeFolder, OfNoKeyframesIsReadBack) {
  write_keyframes(folder_, {});
  EXPECT_TRUE(read_keyframes(folder_).all.empty());
}

TEST_F(KeyframeFolder, TakesLittleRoomHoweverMuchIsSeen) {
  constexpr std::size_t kMost_bytes = 60'000;  // of signature and features a keyframe
  KeptKeyframe full = keyframe(0);
  full.place.features = {points(5000), points(5000)};
  const KeyframeFiles files = keyframe_files(kept({full}));
  EXPECT_LE(files.signatures.size() + files.features.size(), kMost_bytes);
}

TEST_F(KeyframeFolder, ThatLacksAFileIsRefused) {
  for (const char* name : {"keyframes.csv", "signatures.bin", "features.bin", "maps.bin"}) {
    write_keyframes(folder_, kept({keyframe(0)}));
    const auto file = folder_ / "keyframes" / name;
    std::filesystem::remove(file);
    try {
      read_keyframes(folder_);
      FAIL() << name;
    } catch (const ConfigError& error) {
      EXPECT_EQ(error.what(), file.string() + ": no such file" + kCure);
    }
  }
}

TEST(KeyframeFiles, SayWhatIsWrongWithThem) {
  const KeyframeFiles good = keyframe_files(kept({keyframe(0, 2), keyframe(1, 2)}));
  EXPECT_EQ(said_of(good), "");
  KeyframeFiles bad = good;
  bad.signatures.resize(1500);
  EXPECT_EQ(said_of(bad),
            "run/signatures.bin: byte 1500: the file ends 548 bytes before the keyframe that "
            "keyframes.csv tells of" +
                std::string(kCure));
  bad = good;
  bad.features += "more";
  EXPECT_EQ(said_of(bad),
            "run/features.bin: byte 360: goes on after the last keyframe that keyframes.csv tells "
            "of" +
                std::string(kCure));
  bad = good;
  bad.table.resize(bad.table.find('\n') + 1 +
                   bad.table.substr(bad.table.find('\n') + 1).find('\n') + 1);
  EXPECT_THAT(said_of(bad), StartsWith("run/signatures.bin: byte 1024: goes on after"));
  bad = good;
  bad.table.pop_back();
  EXPECT_EQ(said_of(bad), "run/keyframes.csv:3: the line was cut off" + std::string(kCure));
  bad = good;
  bad.table.replace(0, 8, "key");
  EXPECT_EQ(said_of(bad),
            "run/keyframes.csv:1: other columns than this version keeps; repeat the run with it");
  bad = good;
  bad.table.replace(bad.table.find(",1.5,"), 5, ",nan,");
  EXPECT_EQ(said_of(bad),
            "run/keyframes.csv:2: x_m: is not a number from -1e+09 to 1e+09" + std::string(kCure));
  bad = good;
  bad.table.replace(bad.table.find("grid"), 4, "grey");
  EXPECT_EQ(said_of(bad),
            "run/keyframes.csv:2: signature: is neither grid nor mosaic" + std::string(kCure));
  bad = good;
  bad.signatures[3] = '\x7f';
  EXPECT_EQ(said_of(bad),
            "run/signatures.bin: byte 0: is no share from 0 to 1" + std::string(kCure));
  bad = good;
  bad.maps[bad.maps.size() / 2] = 'x';
  EXPECT_EQ(said_of(bad), "run/maps.bin: byte " + std::to_string(good.maps.size() / 2) +
                              ": the map of keyframe 1 is no PNG" + kCure);
  bad = good;
  bad.features[10] = 'x';
  EXPECT_EQ(said_of(bad),
            "run/keyframes.csv:2: crc32: says otherwise than the keyframe's bytes in this table, "
            "signatures.bin, features.bin and maps.bin" +
                std::string(kCure));
}

TEST(KeyframeFiles, AreRefusedCutAnywhereOrWithAnyBitTurned) {
  const KeyframeFiles good = keyframe_files(kept({keyframe(0, 2), keyframe(1, 2)}));
  for (std::string KeyframeFiles::*file : {&KeyframeFiles::table, &KeyframeFiles::signatures,
                                           &KeyframeFiles::features, &KeyframeFiles::maps}) {
    for (std::size_t at = 0; at < (good.*file).size(); ++at) {
      KeyframeFiles bad = good;
      (bad.*file).resize(at);
      EXPECT_NE(said_of(bad), "") << at;
      bad = good;
      (bad.*file)[at] = static_cast<char>((bad.*file)[at] ^ (1 << at % 8));
      EXPECT_NE(said_of(bad), "") << at;
    }
  }
}

}  // namespace
}  // namespace panoptes
