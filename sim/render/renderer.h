// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

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

/// Where a pinhole camera stands and how it sees. (Lenses that bend are sim/sensors'.)
struct View {
  Intrinsics intrinsics;
  Pose3 T_scene_camera;
  double gain = 1;  ///< on the light that reaches the picture: light 1/gain is drawn white
};

/// What to draw besides the picture, in the same pass.
struct Ask {
  bool floor_label = false;
  bool depth = false;
  bool instance = false;
};

struct Drawn {
  cv::Mat bgr;          ///< 8-bit, the square root of the light times the gain
  cv::Mat floor_label;  ///< 8-bit, 255 where the picture shows what is below 2 cm; empty unless
                        ///< asked for
  cv::Mat depth_m;      ///< float, along the camera's axis, infinite where nothing is; empty unless
                        ///< asked for
  cv::Mat instance;     ///< 16-bit unsigned, 1 + the number of the object in World::objects, 0
                        ///< where nothing is; empty unless asked for
};

/// Draws a world without a screen: the same bits for any number of threads, and for any order of
/// pictures and moments. Light and shadow are computed once per world and kept in the user's cache
/// folder ($XDG_CACHE_HOME/panoptes or ~/.cache/panoptes). One thread uses it, every picture is a
/// new one; a process that has made one must not fork. Throws DeviceError when there is no OpenGL
/// to be had.
class Renderer {
 public:
  explicit Renderer(const World& world, const RendererOptions& options = {});
  ~Renderer();

  Drawn draw(const View& view, const Ask& ask = {}, const Moment& moment = {});

  std::string drawn_by() const;  ///< as "OSMesa, llvmpipe (LLVM 15.0.6, 256 bits)"

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// How many threads draw, for every renderer of this process: call it before the first one is made.
/// Does nothing where the environment says so already (LP_NUM_THREADS, where 0 and 1 are the
/// calling thread alone).
void set_render_threads(int num_threads);

/// From here on OpenGL, too, draws the same bits on every x86-64 processor (with the same Mesa), by
/// instructions that all of them have (SSE 4.1) and never on a graphics card; for a quarter more
/// time. For every renderer of this process: call it before the first one is made.
void set_same_on_every_processor();

}  // namespace panoptes::sim
