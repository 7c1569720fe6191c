// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/settings_tree.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "core/base/utf8.h"

namespace panoptes {
namespace {

// Far above any settings file; stops aliases of aliases from filling the memory.
constexpr std::size_t kMaxNodes = 200'000;

// Turns the parser's events into a tree.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const SettingsPlace& place, std::vector<SettingsFault>& faults)
      : place_(place), faults_(faults) {}

  SettingsTree take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    SettingsTree node;
    node.place = at(mark);
    finish(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchored_.find(anchor);
    if (found == anchored_.end()) {
      throw YAML::ParserException(mark, "an alias to what is not finished yet");
    }
    nodes_ += size_of(found->second);
    guard(mark);
    finish(found->second, YAML::NullAnchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    SettingsTree node;
    node.kind = SettingsTree::Kind::kScalar;
    node.place = at(mark);
    node.text = value;
    node.quoted = tag != "?" && !tag.empty();
    ++nodes_;
    guard(mark);
    finish(std::move(node), anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, anchor, SettingsTree::Kind::kList);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, anchor, SettingsTree::Kind::kMapping);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    SettingsTree node;
    YAML::anchor_t anchor = YAML::NullAnchor;
    bool has_key = false;
    SettingsTree::Key key;
  };

  SettingsPlace at(const YAML::Mark& mark) const {
    SettingsPlace place = place_;
    if (place.override_path.empty()) {
      place.line = mark.line + 1;
      place.column = mark.column + 1;
    }
    return place;
  }

  static std::size_t size_of(const SettingsTree& node) {
    std::size_t size = 1;
    for (const SettingsTree& item : node.items) {
      size += size_of(item);
    }
    return size;
  }

  void guard(const YAML::Mark& mark) const {
    if (nodes_ > kMaxNodes) {
      throw YAML::ParserException(mark, "too many values for a settings file");
    }
  }

  void open(const YAML::Mark& mark, YAML::anchor_t anchor, SettingsTree::Kind kind) {
    Open fresh;
    fresh.node.kind = kind;
    fresh.node.place = at(mark);
    fresh.anchor = anchor;
    ++nodes_;
    guard(mark);
    stack_.push_back(std::move(fresh));
  }

  void close() {
    Open done = std::move(stack_.back());
    stack_.pop_back();
    finish(std::move(done.node), done.anchor);
  }

  std::string path_of(const std::string& key) const {
    std::string path;
    for (const Open& open : stack_) {
      if (open.node.kind == SettingsTree::Kind::kList) {
        path.append("[").append(std::to_string(open.node.items.size())).append("]");
      } else if (open.has_key) {
        path.append(path.empty() ? "" : ".").append(open.key.name);
      }
    }
    return path.append(path.empty() ? "" : ".").append(key);
  }

  void finish(SettingsTree node, YAML::anchor_t anchor) {
    if (anchor != YAML::NullAnchor) {
      anchored_[anchor] = node;
    }
    if (stack_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = stack_.back();
    if (parent.node.kind == SettingsTree::Kind::kList) {
      parent.node.items.push_back(std::move(node));
    } else if (!parent.has_key) {
      if (node.kind != SettingsTree::Kind::kScalar) {
        faults_.push_back({node.place, path_of("?"), "a key must be a word"});
        node.text = "?";
      }
      parent.has_key = true;
      parent.key = {std::move(node.text), node.place};
    } else {
      parent.has_key = false;
      if (const SettingsTree* first = parent.node.find(parent.key.name)) {
        const auto index = static_cast<std::size_t>(first - parent.node.items.data());
        const SettingsPlace& place = parent.node.keys[index].place;
        faults_.push_back({parent.key.place, path_of(parent.key.name),
                           "given twice; the first is in line " + std::to_string(place.line)});
        return;
      }
      parent.node.keys.push_back(std::move(parent.key));
      parent.node.items.push_back(std::move(node));
    }
  }

  SettingsPlace place_;
  std::vector<SettingsFault>& faults_;
  std::vector<Open> stack_;
  std::map<YAML::anchor_t, SettingsTree> anchored_;
  std::size_t nodes_ = 0;
  SettingsTree root_;
};

// One line, whatever bytes the file holds.
std::string printable(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    out += (byte < 0x20 || byte == 0x7f) ? '?' : c;
  }
  return out;
}

bool is_plain(const std::string& text) {
  static const std::vector<std::string> kWords{"true", "false", "null", "yes", "no",
                                               "on",   "off",   "~",    "y",   "n"};
  if (text.empty() || !(std::isalpha(static_cast<unsigned char>(text.front())) ||
                        text.front() == '/' || text.front() == '_')) {
    return false;
  }
  std::string lower;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (!std::isalnum(byte) && std::string_view("_-./").find(c) == std::string_view::npos) {
      return false;
    }
    lower += static_cast<char>(std::tolower(byte));
  }
  return std::find(kWords.begin(), kWords.end(), lower) == kWords.end();
}

