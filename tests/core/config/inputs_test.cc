// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/inputs.h"

#include <fstream>

#include <gmock/gmock.h>

#include "core/config/sha256.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

class Inputs : public ScratchTest {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return std::filesystem::canonical(folder_ / name).string();
  }
};

TEST_F(Inputs, AreFilesWithTheHashOfWhatWasRead) {
  const std::string a = write("a", "one");
  const std::string b = write("b", "two");
  keep_inputs();
  note_input(a, "one");
  note_input(folder_ / "." / "a", "one, changed since");  // the first reading counts
  note_input(b);
  note_input(folder_ / "none");
  EXPECT_THAT(inputs(), ElementsAre(Pair(a, sha256("one")), Pair(b, sha256("two"))));
  keep_inputs();
  EXPECT_THAT(inputs(), IsEmpty());
}

TEST_F(Inputs, AreWrittenAsSha256sumWritesThem) {
  const std::map<std::string, std::string> some{{"/a", sha256("one")}, {"/b c", sha256("")}};
  EXPECT_EQ(inputs_text(some), sha256("one") + "  /a\n" + sha256("") + "  /b c\n");
  EXPECT_EQ(parse_inputs(inputs_text(some)), some);
  EXPECT_THAT(parse_inputs("# nothing\n\nshort  /a\n" + sha256("")), IsEmpty());
}

}  // namespace
}  // namespace panoptes
