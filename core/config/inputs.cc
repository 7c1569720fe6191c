// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/inputs.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <mutex>
#include <system_error>

#include "core/config/sha256.h"

namespace panoptes {
namespace {

constexpr std::size_t kHash_digits = 64;
constexpr std::string_view kBetween = "  ";

struct Kept {
  std::mutex mutex;
  bool keeping = false;
  std::map<std::string, std::string> files;
};
Kept& kept() {
  static Kept all;
  return all;
}

std::string full_name(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(file, ignored).string();
}

bool wanted(const std::string& name) {
  const std::lock_guard lock(kept().mutex);
  return kept().keeping && !name.empty() && !kept().files.contains(name);
}

bool keeping() {
  const std::lock_guard lock(kept().mutex);
  return kept().keeping;
}

}  // namespace

void keep_inputs() {
  const std::lock_guard lock(kept().mutex);
  kept().keeping = true;
  kept().files.clear();
}

void note_input(const std::filesystem::path& file, std::string_view bytes) {
  if (!keeping()) {
    return;
  }
  const std::string name = full_name(file);
  if (wanted(name)) {
    const std::string hash = sha256(bytes);
    const std::lock_guard lock(kept().mutex);
    kept().files.emplace(name, hash);
  }
}

void note_input(const std::filesystem::path& file) {
  if (!keeping() || !wanted(full_name(file))) {
    return;
  }
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.is_open() && !stream.bad()) {
    note_input(file, bytes);
  }
}

std::map<std::string, std::string> inputs() {
  const std::lock_guard lock(kept().mutex);
  return kept().files;
}

std::string inputs_text(const std::map<std::string, std::string>& inputs) {
  std::string text;
  for (const auto& [name, hash] : inputs) {
    text += hash;
    text += kBetween;
    text += name;
    text += '\n';
  }
  return text;
}

std::map<std::string, std::string> parse_inputs(std::string_view text) {
  std::map<std::string, std::string> all;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    constexpr std::size_t kName = kHash_digits + kBetween.size();
    if (line.size() > kName && line.substr(kHash_digits, kBetween.size()) == kBetween) {
      all.emplace(line.substr(kName), line.substr(0, kHash_digits));
    }
  }
  return all;
}

}  // namespace panoptes
