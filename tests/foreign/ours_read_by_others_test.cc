// SPDX-License-Identifier: BSD-3-Clause
// What we write, read by a few lines that share nothing with us: as somebody's script would.
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numbers>
#include <sstream>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <yaml-cpp/yaml.h>

#include "apps/report/recorder.h"
#include "core/geometry/pose3.h"
#include "core/io/csv.h"
#include "core/io/dataset_writer.h"
#include "core/io/g2o.h"
#include "core/io/keyframe_files.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"
#include "tests/support/floor_plan.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kRoundoff = 1e-12;  // of what is written to the last digit
constexpr double kPi = std::numbers::pi;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream in(file);
  EXPECT_TRUE(in) << file;
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
  }
  return lines;
}

std::vector<std::string> naive_split(const std::string& line, char at = ',') {
  std::istringstream in(line);
  std::vector<std::string> fields;
  for (std::string field; std::getline(in, field, at);) {
    fields.push_back(field);
  }
  if (!line.empty() && line.back() == at) {
    fields.emplace_back();
  }
  return fields;
}

// As spreadsheets do.
std::vector<std::string> split_quoted(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[i++];
    } else if (line[i] == '"') {
      quoted = !quoted;
    } else if (line[i] == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += line[i];
    }
  }
  return fields;
}

std::uint32_t bitwise_crc32(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
    }
  }
  return ~crc;
}

// An F that lies on its side nowhere: neither mirrored nor upside down is it itself.
const std::vector<std::string> kLetter{"#######  ",  //
                                       "#......  ",  //
                                       "#.####.. ",  //
                                       "#.#...   ",  //
                                       "#.#  .   "};
constexpr double kSquare_m = 0.05;

OccupancyMap letter() {
  OccupancyMap map = test::floor_plan(kLetter, kSquare_m, kSquare_m);
  map.origin = {-1.25, 0.4};
  return map;
}

// What ROS's map_server makes of a map: 100 occupied, 0 free, -1 unknown, the lowest row first.
struct RosMap {
  int width = 0;
  int height = 0;
  double resolution_m = 0;
  double x_m = 0;
  double y_m = 0;
  std::vector<int> data;
};

RosMap map_server(const fs::path& yaml) {
  const YAML::Node doc = YAML::LoadFile(yaml.string());
  std::ifstream pgm(yaml.parent_path() / doc["image"].as<std::string>(), std::ios::binary);
  RosMap map;
  std::string magic;
  int most = 0;
  pgm >> magic >> map.width >> map.height >> most;
  pgm.get();
  EXPECT_EQ(magic, "P5");
  EXPECT_EQ(most, 255);
  EXPECT_EQ(doc["mode"].as<std::string>("trinary"), "trinary");
  EXPECT_EQ(doc["negate"].as<int>(), 0);
  EXPECT_EQ(doc["origin"][2].as<double>(), 0);
  map.resolution_m = doc["resolution"].as<double>();
  map.x_m = doc["origin"][0].as<double>();
  map.y_m = doc["origin"][1].as<double>();
  map.data.resize(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
  for (int v = 0; v < map.height; ++v) {
    for (int u = 0; u < map.width; ++u) {
      const double occupancy = (255 - pgm.get()) / 255.0;
      map.data[static_cast<std::size_t>((map.height - 1 - v) * map.width + u)] =
          occupancy > doc["occupied_thresh"].as<double>() ? 100
          : occupancy < doc["free_thresh"].as<double>()   ? 0
                                                          : -1;
    }
  }
  EXPECT_TRUE(pgm);
  EXPECT_EQ(pgm.get(), EOF);
  return map;
}

void expect_letter(const RosMap& map) {
  ASSERT_EQ(map.width, 9);
  ASSERT_EQ(map.height, 5);
  EXPECT_EQ(map.resolution_m, kSquare_m);
  EXPECT_EQ(map.x_m, -1.25);
  EXPECT_EQ(map.y_m, 0.4);
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 9; ++column) {
      const char drawn =
          kLetter[static_cast<std::size_t>(4 - row)][static_cast<std::size_t>(column)];
      EXPECT_EQ(map.data[static_cast<std::size_t>(row * 9 + column)], drawn == '#'   ? 100
                                                                      : drawn == '.' ? 0
                                                                                     : -1)
          << row << " " << column;
    }
  }
}

