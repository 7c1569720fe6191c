// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <variant>

#include "core/config/fields.h"
#include "sim/route.h"

namespace panoptes {

/// A word as an argument of a template.
template <std::size_t N>
struct DriveName {
  char text[N];
  constexpr DriveName(const char (&word)[N]) { std::copy_n(word, N, text); }  // NOLINT: implicit
};

/// Who drives: `drive: NAME` of a mission, with the settings of that word. Slam maps in any case.
template <DriveName Name>
struct Drive {
  static constexpr std::string_view kName = Name.text;
};
template <DriveName Name>
void bind(Fields& /*f*/, Drive<Name>& /*o*/) {}

template <>
struct Drive<"route"> {
  static constexpr std::string_view kName = "route";
  static constexpr std::string_view kShort = "file";
  sim::Route route;  ///< written inline: a replay needs no file but the dataset's
};
template <>
void bind(Fields& f, Drive<"route">& o);

template <class /*before the first comma*/, class... Drives>
using DriveVariant = std::variant<Drives...>;

/// By the pilots that apps/CMakeLists.txt lists. By hand (`teleop`) is at a keyboard or a gamepad,
/// and on a recorded platform as it was driven then.
#define PANOPTES_PILOT(name) , Drive<#name>
using DriveOptions = DriveVariant<void
#include "apps/mission/pilots.inc"
                                  >;
#undef PANOPTES_PILOT

}  // namespace panoptes
