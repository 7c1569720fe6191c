// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "sim/render/clip.h"
#include "sim/render/dynamic_lightmap.h"
#include "sim/render/lightmap.h"
#include "sim/render/occlusion.h"
#include "sim/render/painter.h"
#include "sim/render/texture_arrays.h"

namespace panoptes::sim {
namespace {

// A chart this wide is a wall, floor or ceiling, in front of which everything else stands: drawn
// last.
constexpr double kBackdropRadius_m = 1.5;
constexpr std::size_t kMostObjects = 0xFFFE;

/// The vertices of a chart, each once.
class VertexTable {
 public:
  explicit VertexTable(std::vector<Vertex>& vertices) : vertices_(vertices) {}

  void start_chart(std::size_t most_vertices) {
    std::size_t size = 8;
    while (size < 2 * most_vertices) {
      size *= 2;
    }
    slots_.assign(size, kNone);
  }

  std::uint32_t find_or_add(const Vertex& vertex) {
    std::array<std::uint32_t, 8> words{};
    std::memcpy(words.data(), &vertex, sizeof vertex);
    std::uint64_t hash = 0;
    for (const std::uint32_t word : words) {
      hash = (hash ^ word) * 0x9E3779B97F4A7C15ULL;
      hash ^= hash >> 29U;
    }
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t slot = hash & mask;; slot = (slot + 1) & mask) {
      if (slots_[slot] == kNone) {
        slots_[slot] = static_cast<std::uint32_t>(vertices_.size());
        vertices_.push_back(vertex);
        return slots_[slot];
      }
      if (vertices_[slots_[slot]] == vertex) {
        return slots_[slot];
      }
    }
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;
  std::vector<Vertex>& vertices_;
  std::vector<std::uint32_t> slots_;
};

/// A ball around a group of triangles.
struct Bounds {
  Vec3 centre = Vec3::Zero();
  double radius_m = 0;
};

struct DrawnChart {
  Bounds bounds;
  Vec3 normal;
  double offset_m = 0;  ///< of the plane along its normal
  bool backdrop = false;
  bool flat = false;         ///< within its rectangle
  bool full = false;         ///< its chart's parts together fill the rectangle
  SpaceRectangle rectangle;  ///< about the chart
  std::uint32_t array = 0;   ///< of textures
  std::uint32_t first = 0;   ///< in the list of all indices
  std::uint32_t count = 0;
};

struct DrawnObject {
  Bounds bounds;
  std::size_t first_chart = 0;
  std::size_t end_chart = 0;
};

/// An object that moves: how it is in its own frame, and where it was drawn last.
struct MovingObject {
  std::size_t object = 0;  ///< in World::objects
  std::size_t drawn = 0;   ///< in the drawn objects
  Pose3 T_scene_object;    ///< at time 0
  Pose3 T_scene_drawn;
  bool is_drawn = false;
  DrawnObject in_object;
  std::vector<DrawnChart> charts_in_object;
  std::size_t first_vertex = 0;
  std::vector<Vertex> vertices_in_object;
};

struct Plane {
  Vec3 inwards;
  double offset_m = 0;
  double height(const Vec3& p) const { return inwards.dot(p) + offset_m; }
};

std::array<Plane, 5> frustum(const View& view, double near_m) {
  const Intrinsics& c = view.intrinsics;
  const Vec2 low = c.ray(Vec2(-0.5, -0.5)).head<2>();
  const Vec2 high = c.ray(Vec2(c.width_px - 0.5, c.height_px - 0.5)).head<2>();
  const std::array<Vec3, 5> inwards_camera{
      Vec3(1, 0, -low.x()).normalized(), Vec3(-1, 0, high.x()).normalized(),
      Vec3(0, 1, -low.y()).normalized(), Vec3(0, -1, high.y()).normalized(), Vec3::UnitZ()};
  std::array<Plane, 5> planes;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    planes[i].inwards = view.T_scene_camera.rotation * inwards_camera[i];
    planes[i].offset_m = -planes[i].inwards.dot(view.T_scene_camera.translation);
  }
  planes[4].offset_m -= near_m;
  return planes;
}

bool outside(const std::array<Plane, 5>& planes, const Bounds& bounds) {
  return std::any_of(planes.begin(), planes.end(), [&bounds](const Plane& plane) {
    return plane.height(bounds.centre) < -bounds.radius_m;
  });
}

Bounds bounds_of(const std::vector<Vec3>& points) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Bounds bounds{(low + high) / 2, 0};
  for (const Vec3& p : points) {
    bounds.radius_m = std::max(bounds.radius_m, (p - bounds.centre).norm());
  }
  return bounds;
}

