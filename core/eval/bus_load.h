// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera/rig.h"

namespace panoptes {

/// What a camera sends.
struct CameraStream {
  int width_px = 0;
  int height_px = 0;
  int bits_per_px = 24;
  double rate_hz = 0;
};

/// The streams of all cameras of a rig that take pictures by themselves.
std::vector<CameraStream> streams_of(const Rig& rig, int bits_per_px);

/// What the pixels alone are, in Mbit/s (10^6): Table 3.1 of the thesis, which compares it with the
/// 800 of IEEE 1394b.
double pixel_mbit_per_s(const std::vector<CameraStream>& streams);

enum class BusKind { kFireWire800, kFireWire400, kGigabitEthernet };
std::string_view name(BusKind kind);

struct BusOptions {
  BusKind kind = BusKind::kFireWire800;
  /// Of IEEE 1394: fixed video modes send a frame in nine of ten cycles, Format7 in all.
  bool fixed_modes = false;
  /// Of IEEE 1394: cameras that the host's card can receive from at once; 4 on cards of Texas
  /// Instruments, 8 on those of Agere and LSI.
  int dma_contexts = 8;
};

/// How a bus bears it.
struct BusLoad {
  double pixel_mbit_per_s = 0;
  double load = 0;                  ///< in `unit`
  double allowed = 0;               ///< in `unit`
  std::string unit;                 ///< "allocation units" of IEEE 1394, "Mbit/s" of Ethernet
  std::vector<std::string> faults;  ///< why it does not; empty where it does
  bool fits() const { return faults.empty(); }
};

/// IEEE 1394 gives isochronous traffic 4915 of the 6144 bandwidth allocation units of a cycle of
/// 125 us. As libdc1394 2.2.6 counts them a camera takes (quadlets of its packet + 3) times 4 at
/// S400 and 2 at S800, with packets of up to 4096 and 8192 bytes. Gigabit Ethernet carries 940
/// Mbit/s in packets of 1500 bytes.
BusLoad bus_load(const BusOptions& options, const std::vector<CameraStream>& streams);

}  // namespace panoptes
