// SPDX-License-Identifier: BSD-3-Clause
// Three steps: every triangle becomes what it covers and how it is shaded; each row of tiles of the
// picture finds the nearest triangle at each pixel; then each pixel is shaded, once. Rows of tiles
// are independent, so that threads share them as they come.
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#if defined(__x86_64__) && !defined(__clang__)  // which has no pragma for a set of instructions
#define PANOPTES_HAS_AVX2_KERNEL
#include <immintrin.h>
#endif

#include "core/base/check.h"
#include "sim/render/painter.h"
#include "sim/render/renderer.h"

namespace panoptes::sim {
namespace {

constexpr int kTile = kFaceRows;  // pixels along each side
constexpr int kTileLog2 = 3;
static_assert(kTile == 1 << kTileLog2);
constexpr std::size_t kPixelsOfTile = 64;
constexpr std::uint32_t kNothing = 0xFFFFFFFF;
constexpr int kPerPixel = 256;  // corners are moved to such parts of a pixel
// Triangles are grown by so many of these parts on each side: where a corner of one lies on
// another's edge both are moved by up to half a part, and a gap would show what is behind.
constexpr int kGrown = 1;
// Corners farther outside the picture than this are cut off, so that edges can be counted.
constexpr double kGuard_px = 16384;
constexpr std::int64_t kFarEdge = std::int64_t{1} << 28U;
constexpr std::size_t kMostLevels = 16;

/// Something that is linear over the picture, seen from a pixel near the triangle.
struct Plane3 {
  float at_origin = 0;
  float per_x = 0;
  float per_y = 0;
};

/// Where one side of a triangle lies: at_origin + dx * y - dy * x >= 0 inside, for the centre of
/// pixel (x, y).
struct Edge {
  std::int64_t at_origin = 0;
  std::int32_t dx = 0;
  std::int32_t dy = 0;
};

/// What a triangle, or a part of it, covers.
struct Covered {
  std::array<Edge, 3> edges;
  Plane3 inverse_depth;  ///< 1 / distance along the camera's axis, in 1/m
  float nearest = 0;     ///< at its corners
  int origin_x_px = 0;
  int origin_y_px = 0;
  int first_column = 0;  ///< of tiles
  int last_column = 0;
  std::uint32_t number = 0;  ///< of its Shade
};

/// How a triangle looks; all but `inverse_depth` over the distance.
struct Shade {
  Plane3 inverse_depth;
  std::array<Plane3, 3> sides;  ///< positive inside of each; known for a lens that bends alone
  Plane3 u;                     ///< in its texture, pixels
  Plane3 v;
  Plane3 column;  ///< in the lightmap
  Plane3 row;
  Plane3 above_floor_m;  ///< above kFloorTop_m
  int origin_x_px = 0;
  int origin_y_px = 0;
  std::uint16_t texture = 0;
  std::uint16_t object = 0;
};

/// A picture with all its levels of detail in the pool of texels.
struct PaintedTexture {
  std::array<std::uint32_t, kMostLevels> level_at{};  ///< in the pool
  std::int32_t last_level = 0;
  std::int32_t width_px = 1;  ///< powers of two
  std::int32_t height_px = 1;
  std::int32_t width_log2 = 0;
};

/// Each word has a texel of the lightmap, its right neighbour, and the two below.
struct PaintedLight {
  const std::uint32_t* fours = nullptr;
  std::int32_t columns = 0;
  float last_column = 0;
  float last_row = 0;
};

struct Paint {
  const PaintedTexture* textures = nullptr;
  const std::uint32_t* pool = nullptr;
  PaintedLight light;
  float gain = 1;  ///< takes light() to what texels are multiplied with
  std::uint32_t sky = 0;
};

template <typename T>
struct Aligned {
  using value_type = T;
  Aligned() = default;
  template <typename U>
  explicit Aligned(const Aligned<U>& /*other*/) {}
  T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{32}));
  }
  void deallocate(T* at, std::size_t /*count*/) { ::operator delete (at, std::align_val_t{32}); }
  bool operator==(const Aligned& /*other*/) const { return true; }
};
template <typename T>
using AlignedVector = std::vector<T, Aligned<T>>;

