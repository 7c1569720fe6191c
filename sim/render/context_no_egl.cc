// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/error.h"
#include "sim/render/context.h"

namespace panoptes::sim {

std::unique_ptr<GlContext> make_egl_context(bool /*software*/) {
  throw DeviceError(
      "this Panoptes was built without EGL; build it where libegl-dev is installed "
      "(PANOPTES_DRIVER_EGL=ON) or draw by OSMesa");
}

}  // namespace panoptes::sim
