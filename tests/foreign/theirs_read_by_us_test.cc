// SPDX-License-Identifier: BSD-3-Clause
// What other programs write, read by us: each file made by a few lines, or copied, as they do it.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <numbers>
#include <sstream>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/io/csv.h"
#include "core/io/dataset.h"
#include "core/io/euroc_truth.h"
#include "core/io/graph_file.h"
#include "core/io/map_server.h"
#include "core/io/picture.h"
#include "core/io/tum.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pointwise;

constexpr double kRoundoff = 1e-12;
constexpr double kPi = std::numbers::pi;

void save(const fs::path& file, const std::string& bytes) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << bytes;
}

std::string with_crlf(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c == '\n' ? "\r\n" : std::string(1, c);
  }
  return out;
}

class TheirsReadByUs : public ScratchTest {};

// As OptimizableGraph::save writes it: blanks at line ends, FIX after its vertex, six digits.
const std::string kG2o =
    "# saved by g2o\n"
    "VERTEX_SE2 0 0 0 0 \n"
    "FIX 0\n"
    "VERTEX_SE2 1 1.03039 0.0113498 -0.0129577 \n"
    "VERTEX_SE2 2 2.0437 -1.2e-05 1.57083 \n"
    "\n"
    "EDGE_SE2 0 1 1.03039 1.13498E-02 -1.29577e-2 500 1 2 400 3 5000 \n"
    "EDGE_SE2 1 2 1.0139 -0.058639 +1.58 44.7214 0 -0 44.7214 0 44.7214 \n"
    "EDGE_SE2\t0\t2\t2.04\t.5\t1.57\t1e2\t0\t0\t1e2\t0\t1e3\n";

void expect_the_graph(const GraphFile& file) {
  EXPECT_TRUE(file.poses_given);
  EXPECT_THAT(file.ids, ElementsAre(0, 1, 2));
  ASSERT_EQ(file.graph.T_map_node.size(), 3U);
  EXPECT_EQ(file.graph.T_map_node[1], (Pose2{1.03039, 0.0113498, -0.0129577}));
  EXPECT_EQ(file.graph.T_map_node[2], (Pose2{2.0437, -1.2e-05, 1.57083}));
  ASSERT_EQ(file.graph.edges.size(), 3U);
  EXPECT_EQ(file.graph.edges[0].T_from_to, (Pose2{1.03039, 0.0113498, -0.0129577}));
  EXPECT_EQ(file.graph.edges[1].T_from_to, (Pose2{1.0139, -0.058639, 1.58}));
  EXPECT_EQ(file.graph.edges[2].T_from_to, (Pose2{2.04, 0.5, 1.57}));
  EXPECT_FALSE(file.graph.edges[1].closure);
  EXPECT_TRUE(file.graph.edges[2].closure);
}

TEST_F(TheirsReadByUs, AGraphAsG2oSavesIt) {
  for (const std::string& text : {kG2o, with_crlf(kG2o)}) {
    save(folder_ / "g.g2o", text);
    const GraphFile file = read_graph(folder_ / "g.g2o");
    expect_the_graph(file);
    EXPECT_THAT(file.warnings, ElementsAre(HasSubstr("g.g2o:3: FIX lines are left out")));
    // error' information error, in the frame of the measured `to`, by hand
    GraphEdge edge = file.graph.edges[0];
    PoseGraph off;
    off.T_map_node = {{0, 0, 0}, edge.T_from_to * Pose2{0.1, -0.2, 0.3}};
    const double expected = 500 * 0.01 + 400 * 0.04 + 5000 * 0.09 +
                            2 * (1 * 0.1 * -0.2 + 2 * 0.1 * 0.3 + 3 * -0.2 * 0.3);
    EXPECT_NEAR(chi2(off, edge), expected, kRoundoff * 1e3);
  }
}

TEST_F(TheirsReadByUs, AGraphAsToroSavesIt) {
  // EDGE2's information is ff fs ss rr fr sr, in the frame of the observing vertex
  const std::string toro =
      "VERTEX2 0 0 0 0\n"
      "VERTEX2 1 1.03039 0.0113498 -0.0129577\n"
      "VERTEX2 2 2.0437 -1.2e-05 1.57083\n"
      "EDGE2 0 1 1.03039 0.0113498 -0.0129577 500 1 400 5000 2 3\n"
      "EDGE2 1 2 1.0139 -0.058639 1.58 44.7214 0 44.7214 44.7214 0 0\n"
      "EDGE2 0 2 2.04 0.5 1.57 100 0 100 1000 0 0\n"
      "EQUIV 0 2\n";
  for (const std::string& text : {toro, with_crlf(toro)}) {
    save(folder_ / "g.graph", text);
    const GraphFile file = read_graph(folder_ / "g.graph");
    expect_the_graph(file);
    Mat3 information;
    information << 500, 1, 2, 1, 400, 3, 2, 3, 5000;
    EXPECT_EQ(file.graph.edges[0].information, information);
  }
}

