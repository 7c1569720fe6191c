// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace panoptes {

/// Where something was said: a place in a file, or a `--set` of the command line.
struct SettingsPlace {
  std::string file;  ///< empty for `--set`
  int line = 0;      ///< counted from 1
  int column = 0;
  std::string override_path;  ///< of the `--set`, else empty

  std::string text() const;
};

/// A settings file as plain data, every value with its place: what yaml is read into and written
/// from.
struct SettingsTree {
  enum class Kind { kNull, kScalar, kList, kMapping, kBroken };  ///< kBroken: reported already
  struct Key {
    std::string name;
    SettingsPlace place;
  };

  Kind kind = Kind::kNull;
  SettingsPlace place;
  std::string text;             ///< of a scalar
  bool quoted = false;          ///< a scalar that is text whatever it looks like
  std::string required_sha256;  ///< of the file that is named here
  std::vector<Key> keys;
  std::vector<SettingsTree> items;  ///< of a list, or the values of `keys`

  SettingsTree* find(std::string_view key);
  const SettingsTree* find(std::string_view key) const;
  SettingsTree& add(Key key);  ///< at the end of a mapping
};

/// Reads yaml text. `place` names the file (or the `--set`) the text came from; faults (broken
/// yaml, keys given twice) go to `faults` with their places, and what could be read is returned.
struct SettingsFault {
  SettingsPlace place;
  std::string path;
  std::string text;
  bool missing_asset = false;
};
SettingsTree parse_settings(const std::string& text, const SettingsPlace& place,
                            std::vector<SettingsFault>& faults);

std::string print_settings(const SettingsTree& tree);

}  // namespace panoptes
