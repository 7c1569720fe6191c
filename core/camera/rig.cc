// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/rig.h"

#include <algorithm>

namespace panoptes {

bool is_loop_role(std::string_view role) { return role.starts_with("loop_"); }

bool RigCamera::has_role(std::string_view role) const {
  return std::find(roles.begin(), roles.end(), role) != roles.end();
}

bool RigCamera::is_loop() const { return std::any_of(roles.begin(), roles.end(), is_loop_role); }

std::string Rig::with_role(std::string_view role) const {
  for (const auto& [name, camera] : cameras) {
    if (camera.has_role(role)) {
      return name;
    }
  }
  return {};
}

}  // namespace panoptes
