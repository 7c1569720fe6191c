// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <system_error>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/data_files.h"
#include "core/config/inputs.h"
#include "core/config/settings_tree.h"
#include "core/config/sha256.h"

namespace panoptes {
namespace {

using Kind = SettingsTree::Kind;
using Path = std::vector<std::string>;

constexpr std::string_view kFromElsewhere = "sha256:";

std::string join(const Path& path) {
  std::string out;
  for (const std::string& part : path) {
    out += (out.empty() || part.front() == '[' ? "" : ".") + part;
  }
  return out;
}

Path plus(Path path, const std::string& part) {
  path.push_back(part);
  return path;
}

std::string number_text(double value) {
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
  PANOPTES_CHECK(error == std::errc(), "a double must fit into 32 characters");
  return {digits, end};
}

std::string kind_text(Kind kind) {
  return kind == Kind::kList ? "a list" : kind == Kind::kMapping ? "a mapping" : "nothing";
}

// What the file says instead, in one short line.
std::string got(const SettingsTree& node) {
  constexpr std::size_t kLongest = 60;
  if (node.kind != Kind::kScalar) {
    return ", got " + kind_text(node.kind);
  }
  std::string text = node.text.substr(0, kLongest);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  text += node.text.size() > kLongest ? "..." : "";
  return ", got " + (node.quoted ? "\"" + text + "\"" : text);
}

// Optimal string alignment: insertions, deletions, replacements and swaps of neighbours.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min(
          {d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
  const std::string near = nearest_word(word, known);
  if (!near.empty()) {
    return "did you mean " + near + "?";
  }
  return known.empty() ? "none is known here" : "known: " + joined(known);
}

// A `--set` of the command line.
struct Override {
  Path path;
  std::string written;  // the path as the user wrote it
  SettingsTree value;
  bool used = false;
};

Path split_path(const std::string& text) {
  Path path;
  std::string part;
  const auto flush = [&] {
    if (!part.empty()) {
      path.push_back(part);
    }
    part.clear();
  };
  for (const char c : text) {
    if (c == '.' || c == '[') {
      flush();
    }
    if (c != '.') {
      part += c;
    }
  }
  flush();
  return path;
}

bool starts_with(const Path& path, const Path& beginning) {
  return path.size() >= beginning.size() &&
         std::equal(beginning.begin(), beginning.end(), path.begin());
}

// What one reading or writing shares.
struct Document {
  bool writing = false;
  std::vector<SettingsFault> faults;
  std::vector<Override> overrides;
  std::vector<std::string> files;                   // in the order in which they were read
  std::map<std::string, SettingsTree> before_set;   // what stood where an override lies, by path
  std::vector<std::unique_ptr<Document>> unset;     // read as they stood before the overrides
  SettingsTree root;                                // of one of those
  std::map<std::string, std::string> unsaid_kinds;  // of mappings that name none of them, by path

  void fault(const SettingsTree& at, const Path& path, const std::string& text) {
    faults.push_back({at.place, join(path), text});
  }

  bool overridden_within(const Path& path) const {
    return std::any_of(overrides.begin(), overrides.end(), [&path](const Override& o) {
      return o.path.size() > path.size() && starts_with(o.path, path);
    });
  }

  // `*` in the path of an override stands for every key of a mapping.
  void expand_any(const SettingsTree& node, const Path& path) {
    std::vector<Override> all;
    for (Override& o : overrides) {
      if (o.path.size() <= path.size() || o.path[path.size()] != "*" ||
          !starts_with(o.path, path)) {
        all.push_back(std::move(o));
        continue;
      }
      if (node.keys.empty()) {
        faults.push_back({o.value.place, join(path), "has no keys that * could stand for"});
      }
      for (const SettingsTree::Key& key : node.keys) {
        all.push_back(o);
        all.back().path[path.size()] = key.name;
      }
    }
    overrides = std::move(all);
  }

