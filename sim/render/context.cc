// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/context.h"

#include <string_view>

namespace panoptes::sim {
namespace {

thread_local GlContext* current = nullptr;

}  // namespace

void GlContext::make_current() {
  if (current == this) {
    return;
  }
  // The libraries share OpenGL's table of functions: one lets go of it before another takes it.
  if (current != nullptr && std::string_view(current->name()) != name()) {
    current->release();
  }
  current = nullptr;
  bind();
  current = this;
}

void GlContext::forget() {
  if (current == this) {
    release();
    current = nullptr;
  }
}

}  // namespace panoptes::sim
