// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
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

/// One value of a settings file, being read or written: what the verbs of Fields are made of.
class Setting {
 public:
  class State;  // of the room's .cc files
  explicit Setting(std::unique_ptr<State> state);
  Setting(Setting&&) noexcept;
  ~Setting();

  bool writing() const;
  bool is_null() const;  ///< reading: the file says nothing here, or null
  bool is_list() const;  ///< reading
  void scalar(bool& value);
  void scalar(int& value, const Rule& rule);
  void scalar(std::int64_t& value, const Rule& rule);
  void scalar(std::uint64_t& value, const Rule& rule);
  void scalar(double& value, const Rule& rule);
  void scalar(std::string& value);
  void path(std::string& value);  ///< the name of a file that exists
  std::string where() const;      ///< reading: file:line:column
  void null();                    ///< writing

  std::size_t begin_list();  ///< how many items are there to read; a fault when it is no list
  bool begin_list_of(std::size_t count);  ///< false, and a fault, when it has not `count` items
  Setting item(std::size_t index);        ///< the next one when writing

  std::vector<std::string> begin_mapping();  ///< the keys to read; a fault when it is no mapping
  Setting entry(const std::string& key);

  /// True when there is a mapping to bind to; false (and a fault) when it is something else.
  bool is_mapping();
  class Fields fields();

 private:
  std::unique_ptr<State> state_;
};

/// One mapping of a settings file while a struct is bound to it: reads into, or writes from, the
/// struct's fields, and collects every fault it meets. A struct takes part by a free function
/// `void bind(Fields&, T&)`, which serves reading, checking and writing alike. Defaults are what
/// the struct holds before binding. Keys that no bind asks for are faults.
class Fields {
 public:
  class Node;  // of the room's .cc files
  explicit Fields(std::unique_ptr<Node> node);
  Fields(Fields&&) noexcept;
  ~Fields();

  /// A field by its key: bool, int, std::int64_t, std::uint64_t, double, std::string, Vec2, Vec3
  /// and Mat3 (row by row), a vector, optional or string-keyed map of fields, or any struct with a
  /// bind. Geometry has its binds in core/config/geometry_fields.h.
  template <class T>
  void operator()(std::string_view key, T& value) {
    (*this)(key, value, Rule());
  }
  /// The rule holds for every number inside.
  template <class T>
  void operator()(std::string_view key, T& value, const Rule& rule);

  /// `old_key` is what earlier versions called `key`: a file that still says so is refused, and the
  /// fault names the key of today.
  void renamed(std::string_view old_key, std::string_view key);

  /// A setting of earlier versions that is gone: a file that still gives it is refused, and the
  /// fault says why, once.
  void removed(std::string_view old_key, std::string_view why);

  /// A field by its key whose absence is a fault.
  template <class T>
  void needed(std::string_view key, T& value, const Rule& rule = Rule()) {
    require_present(key);
    (*this)(key, value, rule);
  }

  /// A map whose entries begin as `common` rather than as T's own defaults.
  template <class T>
  void over(std::string_view key, std::map<std::string, T>& values, const T& common);

  /// An angle held in radians, written in the file as `<stem>_deg` or `<stem>_rad`.
  void angle(std::string_view stem, double& value_rad, const Rule& rule_rad = {});

  /// Three numbers in a list, or one for all of them. Written as a list.
  void one_or_each(std::string_view key, Vec3& value, const Rule& rule = {});
  /// The same of angles, written in the file as `<stem>_deg` or `<stem>_rad`.
  void one_angle_or_each(std::string_view stem, Vec3& value_rad, const Rule& rule_rad = {});

  /// One of a few words.
  template <class Enum>
  void word(std::string_view key, Enum& value,
            const std::vector<std::pair<std::string, Enum>>& words);

