// SPDX-License-Identifier: BSD-3-Clause
#define GL_GLEXT_PROTOTYPES
#include "sim/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <GL/glcorearb.h>
#include <GL/osmesa.h>
#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "sim/render/lightmap.h"

namespace panoptes::sim {
namespace {

constexpr int kMostLayerSide_px = 512;
constexpr double kFloorTop_m = 0.02;
// A chart this wide is a wall, floor or ceiling, in front of which everything else stands: drawn
// last.
constexpr double kBackdropRadius_m = 1.5;

constexpr const char* kVertexShader = R"(#version 330 core
layout(location = 0) in vec3 p_scene;
layout(location = 1) in vec3 picture;
layout(location = 2) in vec2 lit;
uniform mat4 clip_scene;
out vec2 at_picture;
flat out float layer;
out vec2 at_lit;
#ifdef LABEL
out float z_m;
#endif
void main() {
  at_picture = picture.xy;
  layer = picture.z;
  at_lit = lit;
#ifdef LABEL
  z_m = p_scene.z;
#endif
  gl_Position = clip_scene * vec4(p_scene, 1.0);
}
)";

// Pictures and lightmap hold square roots, so that their product is the root of the light seen.
constexpr const char* kFragmentShader = R"(#version 330 core
in vec2 at_picture;
flat in float layer;
in vec2 at_lit;
#ifdef LABEL
in float z_m;
#endif
uniform sampler2DArray pictures;
uniform sampler2D light;
uniform float gain;
layout(location = 0) out vec4 colour;
void main() {
  colour.rgb = texture(pictures, vec3(at_picture, layer)).rgb * (texture(light, at_lit).r * gain);
#ifdef LABEL
  colour.a = z_m < FLOOR_TOP_M ? 1.0 : 0.0;
#else
  colour.a = 0.0;
#endif
}
)";

struct Vertex {
  friend bool operator==(const Vertex&, const Vertex&) = default;
  std::array<float, 3> p_scene;
  std::array<float, 3> picture;  ///< u, v, layer
  std::array<float, 2> lit;
};
static_assert(sizeof(Vertex) == 8 * sizeof(float));

/// A ball around a group of triangles, and the plane of a chart.
struct Bounds {
  Vec3 centre = Vec3::Zero();
  double radius_m = 0;
};

struct DrawnChart {
  Bounds bounds;
  Vec3 normal;
  double offset_m = 0;  ///< of the plane along its normal
  bool backdrop = false;
  std::uint32_t first = 0;  ///< in the list of all indices
  std::uint32_t count = 0;
};

struct DrawnObject {
  Bounds bounds;
  std::size_t first_chart = 0;
  std::size_t end_chart = 0;
};

struct Target {
  GLuint framebuffer = 0;
  GLuint colour = 0;
  GLuint depth = 0;
};

struct Plane {
  Vec3 inwards;
  double offset_m = 0;
  double height(const Vec3& p) const { return inwards.dot(p) + offset_m; }
};

GLuint compiled(GLenum kind, const char* source, bool with_label) {
  std::string text = source;
  const std::size_t after_version = text.find('\n') + 1;
  if (with_label) {
    text.insert(after_version, fmt::format("#define LABEL\n#define FLOOR_TOP_M {}\n", kFloorTop_m));
  }
  const char* pointer = text.c_str();
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good == 0) {
    std::array<char, 1024> log{};
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw DeviceError(fmt::format(
        "OSMesa does not take our shader: {}; install Debian 12's libosmesa6", log.data()));
  }
  return shader;
}

struct Program {
  GLuint name = 0;
  GLint clip_scene = -1;
  GLint gain = -1;
};