PoseGraph odd_graph() {
  PoseGraph graph;
  graph.T_map_node = {{0, 0, 0}, {1.03, 0.1, 0.4}, {1.9, 0.7, 1.1}, {1.2, 1.6, -3.1}};
  const auto information = [](double a, double b, double c) {
    Mat3 L;
    L << a, 0, 0, 3, b, 0, -2, 5, c;
    return Mat3(L * L.transpose());
  };
  graph.edges = {{0, 1, {1, 0.05, 0.35}, information(9, 7, 20), false},
                 {1, 2, {1, 0.2, 0.6}, information(4, 11, 15), false},
                 {2, 3, {0.5, 1.1, 2}, information(6, 2, 30), false},
                 {3, 0, {1.1, 1.7, 3.05}, information(12, 3, 8), true}};
  return graph;
}

// As g2o reads and measures it: the error seen from the measured `to`, the upper triangle of its
// information row by row.
double g2o_chi2(const fs::path& file) {
  std::map<int, Eigen::Vector3d> vertices;
  double chi2 = 0;
  for (const std::string& line : lines_of(file)) {
    std::istringstream in(line);
    std::string tag;
    in >> tag;
    if (tag == "VERTEX_SE2") {
      int id = -1;
      in >> id;
      in >> vertices[id][0] >> vertices[id][1] >> vertices[id][2];
    } else {
      EXPECT_EQ(tag, "EDGE_SE2");
      int i = -1;
      int j = -1;
      Eigen::Vector3d z;
      Eigen::Matrix3d omega;
      in >> i >> j >> z[0] >> z[1] >> z[2];
      for (int row = 0; row < 3; ++row) {
        for (int column = row; column < 3; ++column) {
          in >> omega(row, column);
          omega(column, row) = omega(row, column);
        }
      }
      const Eigen::Vector3d a = vertices.at(i);
      const Eigen::Vector3d b = vertices.at(j);
      Eigen::Vector3d e;
      e.head<2>() =
          Eigen::Rotation2Dd(-z[2]) * (Eigen::Rotation2Dd(-a[2]) * (b - a).head<2>() - z.head<2>());
      e[2] = std::remainder(b[2] - a[2] - z[2], 2 * kPi);
      chi2 += e.dot(omega * e);
    }
    EXPECT_TRUE(in) << line;
    EXPECT_TRUE((in >> std::ws).eof()) << line;
  }
  return chi2;
}

// The chunks of a PNG as its specification has them.
void expect_whole_png(const std::string& png, int width, int height) {
  ASSERT_THAT(png, StartsWith("\x89PNG\r\n\x1a\n"));
  const auto number = [&png](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      value = value << 8U | static_cast<unsigned char>(png.at(at + i));
    }
    return value;
  };
  std::string last;
  std::size_t at = 8;
  while (at < png.size()) {
    const std::size_t length = number(at);
    last = png.substr(at + 4, 4);
    EXPECT_EQ(bitwise_crc32(png.substr(at + 4, length + 4)), number(at + 8 + length)) << last;
    if (last == "IHDR") {
      EXPECT_EQ(number(at + 8), static_cast<std::uint32_t>(width));
      EXPECT_EQ(number(at + 12), static_cast<std::uint32_t>(height));
    }
    at += length + 12;
  }
  EXPECT_EQ(at, png.size());
  EXPECT_EQ(last, "IEND");
}

class OursReadByOthers : public ScratchTest {};

TEST_F(OursReadByOthers, AMapIsTheSameInMapServer) {
  write_map_server(folder_ / "letter", letter());
  expect_letter(map_server(folder_ / "letter.yaml"));
}

