// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstdint>

#include <GL/osmesa.h>

#include "core/base/error.h"
#include "sim/render/context.h"

namespace panoptes::sim {
namespace {

class OsMesaContext final : public GlContext {
 public:
  OsMesaContext() {
    const std::array<int, 13> wanted{OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_DEPTH_BITS,
                                     0,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     4,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     5,
                                     0,
                                     0,
                                     0};
    context_ = OSMesaCreateContextAttribs(wanted.data(), nullptr);
    if (context_ == nullptr) {
      throw DeviceError(
          "no OpenGL 4.5 from OSMesa, so nothing can be drawn; install the package libosmesa6 and "
          "unset GALLIUM_DRIVER and MESA_GL_VERSION_OVERRIDE");
    }
  }
  ~OsMesaContext() override {
    forget();
    OSMesaDestroyContext(context_);
  }
  OsMesaContext(const OsMesaContext&) = delete;
  OsMesaContext& operator=(const OsMesaContext&) = delete;

  Function function(const char* name) const override { return OSMesaGetProcAddress(name); }
  const char* name() const override { return "OSMesa"; }

 private:
  void bind() override {
    if (OSMesaMakeCurrent(context_, unused_.data(), GL_UNSIGNED_BYTE, kUnusedSide, kUnusedSide) ==
        0) {
      throw DeviceError(
          "OSMesa's context cannot be used in this thread; draw from one thread only");
    }
  }
  void release() override { OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0); }

  static constexpr int kUnusedSide = 4;  // of unused_, four bytes a pixel

  OSMesaContext context_ = nullptr;
  std::array<std::uint8_t, 64> unused_{};  ///< OSMesa wants one; we draw elsewhere
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context() { return std::make_unique<OsMesaContext>(); }

}  // namespace panoptes::sim
