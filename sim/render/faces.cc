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

Drawn draw_faces(const View& view, const Ask& ask,
                 const std::function<Drawn(const View& pinhole, const Ask&)>& draw) {
  const Faces& faces = *view.faces;
  Drawn canvas;
  for (const Faces::Face& face : faces.faces) {
    const Drawn drawn = draw(view.through(face), ask);
    paste(drawn.bgr, faces.canvas_px, face.top_px, canvas.bgr);
    paste(drawn.floor_label, faces.canvas_px, face.top_px, canvas.floor_label);
    paste(drawn.depth_m, faces.canvas_px, face.top_px, canvas.depth_m);
    paste(drawn.instance, faces.canvas_px, face.top_px, canvas.instance);
  }
  const auto look = [&faces](const cv::Mat& from, int interpolation) {
    cv::Mat to;
    if (!from.empty()) {
      cv::remap(from, to, faces.x_px, faces.y_px, interpolation, cv::BORDER_REPLICATE);
    }
    return to;
  };
  return {look(canvas.bgr, cv::INTER_LINEAR), look(canvas.floor_label, cv::INTER_NEAREST),
          look(canvas.depth_m, cv::INTER_NEAREST), look(canvas.instance, cv::INTER_NEAREST)};
}

}  // namespace panoptes::sim
