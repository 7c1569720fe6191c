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

#include <GL/glcorearb.h>
#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "sim/render/context.h"
#include "sim/render/lightmap.h"
#include "sim/render/moment_light.h"
#include "sim/render/occlusion.h"
#include "sim/render/texture_arrays.h"

namespace panoptes::sim {
namespace {

constexpr double kFloorTop_m = 0.02;
// A chart this wide is a wall, floor or ceiling, in front of which everything else stands: drawn
// last.
constexpr double kBackdropRadius_m = 1.5;
constexpr std::size_t kMostObjects = 0xFFFE;

constexpr const char* kVertexShader = R"(
layout(location = 0) in vec3 p_scene;
layout(location = 1) in vec2 picture;
layout(location = 2) in float picture_layer;
layout(location = 3) in vec2 lit;
layout(location = 4) in uint number;
uniform mat4 clip_scene;
out vec2 at_picture;
flat out float layer;
out vec2 at_lit;
#ifdef LABEL
out float z_m;
#endif
#ifdef INSTANCE
flat out uint object;
#endif
void main() {
  at_picture = picture;
  layer = picture_layer;
  at_lit = lit;
#ifdef LABEL
  z_m = p_scene.z;
#endif
#ifdef INSTANCE
  object = number;
#endif
  gl_Position = clip_scene * vec4(p_scene, 1.0);
}
)";

// Pictures and lightmap hold square roots, so that their product is the root of the light seen.
constexpr const char* kFragmentShader = R"(
in vec2 at_picture;
flat in float layer;
in vec2 at_lit;
#ifdef LABEL
in float z_m;
#endif
#ifdef INSTANCE
flat in uint object;
layout(location = 1) out uint instance;
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
#ifdef INSTANCE
  instance = object;
#endif
}
)";

// What we call of OpenGL: type, name.
// clang-format off
#define PANOPTES_GL_FUNCTIONS(X) \
  X(PFNGLACTIVETEXTUREPROC, ActiveTexture) \
  X(PFNGLATTACHSHADERPROC, AttachShader) \
  X(PFNGLBINDBUFFERPROC, BindBuffer) \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer) \
  X(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer) \
  X(PFNGLBINDTEXTUREPROC, BindTexture) \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray) \
  X(PFNGLBUFFERDATAPROC, BufferData) \
  X(PFNGLBUFFERSUBDATAPROC, BufferSubData) \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus) \
  X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv) \
  X(PFNGLCLEARBUFFERUIVPROC, ClearBufferuiv) \
  X(PFNGLCLIPCONTROLPROC, ClipControl) \
  X(PFNGLCOMPILESHADERPROC, CompileShader) \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram) \
  X(PFNGLCREATESHADERPROC, CreateShader) \
  X(PFNGLCULLFACEPROC, CullFace) \
  X(PFNGLDELETESHADERPROC, DeleteShader) \
  X(PFNGLDEPTHFUNCPROC, DepthFunc) \
  X(PFNGLDRAWBUFFERSPROC, DrawBuffers) \
  X(PFNGLDRAWELEMENTSPROC, DrawElements) \
  X(PFNGLENABLEPROC, Enable) \
  X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray) \
  X(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer) \
  X(PFNGLFRONTFACEPROC, FrontFace) \
  X(PFNGLGENBUFFERSPROC, GenBuffers) \
  X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers) \
  X(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers) \
  X(PFNGLGENTEXTURESPROC, GenTextures) \
  X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays) \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv) \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog) \
  X(PFNGLGETSHADERIVPROC, GetShaderiv) \
  X(PFNGLGETSTRINGPROC, GetString) \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation) \
  X(PFNGLLINKPROGRAMPROC, LinkProgram) \
  X(PFNGLPIXELSTOREIPROC, PixelStorei) \
  X(PFNGLREADBUFFERPROC, ReadBuffer) \
  X(PFNGLREADPIXELSPROC, ReadPixels) \
  X(PFNGLRENDERBUFFERSTORAGEPROC, RenderbufferStorage) \
  X(PFNGLSHADERSOURCEPROC, ShaderSource) \
  X(PFNGLTEXPARAMETERIPROC, TexParameteri) \
  X(PFNGLTEXSTORAGE2DPROC, TexStorage2D) \
  X(PFNGLTEXSTORAGE3DPROC, TexStorage3D) \
  X(PFNGLTEXSUBIMAGE2DPROC, TexSubImage2D) \
  X(PFNGLTEXSUBIMAGE3DPROC, TexSubImage3D) \
  X(PFNGLUNIFORM1FPROC, Uniform1f) \
  X(PFNGLUNIFORM1IPROC, Uniform1i) \
  X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv) \
  X(PFNGLUSEPROGRAMPROC, UseProgram) \
  X(PFNGLVERTEXATTRIBIPOINTERPROC, VertexAttribIPointer) \
  X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer) \
  X(PFNGLVIEWPORTPROC, Viewport)
