// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/rig_export.h"

#include <numbers>
#include <regex>
#include <sstream>

#include <gmock/gmock.h>
#include <yaml-cpp/yaml.h>

#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double kRoundoff = 1e-14;  // of a few products of rotations

using Numbers = std::vector<double>;

Rig a_rig() {
  Rig rig;
  RigCamera& ahead = rig.cameras["ahead"];
  ahead.intrinsics = {640, 480, 500, 501.25, 320.5, 239, BrownConrady{-0.2, 0.05, 1e-5, -2e-4, 0}};
  ahead.T_body_camera = mounted_camera({0.2, 0.01, 0.4}, 0.1, 0.2);
  ahead.clock_offset_s = 0.003;
  RigCamera& up = rig.cameras["up-1"];
  up.intrinsics = {320, 320, 100, 100, 159.5, 159.5, Equidistant{-0.01, 0.002, 0, 3e-6}};
  up.T_body_camera = mounted_camera({-0.1, 0, 0.8}, 0, -std::numbers::pi / 2);
  RigCamera& left = rig.cameras["left"];
  left.intrinsics = pinhole(320, 240, 1.2);
  left.T_body_camera = mounted_camera({0, 0.2, 0.4}, std::numbers::pi / 2, -0.3);
  left.T_body_camera.rotation = Eigen::Quaterniond(
      left.T_body_camera.rotation * Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
  return rig;
}

const std::vector<std::string> kOrder{"up-1", "left", "ahead"};

double mounted_apart(const Pose3& a, const Pose3& b) {
  return (a.rotation.toRotationMatrix() - b.rotation.toRotationMatrix()).norm() +
         (a.translation - b.translation).norm();
}

TEST(RigExport, ACamchainLeadsFromCameraToCamera) {
  const Rig rig = a_rig();
  const YAML::Node chain = YAML::Load(kalibr_camchain(rig, kOrder));
  ASSERT_EQ(chain.size(), 3U);
  EXPECT_FALSE(chain["cam0"]["T_cn_cnm1"]);
  Pose3 T_body_camera = rig.cameras.at(kOrder[0]).T_body_camera;
  for (std::size_t i = 1; i < kOrder.size(); ++i) {
    const YAML::Node rows = chain["cam" + std::to_string(i)]["T_cn_cnm1"];
    Eigen::Matrix4d m;
    for (int row = 0; row < 4; ++row) {
      const auto numbers = rows[row].as<Numbers>();
      m.row(row) = Eigen::Map<const Eigen::RowVector4d>(numbers.data());
    }
    EXPECT_EQ(m.row(3), Eigen::RowVector4d(0, 0, 0, 1));
    const Pose3 T_camera_before{Eigen::Quaterniond(Mat3(m.topLeftCorner<3, 3>())),
                                m.topRightCorner<3, 1>()};
    T_body_camera = T_body_camera * T_camera_before.inverse();
    EXPECT_LT(mounted_apart(T_body_camera, rig.cameras.at(kOrder[i]).T_body_camera), kRoundoff);
  }
}

TEST(RigExport, ACamchainHasEachLens) {
  const Rig rig = a_rig();
  const YAML::Node chain = YAML::Load(kalibr_camchain(rig, kOrder));
  const YAML::Node up = chain["cam0"];
  EXPECT_EQ(up["camera_model"].as<std::string>(), "pinhole");
  EXPECT_EQ(up["distortion_model"].as<std::string>(), "equidistant");
  EXPECT_THAT(up["distortion_coeffs"].as<Numbers>(), ElementsAre(-0.01, 0.002, 0, 3e-6));
  EXPECT_THAT(up["intrinsics"].as<Numbers>(), ElementsAre(100, 100, 159.5, 159.5));
  EXPECT_THAT(up["resolution"].as<std::vector<int>>(), ElementsAre(320, 320));
  EXPECT_EQ(up["rostopic"].as<std::string>(), "/up_1/image_raw");
  EXPECT_EQ(up["timeshift_cam_imu"].as<double>(), 0);
  const YAML::Node left = chain["cam1"];
  EXPECT_EQ(left["distortion_model"].as<std::string>(), "radtan");
  EXPECT_THAT(left["distortion_coeffs"].as<Numbers>(), ElementsAre(0, 0, 0, 0));
  const YAML::Node ahead = chain["cam2"];
  EXPECT_THAT(ahead["distortion_coeffs"].as<Numbers>(), ElementsAre(-0.2, 0.05, 1e-5, -2e-4));
  EXPECT_EQ(ahead["timeshift_cam_imu"].as<double>(), -0.003) << "a stamp is late, and earlier then";
}

// As YAML 1.1 has floats: Kalibr refuses a focal length that is an integer, and a word.
TEST(RigExport, FloatsAreFloatsForEveryReader) {
  const std::string text = kalibr_camchain(a_rig(), kOrder);
  EXPECT_THAT(text, HasSubstr("intrinsics: [500.0, 501.25, 320.5, 239.0]"));
  EXPECT_THAT(text, HasSubstr("[-0.2, 0.05, 1.0e-05, -2.0e-04]"));
}

TEST(RigExport, ACamchainSaysWhatItCannotHold) {
  Rig rig = a_rig();
  EXPECT_THAT(kalibr_camchain(rig, kOrder), Not(HasSubstr("k3")));
  std::get<BrownConrady>(rig.cameras["ahead"].intrinsics.distortion).k3 = -0.01;
  const std::string text = kalibr_camchain(rig, kOrder);
  EXPECT_THAT(text, HasSubstr("# Kalibr has no k3, which is -0.01: left out, corners of the "
                              "picture are off by up to "));
  EXPECT_THAT(YAML::Load(text)["cam2"]["distortion_coeffs"].as<Numbers>(),
              ElementsAre(-0.2, 0.05, 1e-5, -2e-4));
}

TEST(RigExport, ACameraInfoIsReadAsRosReadsIt) {
  const Rig rig = a_rig();
  const auto matrix = [](const YAML::Node& node) {
    const auto data = node["data"].as<Numbers>();
    EXPECT_EQ(data.size(), node["rows"].as<std::size_t>() * node["cols"].as<std::size_t>());
    return data;
  };
  for (const auto& [name, camera] : rig.cameras) {
    const Intrinsics& lens = camera.intrinsics;
    const YAML::Node info = YAML::Load(ros_camera_info(name, lens));
    EXPECT_EQ(info["camera_name"].as<std::string>(), name);
    EXPECT_EQ(info["image_width"].as<int>(), lens.width_px);
    EXPECT_EQ(info["image_height"].as<int>(), lens.height_px);
    EXPECT_THAT(matrix(info["camera_matrix"]),
                ElementsAre(lens.fx_px, 0, lens.cx_px, 0, lens.fy_px, lens.cy_px, 0, 0, 1));
    EXPECT_THAT(matrix(info["rectification_matrix"]), ElementsAre(1, 0, 0, 0, 1, 0, 0, 0, 1));
    EXPECT_THAT(
        matrix(info["projection_matrix"]),
        ElementsAre(lens.fx_px, 0, lens.cx_px, 0, 0, lens.fy_px, lens.cy_px, 0, 0, 0, 1, 0));
  }
  const auto lens_of = [&](const char* name) {
    return YAML::Load(ros_camera_info(name, rig.cameras.at(name).intrinsics));
  };
  EXPECT_EQ(lens_of("ahead")["distortion_model"].as<std::string>(), "plumb_bob");
  EXPECT_THAT(matrix(lens_of("ahead")["distortion_coefficients"]),
              ElementsAre(-0.2, 0.05, 1e-5, -2e-4, 0));
  EXPECT_EQ(lens_of("up-1")["distortion_model"].as<std::string>(), "equidistant");
  EXPECT_THAT(matrix(lens_of("up-1")["distortion_coefficients"]),
              ElementsAre(-0.01, 0.002, 0, 3e-6));
  EXPECT_THAT(matrix(lens_of("left")["distortion_coefficients"]), ElementsAre(0, 0, 0, 0, 0));
}

Vec3 numbers_of(const std::string& text) {
  std::istringstream words(text);
  Vec3 v;
  words >> v.x() >> v.y() >> v.z();
  return v;
}

// One that looks ahead with its picture upright is turned by -90, 0 and -90 degrees; of one that
// lies on its side pitch is a quarter turn.
TEST(RigExport, AnOriginIsTurnedAboutFixedAxes) {
  const Rig rig = a_rig();
  const std::string text = urdf_of(rig, kOrder);
  EXPECT_THAT(text, HasSubstr("<link name=\"base_link\"/>"));
  const std::regex joint(
      "<joint name=\"[^\"]*\" type=\"fixed\">\\s*<parent link=\"base_link\"/>\\s*"
      "<child link=\"([^\"]*)_optical_frame\"/>\\s*<origin xyz=\"([^\"]*)\" rpy=\"([^\"]*)\"/>");
  std::size_t i = 0;
  for (std::sregex_iterator found(text.begin(), text.end(), joint), end; found != end; ++found) {
    ASSERT_LT(i, kOrder.size());
    EXPECT_EQ((*found)[1], kOrder[i]);
    const Vec3 rpy = numbers_of((*found)[3]);
    const Pose3 T{Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) *
                      Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) *
                      Eigen::AngleAxisd(rpy.x(), Vec3::UnitX()),
                  numbers_of((*found)[2])};
    EXPECT_LT(mounted_apart(T, rig.cameras.at(kOrder[i]).T_body_camera), kRoundoff);
    ++i;
  }
  EXPECT_EQ(i, kOrder.size());
}

TEST(RigExport, NamesAreEscaped) {
  Rig rig;
  const std::string name = R"(a<"&b>)";
  rig.cameras[name].intrinsics = pinhole(320, 240, 1.2);
  EXPECT_THAT(urdf_of(rig, {name}),
              HasSubstr("<child link=\"a&lt;&quot;&amp;b&gt;_optical_frame\"/>"));
  EXPECT_EQ(YAML::Load(ros_camera_info(name, rig.cameras[name].intrinsics))["camera_name"]
                .as<std::string>(),
            name);
  EXPECT_EQ(YAML::Load(ros_camera_info("007", rig.cameras[name].intrinsics))["camera_name"].Tag(),
            "!")
      << "a name that looks like a number is a word";
}

}  // namespace
}  // namespace panoptes
