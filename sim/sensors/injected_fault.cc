// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/injected_fault.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace panoptes::sim {

void bind(Fields& f, InjectedFault& o) {
  f("camera", o.camera);
  f.require(f.writing() || f.present("fault"), "fault",
            "missing; it must be freeze, cover, black, unplug or knock");
  if (f.writing() || f.present("fault")) {
    f.word("fault", o.fault,
           {{"freeze", CameraFaultKind::kFreeze},
            {"cover", CameraFaultKind::kCover},
            {"black", CameraFaultKind::kBlack},
            {"unplug", CameraFaultKind::kUnplug},
            {"knock", CameraFaultKind::kKnock}});
  }
  f.needed("at_s", o.at_s, not_negative);
  f("for_s", o.for_s, positive);
  if (o.fault == CameraFaultKind::kKnock) {
    f.require(!o.for_s, "for_s",
              "must not be given: what is knocked stays as it is; to put it back, knock it back");
    bind(f, o.knock);
    f.require(!o.knock.rotation_rad.isZero(0) || !o.knock.shift_m.isZero(0), "fault",
              "must turn or shift the camera; give roll_deg, pitch_deg, yaw_deg, x_m, y_m or z_m");
  }
}

bool InjectedFault::befalls(const std::string& name, Time stamp) const {
  return (camera.empty() || camera == name) && stamp >= time_at(at_s) &&
         (!for_s || stamp < time_at(at_s + *for_s));
}

std::vector<KeyFault> injection_faults(const std::vector<InjectedFault>& faults, const Rig& rig) {
  std::vector<std::string> known;
  for (const auto& [name, camera] : rig.cameras) {
    known.push_back(name);
  }
  std::vector<KeyFault> wrong;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const std::string& camera = faults[i].camera;
    if (!camera.empty() && !rig.cameras.contains(camera)) {
      const std::string near = nearest_word(camera, known);
      wrong.push_back(
          {"faults[" + std::to_string(i) + "].camera",
           "the rig has no camera " + camera +
               (near.empty() ? "; name one of the rig's" : "; did you mean " + near + "?")});
    }
  }
  return wrong;
}

std::optional<CameraFaultKind> fault_at(const std::vector<InjectedFault>& faults,
                                        const std::string& camera, Time stamp) {
  for (const InjectedFault& one : faults) {
    if (one.fault != CameraFaultKind::kKnock && one.befalls(camera, stamp)) {
      return one.fault;
    }
  }
  return std::nullopt;
}

bool is_knocked(const std::vector<InjectedFault>& faults, const std::string& camera, Time t) {
  return std::any_of(faults.begin(), faults.end(), [&](const InjectedFault& one) {
    return one.fault == CameraFaultKind::kKnock && one.befalls(camera, t);
  });
}

Pose3 knocked(const std::vector<InjectedFault>& faults, const std::string& camera, Time t,
              const Pose3& T_body_camera) {
  Pose3 T = T_body_camera;
  for (const InjectedFault& one : faults) {
    if (one.fault == CameraFaultKind::kKnock && one.befalls(camera, t)) {
      T = displaced(T, one.knock);
    }
  }
  return T;
}

void cover(cv::Mat& bgr) {
  const cv::Size size = bgr.size();
  const cv::Size few(4, 3);  // so much form is left of what is outside
  const cv::Scalar skin(0.15, 0.2, 0.3);
  cv::Mat light;
  cv::resize(bgr, light, few, 0, 0, cv::INTER_AREA);
  cv::multiply(light, skin, light);
  cv::resize(light, bgr, size, 0, 0, cv::INTER_CUBIC);
}

}  // namespace panoptes::sim
