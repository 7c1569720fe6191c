// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "sim/render/renderer.h"
#include "sim/render/texture_arrays.h"

namespace panoptes::sim {

inline constexpr double kFloorTop_m = 0.02;  ///< what is lower is labelled as floor

struct Vertex {
  std::array<float, 3> p_scene;
  std::array<float, 2> texture_uv;   ///< texture coordinates, 0 to 1
  std::array<float, 2> lightmap_uv;  ///< lightmap coordinates, 0 to 1
  std::uint16_t layer;               ///< of the texture array
  std::uint16_t object;              ///< 1 + its number

  bool operator==(const Vertex&) const = default;
};
static_assert(sizeof(Vertex) == 32);

/// Triangles that show textures of one array.
struct Call {
  std::uint32_t array = 0;
  std::size_t first = 0;  ///< in the indices
  std::size_t count = 0;
};

/// Which triangles to paint, in this order: three vertices each.
struct DrawList {
  std::vector<std::uint32_t> indices;
  std::vector<Call> calls;
};

/// Which of them a pinhole sees; good until it is asked again.
using Visible = std::function<const DrawList&(const View& pinhole)>;

/// A picture of textured triangles on which light has fallen.
struct RenderJob {
  View view;
  double near_m = 0.03;
  double light_gain = 1;         ///< on the lightmap's values, which are roots of light
  std::array<float, 3> sky_bgr;  ///< where nothing is, 0 to 1
  RenderOutputs outputs;
};

/// What turns triangles into pixels. Used in one thread at a time; textures and lightmap hold
/// square roots, so that their product is the root of the light seen.
class Painter {
 public:
  Painter() = default;
  virtual ~Painter() = default;
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  virtual std::string name() const = 0;
  /// Whether each call costs, so that few of them are better than the nearest triangles first.
  virtual bool prefers_few_calls() const = 0;
  /// All that there are; then some of them anew.
  virtual void set_vertices(const std::vector<Vertex>& vertices) = 0;
  virtual void move_vertices(std::size_t first, const std::vector<Vertex>& vertices) = 0;
  /// The lightmap, of which only a place has changed since it was given last.
  virtual void set_light(const cv::Mat& texels, const cv::Rect& changed) = 0;
  virtual RenderedImage paint(const RenderJob& job, const Visible& visible) = 0;
};

/// OpenGL's. Throws DeviceError when there is none to be had.
std::unique_ptr<Painter> make_gl_painter(PainterKind kind, const World& world,
                                         const TextureArrays& textures);
/// Ours: see RendererOptions::narrow_vectors.
std::unique_ptr<Painter> make_software_painter(const World& world, const TextureArrays& textures,
                                               bool narrow_vectors);

}  // namespace panoptes::sim
