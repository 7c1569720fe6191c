// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace panoptes {

/// The whole program: reads the command line, runs what it asks for and returns the exit status.
/// Alone catches what goes wrong: 2 for what the user wrote, 3 for the machine, 4 for our own bugs.
int run_app(int argc, const char* const* argv);

}  // namespace panoptes