// TORO's loaders take the words of its first version as well.
TEST_F(TheirsReadByUs, AGraphInTorosFirstWords) {
  save(folder_ / "old", "VERTEX 0 0 0 0\nVERTEX 1 1 0 0\nEDGE 0 1 1.5 0 0 4 0 4 9 0 0\n");
  const GraphFile file = read_graph(folder_ / "old");
  ASSERT_EQ(file.graph.edges.size(), 1U);
  EXPECT_EQ(file.graph.edges[0].T_from_to.x_m, 1.5);
  EXPECT_EQ(file.graph.edges[0].information(2, 2), 9);
}

// The same drive in both formats: they measure the error in other frames, and round information is
// the same in both.
TEST_F(TheirsReadByUs, AGraphOfEitherKindIsTheSameWhereInformationIsRound) {
  save(folder_ / "a",
       "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.5\nEDGE_SE2 0 1 1.1 0.1 0.4 20 0 0 "
       "20 0 50\n");
  save(folder_ / "b", "VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0.5\nEDGE2 0 1 1.1 0.1 0.4 20 0 20 50 0 0\n");
  const PoseGraph g2o = read_graph(folder_ / "a").graph;
  const PoseGraph toro = read_graph(folder_ / "b").graph;
  EXPECT_EQ(g2o.edges[0].information, toro.edges[0].information);
  EXPECT_NEAR(chi2(g2o), 20 * (0.01 + 0.01) + 50 * 0.01, kRoundoff * 10);
}

TEST_F(TheirsReadByUs, ATrajectoryOfTheTumBenchmark) {
  // the head of freiburg1_xyz's groundtruth.txt
  const std::string tum =
      "# ground truth trajectory\n"
      "# file: 'rgbd_dataset_freiburg1_xyz.bag'\n"
      "# timestamp tx ty tz qx qy qz qw\n"
      "1305031098.6659 1.3563 0.6305 1.6380 0.6132 0.5962 -0.3311 -0.3986\n"
      "1305031098.6758 1.3543 0.6306 1.6360 0.6129 0.5966 -0.3316 -0.3980\n";
  for (const std::string& text : {tum, with_crlf(tum)}) {
    save(folder_ / "groundtruth.txt", text);
    const std::vector<TumPose> poses = read_tum(folder_ / "groundtruth.txt");
    ASSERT_EQ(poses.size(), 2U);
    EXPECT_EQ(poses[0].stamp.time_since_epoch().count(), 1'305'031'098'665'900'000);
    EXPECT_EQ(poses[1].T_frame_body.translation, Vec3(1.3543, 0.6306, 1.6360));
    constexpr double kFourDigits = 1e-4;
    EXPECT_NEAR(poses[0].T_frame_body.rotation.x(), 0.6132, kFourDigits);
    EXPECT_NEAR(poses[0].T_frame_body.rotation.w(), -0.3986, kFourDigits);
  }
}

TEST_F(TheirsReadByUs, ATrajectoryByPrintfInAnyStyle) {
  struct Style {
    const char* format;
    double roundoff;
  };
  for (const Style& style : std::vector<Style>{
           {"%.6f %.7f %.7f %.7f %.7f %.7f %.7f %.7f\n", 1e-6},               // ORB-SLAM
           {"%.18e %.18e %.18e %.18e %.18e %.18e %.18e %.18e\n", kRoundoff},  // numpy.savetxt, evo
           {"%.9f\t%g\t%g\t%g\t%g\t%g\t%g\t%g\n", 1e-5},                      // by tabs
           {"  %.9f   %+.17g %+.17g %+.17g %+.17g %+.17g %+.17g %+.17g  \n", kRoundoff}}) {
    std::string text = "\n# a comment\n";
    for (int i = 0; i < 3; ++i) {
      std::array<char, 512> line{};
      std::snprintf(line.data(), line.size(), style.format, 12.25 + i, 1.0 + i, -2.5, 0.0, 0.0, 0.0,
                    std::sin(0.25 * i), std::cos(0.25 * i));
      text += line.data();
    }
    save(folder_ / "t.txt", text);
    const std::vector<TumPose> poses = read_tum(folder_ / "t.txt");
    ASSERT_EQ(poses.size(), 3U) << style.format;
    for (int i = 0; i < 3; ++i) {
      const TumPose& pose = poses[static_cast<std::size_t>(i)];
      EXPECT_EQ(pose.stamp, time_at(12.25 + i));
      const Pose2 on_the_floor = floor_pose(pose);
      EXPECT_NEAR(on_the_floor.x_m, 1 + i, kRoundoff);
      EXPECT_NEAR(on_the_floor.y_m, -2.5, kRoundoff);
      EXPECT_NEAR(on_the_floor.theta_rad, 0.5 * i, style.roundoff) << style.format;
    }
  }
}

