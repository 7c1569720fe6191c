// SPDX-License-Identifier: BSD-3-Clause
#include "apps/doctor/doctor.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "apps/teleop/gamepads.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/data_files.h"
#include "hw/pioneer/line.h"
#include "sim/render/renderer.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;
constexpr double kNeededMemory_gib = 1.5;
constexpr double kNeededDisk_gib = 0.5;

struct Finding {
  std::string what;
  std::string found;
  std::string cure;    ///< empty when all is well
  bool needed = true;  ///< nothing runs without it
  const char* unwell = "low";
};

// A floor under a camera that looks down on it.
sim::World one_tile() {
  sim::World world;
  world.ambient = 1;
  world.textures.push_back({"grey", cv::Mat(2, 2, CV_8UC3, cv::Scalar(128, 128, 128))});
  sim::Triangle tile;
  tile.corners[0].p_object = {-9, -9, 0};
  tile.corners[1].p_object = {9, -9, 0};
  tile.corners[2].p_object = {0, 9, 0};
  world.objects.push_back({"tile", Pose3(), {tile}});
  return world;
}

Finding renderer(const std::string& name, sim::PainterKind painter, const std::string& package) {
  const bool needed = painter == sim::PainterKind::kSoftware;
  try {
    sim::RendererOptions options;
    options.painter = painter;
    sim::Renderer renderer(one_tile(), options);
    const sim::View view{pinhole(32, 24, 1), mounted_camera({0, 0, 1}, 0, std::acos(0.0))};
    const cv::Mat bgr = renderer.draw(view).bgr;
    const bool drawn = !bgr.empty() && bgr.at<cv::Vec3b>(12, 16)[0] > 0;
    return {name, renderer.drawn_by() + (drawn ? "" : " draws black"),
            drawn ? "" : "apt-get install --reinstall " + package, needed};
  } catch (const DeviceError& error) {
    return {name, error.what(), "apt-get install " + package, needed};
  }
}

Finding processors() {
  return {"processors", std::to_string(std::thread::hardware_concurrency()), ""};
}

Finding memory() {
  std::ifstream stream("/proc/meminfo");
  std::string word;
  double kib = 0;
  while (stream >> word) {
    if (word == "MemAvailable:") {
      stream >> kib;
    }
  }
  const double gib = kib * 1024 / kGiB;
  return {"memory", fmt::format("{:.1f} GiB free", gib),
          gib >= kNeededMemory_gib
              ? ""
              : fmt::format("a run needs {} GiB: close other programs", kNeededMemory_gib),
          false};
}

Finding disk() {
  std::error_code error;
  const fs::space_info space = fs::space(".", error);
  const double gib = error ? 0 : static_cast<double>(space.available) / kGiB;
  return {"disk", fmt::format("{:.1f} GiB free here", gib),
          gib >= kNeededDisk_gib ? "" : "make room, or give --out another disk", false};
}

Finding data_files() {
  const fs::path root = data_root();
  std::error_code error;
  for (const char* file : {"scenes/missions/explore-office.yaml", "scenes/worlds/office.yaml",
                           "assets/office/room.gltf"}) {
    if (!fs::is_regular_file(root / file, error)) {
      return {"data files", (root / file).string() + " does not exist",
              "set PANOPTES_DATA to the folder that holds scenes/ and assets/"};
    }
  }
  return {"data files", root.string(), ""};
}

Finding cache() {
  const char* named = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if ((named == nullptr || *named == '\0') && (home == nullptr || *home == '\0')) {
    return {"cache", "none", "set HOME: without it light is computed anew for every run", false};
  }
  const fs::path folder = named != nullptr && *named != '\0' ? fs::path(named) / "panoptes"
                                                             : fs::path(home) / ".cache/panoptes";
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path probe = folder / ".probe";
  const bool writable = !error && static_cast<bool>(std::ofstream(probe) << "x");
  fs::remove(probe, error);
  return {"cache", folder.string(),
          writable ? "" : "cannot be written: light is computed anew for every run", false};
}

// One line a port; a machine without any simulates all the same.
std::vector<Finding> ports() {
  std::vector<Finding> findings;
  for (const ListedPort& port : serial_ports()) {
    std::string found = port.node;
    for (const std::string& name : port.by_id) {
      found += " = " + name;
    }
    found += port.fault.empty() ? "" : " " + port.fault;
    findings.push_back({"serial port", found, port.cure, false, "blocked"});
  }
  if (findings.empty()) {
    findings.push_back({"serial port", "none", "", false});
  }
  return findings;
}

std::vector<Finding> gamepads() {
  const Gamepads found;
  std::vector<Finding> findings{
      {"gamepads", found.names().empty() ? "none" : joined(found.names()), "", false}};
  for (const std::string& name : found.unknown()) {
    findings.push_back({"gamepads", name + " has buttons that nobody knows",
                        "describe them in SDL_GAMECONTROLLERCONFIG", false, "blocked"});
  }
  return findings;
}

int doctor() {
  std::vector<Finding> findings{renderer("renderer", sim::PainterKind::kSoftware, "panoptes"),
                                renderer("osmesa", sim::PainterKind::kOsMesa, "libosmesa6"),
                                renderer("egl", sim::PainterKind::kEgl, "libegl1"),
                                processors(),
                                memory(),
                                disk(),
                                data_files(),
                                cache(),
                                {"libraries", PANOPTES_LIBRARY_VERSIONS, ""}};
  for (const std::vector<Finding>& more : {ports(), gamepads()}) {
    findings.insert(findings.end(), more.begin(), more.end());
  }
  int status = 0;
  for (const Finding& finding : findings) {
    const bool well = finding.cure.empty();
    std::printf("%-8s%-12s%s%s\n",
                well             ? "ok"
                : finding.needed ? "missing"
                                 : finding.unwell,
                finding.what.c_str(), finding.found.c_str(),
                well ? "" : ("; " + finding.cure).c_str());
    status = !well && finding.needed ? 3 : status;
  }
  return status;
}

}  // namespace

void add_doctor(CLI::App& app, Command& chosen, const ProbePort& probe) {
  auto port = std::make_shared<std::optional<std::string>>();
  CLI::App* sub = app.add_subcommand("doctor", "What is here, and what is missing?");
  if (probe) {
    sub->add_option("--port", *port, "who answers there: serial:/dev/ttyUSB0 or tcp:host:8101")
        ->type_name("PORT");
  }
  sub->footer(std::string("Example: panoptes doctor") +
              (probe ? " --port serial:/dev/ttyUSB0" : ""));
  sub->callback([&chosen, port, probe] {
    chosen = [port, probe] {
      if (!*port) {
        return doctor();
      }
      const std::string& address = **port;
      if (const std::string fault = hw::LineAddress::fault(address); !fault.empty()) {
        throw ConfigError("--port '" + address + "': " + fault);
      }
      std::printf("%s: %s\n", address.c_str(), answer_line(probe(address)).c_str());
      return 0;
    };
  });
}

void add_doctor(CLI::App& app, Command& chosen) { add_doctor(app, chosen, hw::probe_pioneer); }

}  // namespace panoptes