// clang-format on

/// OpenGL's functions, as the context has them.
struct Gl {
#define PANOPTES_GL_DECLARE(type, name) type name = nullptr;
  PANOPTES_GL_FUNCTIONS(PANOPTES_GL_DECLARE)
#undef PANOPTES_GL_DECLARE

  explicit Gl(const GlContext& context) {
    const auto find = [&context](auto& function, const char* name) {
      function =
          reinterpret_cast<std::remove_reference_t<decltype(function)>>(context.function(name));
      if (function == nullptr) {
        throw DeviceError(fmt::format("{} has no {}; install Debian 12's Mesa packages again",
                                      context.name(), name));
      }
    };
#define PANOPTES_GL_FIND(type, name) find(name, "gl" #name);
    PANOPTES_GL_FUNCTIONS(PANOPTES_GL_FIND)
#undef PANOPTES_GL_FIND
  }
};
#undef PANOPTES_GL_FUNCTIONS

struct Vertex {
  std::array<float, 3> p_scene;
  std::array<float, 2> picture;
  std::array<float, 2> lit;
  std::uint16_t layer;   ///< of the texture array
  std::uint16_t object;  ///< 1 + its number
};
static_assert(sizeof(Vertex) == 32);

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
      if (std::memcmp(&vertices_[slots_[slot]], &vertex, sizeof vertex) == 0) {
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
  bool flat = false;        ///< within its rectangle
  bool full = false;        ///< its chart's parts together fill the rectangle
  Rectangle rectangle;      ///< about the chart
  std::uint32_t array = 0;  ///< of textures
  std::uint32_t first = 0;  ///< in the list of all indices
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

/// Triangles that show textures of one array.
struct Call {
  std::uint32_t array = 0;
  std::size_t first = 0;  ///< in the drawn indices
  std::size_t count = 0;
};

struct Target {
  GLuint framebuffer = 0;
  GLuint colour = 0;
  GLuint instance = 0;
  GLuint depth = 0;
};

struct Program {
  GLuint name = 0;
  GLint clip_scene = -1;
  GLint gain = -1;
};

struct Plane {
  Vec3 inwards;
  double offset_m = 0;
  double height(const Vec3& p) const { return inwards.dot(p) + offset_m; }
};

/// Our picture's rows run downwards, OpenGL's upwards: the picture is drawn upside down and read
/// back right. So clip y points down like the camera's own. Depth is near_m over the distance along
/// the axis: as exact far away as floating point is.
Eigen::Matrix4d clip_from_camera(const Intrinsics& camera, double near_m) {
  const double w = camera.width_px;
  const double h = camera.height_px;
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = 2 * camera.fx_px / w;
  clip(0, 2) = 2 * (camera.cx_px + 0.5) / w - 1;
  clip(1, 1) = 2 * camera.fy_px / h;
  clip(1, 2) = 2 * (camera.cy_px + 0.5) / h - 1;
  clip(2, 3) = near_m;
  clip(3, 2) = 1;
  return clip;
}

Eigen::Matrix4d matrix_of(const Pose3& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = pose.translation;
  return matrix;
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

bool same_pose(const Pose3& a, const Pose3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

/// Whether set_same_on_every_processor was called, or somebody asked for the like.
bool software_only() { return std::getenv("GALLIUM_OVERRIDE_CPU_CAPS") != nullptr; }

std::unique_ptr<GlContext> make_context(GlLibrary library) {
  return library == GlLibrary::kEgl ? make_egl_context(software_only()) : make_osmesa_context();
}

}  // namespace

class Renderer::Impl {
 public:
  Impl(const World& world, const RendererOptions& options)
      : Impl(world, options, make_charts(world, checked(world, options).lightmap_cell_m)) {}

  Drawn draw(const View& view, const Ask& ask, const Moment& moment) {
    PANOPTES_CHECK(view.intrinsics.is_pinhole(), "the renderer draws what a pinhole sees");
    const int width = view.intrinsics.width_px;
    const int height = view.intrinsics.height_px;
    context_->make_current();
    bring_to(moment);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, target(width, height, ask.instance));
    gl_.Viewport(0, 0, width, height);
    clear(view.gain, ask.instance);
    draw_geometry(view, program(ask));

    Drawn drawn;
    bgra_.create(height, width, CV_8UC4);
    gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl_.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, bgra_.data);
    cv::cvtColor(bgra_, drawn.bgr, cv::COLOR_BGRA2BGR);
    if (ask.floor_label) {
      cv::extractChannel(bgra_, drawn.floor_label, 3);
    }
    if (ask.instance) {
      drawn.instance.create(height, width, CV_16U);
      gl_.ReadBuffer(GL_COLOR_ATTACHMENT1);
      gl_.PixelStorei(GL_PACK_ALIGNMENT, 2);
      gl_.ReadPixels(0, 0, width, height, GL_RED_INTEGER, GL_UNSIGNED_SHORT, drawn.instance.data);
      gl_.PixelStorei(GL_PACK_ALIGNMENT, 4);
    }
    if (ask.depth) {
      drawn.depth_m = read_depth(width, height);
    }
    return drawn;
  }

  std::string drawn_by() {
    context_->make_current();
    return fmt::format("{}, {}", context_->name(),
                       reinterpret_cast<const char*>(gl_.GetString(GL_RENDERER)));
  }

 private:
  Impl(const World& world, const RendererOptions& options, const Charts& charts)
      : options_(options),
        sky_bgr_(world.sky_bgr),
        ambient_group_(world.ambient_group),
        light_(charts, cached_light(world, charts, options.bake_threads, options.bake_progress)),
        context_(make_context(options.gl_library)),
        gl_((context_->make_current(), *context_)) {
    const TextureArrays textures = sort_textures(world);
    upload_textures(world, textures);
    make_lightmap();
    upload_geometry(world, charts, textures);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthFunc(GL_GREATER);
    gl_.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl_.Enable(GL_CULL_FACE);
    gl_.FrontFace(GL_CW);  // counter-clockwise, seen upside down
  }

  static const RendererOptions& checked(const World& world, const RendererOptions& options) {
    PANOPTES_CHECK(options.near_m > 0 && options.lightmap_cell_m > 0, "lengths are positive");
    PANOPTES_CHECK(world.objects.size() <= kMostObjects, "an object's number has 16 bits");
    return options;
  }

  GLuint compiled(GLenum kind, const char* source, const Ask& ask) const {
    const std::string text = fmt::format("#version 330 core\n#define FLOOR_TOP_M {}\n{}{}{}",
                                         kFloorTop_m, ask.floor_label ? "#define LABEL\n" : "",
                                         ask.instance ? "#define INSTANCE\n" : "", source);
    const char* pointer = text.c_str();
    const GLuint shader = gl_.CreateShader(kind);
    gl_.ShaderSource(shader, 1, &pointer, nullptr);
    gl_.CompileShader(shader);
    GLint good = 0;
    gl_.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (good == 0) {
      std::array<char, 1024> log{};
      gl_.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
      throw DeviceError(fmt::format("{} does not take our shader: {}; install Debian 12's Mesa",
                                    context_->name(), log.data()));
    }
    return shader;
  }

  /// Compiled when it is first needed.
  const Program& program(const Ask& ask) {
    Program& p = programs_[(ask.floor_label ? 1U : 0U) + (ask.instance ? 2U : 0U)];
    if (p.name == 0) {
      p.name = gl_.CreateProgram();
      for (const auto& [kind, source] :
           {std::pair<GLenum, const char*>{GL_VERTEX_SHADER, kVertexShader},
            std::pair<GLenum, const char*>{GL_FRAGMENT_SHADER, kFragmentShader}}) {
        const GLuint shader = compiled(kind, source, ask);
        gl_.AttachShader(p.name, shader);
        gl_.DeleteShader(shader);
      }
      gl_.LinkProgram(p.name);
      GLint good = 0;
      gl_.GetProgramiv(p.name, GL_LINK_STATUS, &good);
      if (good == 0) {
        throw DeviceError(fmt::format("{} does not link our shaders; install Debian 12's Mesa",
                                      context_->name()));
      }
      gl_.UseProgram(p.name);
      p.clip_scene = gl_.GetUniformLocation(p.name, "clip_scene");
      p.gain = gl_.GetUniformLocation(p.name, "gain");
      gl_.Uniform1i(gl_.GetUniformLocation(p.name, "pictures"), 0);
      gl_.Uniform1i(gl_.GetUniformLocation(p.name, "light"), 1);
    }
    return p;
  }

  void upload_textures(const World& world, const TextureArrays& textures) {
    gl_.ActiveTexture(GL_TEXTURE0);
    for (const TextureArray& array : textures.arrays) {
      const std::size_t layers = array.textures.size() + array.palettes.size();
      GLuint name = 0;
      gl_.GenTextures(1, &name);
      gl_.BindTexture(GL_TEXTURE_2D_ARRAY, name);
      GLsizei levels = 1;
      for (int side = std::max(array.width_px, array.height_px); side > 1; side /= 2) {
        ++levels;
      }
      gl_.TexStorage3D(GL_TEXTURE_2D_ARRAY, levels, GL_RGBA8, array.width_px, array.height_px,
                       static_cast<GLsizei>(layers));
      for (std::size_t l = 0; l < layers; ++l) {
        GLint level = 0;  // blue comes first in memory all the way from file to picture
        for (const cv::Mat& bgra : detail_levels(world, array, l)) {
          gl_.TexSubImage3D(GL_TEXTURE_2D_ARRAY, level++, 0, 0, static_cast<GLint>(l), bgra.cols,
                            bgra.rows, 1, GL_RGBA, GL_UNSIGNED_BYTE, bgra.data);
        }
      }
      const auto set = [this](GLenum what, GLint value) {
        gl_.TexParameteri(GL_TEXTURE_2D_ARRAY, what, value);
      };
      set(GL_TEXTURE_MIN_FILTER,
          options_.trilinear ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR_MIPMAP_NEAREST);
      set(GL_TEXTURE_MAG_FILTER, GL_LINEAR);
      set(GL_TEXTURE_WRAP_S, GL_REPEAT);
      set(GL_TEXTURE_WRAP_T, GL_REPEAT);
      texture_arrays_.push_back(name);
    }
  }

  void make_lightmap() {
    GLuint name = 0;
    gl_.GenTextures(1, &name);
    gl_.ActiveTexture(GL_TEXTURE1);
    gl_.BindTexture(GL_TEXTURE_2D, name);
    const cv::Mat& texels = light_.texels();
    gl_.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, texels.cols, texels.rows);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl_.ActiveTexture(GL_TEXTURE0);
    upload_light({0, 0, texels.cols, texels.rows});
  }

  void upload_light(const cv::Rect& place) {
    if (place.empty()) {
      return;
    }
    cv::Mat four;  // one channel would do, but four are looked up by a faster way
    cv::cvtColor(light_.texels()(place), four, cv::COLOR_GRAY2BGRA);
    gl_.ActiveTexture(GL_TEXTURE1);
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, place.x, place.y, four.cols, four.rows, GL_RGBA,
                      GL_UNSIGNED_BYTE, four.data);
    gl_.ActiveTexture(GL_TEXTURE0);
  }

  void upload_geometry(const World& world, const Charts& charts, const TextureArrays& textures) {
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
    GLuint array = 0;
    gl_.GenVertexArrays(1, &array);
    gl_.BindVertexArray(array);
    std::array<GLuint, 2> buffers{};
    gl_.GenBuffers(2, buffers.data());
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                   vertices.data(), moving_.empty() ? GL_STATIC_DRAW : GL_DYNAMIC_DRAW);
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    // OpenGL takes offsets into its buffer as pointers.
    const auto at = [](std::size_t offset) {
      return reinterpret_cast<const void*>(offset);  // NOLINT(performance-no-int-to-ptr)
    };
    const auto floats = [&](GLuint location, GLint size, std::size_t offset) {
      gl_.VertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(Vertex), at(offset));
      gl_.EnableVertexAttribArray(location);
    };
    floats(0, 3, offsetof(Vertex, p_scene));
    floats(1, 2, offsetof(Vertex, picture));
    gl_.VertexAttribPointer(2, 1, GL_UNSIGNED_SHORT, GL_FALSE, sizeof(Vertex),
                            at(offsetof(Vertex, layer)));
    gl_.EnableVertexAttribArray(2);
    floats(3, 2, offsetof(Vertex, lit));
    gl_.VertexAttribIPointer(4, 1, GL_UNSIGNED_SHORT, sizeof(Vertex), at(offsetof(Vertex, object)));
    gl_.EnableVertexAttribArray(4);
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

  /// Lamps and moving things as they are at a moment.
  void bring_to(const Moment& moment) {
    const bool all_changed = light_.set_powers(moment.power);
    for (MovingObject& moving : moving_) {
      const auto moved = moment.T_scene_object.find(moving.object);
      const Pose3& pose =
          moved == moment.T_scene_object.end() ? moving.T_scene_object : moved->second;
      const bool stays = moving.is_drawn && same_pose(pose, moving.T_scene_drawn);
      if (stays && !all_changed) {
        continue;
      }
      if (!stays) {
        place(moving, pose);
      }
      const cv::Rect lit = light_.light_object(moving.object, pose);
      if (!all_changed) {
        upload_light(lit);
      }
    }
    if (all_changed) {
      upload_light({0, 0, light_.texels().cols, light_.texels().rows});
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
    gl_.BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(moving.first_vertex * sizeof(Vertex)),
                      static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data());
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

  GLuint target(int width, int height, bool with_instance) {
    Target& t = targets_[{width, height, with_instance}];
    if (t.framebuffer != 0) {
      return t.framebuffer;
    }
    gl_.GenFramebuffers(1, &t.framebuffer);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, t.framebuffer);
    const auto attach = [&](GLuint& buffer, GLenum format, GLenum where) {
      gl_.GenRenderbuffers(1, &buffer);
      gl_.BindRenderbuffer(GL_RENDERBUFFER, buffer);
      gl_.RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
      gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, where, GL_RENDERBUFFER, buffer);
    };
    attach(t.colour, GL_RGBA8, GL_COLOR_ATTACHMENT0);
    if (with_instance) {
      attach(t.instance, GL_R16UI, GL_COLOR_ATTACHMENT1);
    }
    attach(t.depth, GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
    constexpr std::array<GLenum, 2> kDrawn{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    gl_.DrawBuffers(with_instance ? 2 : 1, kDrawn.data());
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw DeviceError(fmt::format("{} cannot draw a picture of {}x{}; ask for a smaller one",
                                    context_->name(), width, height));
    }
    return t.framebuffer;
  }

  void clear(double gain, bool with_instance) const {
    const double shown = light_.power(ambient_group_) * gain;
    std::array<float, 4> sky{};
    for (std::size_t i = 0; i < sky_bgr_.size(); ++i) {
      sky[i] = static_cast<float>(std::sqrt(std::clamp(sky_bgr_[i] * shown, 0.0, 1.0)));
    }
    gl_.ClearBufferfv(GL_COLOR, 0, sky.data());
    constexpr std::array<GLuint, 4> kNothing{};
    if (with_instance) {
      gl_.ClearBufferuiv(GL_COLOR, 1, kNothing.data());
    }
    constexpr GLfloat kInfinity = 0;
    gl_.ClearBufferfv(GL_DEPTH, 0, &kInfinity);
  }

  /// What may be seen, near things first: a pixel behind a drawn one costs next to nothing.
  void draw_geometry(const View& view, const Program& program) {
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
          // Array by array, which are a call each; backdrops of every array last.
          const auto call = chart.array + (chart.backdrop ? texture_arrays_.size() : 0);
          order_.emplace_back(static_cast<std::uint32_t>(call),
                              static_cast<float>((chart.bounds.centre - eye).norm()),
                              static_cast<std::uint32_t>(c));
        }
      }
    }
    if (order_.empty()) {
      return;
    }
    std::sort(order_.begin(), order_.end());
    const Eigen::Matrix4f clip_scene = (clip_from_camera(view.intrinsics, options_.near_m) *
                                        matrix_of(view.T_scene_camera.inverse()))
                                           .cast<float>();
    occlusion_.start(clip_scene, view.intrinsics.width_px, view.intrinsics.height_px,
                     static_cast<float>(options_.near_m));
    drawn_indices_.clear();
    calls_.clear();
    for (const auto& [call, distance, c] : order_) {
      const DrawnChart& chart = charts_[c];
      if (chart.flat) {
        if (occlusion_.hides(chart.rectangle)) {
          continue;
        }
        if (chart.full) {
          occlusion_.add();
        }
      }
      if (calls_.empty() || calls_.back().array != chart.array) {
        calls_.push_back({chart.array, drawn_indices_.size(), 0});
      }
      const auto first = indices_.begin() + chart.first;
      drawn_indices_.insert(drawn_indices_.end(), first, first + chart.count);
      calls_.back().count += chart.count;
    }
    gl_.UseProgram(program.name);
    gl_.UniformMatrix4fv(program.clip_scene, 1, GL_FALSE, clip_scene.data());
    gl_.Uniform1f(program.gain, static_cast<float>(std::sqrt(light_.most_light() * view.gain)));
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(drawn_indices_.size() * sizeof(std::uint32_t)),
                   drawn_indices_.data(), GL_STREAM_DRAW);
    for (const Call& call : calls_) {
      gl_.BindTexture(GL_TEXTURE_2D_ARRAY, texture_arrays_[call.array]);
      const std::size_t offset = call.first * sizeof(std::uint32_t);
      gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(call.count), GL_UNSIGNED_INT,
                       reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr)
    }
  }

  cv::Mat read_depth(int width, int height) const {
    cv::Mat depth(height, width, CV_32F);
    gl_.ReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data);
    const auto near_m = static_cast<float>(options_.near_m);
    for (int row = 0; row < height; ++row) {
      auto* z = depth.ptr<float>(row);
      for (int column = 0; column < width; ++column) {
        z[column] = near_m / z[column];  // 0, where nothing is, gives infinity
      }
    }
    return depth;
  }

  RendererOptions options_;
  std::array<double, 3> sky_bgr_;
  std::string ambient_group_;
  MomentLight light_;
  std::unique_ptr<GlContext> context_;
  Gl gl_;
  std::array<Program, 4> programs_;                       ///< by floor label, instance
  std::map<std::tuple<int, int, bool>, Target> targets_;  ///< by width, height, instance
  std::vector<GLuint> texture_arrays_;
  std::vector<std::uint32_t> indices_;
  std::vector<DrawnChart> charts_;
  std::vector<DrawnObject> objects_;
  std::vector<MovingObject> moving_;
  std::vector<std::tuple<std::uint32_t, float, std::uint32_t>> order_;  ///< call, distance, chart
  Occlusion occlusion_;
  std::vector<Call> calls_;
  std::vector<std::uint32_t> drawn_indices_;
  cv::Mat bgra_;
};

Renderer::Renderer(const World& world, const RendererOptions& options)
    : impl_(std::make_unique<Impl>(world, options)) {}
Renderer::~Renderer() = default;

Drawn Renderer::draw(const View& view, const Ask& ask, const Moment& moment) {
  return impl_->draw(view, ask, moment);
}

std::string Renderer::drawn_by() const { return impl_->drawn_by(); }

void set_render_threads(int num_threads) {
  ::setenv("LP_NUM_THREADS", std::to_string(num_threads).c_str(), 0);
}

void set_same_on_every_processor() { ::setenv("GALLIUM_OVERRIDE_CPU_CAPS", "sse4.1", 1); }

}  // namespace panoptes::sim
