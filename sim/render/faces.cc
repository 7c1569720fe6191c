// SPDX-License-Identifier: BSD-3-Clause
#include <opencv2/imgproc.hpp>

#include "sim/render/renderer.h"

namespace panoptes::sim {
namespace {

void paste(const cv::Mat& part, const cv::Size& canvas_px, int row, cv::Mat& canvas) {
  if (!part.empty()) {
    canvas.create(canvas_px, part.type());
    part.copyTo(canvas(cv::Rect(0, row, part.cols, part.rows)));
  }
}

}  // namespace

RenderedImage draw_faces(
    const View& view, const RenderOutputs& outputs,
    const std::function<RenderedImage(const View& pinhole, const RenderOutputs&)>& draw) {
  const PinholeFaces& faces = *view.faces;
  RenderedImage canvas;
  for (const PinholeFaces::Face& face : faces.faces) {
    const RenderedImage rendered = draw(view.through(face), outputs);
    paste(rendered.bgr, faces.canvas_px, face.top_px, canvas.bgr);
    paste(rendered.floor_label, faces.canvas_px, face.top_px, canvas.floor_label);
    paste(rendered.depth_m, faces.canvas_px, face.top_px, canvas.depth_m);
    paste(rendered.instance, faces.canvas_px, face.top_px, canvas.instance);
  }
  const auto remap = [&faces](const cv::Mat& from, int interpolation) {
    cv::Mat to;
    if (!from.empty()) {
      cv::remap(from, to, faces.x_px, faces.y_px, interpolation, cv::BORDER_REPLICATE);
    }
    return to;
  };
  return {remap(canvas.bgr, cv::INTER_LINEAR), remap(canvas.floor_label, cv::INTER_NEAREST),
          remap(canvas.depth_m, cv::INTER_NEAREST), remap(canvas.instance, cv::INTER_NEAREST)};
}

}  // namespace panoptes::sim
