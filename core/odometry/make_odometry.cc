// SPDX-License-Identifier: BSD-3-Clause
#include "core/odometry/make_odometry.h"

#include <map>

namespace panoptes {

#define PANOPTES_ODOMETRY_SOURCE(name) \
  std::unique_ptr<OdometrySource> make_##name##_odometry(const OdometryParts& parts);
#include "core/odometry/odometry_sources.inc"
#undef PANOPTES_ODOMETRY_SOURCE

std::unique_ptr<OdometrySource> make_odometry(const OdometryParts& parts) {
  using Make = std::unique_ptr<OdometrySource> (*)(const OdometryParts&);
  const std::map<std::string_view, Make> sources = {
#define PANOPTES_ODOMETRY_SOURCE(name) {#name, make_##name##_odometry},
#include "core/odometry/odometry_sources.inc"
#undef PANOPTES_ODOMETRY_SOURCE
  };
  return sources.at(std::visit([](const auto& chosen) { return chosen.kName; }, parts.options))(
      parts);
}

}  // namespace panoptes
