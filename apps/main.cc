// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run_app.h"

int main(int argc, char** argv) { return panoptes::run_app(argc, argv); }
