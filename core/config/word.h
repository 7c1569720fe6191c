// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>

namespace panoptes {

/// A word of a settings file as an argument of a template.
template <std::size_t N>
struct Word {
  char text[N];
  constexpr Word(const char (&word)[N]) { std::copy_n(word, N, text); }  // NOLINT: implicit
};

}  // namespace panoptes
