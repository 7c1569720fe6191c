// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run_app.h"

#include <cerrno>
#include <cstdio>
#include <iostream>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/process/fault.h"
#include "apps/process/process.h"
#include "core/config/fields.h"

namespace panoptes {

#define PANOPTES_COMMAND(name) void add_##name(CLI::App& app, Command& chosen);
#include "apps/commands.inc"
#undef PANOPTES_COMMAND

namespace {

enum ExitStatus { kDone = 0, kBadInput = 2, kMachine = 3 };

int complain(int status, const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  return status;
}

// One line, however CLI11 words it.
std::string one_line(std::string text) {
  for (char& c : text) {
    c = c == '\n' ? ' ' : c;
  }
  return text;
}

// What is wrong with the command line, and where to read what is right.
std::string usage_fault(const CLI::App& app, const std::string& first, const CLI::Error& error) {
  std::vector<std::string> names;
  for (const CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(subcommand->get_name());
    if (subcommand->get_name() == first) {
      return "panoptes: " + one_line(error.what()) + "; see panoptes " + first + " --help";
    }
  }
  if (first.empty() || first.front() == '-') {
    return "panoptes: " + one_line(error.what()) + "; see panoptes --help";
  }
  const std::string near = nearest_word(first, names);
  return "panoptes: " + first + " is no subcommand; " +
         (near.empty() ? "see panoptes --help" : "did you mean " + near + "?");
}

// What has been said on stdout must have arrived, or nobody knows that it was said.
int heard(int status) {
  errno = 0;
  std::cout.flush();
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
  if (written) {
    return status;
  }
  const int why = errno != 0 ? errno : EIO;  // it may have failed before
  const int told =
      complain(kMachine, "stdout: cannot be written: " + std::generic_category().message(why));
  std::clearerr(stdout);  // said once
  std::cout.clear();
  return status == kDone ? told : status;
}

int run(int argc, const char* const* argv) {
  set_up_process();
  CLI::App app("Panoptes lets a wheeled robot map a room with several ordinary cameras.",
               "panoptes");
  app.set_version_flag("--version", std::string("panoptes ") + PANOPTES_VERSION);
  app.require_subcommand(1);
  app.footer("Example: panoptes explore scenes/missions/explore-office.yaml --seed 1");
  Command chosen;
#define PANOPTES_COMMAND(name) add_##name(app, chosen);
#include "apps/commands.inc"
#undef PANOPTES_COMMAND
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return heard(app.exit(asked) == 0 ? kDone : kBadInput);
  } catch (const CLI::ParseError& error) {
    return complain(kBadInput, usage_fault(app, argc > 1 ? argv[1] : "", error));
  }
  return heard(chosen());
}

}  // namespace

int run_app(int argc, const char* const* argv) {
  try {
    return run(argc, argv);
  } catch (...) {
    const Fault fault = current_fault();
    return complain(fault.status, fault.what);
  }
}

}  // namespace panoptes
