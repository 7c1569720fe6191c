// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/bus_load.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/base/text.h"

namespace panoptes {
namespace {

constexpr double kCycles_hz = 8000;
constexpr double kIsochronousUnits = 4915;  // 80 % of 6144
constexpr double kHeaderQuadlets = 3;
constexpr double kFixedModeShare = 0.9;  // of the cycles of a frame that carry it: 240 of 266.7
constexpr double kEthernet_mbit = 940;

double frame_bytes(const CameraStream& stream) {
  return static_cast<double>(stream.width_px) * stream.height_px * stream.bits_per_px / 8;
}

void load_firewire(const BusOptions& options, const std::vector<CameraStream>& streams,
                   BusLoad& out) {
  const bool s800 = options.kind == BusKind::kFireWire800;
  const double largest_bytes = s800 ? 8192 : 4096;
  const double units_per_quadlet = s800 ? 2 : 4;
  out.unit = "allocation units";
  out.allowed = kIsochronousUnits;
  for (const CameraStream& stream : streams) {
    const double cycles = kCycles_hz / stream.rate_hz * (options.fixed_modes ? kFixedModeShare : 1);
    constexpr double kRoundoff = 1e-9;  // 8000 / rate is not exact
    const double quadlets = std::ceil(frame_bytes(stream) / cycles / 4 - kRoundoff);
    out.load += (quadlets + kHeaderQuadlets) * units_per_quadlet;
    if (4 * quadlets > largest_bytes) {
      out.faults.push_back(fmt::format(
          "a camera of {} x {} px, {} bit at {:g} Hz needs packets of {:.0f} bytes, and the "
          "largest are {:.0f}",
          stream.width_px, stream.height_px, stream.bits_per_px, stream.rate_hz, 4 * quadlets,
          largest_bytes));
    }
  }
  if (static_cast<int>(streams.size()) > options.dma_contexts) {
    out.faults.push_back(
        fmt::format("{} are more than the {} that the host's card receives from "
                    "at once",
                    counted(streams.size(), "camera"), options.dma_contexts));
  }
}

}  // namespace

std::string_view name(BusKind kind) {
  switch (kind) {
    case BusKind::kFireWire800:
      return "firewire800";
    case BusKind::kFireWire400:
      return "firewire400";
    case BusKind::kGigabitEthernet:
      return "gige";
  }
  return "";
}

std::vector<CameraStream> streams_of(const Rig& rig, int bits_per_px) {
  std::vector<CameraStream> streams;
  for (const auto& [name, camera] : rig.cameras) {
    if (camera.rate_hz > 0) {
      streams.push_back(
          {camera.intrinsics.width_px, camera.intrinsics.height_px, bits_per_px, camera.rate_hz});
    }
  }
  return streams;
}

double pixel_mbit_per_s(const std::vector<CameraStream>& streams) {
  double sum = 0;
  for (const CameraStream& stream : streams) {
    sum += 8 * frame_bytes(stream) * stream.rate_hz / 1e6;
  }
  return sum;
}

BusLoad bus_load(const BusOptions& options, const std::vector<CameraStream>& streams) {
  BusLoad out;
  out.pixel_mbit_per_s = pixel_mbit_per_s(streams);
  if (options.kind == BusKind::kGigabitEthernet) {
    out.unit = "Mbit/s";
    out.load = out.pixel_mbit_per_s;
    out.allowed = kEthernet_mbit;
  } else {
    load_firewire(options, streams, out);
  }
  if (out.load > out.allowed) {
    out.faults.push_back(
        fmt::format("{:.0f} of {:.0f} {} are taken", out.load, out.allowed, out.unit));
  }
  return out;
}

}  // namespace panoptes