// 3 x 2 with pixels that look like blanks and comments: the upper row occupied, unknown, occupied.
const std::string kPixels("\n\xcd#\xfe\xfe\x00", 6);

void expect_map(const OccupancyMap& map) {
  ASSERT_EQ(map.columns, 3);
  ASSERT_EQ(map.rows, 2);
  EXPECT_EQ(map.cell_m, 0.05);
  EXPECT_EQ(map.origin, Vec2(-10, -12.5));
  EXPECT_THAT(map.cells, ElementsAre(Cell::kFree, Cell::kFree, Cell::kOccupied, Cell::kOccupied,
                                     Cell::kUnknown, Cell::kOccupied));
}

TEST_F(TheirsReadByUs, AMapAsMapSaverAndGimpWriteIt) {
  const std::string ros1 =
      "image: map.pgm\nresolution: 0.050000\norigin: [-10.000000, -12.500000, 0.000000]\n"
      "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n\n";
  const std::string nav2 =
      "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-10, -12.5, 0]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196";
  const std::string whole_path = "image: " + path("map.pgm") + "\n" + ros1.substr(15);
  // A tool that knows YAML's booleans writes them.
  std::string yaml_1_1 = ros1;
  yaml_1_1.replace(yaml_1_1.find("negate: 0"), 9, "negate: no");
  for (const std::string& yaml : {ros1, nav2, with_crlf(ros1), whole_path, yaml_1_1}) {
    for (const char* header : {"P5\n# CREATOR: map_saver.cpp 0.050 m/pix\n3 2\n255\n",
                               "P5\n# Created by GIMP version 2.10.34 PNM plug-in\n3 2\n255\n",
                               "P5\n#one\n#two\n3 # wide\n2\n#and\n255\n", "P5 3 2 255\n"}) {
      save(folder_ / "map.yaml", yaml);
      save(folder_ / "map.pgm", header + kPixels);
      expect_map(read_map_server(folder_ / "map.yaml"));
    }
  }
}

