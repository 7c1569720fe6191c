// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
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

#include "core/base/error.h"
#include "sim/render/clip.h"
#include "sim/render/context.h"
#include "sim/render/painter.h"

namespace panoptes::sim {
namespace {

constexpr const char* kVertexShader = R"(
layout(location = 0) in vec3 p_scene;
layout(location = 1) in vec2 texture_uv;
layout(location = 2) in float texture_layer;
layout(location = 3) in vec2 lightmap_uv;
layout(location = 4) in uint number;
uniform mat4 clip_scene;
out vec2 at_texture;
flat out float layer;
out vec2 at_lightmap;
#ifdef LABEL
out float z_m;
#endif
#ifdef INSTANCE
flat out uint object;
#endif
void main() {
  at_texture = texture_uv;
  layer = texture_layer;
  at_lightmap = lightmap_uv;
#ifdef LABEL
  z_m = p_scene.z;
#endif
#ifdef INSTANCE
  object = number;
#endif
  gl_Position = clip_scene * vec4(p_scene, 1.0);
}
)";

// Textures and lightmap hold square roots, so that their product is the root of the light seen.
constexpr const char* kFragmentShader = R"(
in vec2 at_texture;
flat in float layer;
in vec2 at_lightmap;
#ifdef LABEL
in float z_m;
#endif
#ifdef INSTANCE
flat in uint object;
layout(location = 1) out uint instance;
#endif
uniform sampler2DArray textures;
uniform sampler2D light;
uniform float gain;
layout(location = 0) out vec4 colour;
void main() {
  colour.rgb = texture(textures, vec3(at_texture, layer)).rgb * (texture(light, at_lightmap).r * gain);
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

/// Whether set_same_on_every_processor was called, or somebody asked for the like.
bool software_only() { return std::getenv("GALLIUM_OVERRIDE_CPU_CAPS") != nullptr; }

std::unique_ptr<GlContext> make_context(PainterKind kind) {
  return kind == PainterKind::kEgl ? make_egl_context(software_only()) : make_osmesa_context();
}

class GlPainter final : public Painter {
 public:
  GlPainter(PainterKind kind, const World& world, const TextureArrays& textures)
      : context_(make_context(kind)), gl_((context_->make_current(), *context_)) {
    upload_textures(world, textures);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthFunc(GL_GREATER);
    gl_.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl_.Enable(GL_CULL_FACE);
    gl_.FrontFace(GL_CW);  // counter-clockwise, seen upside down
  }

  std::string name() const override {
    context_->make_current();
    return fmt::format("{}, {}", context_->name(),
                       reinterpret_cast<const char*>(gl_.GetString(GL_RENDERER)));
  }

  bool prefers_few_calls() const override { return true; }

  void set_vertices(const std::vector<Vertex>& vertices) override {
    context_->make_current();
    GLuint array = 0;
    gl_.GenVertexArrays(1, &array);
    gl_.BindVertexArray(array);
    std::array<GLuint, 2> buffers{};
    gl_.GenBuffers(2, buffers.data());
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                   vertices.data(), GL_DYNAMIC_DRAW);
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
    floats(1, 2, offsetof(Vertex, texture_uv));
    gl_.VertexAttribPointer(2, 1, GL_UNSIGNED_SHORT, GL_FALSE, sizeof(Vertex),
                            at(offsetof(Vertex, layer)));
    gl_.EnableVertexAttribArray(2);
    floats(3, 2, offsetof(Vertex, lightmap_uv));
    gl_.VertexAttribIPointer(4, 1, GL_UNSIGNED_SHORT, sizeof(Vertex), at(offsetof(Vertex, object)));
    gl_.EnableVertexAttribArray(4);
  }

  void move_vertices(std::size_t first, const std::vector<Vertex>& vertices) override {
    context_->make_current();
    gl_.BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(first * sizeof(Vertex)),
                      static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data());
  }