  // Lays the overrides that concern the values directly inside `node` over them, and makes room for
  // those that go deeper.
  void apply_overrides(SettingsTree& node, const Path& path) {
    if (node.kind == Kind::kMapping) {
      expand_any(node, path);
    }
    for (Override& o : overrides) {
      if (o.path.size() <= path.size() || !starts_with(o.path, path)) {
        continue;
      }
      const std::string& key = o.path[path.size()];
      SettingsTree* child = nullptr;
      if (node.kind == Kind::kList) {
        std::size_t index = 0;
        const auto [end, error] = std::from_chars(key.data() + 1, key.data() + key.size(), index);
        if (key.front() != '[' || error != std::errc() || *end != ']' ||
            index >= node.items.size()) {
          if (!o.used) {
            faults.push_back({o.value.place, join(path),
                              "is a list of " + std::to_string(node.items.size()) +
                                  "; an item is named [0], [1], ..."});
          }
          o.used = true;
          continue;
        }
        child = &node.items[index];
      } else {
        child = node.find(key);
      }
      before_set.try_emplace(join(plus(path, key)), child == nullptr ? SettingsTree() : *child);
      const bool whole = o.path.size() == path.size() + 1;
      if (child == nullptr) {
        child = &node.add({key, o.value.place});
        child->kind = Kind::kMapping;
        child->place = o.value.place;
      }
      if (whole && !o.used) {
        std::string sha = child->kind == Kind::kScalar && child->text.starts_with(kFromElsewhere)
                              ? child->text.substr(kFromElsewhere.size(), 64)
                              : child->required_sha256;
        *child = o.value;
        child->required_sha256 = std::move(sha);
        o.used = true;
      }
    }
  }

  // Reads the file named by `at`; a mapping or kBroken comes back.
  SettingsTree load(const std::string& file, const SettingsTree& at, const Path& path) {
    SettingsTree broken;
    broken.kind = Kind::kBroken;
    const auto refuse = [&](const std::string& text) {
      fault(at, path, text);
      return broken;
    };
    std::error_code error;
    if (!std::filesystem::exists(file, error)) {
      return refuse(at.place.file == file ? "no such file" : "no such file: " + file);
    }
    if (!std::filesystem::is_regular_file(file, error)) {
      return refuse(at.place.file == file ? "not a file" : "not a file: " + file);
    }
    std::ifstream stream(file, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    if (!stream.is_open() || stream.bad()) {
      return refuse(at.place.file == file ? "cannot be read" : "cannot be read: " + file);
    }
    note_input(file, text);
    if (!at.required_sha256.empty() && sha256(text) != at.required_sha256) {
      return refuse("not the file of that run: its SHA-256 is " + sha256(text) + ", must be " +
                    at.required_sha256);
    }
    return parse_file(text, file, path);
  }

  SettingsTree parse_file(const std::string& text, const std::string& file, const Path& path) {
    files.push_back(file);
    SettingsPlace place;
    place.file = file;
    SettingsTree tree = parse_settings(text, place, faults);
    if (tree.kind == Kind::kNull) {
      tree.kind = Kind::kMapping;
      tree.place = {file, 1, 1, {}};
    }
    if (tree.kind == Kind::kScalar || tree.kind == Kind::kList) {
      fault(tree, path, "the file must hold a mapping (key: value)");
      tree.kind = Kind::kBroken;
    }
    return tree;
  }

  // What is wrong with a place that was read twice is said once.
  void take_faults_before_set() {
    for (const auto& other : unset) {
      for (const SettingsFault& fault : other->faults) {
        if (std::none_of(faults.begin(), faults.end(), [&fault](const SettingsFault& said) {
              return said.place.text() == fault.place.text() && said.path == fault.path &&
                     said.text == fault.text;
            })) {
          faults.push_back(fault);
        }
      }
      files.insert(files.end(), other->files.begin(), other->files.end());
    }
    unset.clear();
  }

  [[noreturn]] void fail() {
    const auto rank = [this](const SettingsFault& f) {
      return std::find(files.begin(), files.end(), f.place.file) - files.begin();
    };
    std::stable_sort(faults.begin(), faults.end(),
                     [&rank](const SettingsFault& a, const SettingsFault& b) {
                       return std::make_tuple(rank(a), a.place.line, a.place.column) <
                              std::make_tuple(rank(b), b.place.line, b.place.column);
                     });
    std::vector<std::string> lines;
    for (const SettingsFault& f : faults) {
      const bool said = f.path.empty() || f.path == f.place.override_path;
      lines.push_back(f.place.text() + ": " + (said ? "" : f.path + ": ") + f.text);
    }
    if (std::all_of(faults.begin(), faults.end(),
                    [](const SettingsFault& f) { return f.missing_asset; })) {
      throw IoError(joined(lines, "\n"));
    }
    throw ConfigError(lines);
  }
};

template <class Integer>
bool parse_integer(const std::string& text, Integer& value) {
  const char* begin = text.data() + (text.size() > 1 && text.front() == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

bool is_non_finite_word(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!word.empty() && (word.front() == '+' || word.front() == '-')) {
    word.erase(0, 1);
  }
  return word == ".nan" || word == ".inf" || word == "nan" || word == "inf" || word == "infinity";
}

// Empty when `text` is a finite number, else what it must be.
std::string parse_double(const std::string& text, double& value) {
  if (is_non_finite_word(text)) {
    return "must be finite";
  }
  const char* begin = text.data() + (text.size() > 1 && text.front() == '+' ? 1 : 0);
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error == std::errc::result_out_of_range && stop == end) {
    return "must be a number that a double can hold";
  }
  if (error != std::errc() || stop != end) {
    return "must be a number";
  }
  return std::isfinite(value) ? "" : "must be finite";
}

struct Between {
  double low;
  double high;