TEST_F(TheirsReadByUs, AMapAsAnotherKindOfPicture) {
  const cv::Mat grey(2, 3, CV_8U, const_cast<char*>(kPixels.data()));
  cv::Mat bgr;
  cv::merge(std::vector<cv::Mat>{grey, grey, grey}, bgr);
  cv::Mat bgra;
  cv::merge(std::vector<cv::Mat>{grey, grey, grey, cv::Mat(2, 3, CV_8U, cv::Scalar(255))}, bgra);
  std::string plain = "P2\n# by hand\n3 2\n255\n";
  for (const unsigned char pixel : kPixels) {
    plain += std::to_string(pixel) + "\n";
  }
  for (const char* name : {"grey.png", "bgr.png", "bgra.png", "grey.bmp", "grey.pgm"}) {
    const std::string kind = name;
    ASSERT_TRUE(cv::imwrite(path(kind), kind.starts_with("bgra")  ? bgra
                                        : kind.starts_with("bgr") ? bgr
                                                                  : grey));
  }
  save(folder_ / "plain.pgm", plain);
  for (const char* name :
       {"grey.png", "bgr.png", "bgra.png", "grey.bmp", "grey.pgm", "plain.pgm"}) {
    save(folder_ / "map.yaml", "image: " + std::string(name) +
                                   "\nresolution: 0.05\norigin: [-10, -12.5, 0]\nnegate: 0\n"
                                   "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
    SCOPED_TRACE(name);
    expect_map(read_map_server(folder_ / "map.yaml"));
  }
}

// A picture whose left half is dark red and whose lower right quarter is light.
cv::Mat halves(int type) {
  cv::Mat picture(32, 48, type, cv::Scalar(90, 120, 150));
  picture(cv::Rect(0, 0, 24, 32)).setTo(cv::Scalar(20, 30, 110));
  picture(cv::Rect(24, 16, 24, 16)).setTo(cv::Scalar(200, 220, 240));
  return picture;
}

TEST_F(TheirsReadByUs, PicturesAsOpencvWritesThem) {
  struct Written {
    const char* name;
    std::vector<int> how;
    double most_grey;  // what packing changes
  };
  constexpr double kJpeg_grey = 12;
  for (const Written& written : std::vector<Written>{
           {"a.png", {}, 0},
           {"b.png", {cv::IMWRITE_PNG_COMPRESSION, 0}, 0},
           {"c.png", {cv::IMWRITE_PNG_COMPRESSION, 9}, 0},
           {"d.bmp", {}, 0},
           {"e.ppm", {}, 0},
           {"f.ppm", {cv::IMWRITE_PXM_BINARY, 0}, 0},
           {"g.jpg", {}, kJpeg_grey},
           {"h.jpg", {cv::IMWRITE_JPEG_PROGRESSIVE, 1}, kJpeg_grey},
           {"i.jpg", {cv::IMWRITE_JPEG_OPTIMIZE, 1, cv::IMWRITE_JPEG_QUALITY, 95}, kJpeg_grey},
           {"j.jpg", {cv::IMWRITE_JPEG_RST_INTERVAL, 2}, kJpeg_grey}}) {
    for (const int type : {CV_8UC3, CV_8UC1}) {
      std::string name = written.name;
      if (name.ends_with(".ppm") && type == CV_8UC1) {
        name.replace(name.size() - 2, 1, "g");  // pgm
      }
      SCOPED_TRACE(name);
      const cv::Mat picture = halves(type);
      ASSERT_TRUE(cv::imwrite(path(name), picture, written.how));
      std::ifstream in(path(name), std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(in), {}};
      const std::optional<PictureSize> size = picture_size(bytes);
      ASSERT_TRUE(size);
      EXPECT_EQ(size->width_px, 48);
      EXPECT_EQ(size->height_px, 32);
      const cv::Mat read = decode_picture(bytes, 100, PictureColours::kBgr);
      ASSERT_EQ(read.size(), picture.size());
      ASSERT_EQ(read.type(), CV_8UC3);
      for (const auto& [u, v] : {std::pair{5, 5}, {5, 27}, {40, 5}, {40, 27}}) {
        for (int channel = 0; channel < 3; ++channel) {
          const int wanted = type == CV_8UC1 ? picture.at<unsigned char>(v, u)
                                             : picture.at<cv::Vec3b>(v, u)[channel];
          EXPECT_NEAR(read.at<cv::Vec3b>(v, u)[channel], wanted, written.most_grey)
              << u << " " << v << " " << channel;
        }
      }
    }
  }
}

TEST_F(TheirsReadByUs, ATableFromASpreadsheet) {
  // quotes around everything, CRLF, an empty field, a number with an exponent, no last end of line
  save(folder_ / "t.csv",
       "stamp_s,\"why, in words\",x_m\r\n\"1.25\",\"he said \"\"go\"\", and\r\nwent\",-1E-3\r\n"
       "2,,+4");
  const CsvTable table = read_csv(folder_ / "t.csv");
  EXPECT_THAT(table.columns, ElementsAre("stamp_s", "why, in words", "x_m"));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.stamp(0, 0), time_at(1.25));
  EXPECT_EQ(table.rows[0][1], "he said \"go\", and\r\nwent");
  EXPECT_EQ(table.number(0, 2), -1e-3);
  EXPECT_EQ(table.rows[1][1], "");
  EXPECT_EQ(table.whole(1, 2), 4);
}

// As spreadsheets and editors save text: a byte order mark first, empty lines last.
TEST_F(TheirsReadByUs, FilesWithAByteOrderMark) {
  const std::string mark = "\xef\xbb\xbf";
  save(folder_ / "t.csv", mark + "stamp_s,x_m\r\n1,2\r\n\r\n\r\n");
  const CsvTable table = read_csv(folder_ / "t.csv");
  EXPECT_EQ(table.number(0, table.column("stamp_s")), 1);
  EXPECT_EQ(table.rows.size(), 1U);
  save(folder_ / "gap.csv", "stamp_s,x_m\n\n1,2\n");
  EXPECT_THROW(read_csv(folder_ / "gap.csv"), IoError);
  save(folder_ / "t.tum", mark + "1.5 1 2 3 0 0 0 1\n");
  EXPECT_EQ(read_tum(folder_ / "t.tum").front().stamp, time_at(1.5));
  save(folder_ / "g.g2o", mark + "VERTEX_SE2 0 0 0 0\n");
  EXPECT_EQ(read_graph(folder_ / "g.g2o").ids.size(), 1U);
}

