// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/port_access.h"

#include <gmock/gmock.h>

namespace panoptes::hw {
namespace {

using testing::HasSubstr;

TEST(AccessCure, JoinsTheGroupThatMay) {
  EXPECT_EQ(access_cure({"/dev/ttyUSB0", "dialout", true, "ann", false}),
            "sudo usermod -aG dialout ann, then log out and in again");
  EXPECT_EQ(access_cure({"/dev/ttyUSB0", "uucp", true, "ann", false}),
            "sudo usermod -aG uucp ann, then log out and in again");
}

TEST(AccessCure, TellsWhoHasJoinedToLogInAgain) {
  EXPECT_EQ(access_cure({"/dev/ttyUSB0", "dialout", true, "ann", true}),
            "ann is in the group dialout already: log out and in again (or newgrp dialout)");
}

TEST(AccessCure, IsARuleWhereTheGroupIsRootsOrMayNot) {
  for (const PortAccess& access : {PortAccess{"/dev/ttyUSB3", "root", true, "ann", false},
                                   PortAccess{"/dev/ttyUSB3", "dialout", false, "ann", false},
                                   PortAccess{"/dev/ttyUSB3", "", true, "ann", false}}) {
    const std::string cure = access_cure(access);
    EXPECT_THAT(cure, HasSubstr(R"(KERNEL=="ttyUSB[0-9]*", GROUP="dialout", MODE="0660")"));
    EXPECT_THAT(cure, HasSubstr("sudo usermod -aG dialout ann"));
  }
}

}  // namespace
}  // namespace panoptes::hw