Program linked(bool with_label) {
  Program program;
  program.name = glCreateProgram();
  for (const auto& [kind, source] :
       {std::pair<GLenum, const char*>{GL_VERTEX_SHADER, kVertexShader},
        std::pair<GLenum, const char*>{GL_FRAGMENT_SHADER, kFragmentShader}}) {
    const GLuint shader = compiled(kind, source, with_label);
    glAttachShader(program.name, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(program.name);
  glUseProgram(program.name);
  program.clip_scene = glGetUniformLocation(program.name, "clip_scene");
  program.gain = glGetUniformLocation(program.name, "gain");
  glUniform1i(glGetUniformLocation(program.name, "pictures"), 0);
  glUniform1i(glGetUniformLocation(program.name, "light"), 1);
  return program;
}

int layer_side(const World& world) {
  int side_px = 1;
  for (const Texture& texture : world.textures) {
    while (side_px < kMostLayerSide_px && side_px < std::max(texture.bgr.cols, texture.bgr.rows)) {
      side_px *= 2;
    }
  }
  return side_px;
}

/// Our picture's rows run downwards, OpenGL's upwards: the picture is drawn upside down and read
/// back right. So clip y points down like the camera's own.
Eigen::Matrix4d clip_from_camera(const Intrinsics& camera, double near_m, double far_m) {
  const double w = camera.width_px;
  const double h = camera.height_px;
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = 2 * camera.fx_px / w;
  clip(0, 2) = 2 * (camera.cx_px + 0.5) / w - 1;
  clip(1, 1) = 2 * camera.fy_px / h;
  clip(1, 2) = 2 * (camera.cy_px + 0.5) / h - 1;
  clip(2, 2) = (far_m + near_m) / (far_m - near_m);
  clip(2, 3) = -2 * far_m * near_m / (far_m - near_m);
  clip(3, 2) = 1;
  return clip;
}

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

}  // namespace

class Renderer::Impl {
 public:
  Impl(const World& world, const RendererOptions& options) : options_(options) {
    PANOPTES_CHECK(options.near_m > 0 && options.lightmap_cell_m > 0 && true,
                   "lengths are positive");
    const Charts charts = make_charts(world, options.lightmap_cell_m);
    const cv::Mat light = cached_light(world, charts, options.bake_threads);
    make_context();
    programs_ = {linked(false), linked(true)};
    upload_textures(world);
    upload_light(light);
    upload_geometry(charts, light);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_CULL_FACE);
    glFrontFace(GL_CW);  // counter-clockwise, seen upside down
    glClearColor(0, 0, 0, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
  }
  ~Impl() {
    if (context_ != nullptr) {
      if (OSMesaGetCurrentContext() == context_) {
        OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0);
      }
      OSMesaDestroyContext(context_);
    }
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Drawn draw(const View& view, const Ask& ask) {
    PANOPTES_CHECK(view.intrinsics.is_pinhole(), "the renderer draws what a pinhole sees");
    const int width = view.intrinsics.width_px;
    const int height = view.intrinsics.height_px;
    make_current();
    glBindFramebuffer(GL_FRAMEBUFFER, target(width, height));
    glViewport(0, 0, width, height);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    const double far_m = (view.T_scene_camera.translation - all_.centre).norm() + all_.radius_m +
                         2 * options_.near_m;
    draw_geometry(view, far_m, ask.floor_label);

    Drawn drawn;
    bgra_.create(height, width, CV_8UC4);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, bgra_.data);
    cv::cvtColor(bgra_, drawn.bgr, cv::COLOR_BGRA2BGR);
    if (ask.floor_label) {
      cv::extractChannel(bgra_, drawn.floor_label, 3);
    }
    if (ask.depth) {
      drawn.depth_m = read_depth(width, height, far_m);
    }
    return drawn;
  }

 private:
  void make_context() {
    const std::array<int, 13> wanted{OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_DEPTH_BITS,
                                     0,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     3,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     3,
                                     0,
                                     0,
                                     0};
    context_ = OSMesaCreateContextAttribs(wanted.data(), nullptr);
    if (context_ == nullptr) {
      throw DeviceError(
          "no OpenGL 3.3 from OSMesa, so nothing can be drawn; install the package libosmesa6 and "
          "unset GALLIUM_DRIVER and MESA_GL_VERSION_OVERRIDE");
    }
    make_current();
  }

  void make_current() {
    if (OSMesaGetCurrentContext() != context_ &&
        OSMesaMakeCurrent(context_, unused_.data(), GL_UNSIGNED_BYTE, kUnusedSide, kUnusedSide) ==
            0) {
      throw DeviceError(
          "OSMesa's context cannot be used in this thread; draw from one thread only");
    }
  }

  void upload_textures(const World& world) {
    const int side_px = layer_side(world);
    const auto layers = static_cast<GLsizei>(std::max<std::size_t>(world.textures.size(), 1));
    GLuint name = 0;
    glGenTextures(1, &name);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D_ARRAY, name);
    GLint level = 0;
    for (int side = side_px; side >= 1; side /= 2, ++level) {
      glTexImage3D(GL_TEXTURE_2D_ARRAY, level, GL_RGBA8, side, side, layers, 0, GL_RGBA,
                   GL_UNSIGNED_BYTE, nullptr);
    }
    for (std::size_t i = 0; i < world.textures.size(); ++i) {
      const cv::Mat& bgr = world.textures[i].bgr;
      PANOPTES_CHECK(bgr.type() == CV_8UC3 && !bgr.empty(), "textures are 8-bit BGR");
      cv::Mat bgra;  // blue comes first in memory all the way from file to picture
      cv::cvtColor(bgr, bgra, cv::COLOR_BGR2BGRA);
      const bool shrinks = bgr.cols > side_px || bgr.rows > side_px;
      cv::resize(bgra, bgra, {side_px, side_px}, 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
      for (GLint l = 0; l < level; ++l) {
        glTexSubImage3D(GL_TEXTURE_2D_ARRAY, l, 0, 0, static_cast<GLint>(i), bgra.cols, bgra.rows,
                        1, GL_RGBA, GL_UNSIGNED_BYTE, bgra.data);
        if (bgra.cols > 1) {
          cv::resize(bgra, bgra, {bgra.cols / 2, bgra.rows / 2}, 0, 0, cv::INTER_AREA);
        }
      }
    }
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER,
                    options_.trilinear ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR_MIPMAP_NEAREST);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_REPEAT);
  }

  static void upload_light(const cv::Mat& light) {
    GLuint name = 0;
    glGenTextures(1, &name);
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D, name);
    cv::Mat four;  // one channel would do, but four are looked up by a faster way
    cv::cvtColor(light, four, cv::COLOR_GRAY2BGRA);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, four.cols, four.rows, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 four.data);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }

  void upload_geometry(const Charts& charts, const cv::Mat& light) {
    std::vector<Vertex> vertices;
    std::vector<Vec3> all_points;
    std::vector<Vec3> object_points;
    for (std::size_t c = 0; c < charts.charts.size(); ++c) {
      const Chart& chart = charts.charts[c];
      DrawnChart drawn;
      drawn.normal = chart.normal;
      drawn.offset_m = chart.normal.dot(chart.origin_scene);
      drawn.first = static_cast<std::uint32_t>(indices_.size());
      const std::size_t first_vertex = vertices.size();
      std::vector<Vec3> points;
      for (const LitTriangle& t : chart.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
          const Vec3& p = t.p_scene[i];
          points.push_back(p);
          const Vertex vertex{
              {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())},
              {static_cast<float>(t.uv[i].x()), static_cast<float>(t.uv[i].y()),
               static_cast<float>(t.texture)},
              {static_cast<float>((t.texel[i].x() + 0.5) / light.cols),
               static_cast<float>((t.texel[i].y() + 0.5) / light.rows)}};
          const auto same = [&vertex](const Vertex& other) { return vertex == other; };
          const auto found = std::find_if(
              vertices.begin() + static_cast<std::ptrdiff_t>(first_vertex), vertices.end(), same);
          indices_.push_back(static_cast<std::uint32_t>(found - vertices.begin()));
          if (found == vertices.end()) {
            vertices.push_back(vertex);
          }
        }
      }
      drawn.count = static_cast<std::uint32_t>(indices_.size()) - drawn.first;
      drawn.bounds = bounds_of(points);
      drawn.backdrop = drawn.bounds.radius_m > kBackdropRadius_m;
      charts_.push_back(drawn);
      all_points.insert(all_points.end(), points.begin(), points.end());
      object_points.insert(object_points.end(), points.begin(), points.end());
      if (c + 1 == charts.charts.size() || charts.charts[c + 1].object != chart.object) {
        const std::size_t first = objects_.empty() ? 0 : objects_.back().end_chart;
        objects_.push_back({bounds_of(object_points), first, c + 1});
        object_points.clear();
      }
    }
    if (!all_points.empty()) {
      all_ = bounds_of(all_points);
    }
    GLuint array = 0;
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    std::array<GLuint, 2> buffers{};
    glGenBuffers(2, buffers.data());
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                 vertices.data(), GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    const auto attribute = [](GLuint location, GLint size, std::size_t offset) {
      // OpenGL takes offsets into its buffer as pointers.
      const void* place =
          reinterpret_cast<const void*>(offset);  // NOLINT(performance-no-int-to-ptr)
      glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(Vertex), place);
      glEnableVertexAttribArray(location);
    };
    attribute(0, 3, offsetof(Vertex, p_scene));
    attribute(1, 3, offsetof(Vertex, picture));
    attribute(2, 2, offsetof(Vertex, lit));
  }

  GLuint target(int width, int height) {
    Target& t = targets_[{width, height}];
    if (t.framebuffer != 0) {
      return t.framebuffer;
    }
    glGenFramebuffers(1, &t.framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, t.framebuffer);
    glGenRenderbuffers(1, &t.colour);
    glBindRenderbuffer(GL_RENDERBUFFER, t.colour);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, t.colour);
    glGenRenderbuffers(1, &t.depth);
    glBindRenderbuffer(GL_RENDERBUFFER, t.depth);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, t.depth);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw DeviceError(fmt::format("OSMesa cannot draw a picture of {}x{}; ask for a smaller one",
                                    width, height));
    }
    return t.framebuffer;
  }

  /// What may be seen, near things first: a pixel behind a drawn one costs next to nothing.
  void draw_geometry(const View& view, double far_m, bool with_label) {
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
          const double distance_m = (chart.bounds.centre - eye).norm();
          order_.emplace_back(static_cast<float>(distance_m + (chart.backdrop ? far_m : 0.0)),
                              static_cast<std::uint32_t>(c));
        }
      }
    }
    if (order_.empty()) {
      return;
    }
    std::sort(order_.begin(), order_.end());
    drawn_indices_.clear();
    for (const auto& [distance, c] : order_) {
      const auto first = indices_.begin() + charts_[c].first;
      drawn_indices_.insert(drawn_indices_.end(), first, first + charts_[c].count);
    }
    const Program& program = programs_[with_label ? 1 : 0];
    glUseProgram(program.name);
    const Pose3 T_camera_scene = view.T_scene_camera.inverse();
    Eigen::Matrix4d camera_scene = Eigen::Matrix4d::Identity();
    camera_scene.topLeftCorner<3, 3>() = T_camera_scene.rotation.toRotationMatrix();
    camera_scene.topRightCorner<3, 1>() = T_camera_scene.translation;
    const Eigen::Matrix4f clip_scene =
        (clip_from_camera(view.intrinsics, options_.near_m, far_m) * camera_scene).cast<float>();
    glUniformMatrix4fv(program.clip_scene, 1, GL_FALSE, clip_scene.data());
    glUniform1f(program.gain, static_cast<float>(std::sqrt(kMostLight * view.gain)));
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(drawn_indices_.size() * sizeof(std::uint32_t)),
                 drawn_indices_.data(), GL_STREAM_DRAW);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(drawn_indices_.size()), GL_UNSIGNED_INT,
                   nullptr);
  }

  cv::Mat read_depth(int width, int height, double far_m) const {
    cv::Mat depth(height, width, CV_32F);
    glReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data);
    const double near_m = options_.near_m;
    for (int row = 0; row < height; ++row) {
      float* z = depth.ptr<float>(row);
      for (int column = 0; column < width; ++column) {
        z[column] =
            z[column] >= 1.0F
                ? std::numeric_limits<float>::infinity()
                : static_cast<float>(far_m * near_m / (far_m - z[column] * (far_m - near_m)));
      }
    }
    return depth;
  }

  static constexpr int kUnusedSide = 4;  // of unused_, four bytes a pixel

  RendererOptions options_;
  OSMesaContext context_ = nullptr;
  std::array<std::uint8_t, 64> unused_{};          ///< OSMesa wants one; we draw elsewhere
  std::array<Program, 2> programs_;                ///< without and with label
  std::map<std::pair<int, int>, Target> targets_;  ///< by width and height
  std::vector<std::uint32_t> indices_;
  std::vector<DrawnChart> charts_;
  std::vector<DrawnObject> objects_;
  Bounds all_;
  std::vector<std::pair<float, std::uint32_t>> order_;
  std::vector<std::uint32_t> drawn_indices_;
  cv::Mat bgra_;
};

Renderer::Renderer(const World& world, const RendererOptions& options)
    : impl_(std::make_unique<Impl>(world, options)) {}
Renderer::~Renderer() = default;

Drawn Renderer::draw(const View& view, const Ask& ask, const Moment& /*moment*/) {
  return impl_->draw(view, ask);
}

void set_render_threads(int num_threads) {
  ::setenv("LP_NUM_THREADS", std::to_string(num_threads).c_str(), 0);
}

}  // namespace panoptes::sim
