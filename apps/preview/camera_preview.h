// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/mission/mission.h"
#include "core/base/time.h"
#include "sim/render/renderer.h"
#include "sim/sensors/camera_sensor.h"

namespace panoptes {

/// A camera of the rig, and what it sees from somewhere.
struct CameraView {
  std::string name;
  RigCamera camera;
  Pose3 T_scene_camera;
  sim::SensorImage image;  ///< with the floor's label
};

/// What the cameras of a mission's rig see of its world from anywhere: as believed to be mounted,
/// through their lenses and as they expose, but without noise and standing still.
class CameraPreview {
 public:
  /// Throws as making the world and the renderer does.
  CameraPreview(const ExploreMission& mission, const sim::SimulatedOptions& platform,
                const sim::RendererOptions& renderer);
  ~CameraPreview();

  /// At an instant of the world, the robot having stood there all the time.
  struct Views {
    std::vector<CameraView> cameras;                ///< in the order of the cameras' names
    std::vector<std::vector<Vec2>> outlines_scene;  ///< of what stands in the robot's way
    Vec2 low_scene = Vec2::Zero();                  ///< corners of the world
    Vec2 high_scene = Vec2::Zero();
    std::optional<double> clearance_m;  ///< from the body to the nearest object; none outside
    std::string fault;  ///< why no robot can stand there, in words; empty when one can
  };
  Views render(const Pose2& T_scene_body, Time at, const sim::RenderOutputs& outputs);

  const std::vector<std::string>& instance_names()
      const;  ///< what SensorImage::instance counts, from 1

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace panoptes