  std::string must() const {
    return "must be from " + number_text(low) + " to " + number_text(high);
  }
  std::string operator()(double value) const {
    return value >= low && value <= high ? std::string() : must();
  }
};

// What a rule on an angle in radians says of one that was written in degrees.
std::string rule_in_degrees(const Rule& rule_rad, double value_deg) {
  const std::string must = rule_rad ? rule_rad(deg_to_rad(value_deg)) : std::string();
  const auto* range = rule_rad.target<Between>();
  const auto printed_deg = [](double rad) { return std::round(1e6 * rad_to_deg(rad)) / 1e6; };
  return must.empty() || range == nullptr
             ? must
             : Between{printed_deg(range->low), printed_deg(range->high)}.must();
}

}  // namespace

class Setting::State {
 public:
  Document* document = nullptr;
  SettingsTree* tree = nullptr;
  Path path;

  void fault(const std::string& text) const { document->fault(*tree, path, text); }

  // True when there is a single value to read. Says why not, unless it was said before.
  bool readable(const std::string& must) const {
    if (document->overridden_within(path)) {
      for (Override& o : document->overrides) {
        if (o.path.size() > path.size() && starts_with(o.path, path)) {
          document->faults.push_back(
              {o.value.place, join(path), "is a single value; it has no keys inside"});
          o.used = true;
        }
      }
      return false;
    }
    if (tree->kind == Kind::kBroken) {
      return false;
    }
    if (tree->kind != Kind::kScalar) {
      fault(must + got());
      return false;
    }
    return true;
  }

  std::string got() const { return panoptes::got(*tree); }

  void write(std::string text, bool quoted) const {
    tree->kind = Kind::kScalar;
    tree->text = std::move(text);
    tree->quoted = quoted;
  }

  template <class Integer>
  void integer(Integer& value, const Rule& rule) const {
    if (document->writing) {
      write(std::to_string(value), false);
      return;
    }
    if (!readable("must be a whole number")) {
      return;
    }
    Integer read = 0;
    double as_double = 0;
    if (!tree->quoted && parse_integer(tree->text, read)) {
      const std::string must = rule ? rule(static_cast<double>(read)) : "";
      if (must.empty()) {
        value = read;
      } else {
        fault(must + got());
      }
    } else if (!tree->quoted && parse_double(tree->text, as_double).empty() &&
               as_double == std::floor(as_double) &&
               tree->text.find_first_of(".eE") == std::string::npos) {
      fault("must be a whole number from " + std::to_string(std::numeric_limits<Integer>::min()) +
            " to " + std::to_string(std::numeric_limits<Integer>::max()) + got());
    } else {
      fault("must be a whole number" + got());
    }
  }
};

class Fields::Node {
 public:
  Document* document = nullptr;
  SettingsTree* tree = nullptr;
  Path path;
  std::vector<std::string> asked;
  std::map<std::string, std::string, std::less<>> outdated;  // what is said of it, by the key

