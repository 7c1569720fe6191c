// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/map_server.h"

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using MapServer = ScratchTest;

/// 3 x 2: below free, unknown, occupied; above unknown, free, free.
OccupancyMap small_map() {
  OccupancyMap map;
  map.cell_m = 0.01;
  map.origin = {-1.25, 0.1};
  map.columns = 3;
  map.rows = 2;
  map.cells = {Cell::kFree,    Cell::kUnknown, Cell::kOccupied,
               Cell::kUnknown, Cell::kFree,    Cell::kFree};
  return map;
}

std::string message_of(const std::filesystem::path& yaml) {
  try {
    read_map_server(yaml);
  } catch (const std::exception& e) {
    return e.what();
  }
  return "no error";
}

TEST_F(MapServer, WritesWhatRosReads) {
  write_map_server(folder_ / "map", small_map());
  EXPECT_EQ(read_file(folder_ / "map.yaml"),
            "image: map.pgm\nmode: trinary\nresolution: 0.01\norigin: [-1.25, 0.1, 0]\n"
            "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  // the top row comes first
  EXPECT_EQ(read_file(folder_ / "map.pgm"),
            std::string("P5\n3 2\n255\n\xCD\xFE\xFE\xFE\xCD\0", 17));
}

TEST_F(MapServer, NothingMappedIsOneUnknownCell) {
  write_map_server(folder_ / "map", OccupancyMap());
  EXPECT_EQ(read_file(folder_ / "map.pgm"), "P5\n1 1\n255\n\xCD");
  EXPECT_EQ(read_map_server(folder_ / "map.yaml").cells, std::vector<Cell>{Cell::kUnknown});
}

TEST_F(MapServer, ReadsBackWhatItWrote) {
  const OccupancyMap map = small_map();
  write_map_server(folder_ / "map", map);
  const OccupancyMap back = read_map_server(folder_ / "map.yaml");
  EXPECT_EQ(back.cell_m, map.cell_m);
  EXPECT_EQ(back.origin, map.origin);
  EXPECT_EQ(back.columns, map.columns);
  EXPECT_EQ(back.rows, map.rows);
  EXPECT_EQ(back.cells, map.cells);
}

TEST_F(MapServer, ObeysTheYamlsOwnThresholds) {
  const cv::Mat grey = (cv::Mat_<unsigned char>(1, 4) << 0, 100, 205, 255);
  cv::imwrite((folder_ / "grey.png").string(), grey);
  // occupancy 1, 0.61, 0.196, 0
  const auto read = [&](const std::string& rest) {
    write_file(folder_ / "m.yaml", "image: grey.png\nresolution: 0.05\norigin: [0, 0, 0]\n" + rest);
    return read_map_server(folder_ / "m.yaml").cells;
  };
  using testing::ElementsAre;
  EXPECT_THAT(read("occupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n"),
              ElementsAre(Cell::kOccupied, Cell::kUnknown, Cell::kUnknown, Cell::kFree));
  EXPECT_THAT(read("occupied_thresh: 0.6\nfree_thresh: 0.25\nnegate: 0\n"),
              ElementsAre(Cell::kOccupied, Cell::kOccupied, Cell::kFree, Cell::kFree));
  EXPECT_THAT(read("occupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 1\n"),
              ElementsAre(Cell::kFree, Cell::kUnknown, Cell::kOccupied, Cell::kOccupied));
}

TEST_F(MapServer, SaysWhereTheYamlIsWrong) {
  const std::string path = (folder_ / "m.yaml").string();
  const auto message = [&](const std::string& text) {
    write_file(path, text);
    return message_of(path);
  };
  const std::string good =
      "image: a.pgm\norigin: [0, 0, 0]\nfree_thresh: 0.2\noccupied_thresh: 0.6\n";
  EXPECT_EQ(message(good), path + ":1:1: resolution: is missing");
  EXPECT_EQ(message(good + "resolution: fine\n"), path + ":5:13: resolution: has the wrong type");
  EXPECT_EQ(message(good + "resolution: -1\n"),
            path + ":5:13: resolution: must be at least 0.001 and less than 10 metres, got -1");
  EXPECT_EQ(message("image: a.pgm\norigin: [0, 0]\nresolution: 0.1\n"),
            path + ":2:9: origin: must be [x, y, yaw], three numbers; got 2");
  EXPECT_EQ(message(good + "resolution: 0.1\nmode: row\n"),
            path + ":6:7: mode: must be trinary, scale or raw, got row");
  EXPECT_EQ(message(good + "resolution: 0.1\n"),
            (folder_ / "a.pgm").string() + ": cannot be opened: No such file or directory");
  write_file(folder_ / "a.pgm", "no picture");
  EXPECT_EQ(message(good + "resolution: 0.1\n"),
            (folder_ / "a.pgm").string() +
                ": is not a picture that can be read; save it again as PNG or JPEG");
}

}  // namespace
}  // namespace panoptes
