// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace panoptes {

/// What went wrong, in words, and the status that the program ends with for it: 2 what the user
/// wrote, 3 the machine (a device, a file, memory), 4 a bug of ours.
struct Fault {
  int status = 0;
  std::string what;
};

/// Of the exception that is being handled, whatever it is.
Fault current_fault();

/// Does one thing after another, whatever is thrown by any of them: what went wrong is told on
/// stderr at once and kept, each of the same words once.
class Faults {
 public:
  /// False when it threw.
  template <class Act>
  bool attempt(const Act& act) {  // no std::function: making one may throw, too
    try {
      act();
      return true;
    } catch (...) {
      keep(current_fault());
      return false;
    }
  }

  bool none() const { return all_.empty(); }
  int status() const { return all_.empty() ? 0 : all_.front().status; }  ///< of the first
  std::string text() const;                                              ///< a line each

 private:
  void keep(Fault fault);

  std::vector<Fault> all_;
};

}  // namespace panoptes
