// SPDX-License-Identifier: BSD-3-Clause
#include "apps/process/fault.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <system_error>
#include <utility>

#include <opencv2/core.hpp>

#include "core/base/error.h"

namespace panoptes {
namespace {

enum Status { kUser = 2, kMachine = 3, kOurBug = 4 };

Fault out_of_memory() {
  return {kMachine, "out of memory; close other programs or use a smaller world"};
}

Fault our_bug(const std::string& what) {
  return {kOurBug, "a bug of panoptes, please report it: " + what};
}

}  // namespace

Fault current_fault() {
  try {
    throw;
  } catch (const ConfigError& error) {
    return {kUser, error.what()};
  } catch (const IoError& error) {
    return {kMachine, error.what()};
  } catch (const DeviceError& error) {
    return {kMachine, error.what()};
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const cv::Exception& error) {
    return error.code == cv::Error::StsNoMem ? out_of_memory() : our_bug(error.what());
  } catch (const std::system_error& error) {  // of files, of threads
    return {kMachine, error.what()};
  } catch (const std::exception& error) {
    return our_bug(error.what());
  } catch (...) {
    return our_bug("something was thrown that is no exception");
  }
}

void Faults::keep(Fault fault) {
  const bool told = std::any_of(all_.begin(), all_.end(),
                                [&](const Fault& before) { return before.what == fault.what; });
  if (!told) {
    std::fprintf(stderr, "%s\n", fault.what.c_str());
    all_.push_back(std::move(fault));
  }
}

std::string Faults::text() const {
  std::string all;
  for (const Fault& fault : all_) {
    all += (all.empty() ? "" : "\n") + fault.what;
  }
  return all;
}

}  // namespace panoptes
