// SPDX-License-Identifier: BSD-3-Clause
#include "apps/relax/graph_picture.h"

#include <algorithm>

#include "apps/draw/canvas.h"
#include "apps/draw/pictures.h"
#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kPanel_px = 620;
constexpr double kMargin_px = 24;
constexpr double kHead_px = 72;
constexpr double kFoot_px = 56;

void draw_panel(Canvas& canvas, const GraphPicture& picture, const std::vector<Pose2>& poses,
                double left_px, const std::string& name, bool rejected) {
  Vec2 low = poses.front().position();
  Vec2 high = low;
  for (const Pose2& pose : poses) {
    low = low.cwiseMin(pose.position());
    high = high.cwiseMax(pose.position());
  }
  constexpr double kInside_px = kPanel_px - 2 * kMargin_px;
  constexpr double kLeast_m = 1e-3;  // a graph of one place has no size
  const double px_per_m = kInside_px / std::max(kLeast_m, (high - low).maxCoeff());
  const Vec2 middle = 0.5 * (low + high);
  const auto to_px = [&](int node) {
    const Vec2 p = (poses[node].position() - middle) * px_per_m;
    return Vec2(left_px + kPanel_px / 2 + p.x(), kHead_px + kPanel_px / 2 - p.y());
  };
  canvas.text(name, {left_px + kMargin_px, kHead_px - 10}, kInk);
  const auto draw = [&](bool closure, bool kept, const Colour& colour, double width) {
    for (std::size_t e = 0; e < picture.before.edges.size(); ++e) {
      const GraphEdge& edge = picture.before.edges[e];
      if (picture.kept[e] == kept && (edge.closure == closure || !kept)) {
        canvas.line(to_px(edge.from), to_px(edge.to), colour, width);
      }
    }
  };
  draw(true, true, kLoopColour, 1);
  if (rejected) {
    draw(true, false, kWrongColour, 1.25);
  }
  draw(false, true, kEstimateColour, 1.5);
  canvas.disc(to_px(0), 5, kInk);
  const double bar_m = round_step((high - low).maxCoeff() / 3, 2);
  canvas.scale_bar({left_px + kPanel_px - kMargin_px, kHead_px - 14}, bar_m, px_per_m);
}

}  // namespace

cv::Mat draw_graph(const GraphPicture& picture) {
  PANOPTES_CHECK(!picture.before.T_map_node.empty() &&
                     picture.T_map_node_after.size() == picture.before.T_map_node.size() &&
                     picture.kept.size() == picture.before.edges.size(),
                 "a graph, its relaxed poses and a verdict an edge");
  Canvas canvas(static_cast<int>(2 * kPanel_px), static_cast<int>(kHead_px + kPanel_px + kFoot_px),
                kPaper);
  canvas.text(picture.title, {kMargin_px, 32}, kInk, 19);
  draw_panel(canvas, picture, picture.before.T_map_node, 0, "before", true);
  draw_panel(canvas, picture, picture.T_map_node_after, kPanel_px, "after", false);
  double x = kMargin_px;
  const double base = kHead_px + kPanel_px + 34;
  const auto entry = [&](const std::string& name, const Colour& colour) {
    canvas.line({x, base - 5}, {x + 22, base - 5}, colour, 3);
    canvas.text(name, {x + 28, base}, kInk);
    x += 28 + Canvas::text_width(name, 15) + 20;
  };
  entry("odometry", kEstimateColour);
  entry("loop closures", kLoopColour);
  if (std::find(picture.kept.begin(), picture.kept.end(), false) != picture.kept.end()) {
    entry("rejected ones", kWrongColour);
  }
  return canvas.shrunk();
}

}  // namespace panoptes