/// A row of tiles: tile by tile, in each row by row.
struct TileRow {
  AlignedVector<float> inverse_depth;
  std::uint32_t* numbers = nullptr;  ///< of the triangle that is seen
  std::vector<float> farthest;       ///< the least inverse_depth in each tile
};

/// Where a row of a tile begins in a row of tiles.
std::size_t first_of(int column, int row) {
  return (static_cast<std::size_t>(column) * kTile + static_cast<std::size_t>(row)) * kTile;
}

/// And in a row of the picture.
std::size_t pixel_of(int column, int row, int columns) {
  return (static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
          static_cast<std::size_t>(column)) *
         kTile;
}

/// The numbers of all rows of tiles.
struct Canvas {
  const std::uint32_t* numbers = nullptr;
  int columns = 0;  ///< of tiles
};

/// Where the pixels of a row of tiles sample the canvas: see PinholeFaces. Row by row, as wide as
/// the tiles.
struct RemapTable {
  const float* x_px = nullptr;
  const float* y_px = nullptr;
  const float* detail_px2 = nullptr;
};

/// The same as rows of the picture, as wide as the tiles.
struct PixelRows {
  std::uint32_t* bgra = nullptr;
  std::uint8_t* floor = nullptr;
  float* depth_m = nullptr;
  std::uint16_t* instance = nullptr;
};

namespace plain {
#include "sim/render/raster_kernel.h"  // NOLINT(bugprone-suspicious-include)
}  // namespace plain

#if defined(PANOPTES_HAS_AVX2_KERNEL)
#pragma GCC push_options
#pragma GCC target("avx2")
#define PANOPTES_AVX2_KERNEL
namespace avx2 {
#include "sim/render/raster_kernel.h"  // NOLINT(bugprone-suspicious-include)
}  // namespace avx2
#undef PANOPTES_AVX2_KERNEL
#pragma GCC pop_options
#endif

struct Kernel {
  const char* name;
  decltype(&plain::raster_row) raster_row;
  decltype(&plain::shade_row) shade_row;
  decltype(&plain::remap_row) remap_row;
};

/// The fastest that this processor has, or the one that all have.
Kernel kernel([[maybe_unused]] bool narrow_vectors) {
#if defined(PANOPTES_HAS_AVX2_KERNEL)
  if (!narrow_vectors && __builtin_cpu_supports("avx2")) {
    return {"8 pixels at once", avx2::raster_row, avx2::shade_row, avx2::remap_row};
  }
#endif
  return {"4 pixels at once", plain::raster_row, plain::shade_row, plain::remap_row};
}

/// Threads that share a number of tasks among them and the calling one.
class ThreadPool {
 public:
  explicit ThreadPool(int helpers) {
    for (int i = 0; i < helpers; ++i) {
      threads_.emplace_back([this, i] { help(i + 1); });
    }
  }
  ~ThreadPool() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    start_.notify_all();
    for (std::thread& thread : threads_) {
      thread.join();
    }
  }
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int size() const { return static_cast<int>(threads_.size()) + 1; }

  /// Calls task(number, who) for each number below `count`, in any order; `who` is below size().
  /// Throws what one of the calls has thrown, when all threads are done with theirs.
  void share(int count, const std::function<void(int, int)>& task) {
    {
      const std::lock_guard lock(mutex_);
      task_ = &task;
      count_ = count;
      next_ = 0;
      busy_ = static_cast<int>(threads_.size());
      ++round_;
    }
    start_.notify_all();
    work(0);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return busy_ == 0; });
    if (const std::exception_ptr fault = std::exchange(fault_, nullptr)) {
      lock.unlock();
      std::rethrow_exception(fault);
    }
  }

 private:
  void work(int who) {
    try {
      for (int number = next_++; number < count_; number = next_++) {
        (*task_)(number, who);
      }
    } catch (...) {
      next_ = count_;
      const std::lock_guard lock(mutex_);
      fault_ = std::current_exception();
    }
  }

  void help(int who) {
    std::uint64_t seen = 0;
    std::unique_lock lock(mutex_);
    while (true) {
      start_.wait(lock, [&] { return stopped_ || round_ != seen; });
      if (stopped_) {
        return;
      }
      seen = round_;
      lock.unlock();
      work(who);
      lock.lock();
      if (--busy_ == 0) {
        done_.notify_one();
      }
    }
  }

  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable start_;
  std::condition_variable done_;
  const std::function<void(int, int)>* task_ = nullptr;
  int count_ = 0;
  std::atomic<int> next_ = 0;
  std::exception_ptr fault_;
  int busy_ = 0;
  std::uint64_t round_ = 0;
  bool stopped_ = false;
};