TEST_F(OursReadByOthers, AMapIsAPictureForWhoeverShowsIt) {
  write_map_server(folder_ / "letter", letter());
  const cv::Mat shown = cv::imread(path("letter.pgm"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(shown.size(), cv::Size(9, 5));
  ASSERT_EQ(shown.type(), CV_8U);
  EXPECT_EQ(shown.at<unsigned char>(0, 0), 0);    // the letter's upper left corner
  EXPECT_EQ(shown.at<unsigned char>(1, 1), 254);  // its inside
  EXPECT_EQ(shown.at<unsigned char>(4, 8), 205);  // beside its foot
}

TEST_F(OursReadByOthers, ATrajectoryIsEightNumbersALine) {
  const std::vector<Pose2> trajectory{{0, 0, 0}, {1.5, -2.25, 3}, {-0.1, 1e-7, -kPi / 2}};
  std::vector<TumPose> poses;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    poses.push_back({Time(Duration(1'700'000'000'123'456'789 + static_cast<std::int64_t>(i))),
                     on_floor(trajectory[i])});
  }
  write_tum(folder_ / "t.tum", poses);
  const std::vector<std::string> lines = lines_of(folder_ / "t.tum");
  ASSERT_EQ(lines.size(), trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    long s = 0;
    std::array<char, 16> fraction{};
    std::array<double, 7> v{};
    char more = 0;
    ASSERT_EQ(std::sscanf(lines[i].c_str(), "%ld.%15[0-9] %lf %lf %lf %lf %lf %lf %lf %c", &s,
                          fraction.data(), &v[0], &v[1], &v[2], &v[3], &v[4], &v[5], &v[6], &more),
              9)
        << lines[i];
    EXPECT_EQ(s, 1'700'000'000);
    std::string nanoseconds = fraction.data();
    nanoseconds.resize(9, '0');
    EXPECT_EQ(std::stoi(nanoseconds), 123'456'789 + static_cast<int>(i));
    EXPECT_EQ(v[0], trajectory[i].x_m);
    EXPECT_EQ(v[1], trajectory[i].y_m);
    EXPECT_EQ(v[2], 0);
    EXPECT_EQ(v[3], 0);
    EXPECT_EQ(v[4], 0);
    EXPECT_NEAR(2 * std::atan2(v[5], v[6]), trajectory[i].theta_rad, kRoundoff);
  }
}

TEST_F(OursReadByOthers, AGraphHasTheSameChi2InG2o) {
  const PoseGraph graph = odd_graph();
  write_g2o(folder_ / "g.g2o", graph, {7, 8, 12, 40});
  const double expected = chi2(graph);
  EXPECT_GT(expected, 1);
  EXPECT_NEAR(g2o_chi2(folder_ / "g.g2o"), expected, kRoundoff * expected);
  EXPECT_THAT(lines_of(folder_ / "g.g2o")[1], StartsWith("VERTEX_SE2 8 1.03 0.1 0.4"));
  EXPECT_THAT(lines_of(folder_ / "g.g2o")[7], StartsWith("EDGE_SE2 40 7 1.1 1.7 3.05 "));
}

TEST_F(OursReadByOthers, ATableSplitsAtCommas) {
  CsvWriter csv(folder_ / "t.csv", {"stamp_s", "x_m", "keyframe", "coverage"});
  csv << Time(Duration(1'250'000'000)) << -0.1 << 3;
  csv.skip();
  csv.end_row();
  csv << Time(Duration(2'000'000'001)) << 1e-9 << -4 << 0.3;
  csv.end_row();
  csv.finish();
  const std::vector<std::string> lines = lines_of(folder_ / "t.csv");
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_THAT(naive_split(lines[0]), ElementsAre("stamp_s", "x_m", "keyframe", "coverage"));
  EXPECT_THAT(naive_split(lines[1]), ElementsAre("1.25", "-0.1", "3", ""));
  const std::vector<std::string> last = naive_split(lines[2]);
  ASSERT_EQ(last.size(), 4U);
  EXPECT_EQ(last[0], "2.000000001");
  EXPECT_EQ(std::stod(last[1]), 1e-9);
  EXPECT_EQ(std::stoi(last[2]), -4);
  EXPECT_EQ(std::stod(last[3]), 0.3);
}

// A run of three steps, recorded.
class ARunReadByOthers : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    RunInfo info;
    info.version = "0.1.0";
    info.mission = "a \"quoted\" one, with a \\ and a \t";
    info.seed = 9'007'199'254'740'993;  // more than a double holds
    info.mission_yaml = "seed: 7\n";
    Recorder recorder(folder_, info, nullptr);
    RunResult result;
    for (int i = 0; i < 3; ++i) {
      const Time stamp(Duration(250'000'000LL * i));
      Observation seen;
      seen.stamp = stamp;
      seen.pictures["front"].stamp = stamp;
      seen.odometry.T_odom_body = {0.1 * i, 0, 0};
      SlamStep at;
      at.stamp = stamp;
      at.T_map_body = {0.1 * i, 0, 0.5 * i};
      at.keyframe_made = i;
      PilotStep step;
      step.state = PilotState::kDriving;
      step.reason = i == 1 ? "to a frontier, 1.2 m2: \"there\"" : "waits";
      recorder.add(seen, at, step);
      result.keyframes.push_back({stamp, at.T_map_body, seen.odometry.T_odom_body});
      result.graph.T_map_node.push_back(at.T_map_body);
    }
    result.graph.edges = {{0, 1, {0.1, 0, 0.5}, Mat3::Identity(), false},
                          {1, 2, {0.1, 0, 0.5}, Mat3::Identity(), false}};
    result.map = letter();
    ASSERT_EQ(recorder.write_report(std::nullopt, result, {"completed", "explored"}).exit_status,
              0);
  }
};

TEST_F(ARunReadByOthers, LeavesItsMapItsGraphAndItsTrajectory) {
  expect_letter(map_server(folder_ / "map.yaml"));
  EXPECT_GT(g2o_chi2(folder_ / "graph.g2o"), 0);
  for (const char* file : {"trajectory.tum", "odometry.tum", "keyframes.tum"}) {
    const std::vector<std::string> lines = lines_of(folder_ / file);
    ASSERT_EQ(lines.size(), 3U) << file;
    double t = 0;
    double x = 0;
    ASSERT_EQ(std::sscanf(lines[2].c_str(), "%lf %lf", &t, &x), 2);
    EXPECT_EQ(t, 0.5);
    EXPECT_NEAR(x, 0.2, kRoundoff);
  }
}

TEST_F(ARunReadByOthers, LeavesJsonThatAnotherParserReads) {
  const YAML::Node m = YAML::LoadFile(path("metrics.json"));  // YAML's flow style holds JSON
  EXPECT_EQ(m["schema"].as<std::string>(), "panoptes.metrics/1");
  EXPECT_EQ(m["mission"].as<std::string>(), "a \"quoted\" one, with a \\ and a \t");
  EXPECT_EQ(m["seed"].as<std::uint64_t>(), 9'007'199'254'740'993U);
  EXPECT_EQ(m["outcome"].as<std::string>(), "completed");
  EXPECT_EQ(m["end_reason"].as<std::string>(), "explored");
  EXPECT_EQ(m["frames"].as<int>(), 3);
  EXPECT_EQ(m["run_s"].as<double>(), 0.5);
  EXPECT_NEAR(m["distance_m"].as<double>(), 0.2, kRoundoff);
  const std::string text = bytes_of(folder_ / "metrics.json");
  for (const char* no_json : {"nan", "NaN", "inf,", "Infinity"}) {
    EXPECT_THAT(text, testing::Not(HasSubstr(no_json)));
  }
  EXPECT_EQ(YAML::LoadFile(path("mission.yaml"))["seed"].as<int>(), 7);
}

TEST_F(ARunReadByOthers, LeavesTablesWithAsManyFieldsInEachRow) {
  for (const char* file : {"steps.csv", "loops.csv", "exploration.csv"}) {
    const std::vector<std::string> lines = lines_of(folder_ / file);
    ASSERT_FALSE(lines.empty());
    for (const std::string& line : lines) {
      EXPECT_EQ(split_quoted(line).size(), naive_split(lines[0]).size()) << line;
    }
  }
  const std::vector<std::string> steps = lines_of(folder_ / "steps.csv");
  ASSERT_EQ(steps.size(), 4U);
  const std::vector<std::string> names = naive_split(steps[0]);
  const auto field = [&](std::size_t row, const std::string& name) {
    const auto column = std::find(names.begin(), names.end(), name) - names.begin();
    return split_quoted(steps[row + 1]).at(static_cast<std::size_t>(column));
  };
  EXPECT_EQ(field(1, "stamp_s"), "0.25");
  EXPECT_NEAR(std::stod(field(2, "theta_deg")), 180 / kPi, 1e-9);
  EXPECT_EQ(field(2, "keyframe"), "2");
  EXPECT_EQ(field(1, "why"), "to a frontier, 1.2 m2: \"there\"");
  EXPECT_EQ(field(1, "goal_x_m"), "");
}

TEST_F(ARunReadByOthers, LeavesWholePictures) {
  for (const char* file : {"map.png", "coverage.png"}) {
    const cv::Mat picture = cv::imread(path(file));
    ASSERT_FALSE(picture.empty()) << file;
    expect_whole_png(bytes_of(folder_ / file), picture.cols, picture.rows);
    double least = 0;
    double most = 0;
    cv::minMaxIdx(picture.reshape(1), &least, &most);
    EXPECT_GT(most - least, 100) << file;  // something is drawn
  }
}

TEST_F(OursReadByOthers, ADatasetIsEurocs) {
  Rig rig;
  RigCamera camera;
  camera.rate_hz = 10;
  camera.intrinsics = {8, 6, 100.5, 101.25, 3.5, 2.5, BrownConrady{-0.2, 0.05, 1e-4, -2e-4, 0}};
  camera.T_body_camera = mounted_camera({0.1, -0.02, 0.75}, kPi / 2, 0);  // it looks to the left
  rig.cameras["cam0"] = camera;
  const std::int64_t epoch_ns = 1'403'636'579'763'555'584;
  std::vector<cv::Mat> pictures;
  {
    DatasetWriter writer(folder_, {.version = "1", .mission = "m", .seed = 7}, rig, Body{});
    for (int i = 0; i < 3; ++i) {
      cv::Mat bgr(6, 8, CV_8UC3);
      for (int k = 0; k < 6 * 8 * 3; ++k) {
        bgr.data[k] = static_cast<unsigned char>(37 * k + 11 * i);
      }
      pictures.push_back(bgr);
      Observation seen;
      seen.stamp = Time(Duration(epoch_ns + 100'000'000LL * i));
      seen.pictures["cam0"] = {seen.stamp, bgr};
      seen.odometry = {{0.5 * i, -0.25 * i, 0.125 * i}, {0.5, 0.1}};
      writer.add(seen, seen.stamp);
    }
  }
  const fs::path mav = folder_ / "mav0";
  const std::vector<std::string> rows = lines_of(mav / "cam0/data.csv");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0], "#timestamp [ns],filename");
  for (int i = 0; i < 3; ++i) {
    const std::vector<std::string> fields = naive_split(rows[static_cast<std::size_t>(i) + 1]);
    ASSERT_EQ(fields.size(), 2U);
    EXPECT_EQ(std::stoll(fields[0]), epoch_ns + 100'000'000LL * i);
    EXPECT_EQ(fields[1], fields[0] + ".png");
    expect_whole_png(bytes_of(mav / "cam0/data" / fields[1]), 8, 6);
    const cv::Mat read = cv::imread((mav / "cam0/data" / fields[1]).string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(read.type(), CV_8UC3);
    EXPECT_EQ(cv::norm(read, pictures[static_cast<std::size_t>(i)], cv::NORM_INF), 0);
  }
  const std::vector<std::string> odometry = lines_of(mav / "odom0/data.csv");
  ASSERT_EQ(odometry.size(), 4U);
  EXPECT_THAT(naive_split(odometry[3]), ElementsAre(std::to_string(epoch_ns + 200'000'000LL), "1",
                                                    "-0.5", "0.25", "0.5", "0.1"));

  const YAML::Node sensor = YAML::LoadFile((mav / "cam0/sensor.yaml").string());
  EXPECT_EQ(sensor["sensor_type"].as<std::string>(), "camera");
  EXPECT_EQ(sensor["rate_hz"].as<double>(), 10);
  EXPECT_THAT(sensor["resolution"].as<std::vector<int>>(), ElementsAre(8, 6));
  EXPECT_EQ(sensor["camera_model"].as<std::string>(), "pinhole");
  EXPECT_THAT(sensor["intrinsics"].as<std::vector<double>>(), ElementsAre(100.5, 101.25, 3.5, 2.5));
  EXPECT_EQ(sensor["distortion_model"].as<std::string>(), "radial-tangential");
  EXPECT_THAT(sensor["distortion_coefficients"].as<std::vector<double>>(),
              ElementsAre(-0.2, 0.05, 1e-4, -2e-4));
  ASSERT_EQ(sensor["T_BS"]["cols"].as<int>(), 4);
  ASSERT_EQ(sensor["T_BS"]["rows"].as<int>(), 4);
  const auto T = sensor["T_BS"]["data"].as<std::vector<double>>();
  ASSERT_EQ(T.size(), 16U);
  // a point two metres ahead of the camera and one to its right lies to the body's left and ahead
  const std::array<double, 4> p_camera{1, 0, 2, 1};
  std::array<double, 4> p_body{};
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 4; ++column) {
      p_body[row] += T[4 * row + column] * p_camera[column];
    }
  }
  EXPECT_NEAR(p_body[0], 0.1 + 1, kRoundoff);
  EXPECT_NEAR(p_body[1], -0.02 + 2, kRoundoff);
  EXPECT_NEAR(p_body[2], 0.75, kRoundoff);
  EXPECT_EQ(p_body[3], 1);
}

TEST_F(OursReadByOthers, KeyframesAddUpToTheirCrc) {
  EXPECT_EQ(bitwise_crc32("123456789"), 0xcbf43926U);  // as everybody's does
  KeptKeyframes kept;
  for (int k = 0; k < 2; ++k) {
    KeptKeyframe keyframe;
    keyframe.stamp = time_at(k + 0.5);
    keyframe.T_map_keyframe = {1.5, -2, kPi / 2};
    keyframe.place.signature.cumulative.resize(256);
    keyframe.place.signature.cumulative[7] = 0.25F;
    for (const int count : {2, 3 + k}) {
      LocalFeatures points;
      points.descriptors = cv::Mat(count, 32, CV_8U, cv::Scalar(17 * count + k));
      points.px.assign(static_cast<std::size_t>(count), {1.25F, 2.5F});
      keyframe.place.features.push_back(points);
    }
    GridCrop grid;
    grid.first_row = -1;
    grid.rows = {{2, 4, 0}, {0, 0, 2}, {5, 6, 2}};
    grid.cells = {10, -20, static_cast<std::int8_t>(100 - k)};
    keyframe.grid = std::make_shared<const GridCrop>(grid);
    kept.all.push_back(keyframe);
  }
  write_keyframes(folder_, kept);
  const fs::path folder = folder_ / "keyframes";
  const std::vector<std::string> table = lines_of(folder / "keyframes.csv");
  ASSERT_EQ(table.size(), 3U);
  const std::vector<std::string> names = naive_split(table[0]);
  std::ifstream signatures(folder / "signatures.bin", std::ios::binary);
  std::ifstream features(folder / "features.bin", std::ios::binary);
  std::ifstream maps(folder / "maps.bin", std::ios::binary);
  const auto take = [](std::ifstream& in, int count) {
    std::string bytes(static_cast<std::size_t>(count), '\0');
    EXPECT_TRUE(in.read(bytes.data(), count));
    return bytes;
  };
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string& row = table[k + 1];
    const std::vector<std::string> fields = naive_split(row);
    ASSERT_EQ(fields.size(), names.size());
    const auto number = [&](const char* name) {
      return std::stoi(fields.at(
          static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())));
    };
    EXPECT_EQ(number("keyframe"), static_cast<int>(k));
    EXPECT_EQ(number("back_features"), 3 + static_cast<int>(k));
    const std::string shares = take(signatures, 4 * 256);
    float share = 0;
    std::memcpy(&share, shares.data() + 4 * 7, 4);
    EXPECT_EQ(share, 0.25F);
    const std::string points =
        take(features, 36 * (number("front_features") + number("back_features")));
    const std::string png = take(maps, number("map_bytes"));
    expect_whole_png(png, 4, 3);
    std::array<char, 9> crc{};
    std::snprintf(crc.data(), crc.size(), "%08x",
                  bitwise_crc32(table[0] + row.substr(0, row.rfind(',')) + shares + points + png));
    EXPECT_EQ(fields.back(), crc.data());
  }
  for (std::ifstream* in : {&signatures, &features, &maps}) {
    EXPECT_EQ(in->get(), EOF);
  }
}

}  // namespace
}  // namespace panoptes
