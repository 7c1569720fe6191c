// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/command.h"
#include "apps/run/mission.h"
#include "apps/run/out_dir.h"
#include "apps/run/pictures.h"
#include "apps/run/recorder.h"
#include "core/base/error.h"
#include "core/io/file.h"
#include "sim/render/renderer.h"
#include "sim/world/layers.h"
#include "sim/world/load.h"

namespace panoptes {
namespace {

constexpr double kPlanCell_m = 0.02;  // of a pixel of the floor plan
constexpr double kFrustum_m = 1.0;    // how far the sides of a view are drawn
constexpr int kGap_px = 8;
constexpr int kLine_px = 20;

struct RenderArguments {
  std::string mission;
  std::string pose;
  CommonArguments common;
};

Pose2 parse_pose(const std::string& text) {
  std::array<double, 3> numbers{};
  const char* at = text.data();
  const char* end = at + text.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto [after, error] = std::from_chars(at, end, numbers[i]);
    const bool last = i + 1 == numbers.size();
    if (error != std::errc() || !std::isfinite(numbers[i]) ||
        (last ? after != end : after == end || *after != ',')) {
      throw ConfigError("--pose " + text +
                        ": must be x,y,theta_deg in scene, metres and degrees, e.g. 2,3,90");
    }
    at = after + (last ? 0 : 1);
  }
  return {numbers[0], numbers[1], deg_to_rad(numbers[2])};
}

/// A camera of the rig at the pose, and what it sees.
struct Shot {
  std::string name;
  std::optional<FloorView> floor;  ///< where it maps the floor
  sim::View view;
  sim::Drawn drawn;
};

std::vector<Shot> shoot(const sim::World& world, const Rig& rig, const Pose2& T_scene_body) {
  sim::Renderer renderer(world);
  std::vector<Shot> shots;
  for (const auto& [name, camera] : rig.cameras) {
    Shot shot{
        name, camera.floor, {camera.intrinsics, on_floor(T_scene_body) * camera.T_body_camera}, {}};
    shot.drawn = renderer.draw(shot.view, {.depth = shot.floor.has_value()});
    shots.push_back(std::move(shot));
  }
  return shots;
}

bool sees_floor(const Shot& shot, const Vec2& p_scene) {
  const Vec3 p_camera = shot.view.T_scene_camera.inverse() * Vec3(p_scene.x(), p_scene.y(), 0);
  if (p_camera.z() <= 0) {
    return false;
  }
  const Vec2 px = shot.view.intrinsics.project(p_camera);
  const cv::Rect picture({}, shot.drawn.depth_m.size());
  const cv::Point pixel(static_cast<int>(std::lround(px.x())),
                        static_cast<int>(std::lround(px.y())));
  if (!picture.contains(pixel)) {
    return false;
  }
  // The pixel's middle may show floor that is nearer, by up to the depth that one row of it spans.
  const double height_m = shot.view.T_scene_camera.translation.z();
  const double row_m = p_camera.z() * p_camera.z() / (height_m * shot.view.intrinsics.fy_px);
  return shot.drawn.depth_m.at<float>(pixel) > p_camera.z() - row_m;
}

/// The world from above, north up: what stands there at the height of the robot's body, the robot,
/// the sides of its cameras' views, and the floor that its floor cameras see, the mapped part
/// darker.
cv::Mat floor_plan(const sim::World& world, const Body& body, const Pose2& T_scene_body,
                   const std::vector<Shot>& shots) {
  const TruthLayer layer = sim::occupancy(world, sim::kFloorLayerTop_m, body.height_m, kPlanCell_m);
  cv::Mat plan(layer.rows, layer.columns, CV_8UC3, cv::Scalar::all(255));
  for (int row = 0; row < layer.rows; ++row) {
    auto* pixels = plan.ptr<cv::Vec3b>(layer.rows - 1 - row);
    for (int column = 0; column < layer.columns; ++column) {
      const Vec2 centre = layer.origin_scene + kPlanCell_m * Vec2(column + 0.5, row + 0.5);
      if (layer.at(centre)) {
        pixels[column] = {70, 70, 70};
        continue;
      }
      const double ahead_m = (T_scene_body.inverse() * centre).x() - body.radius_m;
      for (const Shot& shot : shots) {
        if (shot.floor && sees_floor(shot, centre)) {
          const bool mapped = ahead_m >= shot.floor->near_m && ahead_m <= shot.floor->far_m;
          pixels[column] = mapped ? cv::Vec3b(150, 215, 150) : cv::Vec3b(215, 238, 215);
        }
      }
    }
  }
  const auto pixel = [&layer](const Vec2& p_scene) {
    const Vec2 cell = (p_scene - layer.origin_scene) / kPlanCell_m;
    return cv::Point(static_cast<int>(std::lround(cell.x())),
                     layer.rows - 1 - static_cast<int>(std::lround(cell.y())));
  };
  for (const Shot& shot : shots) {
    const Vec3& eye = shot.view.T_scene_camera.translation;
    const cv::Scalar colour = shot.floor ? cv::Scalar(60, 140, 40) : cv::Scalar(196, 98, 31);
    const double middle_px = (shot.view.intrinsics.height_px - 1) / 2.0;
    for (const double side_px : {-0.5, shot.view.intrinsics.width_px - 0.5}) {
      const Vec3 ray =
          shot.view.T_scene_camera.rotation * shot.view.intrinsics.ray(Vec2(side_px, middle_px));
      cv::line(plan, pixel(eye.head<2>()),
               pixel(eye.head<2>() + kFrustum_m * ray.head<2>().normalized()), colour, 1,
               cv::LINE_AA);
    }
  }
  cv::circle(plan, pixel(T_scene_body.position()),
             static_cast<int>(std::lround(body.radius_m / kPlanCell_m)), {38, 28, 214}, 1,
             cv::LINE_AA);
  cv::line(plan, pixel(T_scene_body.position()), pixel(T_scene_body * Vec2(body.radius_m, 0)),
           {38, 28, 214}, 2, cv::LINE_AA);
  return plan;
}

/// The pictures under one another with their names, the plan beside them.
cv::Mat contact_sheet(const std::vector<Shot>& shots, const cv::Mat& plan) {
  int left_px = 0;
  int height_px = kGap_px;
  for (const Shot& shot : shots) {
    left_px = std::max(left_px, shot.drawn.bgr.cols);
    height_px += kLine_px + shot.drawn.bgr.rows + kGap_px;
  }
  const cv::Size size(left_px + plan.cols + 3 * kGap_px,
                      std::max(height_px, plan.rows + 2 * kGap_px));
  cv::Mat sheet(size, CV_8UC3, cv::Scalar::all(235));
  int y = kGap_px;
  for (const Shot& shot : shots) {
    cv::putText(sheet, shot.name, {kGap_px, y + 14}, cv::FONT_HERSHEY_SIMPLEX, 0.5, {40, 40, 40}, 1,
                cv::LINE_AA);
    y += kLine_px;
    shot.drawn.bgr.copyTo(sheet(cv::Rect({kGap_px, y}, shot.drawn.bgr.size())));
    y += shot.drawn.bgr.rows + kGap_px;
  }
  plan.copyTo(sheet(cv::Rect({left_px + 2 * kGap_px, kGap_px}, plan.size())));
  return sheet;
}

// What each camera of the rig would see from there, as believed to be mounted, without noise.
int render(const RenderArguments& args) {
  const Pose2 T_scene_body = parse_pose(args.pose);
  const auto mission = load_mission<ExploreMission>(args.mission, args.common.overrides());
  const auto* simulated = std::get_if<sim::SimulatedOptions>(&mission.platform);
  if (simulated == nullptr) {
    throw ConfigError(args.mission + ": platform: nothing to draw; render needs a simulated one");
  }
  const sim::World world = sim::make_world(simulated->world);
  const std::filesystem::path out_dir = args.common.out_dir.value_or(default_out_dir(mission));
  OutDir out(out_dir);
  out.keep();
  const std::vector<Shot> shots = shoot(world, mission.rig, T_scene_body);
  for (const Shot& shot : shots) {
    write_file(out_dir / (shot.name + ".png"), png(shot.drawn.bgr));
  }
  const cv::Mat plan = floor_plan(world, mission.robot, T_scene_body, shots);
  write_file(out_dir / "render.png", png(contact_sheet(shots, plan)));
  std::printf("%s\n", (out_dir / "render.png").c_str());
  return 0;
}

}  // namespace

void add_render(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<RenderArguments>();
  CLI::App* sub = app.add_subcommand("render", "What would each camera see there?");
  sub->add_option("MISSION", args->mission, "the mission file")->required()->type_name("FILE");
  sub->add_option("--pose", args->pose, "the robot's place in scene, metres and degrees")
      ->required()
      ->type_name("X,Y,THETA_DEG");
  add_common(*sub, args->common);
  sub->footer(
      "Example: panoptes render scenes/missions/explore-office.yaml --pose 5,5,45 --out runs/look");
  sub->callback([args, &chosen] { chosen = [args] { return render(*args); }; });
}

}  // namespace panoptes
