// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera/rig.h"
#include "core/geometry/pose3.h"
#include "sim/world/world.h"

namespace panoptes::sim {

/// What draws. The two of OpenGL give the same bits where EGL finds no graphics card.
enum class PainterKind {
  kSoftware,  ///< our own, the fastest without a graphics card: the same bits on every processor
  kOsMesa,    ///< OpenGL in software
  kEgl        ///< OpenGL on a graphics card where there is one, else as OSMesa
};

struct RendererOptions {
  PainterKind painter = PainterKind::kSoftware;
  double lightmap_cell_m =
      0.05;                     ///< how finely light and shadow are kept, in worlds of a few rooms
  int bake_threads = 2;         ///< the picture does not depend on it
  bool narrow_vectors = false;  ///< our own painter with instructions that every processor has:
                                ///< slower, the same bits
  double near_m = 0.03;         ///< nothing nearer to the camera is drawn
  /// Called now and then, in the constructing thread, with the share that is done while light and
  /// shadow are computed (not when they are known already); false stops it with BakeStopped.
  std::function<bool(double done)> bake_progress;
};

/// RendererOptions::bake_progress said no.
class BakeStopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How a lens that bends sees: through pinholes, whose pictures stand below one another in a
/// canvas. Each pixel of the lens looks at a place in it.
struct PinholeFaces {
  struct Face {
    Intrinsics pinhole;
    Pose3 T_camera_face;  ///< turned, not moved
    int top_px = 0;       ///< its first row in the canvas, a multiple of kFaceRows
  };
  std::vector<Face> faces;
  cv::Size canvas_px;  ///< multiples of kFaceRows
  cv::Mat x_px;        ///< in the canvas, at least half a pixel within a face; float, as the others
  cv::Mat y_px;
  cv::Mat detail_px2;  ///< how much of the canvas a pixel of the lens covers
};
inline constexpr int kFaceRows = 8;

/// Where a camera stands and how it sees.
struct View {
  Intrinsics intrinsics;
  Pose3 T_scene_camera;
  double gain = 1;  ///< on the light that reaches the picture: light 1/gain is drawn white
  const PinholeFaces* faces = nullptr;  ///< of a lens that bends; a pinhole has none

  /// What one of them sees.
  View through(const PinholeFaces::Face& face) const {
    return {face.pinhole, T_scene_camera * face.T_camera_face, gain, nullptr};
  }
};

/// What to draw besides the picture, in the same pass.
struct RenderOutputs {
  bool floor_label = false;
  bool depth = false;
  bool instance = false;
};

struct RenderedImage {
  cv::Mat bgr;          ///< 8-bit, the square root of the light times the gain
  cv::Mat floor_label;  ///< 8-bit, 255 where the picture shows what is below 2 cm; empty unless
                        ///< asked for
  cv::Mat depth_m;      ///< float, along the axis of the pinhole or of the face that shows it,
                        ///< infinite where nothing is; empty unless asked for
  cv::Mat instance;     ///< 16-bit unsigned, 1 + the number of the object in World::objects, 0
                        ///< where nothing is; empty unless asked for
};

/// What a view of several faces shows, by pictures of each.
RenderedImage draw_faces(
    const View& view, const RenderOutputs& outputs,
    const std::function<RenderedImage(const View& pinhole, const RenderOutputs&)>& draw);

/// Draws a world without a screen: the same bits for any number of threads, and for any order of
/// pictures and scene states. Light and shadow are computed once per world and kept in the user's
/// cache folder ($XDG_CACHE_HOME/panoptes or ~/.cache/panoptes). One thread uses it, every picture
/// is a new one; a process that has made one must not fork. Throws DeviceError when there is no
/// OpenGL to be had.
class Renderer {
 public:
  explicit Renderer(const World& world, const RendererOptions& options = {});
  ~Renderer();

  RenderedImage draw(const View& view, const RenderOutputs& outputs = {},
                     const SceneState& scene_state = {});

  std::string drawn_by() const;  ///< as "OSMesa, llvmpipe (LLVM 15.0.6, 256 bits)"

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// How many threads draw, the calling one included, in every renderer that is made from here on;
/// one as long as nobody says so. OpenGL takes the number once in a process, and from
/// LP_NUM_THREADS where the environment has that.
void set_render_threads(int num_threads);
int render_threads();

/// From here on OpenGL, too, draws the same bits on every x86-64 processor (with the same Mesa), by
/// instructions that all of them have (SSE 4.1) and never on a graphics card; for a quarter more
/// time. For every renderer of this process: call it before the first one is made.
void set_same_on_every_processor();

}  // namespace panoptes::sim
