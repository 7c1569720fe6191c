// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace panoptes::sim {

/// OpenGL 4.5 without a screen. Used in one thread at a time.
class GlContext {
 public:
  using Function = void (*)();

  GlContext() = default;
  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// From here on OpenGL's functions mean this context in this thread.
  void make_current();
  virtual Function function(const char* name) const = 0;
  virtual const char* name() const = 0;

 protected:
  virtual void bind() = 0;
  virtual void release() = 0;
  /// Before a context is destroyed.
  void forget();
};

/// Both throw DeviceError when there is no such context to be had.
std::unique_ptr<GlContext> make_osmesa_context();
/// On a graphics card where there is one and `software` does not forbid it, else by the same
/// rasteriser as OSMesa's.
std::unique_ptr<GlContext> make_egl_context(bool software);

}  // namespace panoptes::sim