  /// A method variant: `key: name` or `key: {kind: name, ...its own fields}`. Each alternative has
  /// `static constexpr std::string_view kName` and a bind; one with a `kShort` as well may be
  /// written `key: {name: value}` for `key: {kind: name, <kShort>: value}`.
  template <class... Ts>
  void choice(std::string_view key, std::variant<Ts...>& value);

  /// The same for what may be absent, its name the key: `key: {name: {...its own fields}}`, or
  /// `key: name` with all its defaults.
  template <class... Ts>
  void choice(std::string_view key, std::optional<std::variant<Ts...>>& value);

  /// A struct from another file (`key: ../rigs/front.yaml`, relative to the file that says so, or
  /// `data:rigs/front.yaml`) or written here as a mapping. Written inline.
  template <class T>
  void file_or_inline(std::string_view key, T& value) {
    std::string file;
    resolve_file(key, file);
    (*this)(key, value);
  }
  /// The same, but written as the name of its file as long as the settings are the file's own;
  /// `file` is where they came from, empty when they were given or changed by hand.
  template <class T>
  void file_or_inline(std::string_view key, T& value, std::string& file);

  /// Reading: the struct at `key` as it stood in the file before a `--set` reached there. False,
  /// and nothing read, where no `--set` did, where nothing stood, and where it is faulty.
  template <class T>
  bool file_or_inline_before_set(std::string_view key, T& value);

  /// The name of an existing file (a mesh, a picture), relative to the file that says so or
  /// `data:`. The field holds a name that opens; it is written as `data:` where it is one of
  /// Panoptes' own.
  void path(std::string_view key, std::string& value);
  /// A list or a map of them. `mentions` gets the place (file:line:column) of each.
  void paths(std::string_view key, std::vector<std::string>& values,
             std::vector<std::string>& mentions);
  void paths(std::string_view key, std::map<std::string, std::string>& values,
             std::map<std::string, std::string>& mentions);

  /// A list of words, with the place (file:line:column) of each.
  void texts(std::string_view key, std::vector<std::string>& values,
             std::vector<std::string>& mentions);

  /// A rule between several fields of this struct, reported at `key`, which may lead into what
  /// stands inside (`sensors.front.row_us`, `rows[3].name`): then where as much of it as there is
  /// stands.
  void require(bool holds, std::string_view key, std::string_view must);

  bool writing() const;
  bool present(std::string_view key) const;  ///< reading: the file says something of `key`
  std::string where(
      std::string_view key) const;  ///< reading: file:line:column of what it says of `key`
  std::string here() const;         ///< reading: file:line:column of this mapping
  std::string file() const;  ///< reading: the file that holds this mapping; empty for `--set`
  void finish();  ///< reports the keys that nobody asked for; the entry functions call it

 private:
  std::optional<Setting> setting(std::string_view key);
  std::optional<Setting> setting_before_set(std::string_view key);
  bool sound_before_set() const;
  void require_present(std::string_view key);
  void list_of(std::string_view key, std::vector<std::string>& values,
               std::vector<std::string>& mentions,
               const std::function<void(Setting& item, std::string& value)>& bind_item);
  void resolve_file(std::string_view key, std::string& file);
  bool write_file(std::string_view key, const std::string& file);
  std::size_t word_index(std::string_view key, const std::vector<std::string>& words,
                         std::size_t current);
  std::size_t kind_index(std::string_view key, const std::vector<std::string>& kinds,
                         const std::vector<std::string>& shorts, std::size_t current);
  std::optional<Fields> kind_fields(std::string_view key, const std::string& kind);
  std::optional<std::size_t> named_kind(std::string_view key,
                                        const std::vector<std::string>& kinds);

  std::unique_ptr<Node> node_;
};

/// Reads a settings file over the defaults, then `overrides` (`key.path=value`, the later one
/// wins; `*` in the path stands for every key that a mapping has there). Throws ConfigError with
/// every fault found (IoError where all there is to complain of is missing assets).
template <class T>
T read_settings(const std::string& file, const std::vector<std::string>& overrides = {},
                T defaults = {});

