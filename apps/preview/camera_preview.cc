// SPDX-License-Identifier: BSD-3-Clause
#include "apps/preview/camera_preview.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "sim/physics/drive_world.h"
#include "sim/physics/dynamic_objects.h"
#include "sim/physics/obstacles.h"
#include "sim/simulated_robot.h"
#include "sim/world/layers.h"
#include "sim/world/load.h"

namespace panoptes {
namespace {

sim::SensorOptions quiet(sim::SensorOptions sensor) {
  sensor.noise = sim::NoNoise();
  sensor.motion_blur = false;
  sensor.row_us = 0;
  return sensor;
}

std::string fault_of(const Vec2& at, double radius_m, const sim::Obstacles& obstacles,
                     const sim::WorldBox& world) {
  if (const std::string fault = world.outside_fault(at); !fault.empty()) {
    return fault;
  }
  const auto nearest = obstacles.nearest(at, radius_m);
  if (!nearest) {
    return {};
  }
  return nearest->distance_m == 0
             ? "is inside " + nearest->outline->object
             : fmt::format("is {:.2f} m from {}, but the robot's body reaches {:.2f} m",
                           nearest->distance_m, nearest->outline->object, radius_m);
}

sim::RendererOptions by(sim::PainterKind painter, sim::RendererOptions options) {
  options.painter = painter;
  return options;
}

}  // namespace

class CameraPreview::Impl {
 public:
  Impl(const ExploreMission& mission, const sim::SimulatedOptions& platform,
       const sim::RendererOptions& renderer)
      : mission_(mission),
        platform_(platform),
        world_(sim::make_world(platform.world)),
        around_(sim::bare_surroundings(world_, mission.robot)),
        renderer_(world_, by(platform.renderer, renderer)) {}

  Views render(const Pose2& T_scene_body, Time at, const sim::RenderOutputs& outputs) {
    const Body& body = mission_.robot;
    sim::DynamicObjects dynamic_objects = around_.dynamic_objects;
    for (std::int64_t step = 0; sim::time_of_step(step + 1) <= at; ++step) {
      dynamic_objects.step(sim::time_of_step(step), sim::time_of_step(step + 1),
                           {T_scene_body.position(), body.radius_m});
    }
    const sim::SceneState scene_state = dynamic_objects.scene_state(at, dynamic_objects.places());
    Views views;
    for (const auto& [name, camera] : mission_.rig.cameras) {
      const auto own = platform_.sensors.find(name);
      sim::CameraSensor sensor(
          name, camera.intrinsics,
          quiet(own == platform_.sensors.end() ? platform_.sensor : own->second),
          Rng(mission_.seed).fork("robot").fork("pixels"));
      CameraView camera_view{name, camera, on_floor(T_scene_body) * camera.T_body_camera, {}};
      sim::RenderOutputs with_floor = outputs;
      with_floor.floor_label = true;
      camera_view.image = sensor.take(
          [&](const sim::View& view, const sim::RenderOutputs& of_view) {
            return renderer_.draw(view, of_view, scene_state);
          },
          [&](Duration) { return camera_view.T_scene_camera; }, 0, with_floor);
      views.cameras.push_back(std::move(camera_view));
    }
    std::vector<sim::Outline> outlines = around_.outlines;
    for (sim::Outline& outline : dynamic_objects.outlines_now()) {
      outlines.push_back(std::move(outline));
    }
    const sim::Obstacles obstacles(std::move(outlines));
    for (const sim::Outline& outline : obstacles.outlines()) {
      views.outlines_scene.push_back(outline.corners_scene);
    }
    const sim::WorldBox box = sim::world_box(obstacles, around_.floor_surfaces);
    views.low_scene = box.low_scene;
    views.high_scene = box.high_scene;
    views.fault = fault_of(T_scene_body.position(), body.radius_m, obstacles, box);
    if (const auto nearest = obstacles.nearest(T_scene_body.position())) {
      views.clearance_m = std::max(0.0, nearest->distance_m - body.radius_m);
    }
    return views;
  }

  const std::vector<std::string>& instance_names() const { return around_.object_names; }

 private:
  const ExploreMission& mission_;
  const sim::SimulatedOptions& platform_;
  sim::World world_;
  sim::Surroundings around_;
  sim::Renderer renderer_;
};

CameraPreview::CameraPreview(const ExploreMission& mission, const sim::SimulatedOptions& platform,
                             const sim::RendererOptions& renderer)
    : impl_(std::make_unique<Impl>(mission, platform, renderer)) {}
CameraPreview::~CameraPreview() = default;

CameraPreview::Views CameraPreview::render(const Pose2& T_scene_body, Time at,
                                           const sim::RenderOutputs& outputs) {
  return impl_->render(T_scene_body, at, outputs);
}

const std::vector<std::string>& CameraPreview::instance_names() const {
  return impl_->instance_names();
}

}  // namespace panoptes