class SoftwarePainter final : public Painter {
 public:
  SoftwarePainter(const World& world, const TextureArrays& textures, bool narrow_vectors)
      : kernel_(kernel(narrow_vectors)),
        threads_(render_threads() - 1),
        rows_(static_cast<std::size_t>(threads_.size())) {
    for (const TextureArray& array : textures.arrays) {
      first_texture_.push_back(textures_.size());
      for (std::size_t l = 0; l < array.textures.size() + array.palettes.size(); ++l) {
        PaintedTexture& texture = textures_.emplace_back();
        texture.width_px = array.width_px;
        texture.height_px = array.height_px;
        while (1 << texture.width_log2 < texture.width_px) {
          ++texture.width_log2;
        }
        std::size_t level = 0;
        for (const cv::Mat& bgra : detail_levels(world, array, l)) {
          PANOPTES_CHECK(level < kMostLevels, "textures are at most 32768 pixels wide");
          texture.level_at[level++] = static_cast<std::uint32_t>(pool_.size());
          for (int row = 0; row < bgra.rows; ++row) {
            const auto* first = bgra.ptr<std::uint32_t>(row);
            pool_.insert(pool_.end(), first, first + bgra.cols);
            pool_.push_back(*first);  // what is right of the last
          }
        }
        texture.last_level = static_cast<std::int32_t>(level) - 1;
      }
    }
    PANOPTES_CHECK(textures_.size() <= 0xFFFF, "a texture's number has 16 bits");
  }

  std::string name() const override { return std::string("Panoptes, ") + kernel_.name; }
  bool prefers_few_calls() const override { return false; }

  void set_vertices(const std::vector<Vertex>& vertices) override {
    vertices_ = vertices;
    projected_.resize(vertices.size());
    stamps_.assign(vertices.size(), 0);
  }

  void move_vertices(std::size_t first, const std::vector<Vertex>& vertices) override {
    std::copy(vertices.begin(), vertices.end(),
              vertices_.begin() + static_cast<std::ptrdiff_t>(first));
  }

  void set_light(const cv::Mat& texels, const cv::Rect& changed) override {
    lightmap_ = texels.size();
    light_.resize(texels.total());
    for (int row = std::max(changed.y - 1, 0); row < changed.y + changed.height; ++row) {
      const auto* upper = texels.ptr<std::uint8_t>(row);
      const auto* lower = texels.ptr<std::uint8_t>(std::min(row + 1, texels.rows - 1));
      auto* fours = &light_[static_cast<std::size_t>(row) * static_cast<std::size_t>(texels.cols)];
      for (int column = std::max(changed.x - 1, 0); column < changed.x + changed.width; ++column) {
        const int next = std::min(column + 1, texels.cols - 1);
        fours[column] = std::uint32_t{upper[column]} | std::uint32_t{upper[next]} << 8U |
                        std::uint32_t{lower[column]} << 16U | std::uint32_t{lower[next]} << 24U;
      }
    }
  }