// A EuRoC folder: cameras that nobody has synchronised, odometry at other instants, an IMU and a
// truth that are none of ours, ends of line as Windows has them.
class TheirDataset : public ScratchTest {
 protected:
  static constexpr std::int64_t kEpoch_ns = 1'403'636'579'763'555'584;

  void write(const std::string& end) const {
    const fs::path mav = folder_ / "mav0";
    for (const std::string camera : {"cam0", "cam1"}) {
      std::ostringstream rows;
      rows << "#timestamp [ns],filename" << end;
      for (int i = 0; i < 6; ++i) {
        const std::string name = std::to_string(kEpoch_ns + 50'000'000LL * i);
        rows << name << "," << name << (camera == "cam0" ? ".png" : ".jpg") << end;
        fs::create_directories(mav / camera / "data");
        cv::imwrite(
            (mav / camera / "data" / (name + (camera == "cam0" ? ".png" : ".jpg"))).string(),
            cv::Mat(6, 8, CV_8U, cv::Scalar(40 * i)));
      }
      save(mav / camera / "data.csv", rows.str());
      save(mav / camera / "sensor.yaml",
           "#Default camera sensor yaml file" + end + "sensor_type: camera" + end);
    }
    std::ostringstream odometry;
    odometry << "#timestamp [ns],x [m],y [m],theta [rad]" << end << std::setprecision(17);
    std::ostringstream truth;
    truth << "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], "
             "q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], "
             "b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], "
             "b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]"
          << end;
    for (int ms = -5; ms <= 265; ms += 10) {
      odometry << kEpoch_ns + 1'000'000LL * ms << ", " << 1 + 0.4e-3 * ms << ", -2, 0" << end;
      truth << kEpoch_ns + 1'000'000LL * ms << "," << std::fixed << std::setprecision(6)
            << 4 + 0.4e-3 * ms << ",5.000000,0.100000,0.877583,0.000000,0.000000,0.479426"
            << ",0,0,0,0,0,0,0,0,0" << end;
    }
    save(mav / "odom0/data.csv", odometry.str());
    save(mav / "state_groundtruth_estimate0/data.csv", truth.str());
    save(mav / "imu0/data.csv", "#timestamp [ns],w_RS_S_x [rad s^-1]" + end + "1,2" + end);
    save(mav / "body.yaml", "comment: theirs" + end);
  }
};

TEST_F(TheirDataset, InEurocsLayoutIsReadWhateverItsEndsOfLine) {
  for (const std::string end : {"\n", "\r\n", " \r\n"}) {
    write(end);
    const Dataset dataset = read_dataset(folder_);
    EXPECT_FALSE(dataset.ours);
    EXPECT_THAT(dataset.cameras, ElementsAre("cam0", "cam1"));
    EXPECT_THAT(dataset.warnings, IsEmpty());
    EXPECT_EQ(start_unix_ns(dataset), kEpoch_ns);
    check_pictures(dataset, {});
    ASSERT_EQ(dataset.observations.size(), 6U);
    for (int i = 0; i < 6; ++i) {
      const RecordedObservation& seen = dataset.observations[static_cast<std::size_t>(i)];
      EXPECT_EQ(seen.stamp, Time(Duration(50'000'000LL * i)));
      constexpr double kStamps_m = 1e-9;
      EXPECT_NEAR(seen.odometry.T_odom_body.x_m, 0.02 * i, kStamps_m);
      EXPECT_NEAR(seen.odometry.twist_body.v_mps, 0.4, 1e-6);
      for (const char* camera : {"cam0", "cam1"}) {
        const cv::Mat bgr = read_picture(dataset, seen.pictures.at(camera));
        ASSERT_EQ(bgr.size(), cv::Size(8, 6));
        EXPECT_NEAR(bgr.at<cv::Vec3b>(3, 4)[1], 40 * i, 1) << camera;
      }
    }
    const auto truth = read_euroc_truth(
        folder_.string(), [this](const std::string& file) { return read_part(folder_ / file); });
    ASSERT_TRUE(truth);
    ASSERT_EQ(truth->size(), 28U);
    EXPECT_EQ(truth->front().stamp.time_since_epoch().count(), kEpoch_ns - 5'000'000);
    EXPECT_NEAR(floor_pose(truth->back()).x_m, 4 + 0.4e-3 * 265, 1e-6);
    EXPECT_NEAR(floor_pose(truth->back()).theta_rad, 1, 1e-5);  // six digits of a half turn's sine
  }
}

}  // namespace
}  // namespace panoptes
