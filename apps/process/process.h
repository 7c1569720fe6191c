// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace panoptes {

/// What must hold for the whole process before anything runs: a file that outgrows what the user is
/// allowed is an error like a full disk, not the end of the process, and so is a pipe that nobody
/// reads; OpenCV on one thread, so that
/// results do not depend on the machine, and pictures drawn by as many threads as are of use
/// (`--threads` may say another number; pictures are the same for any).
void set_up_process();

}  // namespace panoptes