  RenderedImage paint(const RenderJob& job, const Visible& visible) override {
    const Intrinsics& camera = job.view.intrinsics;
    RenderedImage rendered;
    rendered.bgr.create(camera.height_px, camera.width_px, CV_8UC3);
    if (job.outputs.floor_label) {
      rendered.floor_label.create(rendered.bgr.size(), CV_8U);
    }
    if (job.outputs.depth) {
      rendered.depth_m.create(rendered.bgr.size(), CV_32F);
    }
    if (job.outputs.instance) {
      rendered.instance.create(rendered.bgr.size(), CV_16U);
    }
    near_m_ = job.near_m;
    bends_ = job.view.faces != nullptr;
    shades_.clear();
    const Paint paint = paint_of(job);
    if (!bends_) {
      add_triangles(job.view, 0, visible);
      const int columns = tiles_across(camera.width_px);
      share_rows(static_cast<int>(bins_.size()), columns, [&](int tile_row, RowMemory& memory) {
        paint_tiles(tile_row, columns, paint, memory, rendered);
      });
      return rendered;
    }
    const PinholeFaces& faces = *job.view.faces;
    const int columns = tiles_across(faces.canvas_px.width);
    numbers_.resize(pixel_of(0, faces.canvas_px.height, columns));
    for (const PinholeFaces::Face& face : faces.faces) {
      add_triangles(job.view.through(face), face.top_px, visible);
      share_rows(static_cast<int>(bins_.size()), columns, [&](int tile_row, RowMemory& memory) {
        memory.tiles.numbers = &numbers_[pixel_of(0, face.top_px + tile_row * kTile, columns)];
        find_nearest(tile_row, columns, memory);
      });
    }
    share_rows(tiles_across(camera.height_px), tiles_across(camera.width_px),
               [&](int tile_row, RowMemory& memory) {
                 paint_remapped(tile_row, faces, columns, paint, memory, rendered);
               });
    return rendered;
  }

 private:
  struct RowMemory {
    TileRow tiles;
    AlignedVector<std::uint32_t> numbers;
    std::vector<std::uint32_t> bgra;
    std::vector<std::uint8_t> floor;
    std::vector<float> depth_m;
    std::vector<std::uint16_t> instance;
    std::array<std::vector<float>, 3> remap;

    void fit(int columns) {
      const std::size_t pixels_in_row = pixel_of(0, kTile, columns);
      tiles.inverse_depth.resize(pixels_in_row);
      tiles.farthest.resize(static_cast<std::size_t>(columns));
      numbers.resize(pixels_in_row);
      bgra.resize(pixels_in_row);
      floor.resize(pixels_in_row);
      depth_m.resize(pixels_in_row);
      instance.resize(pixels_in_row);
    }
  };

  struct Projected {
    Vec3 p_camera;
    std::int32_t x = 0;  ///< in kPerPixel parts, from the centre of the first pixel
    std::int32_t y = 0;
    bool simple = false;  ///< neither too near nor too far outside
  };

  static int tiles_across(int px) { return (px + kTile - 1) / kTile; }

  /// Calls task(number, memory) for each number below `count`, `columns` tiles wide.
  void share_rows(int count, int columns, const std::function<void(int, RowMemory&)>& task) {
    threads_.share(count, [&](int number, int who) {
      RowMemory& memory = rows_[static_cast<std::size_t>(who)];
      memory.fit(columns);
      task(number, memory);
    });
  }

  /// What a pinhole sees, whose picture begins in a row of the canvas.
  void add_triangles(const View& view, int top_px, const Visible& visible) {
    camera_ = view.intrinsics;
    top_px_ = top_px;
    rotation_ = view.T_scene_camera.rotation.toRotationMatrix();
    eye_ = view.T_scene_camera.translation;
    bins_.resize(static_cast<std::size_t>(tiles_across(camera_.height_px)));
    for (auto& bin : bins_) {
      bin.clear();
    }
    covered_.clear();
    ++stamp_;
    const DrawList& list = visible(view);
    for (const Call& call : list.calls) {
      for (std::size_t i = call.first; i < call.first + call.count; i += 3) {
        add_triangle({list.indices[i], list.indices[i + 1], list.indices[i + 2]},
                     first_texture_[call.array]);
      }
    }
  }

