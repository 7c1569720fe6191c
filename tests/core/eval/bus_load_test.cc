// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/bus_load.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Size {
  int width_px;
  int height_px;
};
constexpr Size kSizes[] = {{320, 240}, {640, 480}, {800, 600}, {1024, 768}, {1280, 960}};
constexpr double kRates_hz[] = {3.75, 7.5, 15, 30};

std::vector<CameraStream> streams(int cameras, Size size, double rate_hz, int bits_per_px = 24) {
  return {static_cast<std::size_t>(cameras), {size.width_px, size.height_px, bits_per_px, rate_hz}};
}

// Table 3.1, by rate and then by 2, 3 and 4 cameras.
constexpr double kTable_mbit_per_s[12][5] = {
    {13.824, 55.296, 86.4, 141.558, 221.184},       {20.736, 82.944, 129.6, 212.337, 331.776},
    {27.648, 110.592, 172.8, 283.116, 442.368},     {27.648, 110.592, 172.8, 283.116, 442.368},
    {41.472, 165.888, 259.2, 424.673, 663.552},     {55.296, 221.184, 345.6, 566.231, 884.736},
    {55.296, 221.184, 345.6, 566.231, 884.736},     {82.944, 331.776, 518.4, 849.347, 1327.104},
    {110.592, 442.368, 691.2, 1132.462, 1769.472},  {110.592, 442.368, 691.2, 1132.462, 1769.472},
    {165.888, 663.552, 1036.8, 1698.693, 2654.208}, {221.184, 884.736, 1382.4, 2264.924, 3538.944}};

TEST(PixelRate, IsThatOfTable31) {
  constexpr double kThreeDigits = 1.001e-3;  // some are rounded, some are cut
  int exceeded = 0;
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 5; ++column) {
      const double told =
          pixel_mbit_per_s(streams(2 + row % 3, kSizes[column], kRates_hz[row / 3]));
      EXPECT_NEAR(told, kTable_mbit_per_s[row][column], kThreeDigits) << row << " " << column;
      exceeded += told > 800 ? 1 : 0;
    }
  }
  EXPECT_EQ(exceeded, 15);  // red in the thesis
}

TEST(FireWire, RefusesWhatTheTableLetsPass) {
  struct Cell {
    double rate_hz;
    int cameras;
    Size size;
    double units;
  };
  for (const Cell& cell : {Cell{7.5, 3, {1280, 960}, 5202}, Cell{15, 4, {800, 600}, 5424},
                           Cell{30, 2, {800, 600}, 5412}, Cell{30, 3, {640, 480}, 5202}}) {
    const auto sent = streams(cell.cameras, cell.size, cell.rate_hz);
    EXPECT_LT(pixel_mbit_per_s(sent), 800);
    const BusLoad load = bus_load({}, sent);
    EXPECT_EQ(load.load, cell.units);
    EXPECT_FALSE(load.fits());
  }
  // and no other cell of the table that is not red
  int refused = 0;
  for (const double rate_hz : kRates_hz) {
    for (int cameras = 2; cameras <= 4; ++cameras) {
      for (const Size& size : kSizes) {
        const auto sent = streams(cameras, size, rate_hz);
        refused += pixel_mbit_per_s(sent) <= 800 && !bus_load({}, sent).fits() ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(refused, 4);
}

TEST(FireWire, NeedsMoreInFixedModes) {
  const BusOptions fixed{BusKind::kFireWire800, true, 8};
  for (const auto& sent : {streams(4, {1024, 768}, 7.5), streams(2, {1024, 768}, 15)}) {
    EXPECT_TRUE(bus_load({}, sent).fits());
    EXPECT_FALSE(bus_load(fixed, sent).fits());
  }
}

TEST(FireWire, CarriesRawPictures) {
  EXPECT_EQ(bus_load({}, streams(1, {1280, 960}, 15, 8)).load, 1158);
  EXPECT_EQ(bus_load({}, streams(1, {640, 480}, 30, 8)).load, 582);
  EXPECT_TRUE(bus_load({}, streams(4, {1280, 960}, 15, 8)).fits());
  EXPECT_TRUE(bus_load({}, streams(8, {640, 480}, 30, 8)).fits());
  EXPECT_TRUE(bus_load({}, streams(2, {1280, 960}, 30, 8)).fits());
  EXPECT_FALSE(bus_load({}, streams(5, {1280, 960}, 15, 8)).fits());
}

TEST(FireWire, SaysWhatIsTooMuch) {
  const BusOptions card{BusKind::kFireWire800, false, 4};
  EXPECT_THAT(bus_load(card, streams(5, {320, 240}, 15, 8)).faults,
              ElementsAre("5 cameras are more than the 4 that the host's card receives from at "
                          "once"));
  EXPECT_THAT(bus_load({}, streams(1, {1280, 960}, 30)).faults,
              ElementsAre(HasSubstr("needs packets of 13824 bytes, and the largest are 8192"),
                          "6918 of 4915 allocation units are taken"));
  // half the speed: each quadlet takes twice as long
  const BusOptions s400{BusKind::kFireWire400, false, 8};
  EXPECT_EQ(bus_load(s400, streams(1, {640, 480}, 30, 8)).load, 1164);
}

TEST(GigabitEthernet, CarriesFourAtFullRate) {
  const BusOptions gige{BusKind::kGigabitEthernet, false, 8};
  EXPECT_NEAR(bus_load(gige, streams(1, {640, 480}, 30)).load, 221.184, 1e-9);
  EXPECT_TRUE(bus_load(gige, streams(4, {640, 480}, 30)).fits());
  EXPECT_FALSE(bus_load(gige, streams(5, {640, 480}, 30)).fits());
}

TEST(Streams, AreOfCamerasThatRunByThemselves) {
  Rig rig;
  rig.cameras["a"].intrinsics = pinhole(640, 480, 1);
  rig.cameras["a"].rate_hz = 30;
  rig.cameras["b"].intrinsics = pinhole(320, 240, 1);
  rig.cameras["b"].rate_hz = 0;
  const auto sent = streams_of(rig, 8);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].width_px, 640);
  EXPECT_NEAR(pixel_mbit_per_s(sent), 73.728, 1e-9);
}

}  // namespace
}  // namespace panoptes