std::string quote(const std::string& text) {
  static const char* const kHex = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      out += std::string("\\x") + kHex[byte >> 4U] + kHex[byte & 15U];
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string scalar_text(const SettingsTree& node) {
  return node.quoted && !is_plain(node.text) ? quote(node.text) : node.text;
}

std::string key_text(const std::string& key) { return is_plain(key) ? key : quote(key); }

bool is_flow(const SettingsTree& node) {
  using Kind = SettingsTree::Kind;
  return node.kind == Kind::kScalar || node.kind == Kind::kNull || node.items.empty() ||
         (node.kind == Kind::kList && std::all_of(node.items.begin(), node.items.end(), is_flow));
}

std::string flow_text(const SettingsTree& node) {
  switch (node.kind) {
    case SettingsTree::Kind::kScalar:
      return scalar_text(node);
    case SettingsTree::Kind::kMapping:
      return "{}";
    case SettingsTree::Kind::kList: {
      std::string out = "[";
      for (const SettingsTree& item : node.items) {
        out += (out.size() > 1 ? ", " : "") + flow_text(item);
      }
      return out + "]";
    }
    default:
      return "null";
  }
}

void print(const SettingsTree& node, int indent, std::string& out) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool list = node.kind == SettingsTree::Kind::kList;
    const std::string head = list ? "-" : key_text(node.keys[i].name) + ":";
    const SettingsTree& item = node.items[i];
    if (is_flow(item)) {
      out += margin + head + " " + flow_text(item) + "\n";
    } else {
      out += margin + head + "\n";
      print(item, indent + 2, out);
    }
  }
}

// Text of 16 or 32 bits a letter, which begins with a mark: the parser knows it.
bool says_its_encoding(std::string_view text) {
  return text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") ||
         text.starts_with(std::string_view("\0\0\xfe\xff", 4));
}

SettingsPlace place_of(std::string_view text, std::size_t at, SettingsPlace place) {
  if (place.override_path.empty()) {
    const std::string_view before = text.substr(0, at);
    const std::size_t line = before.rfind('\n');
    place.line = 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
    place.column = static_cast<int>(at - (line == std::string_view::npos ? 0 : line + 1)) + 1;
  }
  return place;
}

}  // namespace

std::string SettingsPlace::text() const {
  if (!override_path.empty()) {
    return "--set " + override_path;
  }
  return line > 0 ? file + ":" + std::to_string(line) + ":" + std::to_string(column) : file;
}

const SettingsTree* SettingsTree::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].name == key) {
      return &items[i];
    }
  }
  return nullptr;
}

SettingsTree* SettingsTree::find(std::string_view key) {
  return const_cast<SettingsTree*>(std::as_const(*this).find(key));
}

SettingsTree& SettingsTree::add(Key key) {
  keys.push_back(std::move(key));
  return items.emplace_back();
}

SettingsTree parse_settings(const std::string& text, const SettingsPlace& place,
                            std::vector<SettingsFault>& faults) {
  if (const std::size_t bad = says_its_encoding(text) ? std::string::npos : first_not_utf8(text);
      bad != std::string::npos) {
    SettingsTree broken;
    broken.kind = SettingsTree::Kind::kBroken;
    broken.place = place_of(text, bad, place);
    faults.push_back({broken.place, "", "not UTF-8 text; save it again as UTF-8"});
    return broken;
  }
  TreeBuilder builder(place, faults);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    if (parser.HandleNextDocument(builder)) {
      SettingsTree tree = builder.take();
      TreeBuilder rest(place, faults);
      if (parser.HandleNextDocument(rest)) {
        faults.push_back({rest.take().place, "", "a second document; there must be one"});
      }
      return tree;
    }
  } catch (const YAML::Exception& error) {
    SettingsPlace where = place;
    if (where.override_path.empty() && !error.mark.is_null()) {
      where.line = error.mark.line + 1;
      where.column = error.mark.column + 1;
    }
    faults.push_back({where, "", "not valid yaml: " + printable(error.msg)});
  }
  SettingsTree broken;
  broken.place = place;
  broken.kind = faults.empty() ? SettingsTree::Kind::kNull : SettingsTree::Kind::kBroken;
  return broken;
}

std::string print_settings(const SettingsTree& tree) {
  if (is_flow(tree)) {
    return flow_text(tree) + "\n";
  }
  std::string out;
  print(tree, 0, out);
  return out;
}

}  // namespace panoptes