  Paint paint_of(const RenderJob& job) const {
    Paint paint;
    paint.textures = textures_.data();
    paint.pool = pool_.data();
    paint.light = {light_.data(), lightmap_.width, static_cast<float>(lightmap_.width - 1),
                   static_cast<float>(lightmap_.height - 1)};
    paint.gain = static_cast<float>(job.light_gain / (255.0 * 65536.0));
    for (std::size_t i = 0; i < 3; ++i) {
      paint.sky |= static_cast<std::uint32_t>(std::lround(job.sky_bgr[i] * 255)) << (8 * i);
    }
    return paint;
  }

  const Projected& projected(std::uint32_t vertex) {
    Projected& out = projected_[vertex];
    if (stamps_[vertex] == stamp_) {
      return out;
    }
    stamps_[vertex] = stamp_;
    const auto& p = vertices_[vertex].p_scene;
    out.p_camera = rotation_.transpose() * (Vec3(p[0], p[1], p[2]) - eye_);
    out.simple = out.p_camera.z() >= near_m_ && to_pixels(out.p_camera, out.x, out.y);
    return out;
  }

  /// False where it is beyond the guard.
  bool to_pixels(const Vec3& p_camera, std::int32_t& x, std::int32_t& y) const {
    const double px = camera_.fx_px * p_camera.x() / p_camera.z() + camera_.cx_px;
    const double py = camera_.fy_px * p_camera.y() / p_camera.z() + camera_.cy_px;
    if (!(std::abs(px) <= kGuard_px && std::abs(py) <= kGuard_px)) {
      return false;
    }
    x = static_cast<std::int32_t>(std::lround(px * kPerPixel));
    y = static_cast<std::int32_t>(std::lround(py * kPerPixel));
    return true;
  }

  void add_triangle(const std::array<std::uint32_t, 3>& corners, std::size_t first_texture) {
    const std::array<const Projected*, 3> p{&projected(corners[0]), &projected(corners[1]),
                                            &projected(corners[2])};
    const Vec3& a = p[0]->p_camera;
    const Vec3& b = p[1]->p_camera;
    const Vec3& c = p[2]->p_camera;
    // A value over the distance is linear in the ray: its gradient in the camera's frame, through
    // the inverse of the matrix of the corners (Olano and Greer 1997).
    const Vec3 bc = b.cross(c);
    const double volume = a.dot(bc);
    if (!(volume < 0)) {
      return;  // seen from behind, or edge on
    }
    const std::array<Vec3, 3> inverse{bc / volume, c.cross(a) / volume, a.cross(b) / volume};
    const std::size_t before = covered_.size();
    if (p[0]->simple && p[1]->simple && p[2]->simple) {
      cover({p[0]->x, p[1]->x, p[2]->x}, {p[0]->y, p[1]->y, p[2]->y});
    } else {
      cover_clipped({a, b, c});
    }
    if (covered_.size() == before) {
      return;
    }
    const Covered& first = covered_[before];
    Shade shade;
    shade.origin_x_px = first.origin_x_px;
    shade.origin_y_px = first.origin_y_px + top_px_;
    const auto plane = [&](double at_a, double at_b, double at_c) {
      const Vec3 gradient = at_a * inverse[0] + at_b * inverse[1] + at_c * inverse[2];
      const double per_x = gradient.x() / camera_.fx_px;
      const double per_y = gradient.y() / camera_.fy_px;
      return Plane3{static_cast<float>(gradient.z() + per_x * (first.origin_x_px - camera_.cx_px) +
                                       per_y * (first.origin_y_px - camera_.cy_px)),
                    static_cast<float>(per_x), static_cast<float>(per_y)};
    };
    const Vertex& va = vertices_[corners[0]];
    const Vertex& vb = vertices_[corners[1]];
    const Vertex& vc = vertices_[corners[2]];
    const std::size_t texture = first_texture + va.layer;
    const PaintedTexture& painted = textures_[texture];
    // Pictures repeat, so that the ones far from the first need not be counted.
    const double skip_u = std::floor(va.texture_uv[0]);
    const double skip_v = std::floor(va.texture_uv[1]);
    shade.inverse_depth = plane(1, 1, 1);
    const double w = painted.width_px;
    const double h = painted.height_px;
    shade.u = plane((va.texture_uv[0] - skip_u) * w, (vb.texture_uv[0] - skip_u) * w,
                    (vc.texture_uv[0] - skip_u) * w);
    shade.v = plane((va.texture_uv[1] - skip_v) * h, (vb.texture_uv[1] - skip_v) * h,
                    (vc.texture_uv[1] - skip_v) * h);
    const auto texel = [](float uv, int size) { return uv * size - 0.5; };
    shade.column =
        plane(texel(va.lightmap_uv[0], lightmap_.width), texel(vb.lightmap_uv[0], lightmap_.width),
              texel(vc.lightmap_uv[0], lightmap_.width));
    shade.row = plane(texel(va.lightmap_uv[1], lightmap_.height),
                      texel(vb.lightmap_uv[1], lightmap_.height),
                      texel(vc.lightmap_uv[1], lightmap_.height));
    shade.above_floor_m = plane(va.p_scene[2] - kFloorTop_m, vb.p_scene[2] - kFloorTop_m,
                                vc.p_scene[2] - kFloorTop_m);
    shade.texture = static_cast<std::uint16_t>(texture);
    shade.object = va.object;
    if (bends_) {
      shade.sides = {plane(1, 0, 0), plane(0, 1, 0), plane(0, 0, 1)};
    }
    const auto number = static_cast<std::uint32_t>(shades_.size());
    const double nearest = 1 / std::max(near_m_, std::min({a.z(), b.z(), c.z()}));
    const int origin_x_px = first.origin_x_px;
    const int origin_y_px = first.origin_y_px;
    for (std::size_t k = before; k < covered_.size(); ++k) {
      covered_[k].number = number;
      covered_[k].inverse_depth = shade.inverse_depth;
      covered_[k].origin_x_px = origin_x_px;
      covered_[k].origin_y_px = origin_y_px;
      covered_[k].nearest = static_cast<float>(nearest * (1 + 1e-6));
    }
    shades_.push_back(shade);
  }