bool same_pose(const Pose3& a, const Pose3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

std::unique_ptr<Painter> make_painter(const RendererOptions& options, const World& world,
                                      const TextureArrays& textures) {
  return options.painter == PainterKind::kSoftware
             ? make_software_painter(world, textures, options.narrow_vectors)
             : make_gl_painter(options.painter, world, textures);
}

}  // namespace

class Renderer::Impl {
 public:
  Impl(const World& world, const RendererOptions& options)
      : Impl(world, options, make_charts(world, checked(world, options).lightmap_cell_m)) {}

  RenderedImage draw(const View& view, const RenderOutputs& outputs,
                     const SceneState& scene_state) {
    PANOPTES_CHECK(view.intrinsics.is_pinhole() != (view.faces != nullptr),
                   "a lens that bends sees through faces");
    set_state(scene_state);
    RenderJob job{view, options_.near_m, std::sqrt(light_.most_light() * view.gain), {}, outputs};
    const double shown = light_.power(ambient_group_) * view.gain;
    for (std::size_t i = 0; i < sky_bgr_.size(); ++i) {
      job.sky_bgr[i] = static_cast<float>(std::sqrt(std::clamp(sky_bgr_[i] * shown, 0.0, 1.0)));
    }
    return painter_->paint(job, [this](const View& pinhole) -> const DrawList& {
      list_visible(pinhole);
      return list_;
    });
  }

  std::string drawn_by() { return painter_->name(); }

 private:
  Impl(const World& world, const RendererOptions& options, const Charts& charts)
      : options_(options),
        sky_bgr_(world.sky_bgr),
        ambient_group_(world.ambient_group),
        light_(charts, cached_light(world, charts, options.bake_threads, options.bake_progress)) {
    const TextureArrays textures = sort_textures(world);
    painter_ = make_painter(options, world, textures);
    painter_->set_light(light_.texels(), {0, 0, light_.texels().cols, light_.texels().rows});
    lay_out_geometry(world, charts, textures);
  }

  static const RendererOptions& checked(const World& world, const RendererOptions& options) {
    PANOPTES_CHECK(options.near_m > 0 && options.lightmap_cell_m > 0, "lengths are positive");
    PANOPTES_CHECK(world.objects.size() <= kMostObjects, "an object's number has 16 bits");
    return options;
  }

  void lay_out_geometry(const World& world, const Charts& charts, const TextureArrays& textures) {
    std::vector<Vertex> vertices;
    VertexTable table(vertices);
    std::vector<Vec3> object_points;
    const cv::Size lightmap = light_.texels().size();
    std::size_t first_vertex = 0;
    for (std::size_t c = 0; c < charts.charts.size(); ++c) {
      const Chart& chart = charts.charts[c];
      add_chart(chart, textures, lightmap, table);
      for (const LitTriangle& t : chart.triangles) {
        object_points.insert(object_points.end(), t.p.begin(), t.p.end());
      }
      if (c + 1 == charts.charts.size() || charts.charts[c + 1].object != chart.object) {
        const std::size_t first = objects_.empty() ? 0 : objects_.back().end_chart;
        objects_.push_back({bounds_of(object_points), first, charts_.size()});
        object_points.clear();
        if (chart.moves) {
          MovingObject& moving = moving_.emplace_back();
          moving.object = chart.object;
          moving.drawn = objects_.size() - 1;
          moving.T_scene_object = world.objects[chart.object].T_scene_object;
          moving.in_object = objects_.back();
          moving.charts_in_object.assign(charts_.begin() + static_cast<std::ptrdiff_t>(first),
                                         charts_.end());
          moving.first_vertex = first_vertex;
          moving.vertices_in_object.assign(
              vertices.begin() + static_cast<std::ptrdiff_t>(first_vertex), vertices.end());
        }
        first_vertex = vertices.size();
      }
    }
    painter_->set_vertices(vertices);
  }

