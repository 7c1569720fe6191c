// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string_view>
#include <variant>

#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/config/word.h"
#include "core/geometry/body.h"
#include "core/odometry/odometry_source.h"
#include "core/odometry/wheel_odometry.h"

namespace panoptes {

/// Where motion comes from, with the settings of that word.
template <Word Name>
struct OdometryFrom {
  static constexpr std::string_view kName = Name.text;
};
template <Word Name>
void bind(Fields& /*f*/, OdometryFrom<Name>& /*o*/) {}

template <class /*before the first comma*/, class... Sources>
using OdometryVariant = std::variant<Sources...>;

/// By the sources that CMakeLists.txt lists.
#define PANOPTES_ODOMETRY_SOURCE(name) , OdometryFrom<#name>
using OdometryOptions = OdometryVariant<void
#include "core/odometry/odometry_sources.inc"
                                        >;
#undef PANOPTES_ODOMETRY_SOURCE

/// What a source may be made of: its own settings are in `options`. `rig` is that of the pictures
/// as the platform gives them.
struct OdometryParts {
  const OdometryOptions& options;
  const WheelNoise& wheels;
  const Body& body;
  const Rig& rig;
};

/// The one that the options choose. NAME is what the file NAME.cc of this folder makes with
/// `std::unique_ptr<OdometrySource> make_NAME_odometry(const OdometryParts& parts)`.
std::unique_ptr<OdometrySource> make_odometry(const OdometryParts& parts);

}  // namespace panoptes