  void set_light(const cv::Mat& texels, const cv::Rect& changed) override {
    if (changed.empty()) {
      return;
    }
    context_->make_current();
    gl_.ActiveTexture(GL_TEXTURE1);
    if (!has_light_) {
      make_lightmap(texels.size());
    }
    cv::Mat four;  // one channel would do, but four are looked up by a faster way
    cv::cvtColor(texels(changed), four, cv::COLOR_GRAY2BGRA);
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, changed.x, changed.y, four.cols, four.rows, GL_RGBA,
                      GL_UNSIGNED_BYTE, four.data);
    gl_.ActiveTexture(GL_TEXTURE0);
  }

  RenderedImage paint(const RenderJob& job, const Visible& visible) override {
    if (job.view.faces != nullptr) {
      return draw_faces(job.view, job.outputs,
                        [&](const View& pinhole, const RenderOutputs& /*ask*/) {
                          RenderJob of_face = job;
                          of_face.view = pinhole;
                          return paint(of_face, visible);
                        });
    }
    const DrawList& list = visible(job.view);
    const Intrinsics& camera = job.view.intrinsics;
    const RenderOutputs& outputs = job.outputs;
    const int width = camera.width_px;
    const int height = camera.height_px;
    context_->make_current();
    gl_.BindFramebuffer(GL_FRAMEBUFFER, target(width, height, outputs.instance));
    gl_.Viewport(0, 0, width, height);
    clear(job);
    draw(job, list);

    RenderedImage rendered;
    bgra_.create(height, width, CV_8UC4);
    gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl_.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, bgra_.data);
    cv::cvtColor(bgra_, rendered.bgr, cv::COLOR_BGRA2BGR);
    if (outputs.floor_label) {
      cv::extractChannel(bgra_, rendered.floor_label, 3);
    }
    if (outputs.instance) {
      rendered.instance.create(height, width, CV_16U);
      gl_.ReadBuffer(GL_COLOR_ATTACHMENT1);
      gl_.PixelStorei(GL_PACK_ALIGNMENT, 2);
      gl_.ReadPixels(0, 0, width, height, GL_RED_INTEGER, GL_UNSIGNED_SHORT,
                     rendered.instance.data);
      gl_.PixelStorei(GL_PACK_ALIGNMENT, 4);
    }
    if (outputs.depth) {
      rendered.depth_m = read_depth(width, height, static_cast<float>(job.near_m));
    }
    return rendered;
  }

 private:
  GLuint compiled(GLenum kind, const char* source, const RenderOutputs& outputs) const {
    const std::string text = fmt::format("#version 330 core\n#define FLOOR_TOP_M {}\n{}{}{}",
                                         kFloorTop_m, outputs.floor_label ? "#define LABEL\n" : "",
                                         outputs.instance ? "#define INSTANCE\n" : "", source);
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
  const Program& program(const RenderOutputs& outputs) {
    Program& p = programs_[(outputs.floor_label ? 1U : 0U) + (outputs.instance ? 2U : 0U)];
    if (p.name == 0) {
      p.name = gl_.CreateProgram();
      for (const auto& [kind, source] :
           {std::pair<GLenum, const char*>{GL_VERTEX_SHADER, kVertexShader},
            std::pair<GLenum, const char*>{GL_FRAGMENT_SHADER, kFragmentShader}}) {
        const GLuint shader = compiled(kind, source, outputs);
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
      gl_.Uniform1i(gl_.GetUniformLocation(p.name, "textures"), 0);
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
      set(GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
      set(GL_TEXTURE_MAG_FILTER, GL_LINEAR);
      set(GL_TEXTURE_WRAP_S, GL_REPEAT);
      set(GL_TEXTURE_WRAP_T, GL_REPEAT);
      texture_arrays_.push_back(name);
    }
  }

  void make_lightmap(const cv::Size& size) {
    has_light_ = true;
    GLuint name = 0;
    gl_.GenTextures(1, &name);
    gl_.BindTexture(GL_TEXTURE_2D, name);
    gl_.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, size.width, size.height);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
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

  void clear(const RenderJob& job) const {
    const std::array<float, 4> sky{job.sky_bgr[0], job.sky_bgr[1], job.sky_bgr[2], 0};
    gl_.ClearBufferfv(GL_COLOR, 0, sky.data());
    constexpr std::array<GLuint, 4> kNothing{};
    if (job.outputs.instance) {
      gl_.ClearBufferuiv(GL_COLOR, 1, kNothing.data());
    }
    constexpr GLfloat kInfinity = 0;
    gl_.ClearBufferfv(GL_DEPTH, 0, &kInfinity);
  }

  void draw(const RenderJob& job, const DrawList& list) {
    if (list.indices.empty()) {
      return;
    }
    const Program& program = this->program(job.outputs);
    const Eigen::Matrix4f clip_scene = clip_from_scene(job.view, job.near_m);
    gl_.UseProgram(program.name);
    gl_.UniformMatrix4fv(program.clip_scene, 1, GL_FALSE, clip_scene.data());
    gl_.Uniform1f(program.gain, static_cast<float>(job.light_gain));
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(list.indices.size() * sizeof(std::uint32_t)),
                   list.indices.data(), GL_STREAM_DRAW);
    for (const Call& call : list.calls) {
      gl_.BindTexture(GL_TEXTURE_2D_ARRAY, texture_arrays_[call.array]);
      const std::size_t offset = call.first * sizeof(std::uint32_t);
      gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(call.count), GL_UNSIGNED_INT,
                       reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr)
    }
  }

  cv::Mat read_depth(int width, int height, float near_m) const {
    cv::Mat depth(height, width, CV_32F);
    gl_.ReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data);
    for (int row = 0; row < height; ++row) {
      auto* z = depth.ptr<float>(row);
      for (int column = 0; column < width; ++column) {
        z[column] = near_m / z[column];  // 0, where nothing is, gives infinity
      }
    }
    return depth;
  }

  std::unique_ptr<GlContext> context_;
  Gl gl_;
  std::array<Program, 4> programs_;                       ///< by floor label, instance
  std::map<std::tuple<int, int, bool>, Target> targets_;  ///< by width, height, instance
  std::vector<GLuint> texture_arrays_;
  bool has_light_ = false;
  cv::Mat bgra_;
};

}  // namespace

std::unique_ptr<Painter> make_gl_painter(PainterKind kind, const World& world,
                                         const TextureArrays& textures) {
  return std::make_unique<GlPainter>(kind, world, textures);
}

}  // namespace panoptes::sim
