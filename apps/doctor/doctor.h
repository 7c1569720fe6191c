// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "apps/command/command.h"
#include "apps/doctor/serial_ports.h"

namespace panoptes {

/// The subcommand with somebody else to ask at ports; without anybody it only lists them.
void add_doctor(CLI::App& app, Command& chosen, const ProbePort& probe);

}  // namespace panoptes