  /// Adds what a triangle in front of the camera covers, given its corners in kPerPixel parts.
  void cover(std::array<std::int32_t, 3> x, std::array<std::int32_t, 3> y) {
    const std::int64_t area =
        std::int64_t{x[1] - x[0]} * (y[2] - y[0]) - std::int64_t{x[2] - x[0]} * (y[1] - y[0]);
    if (area >= 0) {
      return;  // too thin to tell which side is seen
    }
    std::swap(x[1], x[2]);
    std::swap(y[1], y[2]);
    const auto [low_x, high_x] = std::minmax({x[0], x[1], x[2]});
    const auto [low_y, high_y] = std::minmax({y[0], y[1], y[2]});
    // The first and the last pixel whose centre may be inside.
    const auto first = [](std::int32_t at) { return (at + kPerPixel - 1) >> 8; };
    const int left = std::max(first(low_x - kGrown), 0);
    const int right = std::min((high_x + kGrown) >> 8, camera_.width_px - 1);
    const int top = std::max(first(low_y - kGrown), 0);
    const int bottom = std::min((high_y + kGrown) >> 8, camera_.height_px - 1);
    if (left > right || top > bottom) {
      return;
    }
    Covered t;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t k = (i + 1) % 3;
      const std::int32_t dx = x[k] - x[i];
      const std::int32_t dy = y[k] - y[i];
      const std::int64_t from = std::int64_t{dy} * x[i] - std::int64_t{dx} * y[i];
      const std::int64_t grown = std::int64_t{kGrown} * (std::abs(dx) + std::abs(dy));
      t.edges[i] = {(from + grown) >> 8, dx, dy};
    }
    t.origin_x_px = left;
    t.origin_y_px = top;
    t.first_column = left / kTile;
    t.last_column = right / kTile;
    const auto number = static_cast<std::uint32_t>(covered_.size());
    covered_.push_back(t);
    for (int row = top / kTile; row <= bottom / kTile; ++row) {
      bins_[static_cast<std::size_t>(row)].push_back(number);
    }
  }

  /// The same for one that is partly too near or far outside.
  void cover_clipped(const std::array<Vec3, 3>& triangle) {
    // What is beyond each plane, n . p < d, is cut off. Always from the inner end of an edge to
    // the outer, so that two triangles agree where their common edge is cut.
    const double guard = kGuard_px - 1;
    const std::array<std::pair<Vec3, double>, 5> planes{
        {{Vec3::UnitZ(), near_m_},
         {Vec3(camera_.fx_px, 0, camera_.cx_px + guard), 0},
         {Vec3(-camera_.fx_px, 0, guard - camera_.cx_px), 0},
         {Vec3(0, camera_.fy_px, camera_.cy_px + guard), 0},
         {Vec3(0, -camera_.fy_px, guard - camera_.cy_px), 0}}};
    std::vector<Vec3> polygon(triangle.begin(), triangle.end());
    std::vector<Vec3> cut;
    for (const auto& [inwards, least] : planes) {
      cut.clear();
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3& from = polygon[i];
        const Vec3& to = polygon[(i + 1) % polygon.size()];
        const double from_in = inwards.dot(from) - least;
        const double to_in = inwards.dot(to) - least;
        if (from_in >= 0) {
          cut.push_back(from);
        }
        if ((from_in >= 0) != (to_in >= 0)) {
          const bool from_inside = from_in >= 0;
          const Vec3& inner = from_inside ? from : to;
          const Vec3& outer = from_inside ? to : from;
          const double share =
              from_inside ? from_in / (from_in - to_in) : to_in / (to_in - from_in);
          cut.push_back(inner + share * (outer - inner));
        }
      }
      polygon.swap(cut);
    }
    std::vector<std::array<std::int32_t, 2>> corners;
    for (const Vec3& p : polygon) {
      std::array<std::int32_t, 2> at{};
      if (!to_pixels(p, at[0], at[1])) {
        return;
      }
      corners.push_back(at);
    }
    for (std::size_t i = 2; i < corners.size(); ++i) {
      cover({corners[0][0], corners[i - 1][0], corners[i][0]},
            {corners[0][1], corners[i - 1][1], corners[i][1]});
    }
  }

  void find_nearest(int tile_row, int columns, RowMemory& memory) const {
    kernel_.raster_row(covered_, bins_[static_cast<std::size_t>(tile_row)], tile_row, columns,
                       memory.tiles);
  }

  void paint_tiles(int tile_row, int columns, const Paint& paint, RowMemory& memory,
                   RenderedImage& rendered) const {
    memory.tiles.numbers = memory.numbers.data();
    find_nearest(tile_row, columns, memory);
    const int y = tile_row * kTile;
    const int rows_px = std::min(kTile, rendered.bgr.rows - y);
    const PixelRows pixels = pixels_for(rendered, y, columns, memory);
    kernel_.shade_row(shades_, paint, memory.tiles, has_truth(rendered), tile_row, columns, rows_px,
                      pixels);
    hand_over(memory, y, rows_px, columns, rendered);
  }

  void paint_remapped(int tile_row, const PinholeFaces& faces, int canvas_columns,
                      const Paint& paint, RowMemory& memory, RenderedImage& rendered) const {
    const int y = tile_row * kTile;
    const int rows_px = std::min(kTile, rendered.bgr.rows - y);
    const int columns = tiles_across(rendered.bgr.cols);
    const auto padded = [&](const cv::Mat& map, std::vector<float>& own) -> const float* {
      if (map.cols == columns * kTile && map.isContinuous()) {
        return map.ptr<float>(y);
      }
      own.resize(pixel_of(0, kTile, columns));
      for (int row = 0; row < rows_px; ++row) {
        const auto* first = map.ptr<float>(y + row);
        auto* to = std::copy(first, first + map.cols, &own[pixel_of(0, row, columns)]);
        std::fill(to, &own[pixel_of(0, row, columns)] + pixel_of(columns, 0, columns),
                  first[map.cols - 1]);
      }
      return own.data();
    };
    const RemapTable remap{padded(faces.x_px, memory.remap[0]), padded(faces.y_px, memory.remap[1]),
                           padded(faces.detail_px2, memory.remap[2])};
    const PixelRows pixels = pixels_for(rendered, y, columns, memory);
    kernel_.remap_row(shades_, paint, {numbers_.data(), canvas_columns}, remap, has_truth(rendered),
                      columns, rows_px, pixels);
    hand_over(memory, y, rows_px, columns, rendered);
  }

  static bool has_truth(const RenderedImage& rendered) {
    return !rendered.floor_label.empty() || !rendered.depth_m.empty() || !rendered.instance.empty();
  }

  /// Where tiles end with the picture it takes what is true without a copy.
  static bool is_direct(const RenderedImage& rendered, int columns) {
    return columns * kTile == rendered.bgr.cols;
  }

  static PixelRows pixels_for(RenderedImage& rendered, int row, int columns, RowMemory& memory) {
    const auto place = [&](auto& own, cv::Mat& mat) {
      using Value = typename std::remove_reference_t<decltype(own)>::value_type;
      return is_direct(rendered, columns) && !mat.empty() ? mat.ptr<Value>(row) : own.data();
    };
    return {memory.bgra.data(), place(memory.floor, rendered.floor_label),
            place(memory.depth_m, rendered.depth_m), place(memory.instance, rendered.instance)};
  }

  /// Rows as they were painted become rows of the picture.
  static void hand_over(RowMemory& memory, int first_row, int rows_px, int columns,
                        RenderedImage& rendered) {
    const cv::Mat bgra(rows_px, rendered.bgr.cols, CV_8UC4, memory.bgra.data(),
                       pixel_of(columns, 0, columns) * 4);
    cv::Mat bgr = rendered.bgr.rowRange(first_row, first_row + rows_px);
    cv::cvtColor(bgra, bgr, cv::COLOR_BGRA2BGR);
    const auto copy = [&](const auto& own, cv::Mat& mat) {
      if (!is_direct(rendered, columns) && !mat.empty()) {
        for (int row = 0; row < rows_px; ++row) {
          std::memcpy(mat.ptr(first_row + row), &own[pixel_of(0, row, columns)],
                      static_cast<std::size_t>(mat.cols) * mat.elemSize());
        }
      }
    };
    copy(memory.floor, rendered.floor_label);
    copy(memory.depth_m, rendered.depth_m);
    copy(memory.instance, rendered.instance);
  }

  Kernel kernel_;
  ThreadPool threads_;
  std::vector<RowMemory> rows_;  ///< of each thread

  std::vector<PaintedTexture> textures_;
  std::vector<std::size_t> first_texture_;  ///< of each array
  std::vector<std::uint32_t> pool_;
  std::vector<std::uint32_t> light_;
  cv::Size lightmap_;
  std::vector<Vertex> vertices_;

  // Of the picture that is being painted.
  Intrinsics camera_;
  double near_m_ = 0;
  bool bends_ = false;
  int top_px_ = 0;  ///< of its first row in the canvas
  Eigen::Matrix3d rotation_;
  Vec3 eye_;
  std::uint32_t stamp_ = 0;
  std::vector<std::uint32_t> stamps_;  ///< when each vertex was projected
  std::vector<Projected> projected_;
  std::vector<Covered> covered_;
  std::vector<Shade> shades_;
  std::vector<std::vector<std::uint32_t>> bins_;  ///< the triangles of each row of tiles
  AlignedVector<std::uint32_t> numbers_;          ///< of the canvas of a lens that bends
};

}  // namespace

std::unique_ptr<Painter> make_software_painter(const World& world, const TextureArrays& textures,
                                               bool narrow_vectors) {
  return std::make_unique<SoftwarePainter>(world, textures, narrow_vectors);
}

}  // namespace panoptes::sim
