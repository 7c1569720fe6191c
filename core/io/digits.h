// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/time.h"

namespace panoptes {

/// The fewest digits that read back to the same double, the same in every locale. `-0` is written
/// 0.
std::string shortest(double value);

/// The whole text as a finite number; empty when it is not one.
std::optional<double> parse_number(std::string_view text);

/// An instant in seconds, exact to the nanosecond, without trailing zeros: 12.066666667.
std::string seconds(Time stamp);
/// The reverse; digits past the nanosecond are rounded. Empty when the text is no decimal number.
std::optional<Time> parse_seconds(std::string_view text);

}  // namespace panoptes
