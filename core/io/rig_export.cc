// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/rig_export.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include <fmt/format.h>

#include "core/base/text.h"
#include "core/camera/lens_parameters.h"
#include "core/io/digits.h"

namespace panoptes {
namespace {

/// YAML 1.1 takes what has no point for an integer, and 1e-05 for a word.
std::string yaml_float(double value) {
  std::string digits = shortest(value);
  if (digits.find('.') == std::string::npos) {
    digits.insert(std::min(digits.find('e'), digits.size()), ".0");
  }
  return digits;
}

std::string yaml_list(const std::vector<double>& numbers) {
  std::vector<std::string> words;
  for (const double number : numbers) {
    words.push_back(yaml_float(number));
  }
  return fmt::format("[{}]", joined(words, ", "));
}

/// As both have them: those of a lens that bends nothing are zero.
std::vector<double> distortion_coefficients(const Intrinsics& lens) {
  if (lens.is_pinhole()) {
    return {0, 0, 0, 0, 0};
  }
  const Eigen::VectorXd all = lens_parameters(lens);
  return {all.begin() + 4, all.end()};
}

bool is_fisheye(const Intrinsics& lens) {
  return std::holds_alternative<Equidistant>(lens.distortion);
}

/// By how far corners of the picture are drawn elsewhere without k3, at most.
double moved_without_k3_px(const Intrinsics& lens) {
  Intrinsics without = lens;
  std::get<BrownConrady>(without.distortion).k3 = 0;
  double most_px = 0;
  for (const double u : {0.0, lens.width_px - 1.0}) {
    for (const double v : {0.0, lens.height_px - 1.0}) {
      const Vec2 px(u, v);
      most_px = std::max(most_px, (without.project(lens.ray(px)) - px).norm());
    }
  }
  return most_px;
}

std::string camchain_entry(const RigCamera& camera) {
  const Intrinsics& lens = camera.intrinsics;
  std::vector<double> coefficients = distortion_coefficients(lens);
  coefficients.resize(4);
  std::string text = "  camera_model: pinhole\n";
  text += "  intrinsics: " + yaml_list({lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px}) + "\n";
  const auto* bent = std::get_if<BrownConrady>(&lens.distortion);
  if (bent != nullptr && bent->k3 != 0) {
    text += fmt::format(
        "  # Kalibr has no k3, which is {}: left out, corners of the picture are off by up to "
        "{:.2f} px\n",
        shortest(bent->k3), moved_without_k3_px(lens));
  }
  text += fmt::format("  distortion_model: {}\n", is_fisheye(lens) ? "equidistant" : "radtan");
  text += "  distortion_coeffs: " + yaml_list(coefficients) + "\n";
  text += fmt::format("  resolution: [{}, {}]\n", lens.width_px, lens.height_px);
  text += "  timeshift_cam_imu: " + yaml_float(-camera.clock_offset_s) + "\n";
  return text;
}

std::string pose_rows(const Pose3& T) {
  const Mat3 R = T.rotation.toRotationMatrix();
  std::string text;
  for (Eigen::Index row = 0; row < 3; ++row) {
    text += "  - " + yaml_list({R(row, 0), R(row, 1), R(row, 2), T.translation[row]}) + "\n";
  }
  return text + "  - [0.0, 0.0, 0.0, 1.0]\n";
}

std::string ros_matrix(const char* key, int rows, const std::vector<double>& numbers) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", key, rows,
                     numbers.size() / static_cast<std::size_t>(rows), yaml_list(numbers));
}

/// R = Rz(yaw) Ry(pitch) Rx(roll), also where pitch is a quarter turn.
Vec3 roll_pitch_yaw(const Mat3& R) {
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const double s = std::sin(yaw);
  const double c = std::cos(yaw);
  return {std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1)),
          std::atan2(-R(2, 0), c * R(0, 0) + s * R(1, 0)), yaw};
}

std::string xml_numbers(const Vec3& v) {
  return shortest(v.x()) + " " + shortest(v.y()) + " " + shortest(v.z());
}

}  // namespace

std::string kalibr_camchain(const Rig& rig, const std::vector<std::string>& cameras) {
  std::string text =
      "# timeshift_cam_imu: against the odometry's clock. rostopic: change it to your driver's.\n";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const RigCamera& camera = rig.cameras.at(cameras[i]);
    text += fmt::format("cam{}:  # {}\n", i, cameras[i]);
    text += camchain_entry(camera);
    std::string topic = cameras[i];
    std::replace(topic.begin(), topic.end(), '-', '_');  // no name in ROS has it
    text += "  rostopic: " + in_quotes("/" + topic + "/image_raw") + "\n";
    if (i > 0) {
      const Pose3& T_body_before = rig.cameras.at(cameras[i - 1]).T_body_camera;
      text += "  T_cn_cnm1:\n" + pose_rows(camera.T_body_camera.inverse() * T_body_before);
    }
  }
  return text;
}

std::string ros_camera_info(const std::string& camera, const Intrinsics& lens) {
  const double fx = lens.fx_px;
  const double fy = lens.fy_px;
  const double cx = lens.cx_px;
  const double cy = lens.cy_px;
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", lens.width_px,
                     lens.height_px, in_quotes(camera)) +
         ros_matrix("camera_matrix", 3, {fx, 0, cx, 0, fy, cy, 0, 0, 1}) +
         fmt::format("distortion_model: {}\n", is_fisheye(lens) ? "equidistant" : "plumb_bob") +
         ros_matrix("distortion_coefficients", 1, distortion_coefficients(lens)) +
         ros_matrix("rectification_matrix", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         ros_matrix("projection_matrix", 3, {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0});
}

std::string urdf_of(const Rig& rig, const std::vector<std::string>& cameras) {
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<!-- base_link is on the floor between the wheels, x ahead, y to the left, z up. -->\n"
      "<robot name=\"rig\">\n"
      "  <link name=\"base_link\"/>\n";
  for (const std::string& camera : cameras) {
    const Pose3& T = rig.cameras.at(camera).T_body_camera;
    const std::string name = xml_text(camera);
    text += fmt::format(
        "  <link name=\"{0}_optical_frame\"/>\n"
        "  <joint name=\"{0}_optical_joint\" type=\"fixed\">\n"
        "    <parent link=\"base_link\"/>\n"
        "    <child link=\"{0}_optical_frame\"/>\n"
        "    <origin xyz=\"{1}\" rpy=\"{2}\"/>\n"
        "  </joint>\n",
        name, xml_numbers(T.translation),
        xml_numbers(roll_pitch_yaw(T.rotation.toRotationMatrix())));
  }
  return text + "</robot>\n";
}

}  // namespace panoptes