/// The same from text; `name` stands for the file in messages, and files are looked for beside it.
template <class T>
T read_settings_text(const std::string& text, const std::string& name,
                     const std::vector<std::string>& overrides = {}, T defaults = {});

/// The keys at the top of a settings file, to tell what kind it is; throws ConfigError where it
/// cannot be read.
std::vector<std::string> settings_keys(const std::string& file);

/// All settings as yaml: radians, shortest digits that read back to the same double, in the order
/// of the binds. Reading it gives the same settings bit for bit.
template <class T>
std::string write_settings(const T& settings);

/// The nearest of `known` to a misspelt word; empty when none is near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

// What follows is how the templates do it.

namespace fields_detail {

template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};
template <class T>
struct IsMap : std::false_type {};
template <class T>
struct IsMap<std::map<std::string, T>> : std::true_type {};

template <class T>
constexpr bool kIsMatrix =
    std::is_same_v<T, Vec2> || std::is_same_v<T, Vec3> || std::is_same_v<T, Mat3>;
template <class T>
constexpr bool kIsNumber = std::is_same_v<T, int> || std::is_same_v<T, std::int64_t> ||
                           std::is_same_v<T, std::uint64_t> || std::is_same_v<T, double>;

template <class T, class = void>
struct ShortKey {
  static std::string of() { return {}; }
};
template <class T>
struct ShortKey<T, std::void_t<decltype(T::kShort)>> {
  static std::string of() { return std::string(T::kShort); }
};

template <class T>
void bind_setting(Setting setting, T& value, const Rule& rule) {
  if constexpr (kIsNumber<T>) {
    setting.scalar(value, rule);
  } else if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, std::string>) {
    setting.scalar(value);
  } else if constexpr (kIsMatrix<T>) {
    if (!setting.begin_list_of(static_cast<std::size_t>(value.size()))) {
      return;
    }
    T read = value;
    std::size_t i = 0;
    for (Eigen::Index row = 0; row < value.rows(); ++row) {
      for (Eigen::Index column = 0; column < value.cols(); ++column) {
        setting.item(i++).scalar(read(row, column), rule);
      }
    }
    value = read;
  } else if constexpr (IsVector<T>::value) {
    const std::size_t count = setting.begin_list();
    if (!setting.writing()) {
      value = T(count);
    }
    for (std::size_t i = 0; i < value.size(); ++i) {
      bind_setting(setting.item(i), value[i], rule);
    }
  } else if constexpr (IsOptional<T>::value) {
    if (setting.writing() ? !value.has_value() : setting.is_null()) {
      setting.writing() ? setting.null() : value.reset();
      return;
    }
    if (!value) {
      value.emplace();
    }
    bind_setting(std::move(setting), *value, rule);
  } else if constexpr (IsMap<T>::value) {
    const std::vector<std::string> keys = setting.begin_mapping();
    if (!setting.writing()) {
      value.clear();
      for (const std::string& key : keys) {
        value[key];
      }
    }
    for (auto& [key, inner] : value) {
      bind_setting(setting.entry(key), inner, rule);
    }
  } else if (setting.is_mapping()) {
    Fields inner = setting.fields();
    bind(inner, value);
    inner.finish();
  }
}

/// The document as a whole: reads it, binds it through the callback and throws what is wrong.
void read_document(const std::string& name, const std::string* text,
                   const std::vector<std::string>& overrides,
                   const std::function<void(Setting)>& bind_root);
std::string write_document(const std::function<void(Setting)>& bind_root);

}  // namespace fields_detail

template <class T>
void Fields::operator()(std::string_view key, T& value, const Rule& rule) {
  if (std::optional<Setting> found = setting(key)) {
    fields_detail::bind_setting(std::move(*found), value, rule);
  }
}

