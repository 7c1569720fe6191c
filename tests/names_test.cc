// SPDX-License-Identifier: BSD-3-Clause
// Reads every type of the tree and fails on one name for two of them: the linker takes either for
// both without a word.
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/source_tree.h"

namespace panoptes {
namespace {

/// Where a type is defined that more than one source may see.
struct Definition {
  std::string type;  ///< with its namespaces
  std::string place;
};

/// Of one file in our layout: namespaces and what stands in them begin at a line's start.
std::vector<Definition> definitions_in(const std::string& file, const std::string& text) {
  static const std::regex kOpens(R"(^(?:inline )?namespace ?([\w:]*) \{$)");
  static const std::regex kCloses(R"(^\}  // (?:inline )?namespace.*$)");
  static const std::regex kType(
      R"(^(?:struct|class|union|enum|enum class) (\w+)(?: final)?(?: : ?[^;{]*)?(?: \{.*)?$)");
  std::vector<Definition> found;
  std::vector<std::string> namespaces;
  int unnamed = 0;
  int number = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch match;
    if (std::regex_match(line, match, kOpens)) {
      namespaces.push_back(match[1]);
      unnamed += namespaces.back().empty() ? 1 : 0;
    } else if (std::regex_match(line, kCloses) && !namespaces.empty()) {
      unnamed -= namespaces.back().empty() ? 1 : 0;
      namespaces.pop_back();
    } else if (unnamed == 0 && std::regex_match(line, match, kType)) {
      std::string type;
      for (const std::string& name : namespaces) {
        type += name + "::";
      }
      found.push_back({type + match[1].str(), file + ":" + std::to_string(number)});
    }
  }
  return found;
}

/// A line for each definition of a name that has one already.
std::vector<std::string> names_taken_twice(const std::vector<SourceFile>& files) {
  std::map<std::string, std::string> places;
  std::vector<std::string> faults;
  for (const SourceFile& file : files) {
    for (const Definition& found : definitions_in(file.name, file.text)) {
      const auto [first, is_new] = places.emplace(found.type, found.place);
      if (!is_new) {
        faults.push_back(found.place + ": " + found.type + " is at " + first->second + " too");
      }
    }
  }
  return faults;
}

TEST(Names, OfTypesAreGivenOnce) {
  const std::vector<SourceFile> files = source_tree();
  std::size_t types = 0;
  for (const SourceFile& file : files) {
    types += definitions_in(file.name, file.text).size();
  }
  EXPECT_GT(types, 200U) << "the tree was not found, or has another layout";
  EXPECT_THAT(names_taken_twice(files), testing::IsEmpty());
}

TEST(Names, GivenTwiceAreFound) {
  const SourceFile first{"a.h", "namespace n {\n\nclass Taken final : public Base {\n};\n"};
  for (const char* second :
       {"struct Taken {", "class Taken;\nclass Taken {", "enum class Taken { kOne };",
        "template <class T>\nclass Taken final {", "union Taken : public Very,\n    Long {"}) {
    const SourceFile other{"b.h", std::string("namespace n {\nnamespace {\n}  // namespace\n") +
                                      second + "\n};\n}  // namespace n\n"};
    EXPECT_THAT(names_taken_twice({first, other}),
                testing::ElementsAre(testing::MatchesRegex("b.h:[0-9]: n::Taken is at a.h:3 too")))
        << second;
  }
}

TEST(Names, ThatMayBeTheSameAreLeftAlone) {
  const SourceFile first{"a.h", "namespace n {\nstruct Taken {};\n}  // namespace n\n"};
  for (const char* second :
       {"namespace n {\nstruct Taken;\n", "namespace n {\nnamespace {\nstruct Taken {\n",
        "namespace n {\n  struct Taken {\n", "namespace n::m {\nstruct Taken {\n",
        "namespace n {\nstruct Taken<int> {\n",
        "namespace n {\n}  // namespace n\nstruct Taken {\n",
        "namespace n {\nenum class Taken : int;\n", "namespace n {\n// struct Taken {\n"}) {
    EXPECT_THAT(names_taken_twice({first, {"b.h", second}}), testing::IsEmpty()) << second;
  }
}

}  // namespace
}  // namespace panoptes
