// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes {

/// A rule on a number: empty when it holds, else what is allowed ("must be > 0").
using Rule = std::function<std::string(double)>;
Rule between(double low, double high);  ///< both included
Rule at_least(double low);
extern const Rule positive;
extern const Rule not_negative;

/// One node of a settings file while a struct is bound to it: reads into, or writes from, the
/// struct's fields, and collects every fault it meets. A struct takes part by a free function
/// `void bind(Fields&, T&)`, which serves reading, checking and writing alike. Defaults are what the
/// struct holds before binding. Keys that no bind asks for are faults.
class Fields {
 public:
  class Node;  // of the yaml library, unknown here
  explicit Fields(std::unique_ptr<Node> node);
  ~Fields();

  /// A field by its key: bool, int, std::int64_t, std::uint64_t, double, std::string, Vec2, Vec3, a
  /// vector, optional or string-keyed map of fields, or any struct with a bind.
  template <class T>
  void operator()(std::string_view key, T& value);
  template <class T>
  void operator()(std::string_view key, T& value, const Rule& rule);

  /// As above, but its absence is a fault.
  template <class T>
  void needed(std::string_view key, T& value);

  /// An angle held in radians, written in the file as `<stem>_deg` or `<stem>_rad`.
  void angle(std::string_view stem, double& value_rad, const Rule& rule_rad = {});

  /// One of a few words.
  template <class Enum>
  void word(std::string_view key, Enum& value,
            const std::vector<std::pair<std::string, Enum>>& words);

  /// A method variant: `key: name` or `key: {kind: name, ...its own fields}`. Each alternative has
  /// `static constexpr std::string_view kName` and a bind.
  template <class... Ts>
  void choice(std::string_view key, std::variant<Ts...>& value);

  /// A rule between several fields of this struct, reported at `key`.
  void require(bool holds, std::string_view key, std::string_view must);

  bool writing() const;
  bool present(std::string_view key) const;  ///< reading: the file says something of `key`
};

}  // namespace panoptes