template <class T>
void Fields::over(std::string_view key, std::map<std::string, T>& values, const T& common) {
  std::optional<Setting> found = setting(key);
  if (!found) {
    return;
  }
  const std::vector<std::string> names = found->begin_mapping();
  if (!found->writing()) {
    values.clear();
    for (const std::string& name : names) {
      values.emplace(name, common);
    }
  }
  for (auto& [name, inner] : values) {
    fields_detail::bind_setting(found->entry(name), inner, Rule());
  }
}

template <class Enum>
void Fields::word(std::string_view key, Enum& value,
                  const std::vector<std::pair<std::string, Enum>>& words) {
  std::vector<std::string> names;
  std::size_t current = 0;
  for (const auto& [name, meaning] : words) {
    if (meaning == value) {
      current = names.size();
    }
    names.push_back(name);
  }
  value = words[word_index(key, names, current)].second;
}

template <class... Ts>
void Fields::choice(std::string_view key, std::variant<Ts...>& value) {
  const std::vector<std::string> kinds{std::string(Ts::kName)...};
  const std::size_t index =
      kind_index(key, kinds, {fields_detail::ShortKey<Ts>::of()...}, value.index());
  if (index != value.index()) {
    std::size_t i = 0;
    ((i++ == index ? static_cast<void>(value.template emplace<Ts>()) : static_cast<void>(0)), ...);
  }
  if (std::optional<Fields> inner = kind_fields(key, kinds[index])) {
    std::visit([&inner](auto& alternative) { bind(*inner, alternative); }, value);
    inner->finish();
  }
}

template <class... Ts>
void Fields::choice(std::string_view key, std::optional<std::variant<Ts...>>& value) {
  const std::vector<std::string> kinds{std::string(Ts::kName)...};
  if (writing()) {
    if (std::optional<Setting> tag = setting(key); !value) {
      tag->null();
    } else {
      tag->begin_mapping();
      std::visit(
          [&](auto& alternative) {
            fields_detail::bind_setting(tag->entry(kinds[value->index()]), alternative, Rule());
          },
          *value);
    }
    return;
  }
  if (!present(key)) {
    setting(key);
    return;
  }
  value.reset();
  const std::optional<std::size_t> index = named_kind(key, kinds);
  if (!index) {
    return;
  }
  std::size_t i = 0;
  ((i++ == *index ? static_cast<void>(value.emplace(std::in_place_type<Ts>))
                  : static_cast<void>(0)),
   ...);
  std::visit(
      [&](auto& alternative) {
        fields_detail::bind_setting(setting(key)->entry(kinds[*index]), alternative, Rule());
      },
      *value);
}

template <class T>
void Fields::file_or_inline(std::string_view key, T& value, std::string& file) {
  if (writing() ? write_file(key, file) : (resolve_file(key, file), false)) {
    return;
  }
  (*this)(key, value);
}

template <class T>
bool Fields::file_or_inline_before_set(std::string_view key, T& value) {
  std::optional<Setting> found = setting_before_set(key);
  if (!found) {
    return false;
  }
  T read;
  fields_detail::bind_setting(std::move(*found), read, Rule());
  if (!sound_before_set()) {
    return false;
  }
  value = std::move(read);
  return true;
}

template <class T>
T read_settings(const std::string& file, const std::vector<std::string>& overrides, T defaults) {
  fields_detail::read_document(file, nullptr, overrides, [&defaults](Setting root) {
    fields_detail::bind_setting(std::move(root), defaults, Rule());
  });
  return defaults;
}

template <class T>
T read_settings_text(const std::string& text, const std::string& name,
                     const std::vector<std::string>& overrides, T defaults) {
  fields_detail::read_document(name, &text, overrides, [&defaults](Setting root) {
    fields_detail::bind_setting(std::move(root), defaults, Rule());
  });
  return defaults;
}

template <class T>
std::string write_settings(const T& settings) {
  T copy = settings;
  return fields_detail::write_document(
      [&copy](Setting root) { fields_detail::bind_setting(std::move(root), copy, Rule()); });
}

}  // namespace panoptes