  void ask(std::string_view key) {
    if (std::find(asked.begin(), asked.end(), key) == asked.end()) {
      asked.emplace_back(key);
    }
  }
  SettingsTree* child(std::string_view key) {
    ask(key);
    return tree->find(key);
  }
  std::unique_ptr<Setting::State> state(SettingsTree& of, const std::string& key) const {
    auto out = std::make_unique<Setting::State>();
    out->document = document;
    out->tree = &of;
    out->path = plus(path, key);
    return out;
  }
};

Rule between(double low, double high) { return Between{low, high}; }

Rule at_least(double low) {
  return [low](double value) {
    return value >= low ? std::string() : "must be >= " + number_text(low);
  };
}

const Rule positive = [](double value) { return std::string(value > 0 ? "" : "must be > 0"); };
const Rule not_negative = [](double value) {
  return std::string(value >= 0 ? "" : "must be >= 0");
};

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance =
      (word.size() <= 3 ? 1 : std::max<std::size_t>(2, word.size() / 3)) + 1;
  for (const std::string& candidate : known) {
    // A forgotten unit or beginning of a longer name is the commonest slip.
    const bool unit_forgotten = candidate.starts_with(word + "_");
    const std::size_t distance = unit_forgotten ? 1 : edit_distance(word, candidate);
    if (distance < best_distance && distance < std::max(word.size(), candidate.size())) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

Setting::Setting(std::unique_ptr<State> state) : state_(std::move(state)) {}
Setting::Setting(Setting&&) noexcept = default;
Setting::~Setting() = default;

bool Setting::writing() const { return state_->document->writing; }

bool Setting::is_null() const {
  return state_->tree->kind == Kind::kNull && !state_->document->overridden_within(state_->path);
}

bool Setting::is_list() const { return state_->tree->kind == Kind::kList; }

void Setting::null() { state_->tree->kind = Kind::kNull; }

void Setting::scalar(bool& value) {
  if (writing()) {
    state_->write(value ? "true" : "false", false);
  } else if (state_->readable("must be true or false")) {
    const std::string& text = state_->tree->text;
    if (state_->tree->quoted || (text != "true" && text != "false")) {
      state_->fault("must be true or false" + state_->got());
    } else {
      value = text == "true";
    }
  }
}

void Setting::scalar(int& value, const Rule& rule) { state_->integer(value, rule); }
void Setting::scalar(std::int64_t& value, const Rule& rule) { state_->integer(value, rule); }
void Setting::scalar(std::uint64_t& value, const Rule& rule) { state_->integer(value, rule); }

void Setting::scalar(double& value, const Rule& rule) {
  if (writing()) {
    PANOPTES_CHECK(std::isfinite(value), "settings hold finite numbers");
    state_->write(number_text(value), false);
    return;
  }
  if (!state_->readable("must be a number")) {
    return;
  }
  double read = 0;
  std::string must =
      state_->tree->quoted ? "must be a number" : parse_double(state_->tree->text, read);
  if (must.empty() && rule) {
    must = rule(read);
  }
  if (must.empty()) {
    value = read;
  } else {
    state_->fault(must + state_->got());
  }
}

void Setting::scalar(std::string& value) {
  if (writing()) {
    state_->write(value, true);
  } else if (state_->readable("must be text")) {
    value = state_->tree->text;
  }
}

std::size_t Setting::begin_list() {
  SettingsTree& tree = *state_->tree;
  if (writing()) {
    tree.kind = Kind::kList;
    return 0;
  }
  if (tree.kind == Kind::kList) {
    state_->document->apply_overrides(tree, state_->path);
    return tree.items.size();
  }
  if (tree.kind != Kind::kBroken) {
    state_->fault("must be a list" + state_->got());
  }
  return 0;
}

bool Setting::begin_list_of(std::size_t count) {
  if (writing()) {
    state_->tree->kind = Kind::kList;
    return true;
  }
  if (state_->tree->kind == Kind::kBroken) {
    return false;
  }
  const std::string must = "must be a list of " + std::to_string(count) + " numbers";
  if (state_->tree->kind != Kind::kList) {
    state_->fault(must + state_->got());
    return false;
  }
  const std::size_t given = begin_list();
  if (given != count) {
    state_->fault(must + ", got " + std::to_string(given));
  }
  return given == count;
}

Setting Setting::item(std::size_t index) {
  SettingsTree& tree = *state_->tree;
  if (writing()) {
    tree.items.emplace_back();
  }
  auto state = std::make_unique<State>();
  state->document = state_->document;
  state->tree = &tree.items.at(index);
  state->path = plus(state_->path, "[" + std::to_string(index) + "]");
  return Setting(std::move(state));
}

bool Setting::is_mapping() {
  SettingsTree& tree = *state_->tree;
  if (writing()) {
    tree.kind = Kind::kMapping;
    return true;
  }
  if (tree.kind == Kind::kNull) {
    tree.kind = Kind::kMapping;  // `key:` with all its settings commented out
  }
  if (tree.kind == Kind::kMapping) {
    state_->document->apply_overrides(tree, state_->path);
    return true;
  }
  if (tree.kind != Kind::kBroken) {
    state_->fault("must be a mapping (key: value)" + state_->got());
  }
  return false;
}

std::vector<std::string> Setting::begin_mapping() {
  std::vector<std::string> keys;
  if (is_mapping()) {
    for (const SettingsTree::Key& key : state_->tree->keys) {
      keys.push_back(key.name);
    }
  }
  return keys;
}

Setting Setting::entry(const std::string& key) {
  SettingsTree& tree = *state_->tree;
  SettingsTree* child = writing() ? &tree.add({key, {}}) : tree.find(key);
  PANOPTES_CHECK(child != nullptr, "only keys that begin_mapping named are asked for");
  auto state = std::make_unique<State>();
  state->document = state_->document;
  state->tree = child;
  state->path = plus(state_->path, key);
  return Setting(std::move(state));
}

Fields Setting::fields() {
  auto node = std::make_unique<Fields::Node>();
  node->document = state_->document;
  node->tree = state_->tree;
  node->path = state_->path;
  return Fields(std::move(node));
}

Fields::Fields(std::unique_ptr<Node> node) : node_(std::move(node)) {}
Fields::Fields(Fields&&) noexcept = default;
Fields::~Fields() = default;

bool Fields::writing() const { return node_->document->writing; }

bool Fields::present(std::string_view key) const {
  return !writing() && std::as_const(*node_->tree).find(key) != nullptr;
}

std::string Fields::where(std::string_view key) const {
  const SettingsTree* child = std::as_const(*node_->tree).find(key);
  return writing() || child == nullptr ? std::string() : child->place.text();
}

std::string Fields::file() const { return writing() ? "" : node_->tree->place.file; }

std::string Fields::here() const { return writing() ? "" : node_->tree->place.text(); }

std::optional<Setting> Fields::setting(std::string_view key) {
  const std::string name(key);
  if (writing()) {
    PANOPTES_CHECK(node_->tree->find(key) == nullptr, "a bind writes each key once");
    return Setting(node_->state(node_->tree->add({name, {}}), name));
  }
  SettingsTree* child = node_->child(key);
  if (child == nullptr || child->kind == Kind::kBroken) {
    return std::nullopt;
  }
  return Setting(node_->state(*child, name));
}

void Fields::renamed(std::string_view old_key, std::string_view key) {
  node_->outdated.emplace(old_key, std::string(old_key) + " is now " + std::string(key));
}

void Fields::removed(std::string_view old_key, std::string_view why) {
  node_->outdated.emplace(old_key, why);
}

void Fields::require_present(std::string_view key) {
  if (!writing() && node_->child(key) == nullptr) {
    node_->document->fault(*node_->tree, plus(node_->path, std::string(key)),
                           "missing; it must be given");
  }
}

void Fields::angle(std::string_view stem, double& value_rad, const Rule& rule_rad) {
  const std::string in_deg = std::string(stem) + "_deg";
  const std::string in_rad = std::string(stem) + "_rad";
  if (writing()) {
    (*this)(in_rad, value_rad);
    return;
  }
  const SettingsTree* deg = node_->child(in_deg);
  const SettingsTree* rad = node_->child(in_rad);
  if (deg != nullptr && rad != nullptr) {
    node_->document->fault(*rad, plus(node_->path, in_rad),
                           "given twice; " + in_deg + " says it already");
    return;
  }
  double value_deg = 0;
  bool read = false;
  const Rule note = [&](double value) {
    std::string must = rule_in_degrees(rule_rad, value);
    read = must.empty();
    return must;
  };
  (*this)(in_deg, value_deg, note);
  if (read) {
    value_rad = deg_to_rad(value_deg);
  }
  (*this)(in_rad, value_rad, rule_rad);
}

void Fields::one_or_each(std::string_view key, Vec3& value, const Rule& rule) {
  std::optional<Setting> found = setting(key);
  if (!found) {
    return;
  }
  if (writing() || found->is_list()) {
    fields_detail::bind_setting(std::move(*found), value, rule);
    return;
  }
  const std::size_t faults_before = node_->document->faults.size();
  double one = 0;
  found->scalar(one, rule);
  if (node_->document->faults.size() == faults_before) {
    value.setConstant(one);
  }
}

void Fields::one_angle_or_each(std::string_view stem, Vec3& value_rad, const Rule& rule_rad) {
  const std::string in_deg = std::string(stem) + "_deg";
  const std::string in_rad = std::string(stem) + "_rad";
  if (writing()) {
    one_or_each(in_rad, value_rad);
    return;
  }
  const SettingsTree* deg = node_->child(in_deg);
  const SettingsTree* rad = node_->child(in_rad);
  if (deg != nullptr && rad != nullptr) {
    node_->document->fault(*rad, plus(node_->path, in_rad),
                           "given twice; " + in_deg + " says it already");
    return;
  }
  const std::size_t faults_before = node_->document->faults.size();
  Vec3 value_deg = Vec3::Zero();
  one_or_each(in_deg, value_deg, [&](double value) { return rule_in_degrees(rule_rad, value); });
  if (deg != nullptr && node_->document->faults.size() == faults_before) {
    value_rad = value_deg.unaryExpr([](double value) { return deg_to_rad(value); });
  }
  one_or_each(in_rad, value_rad, rule_rad);
}

std::optional<Setting> Fields::setting_before_set(std::string_view key) {
  const Path path = plus(node_->path, std::string(key));
  const auto stood = node_->document->before_set.find(join(path));
  if (writing() || stood == node_->document->before_set.end() ||
      stood->second.kind == Kind::kNull) {
    return std::nullopt;
  }
  Document& unset = *node_->document->unset.emplace_back(std::make_unique<Document>());
  unset.root = stood->second;
  if (unset.root.kind == Kind::kScalar) {
    const std::string file = resolve_path(unset.root.text, unset.root.place.file);
    unset.root = unset.load(file, unset.root, path);
  }
  if (unset.root.kind == Kind::kBroken) {
    return std::nullopt;
  }
  auto state = std::make_unique<Setting::State>();
  state->document = &unset;
  state->tree = &unset.root;
  state->path = path;
  return Setting(std::move(state));
}

bool Fields::sound_before_set() const { return node_->document->unset.back()->faults.empty(); }

void Setting::path(std::string& value) {
  if (writing()) {
    state_->write(value.empty() ? value : portable_path(value), true);
    return;
  }
  if (!state_->readable("must be text")) {
    return;
  }
  const SettingsTree& tree = *state_->tree;
  value = tree.text.empty() ? tree.text : resolve_path(tree.text, tree.place.file);
  std::error_code error;
  if (!value.empty() && !std::filesystem::is_regular_file(value, error)) {
    const std::string root = data_root();
    const std::string looked_for =
        tree.text.starts_with("data:")
            ? tree.text + ", looked for in " + root + "/scenes and " + root + "/assets"
            : value;
    const bool is_folder = std::filesystem::is_directory(value, error);
    state_->document->faults.push_back(
        {tree.place, join(state_->path),
         is_folder ? "is a folder, not a file: " + value : "no such file: " + looked_for,
         !is_folder && is_shipped(value)});
  }
}

std::string Setting::where() const { return writing() ? "" : state_->tree->place.text(); }

void Fields::path(std::string_view key, std::string& value) {
  if (std::optional<Setting> found = setting(key)) {
    found->path(value);
  }
}

void Fields::texts(std::string_view key, std::vector<std::string>& values,
                   std::vector<std::string>& mentions) {
  list_of(key, values, mentions, [](Setting& item, std::string& value) { item.scalar(value); });
}

void Fields::paths(std::string_view key, std::vector<std::string>& values,
                   std::vector<std::string>& mentions) {
  list_of(key, values, mentions, [](Setting& item, std::string& value) { item.path(value); });
}

void Fields::list_of(std::string_view key, std::vector<std::string>& values,
                     std::vector<std::string>& mentions,
                     const std::function<void(Setting& item, std::string& value)>& bind_item) {
  std::optional<Setting> list = setting(key);
  if (!list) {
    return;
  }
  const std::size_t count = list->begin_list();
  if (!writing()) {
    values.assign(count, {});
    mentions.assign(count, {});
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    Setting item = list->item(i);
    bind_item(item, values[i]);
    if (!writing()) {
      mentions[i] = item.where();
    }
  }
}

void Fields::paths(std::string_view key, std::map<std::string, std::string>& values,
                   std::map<std::string, std::string>& mentions) {
  std::optional<Setting> map = setting(key);
  if (!map) {
    return;
  }
  const std::vector<std::string> keys = map->begin_mapping();
  if (!writing()) {
    values.clear();
    mentions.clear();
    for (const std::string& name : keys) {
      values[name];
    }
  }
  for (auto& [name, value] : values) {
    Setting entry = map->entry(name);
    entry.path(value);
    if (!writing()) {
      mentions[name] = entry.where();
    }
  }
}

void Fields::resolve_file(std::string_view key, std::string& file) {
  if (writing()) {
    return;
  }
  SettingsTree* child = node_->child(key);
  if (child == nullptr) {
    return;
  }
  file.clear();
  if (child->kind != Kind::kScalar) {
    return;
  }
  const Path path = plus(node_->path, std::string(key));
  if (child->text.starts_with(kFromElsewhere)) {
    node_->document->fault(*child, path,
                           "a file from elsewhere; name it with --set " + join(path) + "=FILE");
    child->kind = Kind::kBroken;
    return;
  }
  const std::string name = resolve_path(child->text, child->place.file);
  *child = node_->document->load(name, *child, path);
  if (!node_->document->overridden_within(path)) {
    file = name;
  }
}

bool Fields::write_file(std::string_view key, const std::string& file) {
  if (file.empty()) {
    return false;
  }
  std::string name = portable_path(file);
  if (!name.starts_with("data:")) {
    std::ifstream stream(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream),
                           std::istreambuf_iterator<char>()};
    name = std::string(kFromElsewhere) + sha256(text) + ":" +
           std::filesystem::path(file).filename().string();
  }
  (*this)(key, name);
  return true;
}

namespace {

/// Of a mapping by its key, of a list as `[index]`.
const SettingsTree* child_of(const SettingsTree& tree, const std::string& key) {
  if (tree.kind != Kind::kList) {
    return tree.find(key);
  }
  for (std::size_t i = 0; i < tree.items.size(); ++i) {
    if (key == "[" + std::to_string(i) + "]") {
      return &tree.items[i];
    }
  }
  return nullptr;
}

}  // namespace

void Fields::require(bool holds, std::string_view key, std::string_view must) {
  if (holds || writing()) {
    return;
  }
  const SettingsTree* at = node_->tree;
  const std::vector<std::string> keys = split_path(std::string(key));
  std::size_t found = 0;
  for (; found < keys.size(); ++found) {
    const SettingsTree* child = child_of(*at, keys[found]);
    if (child == nullptr) {
      break;
    }
    at = child;
  }
  std::string text(must);
  if (found == keys.size() && at->kind == Kind::kScalar) {
    text += got(*at);
  }
  Path path = node_->path;
  path.insert(path.end(), keys.begin(), keys.end());
  node_->document->fault(*at, path, text);
}

std::size_t Fields::word_index(std::string_view key, const std::vector<std::string>& words,
                               std::size_t current) {
  std::string word = words[current];
  std::optional<Setting> found = setting(key);
  if (!found) {
    return current;
  }
  const std::size_t faults_before = node_->document->faults.size();
  found->scalar(word);
  const auto at = std::find(words.begin(), words.end(), word);
  if (at != words.end()) {
    return static_cast<std::size_t>(at - words.begin());
  }
  if (node_->document->faults.size() == faults_before) {
    const std::string near = nearest_word(word, words);
    node_->document->fault(*node_->tree->find(key), plus(node_->path, std::string(key)),
                           "must be one of " + joined(words) + got(*node_->tree->find(key)) +
                               (near.empty() ? "" : "; did you mean " + near + "?"));
  }
  return current;
}

std::size_t Fields::kind_index(std::string_view key, const std::vector<std::string>& kinds,
                               const std::vector<std::string>& shorts, std::size_t current) {
  SettingsTree* child = writing() ? nullptr : node_->child(key);
  if (child == nullptr || child->kind == Kind::kBroken) {
    return current;
  }
  const Path path = plus(node_->path, std::string(key));
  Document& document = *node_->document;
  if (child->kind == Kind::kScalar) {
    SettingsTree name = *child;
    child->kind = Kind::kMapping;
    child->add({"kind", name.place}) = std::move(name);
  }
  if (child->kind == Kind::kNull) {
    child->kind = Kind::kMapping;
  }
  if (child->kind != Kind::kMapping) {
    document.fault(*child, path, "must be one of " + joined(kinds) + got(*child));
    child->kind = Kind::kBroken;
    return current;
  }
  document.apply_overrides(*child, path);
  const SettingsTree* kind = std::as_const(*child).find("kind");
  if (kind == nullptr) {
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      for (SettingsTree::Key& inner : child->keys) {
        if (!shorts[i].empty() && inner.name == kinds[i]) {
          inner.name = shorts[i];
          return i;
        }
      }
    }
    document.unsaid_kinds[join(path)] = joined(kinds);
    return current;
  }
  const std::string& word = kind->text;
  const auto at = std::find(kinds.begin(), kinds.end(), word);
  if (kind->kind == Kind::kScalar && at != kinds.end()) {
    return static_cast<std::size_t>(at - kinds.begin());
  }
  const std::string near = nearest_word(word, kinds);
  document.fault(*kind, path,
                 "must be one of " + joined(kinds) + got(*kind) +
                     (near.empty() ? "" : "; did you mean " + near + "?"));
  child->kind = Kind::kBroken;
  return current;
}

std::optional<Fields> Fields::kind_fields(std::string_view key, const std::string& kind) {
  const std::string name(key);
  SettingsTree* child = nullptr;
  if (writing()) {
    child = &node_->tree->add({name, {}});
    child->kind = Kind::kMapping;
    SettingsTree& tag = child->add({"kind", {}});
    tag.kind = Kind::kScalar;
    tag.text = kind;
    tag.quoted = true;
  } else {
    child = node_->child(key);
    if (child == nullptr || child->kind != Kind::kMapping) {
      return std::nullopt;
    }
  }
  auto node = std::make_unique<Node>();
  node->document = node_->document;
  node->tree = child;
  node->path = plus(node_->path, name);
  node->asked.emplace_back("kind");
  return Fields(std::move(node));
}

std::optional<std::size_t> Fields::named_kind(std::string_view key,
                                              const std::vector<std::string>& kinds) {
  SettingsTree* child = node_->child(key);
  if (child == nullptr || child->kind == Kind::kBroken) {
    return std::nullopt;
  }
  const Path path = plus(node_->path, std::string(key));
  Document& document = *node_->document;
  if (child->kind == Kind::kNull && !document.overridden_within(path)) {
    return std::nullopt;
  }
  if (child->kind == Kind::kScalar) {
    SettingsTree all_defaults;
    all_defaults.kind = Kind::kMapping;
    all_defaults.place = child->place;
    const SettingsTree::Key name{child->text, child->place};
    child->kind = Kind::kMapping;
    child->add(name) = std::move(all_defaults);
  }
  if (child->kind == Kind::kNull) {
    child->kind = Kind::kMapping;
  }
  if (child->kind != Kind::kMapping) {
    document.fault(*child, path, "must be one of " + joined(kinds) + got(*child));
    return std::nullopt;
  }
  document.apply_overrides(*child, path);
  if (child->keys.size() != 1) {
    document.fault(*child, path,
                   "must name one of " + joined(kinds) + ", got " +
                       std::to_string(child->keys.size()) + " keys");
    return std::nullopt;
  }
  const SettingsTree::Key& name = child->keys.front();
  const auto at = std::find(kinds.begin(), kinds.end(), name.name);
  if (at != kinds.end()) {
    return static_cast<std::size_t>(at - kinds.begin());
  }
  SettingsTree word;
  word.kind = Kind::kScalar;
  word.text = name.name;
  word.place = name.place;
  const std::string near = nearest_word(name.name, kinds);
  document.fault(word, path,
                 "must be one of " + joined(kinds) + got(word) +
                     (near.empty() ? "" : "; did you mean " + near + "?"));
  return std::nullopt;
}

void Fields::finish() {
  if (writing()) {
    return;
  }
  for (const SettingsTree::Key& key : node_->tree->keys) {
    if (std::find(node_->asked.begin(), node_->asked.end(), key.name) == node_->asked.end()) {
      SettingsTree at;
      at.place = key.place;
      const auto kinds = node_->document->unsaid_kinds.find(join(node_->path));
      const auto outdated = node_->outdated.find(key.name);
      node_->document->fault(at, plus(node_->path, key.name),
                             outdated != node_->outdated.end()
                                 ? outdated->second
                                 : "unknown key; " + suggestion(key.name, node_->asked) +
                                       (kinds == node_->document->unsaid_kinds.end() ||
                                                !nearest_word(key.name, node_->asked).empty()
                                            ? ""
                                            : "; kind is one of " + kinds->second));
      for (Override& o : node_->document->overrides) {
        o.used = o.used || starts_with(o.path, plus(node_->path, key.name));
      }
    }
  }
}

std::vector<std::string> settings_keys(const std::string& file) {
  Document document;
  SettingsTree at;
  at.place.file = file;
  const SettingsTree tree = document.load(file, at, {});
  if (!document.faults.empty()) {
    document.fail();
  }
  std::vector<std::string> keys;
  for (const SettingsTree::Key& key : tree.keys) {
    keys.push_back(key.name);
  }
  return keys;
}

namespace fields_detail {

void read_document(const std::string& name, const std::string* text,
                   const std::vector<std::string>& overrides,
                   const std::function<void(Setting)>& bind_root) {
  Document document;
  for (const std::string& written : overrides) {
    const std::size_t equals = written.find('=');
    Override o;
    o.written = written.substr(0, equals);
    o.path = split_path(o.written);
    SettingsPlace place;
    place.override_path = o.path.empty() ? written : o.written;
    if (equals == std::string::npos || o.path.empty()) {
      document.faults.push_back(
          {place, "",
           equals != std::string::npos
               ? "names no setting before the =; it must be key.path=value"
               : "must be key.path=value, got " + (written.empty() ? "nothing" : written)});
      continue;
    }
    o.value = parse_settings(written.substr(equals + 1), place, document.faults);
    o.value.place = place;
    std::erase_if(document.overrides,
                  [&o](const Override& earlier) { return earlier.path == o.path; });
    document.overrides.push_back(std::move(o));
  }
  SettingsTree at;
  at.place.file = name;
  SettingsTree root;
  if (text != nullptr) {
    root = document.parse_file(*text, name, {});
  } else {
    root = document.load(name, at, {});
  }
  if (root.kind == Kind::kMapping) {
    auto state = std::make_unique<Setting::State>();
    state->document = &document;
    state->tree = &root;
    bind_root(Setting(std::move(state)));
  }
  document.take_faults_before_set();
  if (document.faults.empty()) {
    for (const Override& o : document.overrides) {
      if (!o.used) {
        document.faults.push_back({o.value.place, "", "unknown key"});
      }
    }
  }
  if (!document.faults.empty()) {
    document.fail();
  }
}

std::string write_document(const std::function<void(Setting)>& bind_root) {
  Document document;
  document.writing = true;
  SettingsTree root;
  auto state = std::make_unique<Setting::State>();
  state->document = &document;
  state->tree = &root;
  bind_root(Setting(std::move(state)));
  return print_settings(root);
}

}  // namespace fields_detail
}  // namespace panoptes
