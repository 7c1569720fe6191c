// SPDX-License-Identifier: BSD-3-Clause
#include "apps/doctor/serial_ports.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// A machine made of files.
class SerialPorts : public ScratchTest {
 protected:
  // The kernel's side of a port; its node, where it has one, is a plain file.
  void plug_in(const std::string& name, bool node = true) const {
    fs::create_directories(folder_ / "sys/class/tty" / name / "device");
    fs::create_directories(folder_ / "dev");
    if (node) {
      write_file(folder_ / "dev" / name, "");
    }
  }
  void write(const std::string& file, const std::string& text) const {
    fs::create_directories((folder_ / file).parent_path());
    write_file(folder_ / file, text);
  }
};

TEST_F(SerialPorts, AMachineMayHaveNone) {
  EXPECT_THAT(serial_ports(folder_), IsEmpty());
  fs::create_directories(folder_ / "sys/class/tty/tty1");  // a console: no device
  EXPECT_THAT(serial_ports(folder_), IsEmpty());
}

TEST_F(SerialPorts, ThoseWithADeviceAreListedByNameWithTheirLastingNames) {
  plug_in("ttyUSB0");
  plug_in("ttyACM0");
  plug_in("ttyS0");
  plug_in("ttyS1");
  write("sys/class/tty/ttyS0/type", "4\n");
  write("sys/class/tty/ttyS1/type", "0\n");  // the board has no such chip
  fs::create_directories(folder_ / "dev/serial/by-id");
  fs::create_symlink("../../ttyUSB0", folder_ / "dev/serial/by-id/usb-FTDI_A1-if00-port0");
  const std::vector<ListedPort> ports = serial_ports(folder_);
  ASSERT_THAT(ports, SizeIs(3));
  EXPECT_EQ(ports[0].node, "/dev/ttyACM0");
  EXPECT_THAT(ports[0].by_id, IsEmpty());
  EXPECT_EQ(ports[1].node, "/dev/ttyS0");
  EXPECT_EQ(ports[2].node, "/dev/ttyUSB0");
  EXPECT_THAT(ports[2].by_id, ElementsAre("/dev/serial/by-id/usb-FTDI_A1-if00-port0"));
  for (const ListedPort& port : ports) {
    EXPECT_EQ(port.fault, "") << port.node;
    EXPECT_EQ(port.cure, "") << port.node;
  }
}

TEST_F(SerialPorts, OneThatIsLockedIsBusy) {
  plug_in("ttyUSB0");
  const int lock = ::open((folder_ / "dev/ttyUSB0").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(::flock(lock, LOCK_EX), 0);
  const std::vector<ListedPort> ports = serial_ports(folder_);
  ::close(lock);
  ASSERT_THAT(ports, SizeIs(1));
  EXPECT_EQ(ports[0].fault, "busy: another process has it");
  EXPECT_EQ(ports[0].cure, "end that: sudo fuser -v /dev/ttyUSB0");
}

TEST_F(SerialPorts, OneThatAnotherProcessHasOpenIsBusyThoughItIsNotLocked) {
  plug_in("ttyUSB0");
  write("proc/4711/comm", "gpsd\n");
  fs::create_directories(folder_ / "proc/4711/fd");
  fs::create_symlink("/dev/ttyUSB0", folder_ / "proc/4711/fd/5");
  const std::vector<ListedPort> ports = serial_ports(folder_);
  ASSERT_THAT(ports, SizeIs(1));
  EXPECT_EQ(ports[0].fault, "busy: gpsd (pid 4711) has it open");
}

TEST_F(SerialPorts, OneWithoutANodeIsMissingFromAContainer) {
  plug_in("ttyUSB0", false);
  const std::vector<ListedPort> ports = serial_ports(folder_);
  ASSERT_THAT(ports, SizeIs(1));
  EXPECT_EQ(ports[0].fault, "has no node in /dev");
  EXPECT_THAT(ports[0].cure, HasSubstr("--device /dev/ttyUSB0"));
}

TEST_F(SerialPorts, OneThatMayNotBeOpenedNamesItsGroup) {
  plug_in("ttyUSB0");
  fs::permissions(folder_ / "dev/ttyUSB0", fs::perms::none);
  const uid_t self = ::geteuid();
  const bool root = self == 0;  // who may open everything
  if (root) {
    constexpr uid_t kNobody = 65534;
    fs::permissions(folder_, fs::perms::others_read | fs::perms::others_exec,
                    fs::perm_options::add);
    ASSERT_EQ(::seteuid(kNobody), 0);
  }
  const std::vector<ListedPort> ports = serial_ports(folder_);
  ASSERT_EQ(::seteuid(self), 0);
  ASSERT_THAT(ports, SizeIs(1));
  EXPECT_THAT(ports[0].fault, HasSubstr("no permission: it belongs to the group "));
  EXPECT_NE(ports[0].cure, "");
}

TEST(PioneerIdentity, TellsWhoAnswered) {
  EXPECT_EQ(answer_line({"Carrera_0123", "Pioneer", "p3dx-sh", "2.9", 12.64, 9600}),
            "Pioneer p3dx-sh \"Carrera_0123\", firmware 2.9, battery 12.6 V, 9600 baud");
  EXPECT_EQ(answer_line({"sim", "Pioneer", "p3dx", "", 12, 0}),
            "Pioneer p3dx \"sim\", battery 12.0 V");
}

}  // namespace
}  // namespace panoptes
