// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace panoptes {

/// `HOST-PROCESS`: no other process that runs has the same, on whichever machine that shares a
/// folder with this one.
std::string process_name();

}  // namespace panoptes