  /// One for each array of textures that the chart shows.
  void add_chart(const Chart& chart, const TextureArrays& textures, const cv::Size& lightmap,
                 VertexTable& table) {
    std::map<std::size_t, std::vector<const LitTriangle*>> by_array;
    for (const LitTriangle& t : chart.triangles) {
      by_array[textures.places[static_cast<std::size_t>(t.texture)].array].push_back(&t);
    }
    for (const auto& [array, triangles] : by_array) {
      DrawnChart drawn;
      drawn.normal = chart.normal;
      drawn.offset_m = chart.normal.dot(chart.origin);
      drawn.flat = chart.flat;
      drawn.full = chart.full;
      drawn.rectangle = {chart.origin.cast<float>(), (chart.u * chart.size_m.x()).cast<float>(),
                         (chart.v * chart.size_m.y()).cast<float>()};
      drawn.array = static_cast<std::uint32_t>(array);
      drawn.first = static_cast<std::uint32_t>(indices_.size());
      std::vector<Vec3> points;
      table.start_chart(3 * triangles.size());
      for (const LitTriangle* t : triangles) {
        const TexturePlace& place = textures.places[static_cast<std::size_t>(t->texture)];
        for (std::size_t i = 0; i < 3; ++i) {
          const Vec3& p = t->p[i];
          const Vec2& uv = place.uv ? *place.uv : t->uv[i];
          points.push_back(p);
          indices_.push_back(table.find_or_add(
              {{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())},
               {static_cast<float>(uv.x()), static_cast<float>(uv.y())},
               {static_cast<float>((t->texel[i].x() + 0.5) / lightmap.width),
                static_cast<float>((t->texel[i].y() + 0.5) / lightmap.height)},
               static_cast<std::uint16_t>(place.layer),
               static_cast<std::uint16_t>(chart.object + 1)}));
        }
      }
      drawn.count = static_cast<std::uint32_t>(indices_.size()) - drawn.first;
      drawn.bounds = bounds_of(points);
      drawn.backdrop = !chart.moves && drawn.bounds.radius_m > kBackdropRadius_m;
      charts_.push_back(drawn);
    }
  }

  /// Sets lamps and dynamic objects as they are in a scene state.
  void set_state(const SceneState& scene_state) {
    const bool all_changed = light_.set_powers(scene_state.power);
    for (MovingObject& moving : moving_) {
      const auto moved = scene_state.T_scene_object.find(moving.object);
      const Pose3& pose =
          moved == scene_state.T_scene_object.end() ? moving.T_scene_object : moved->second;
      const bool stays = moving.is_drawn && same_pose(pose, moving.T_scene_drawn);
      if (stays && !all_changed) {
        continue;
      }
      if (!stays) {
        place(moving, pose);
      }
      const cv::Rect lit = light_.light_object(moving.object, pose);
      if (!all_changed) {
        painter_->set_light(light_.texels(), lit);
      }
    }
    if (all_changed) {
      painter_->set_light(light_.texels(), {0, 0, light_.texels().cols, light_.texels().rows});
    }
  }

  void place(MovingObject& moving, const Pose3& T_scene_object) {
    std::vector<Vertex> vertices = moving.vertices_in_object;
    for (Vertex& vertex : vertices) {
      const Vec3 p_scene =
          T_scene_object * Vec3(vertex.p_scene[0], vertex.p_scene[1], vertex.p_scene[2]);
      vertex.p_scene = {static_cast<float>(p_scene.x()), static_cast<float>(p_scene.y()),
                        static_cast<float>(p_scene.z())};
    }
    painter_->move_vertices(moving.first_vertex, vertices);
    DrawnObject& object = objects_[moving.drawn];
    object.bounds.centre = T_scene_object * moving.in_object.bounds.centre;
    for (std::size_t c = 0; c < moving.charts_in_object.size(); ++c) {
      DrawnChart& chart = charts_[object.first_chart + c];
      const DrawnChart& in_object = moving.charts_in_object[c];
      chart.bounds.centre = T_scene_object * in_object.bounds.centre;
      chart.normal = T_scene_object.rotation * in_object.normal;
      chart.offset_m = in_object.offset_m + chart.normal.dot(T_scene_object.translation);
      const auto turned = [&T_scene_object](const Eigen::Vector3f& side) -> Eigen::Vector3f {
        return (T_scene_object.rotation * side.cast<double>()).cast<float>();
      };
      chart.rectangle = {(T_scene_object * in_object.rectangle.corner.cast<double>()).cast<float>(),
                         turned(in_object.rectangle.side_u), turned(in_object.rectangle.side_v)};
    }
    moving.T_scene_drawn = T_scene_object;
    moving.is_drawn = true;
  }

  /// What may be seen, near objects first: what is behind a drawn one costs next to nothing.
  void list_visible(const View& view) {
    const std::array<Plane, 5> planes = frustum(view, options_.near_m);
    const Vec3& eye = view.T_scene_camera.translation;
    order_.clear();
    for (const DrawnObject& object : objects_) {
      if (outside(planes, object.bounds)) {
        continue;
      }
      for (std::size_t c = object.first_chart; c < object.end_chart; ++c) {
        const DrawnChart& chart = charts_[c];
        if (chart.normal.dot(eye) > chart.offset_m && !outside(planes, chart.bounds)) {
          order_.emplace_back(chart.backdrop,
                              static_cast<float>((chart.bounds.centre - eye).norm()),
                              static_cast<std::uint32_t>(c));
        }
      }
    }
    std::sort(order_.begin(), order_.end());
    occlusion_.start(clip_from_scene(view, options_.near_m), view.intrinsics.width_px,
                     view.intrinsics.height_px, static_cast<float>(options_.near_m));
    std::erase_if(order_, [this](const auto& seen) {
      const DrawnChart& chart = charts_[std::get<2>(seen)];
      if (chart.flat && occlusion_.hides(chart.rectangle)) {
        return true;
      }
      if (chart.full) {
        occlusion_.add();
      }
      return false;
    });
    if (painter_->prefers_few_calls()) {
      std::stable_sort(order_.begin(), order_.end(), [this](const auto& a, const auto& b) {
        const auto call = [this](const auto& seen) {
          return std::pair(std::get<0>(seen), charts_[std::get<2>(seen)].array);
        };
        return call(a) < call(b);
      });
    }
    list_.indices.clear();
    list_.calls.clear();
    for (const auto& [backdrop, distance, c] : order_) {
      const DrawnChart& chart = charts_[c];
      if (list_.calls.empty() || list_.calls.back().array != chart.array) {
        list_.calls.push_back({chart.array, list_.indices.size(), 0});
      }
      const auto first = indices_.begin() + chart.first;
      list_.indices.insert(list_.indices.end(), first, first + chart.count);
      list_.calls.back().count += chart.count;
    }
  }

  RendererOptions options_;
  std::array<double, 3> sky_bgr_;
  std::string ambient_group_;
  DynamicLightmap light_;
  std::unique_ptr<Painter> painter_;
  std::vector<std::uint32_t> indices_;
  std::vector<DrawnChart> charts_;
  std::vector<DrawnObject> objects_;
  std::vector<MovingObject> moving_;
  std::vector<std::tuple<bool, float, std::uint32_t>> order_;  ///< backdrop, distance, chart
  Occlusion occlusion_;
  DrawList list_;
};

Renderer::Renderer(const World& world, const RendererOptions& options)
    : impl_(std::make_unique<Impl>(world, options)) {}
Renderer::~Renderer() = default;

RenderedImage Renderer::draw(const View& view, const RenderOutputs& outputs,
                             const SceneState& scene_state) {
  return impl_->draw(view, outputs, scene_state);
}

std::string Renderer::drawn_by() const { return impl_->drawn_by(); }

namespace {

int g_render_threads = 1;

}  // namespace

void set_render_threads(int num_threads) {
  static const bool users_own = std::getenv("LP_NUM_THREADS") != nullptr;
  g_render_threads = num_threads;
  if (!users_own) {
    ::setenv("LP_NUM_THREADS", std::to_string(num_threads).c_str(), 1);
  }
}

int render_threads() { return g_render_threads; }

void set_same_on_every_processor() { ::setenv("GALLIUM_OVERRIDE_CPU_CAPS", "sse4.1", 1); }

}  // namespace panoptes::sim
