// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/text.h"

#include <algorithm>
#include <cstddef>

#include "core/base/utf8.h"

namespace panoptes {
namespace {

// The digits at the start, without leading zeros.
std::string_view number_at(std::string_view text) {
  const std::size_t end = std::min(text.find_first_not_of("0123456789"), text.size());
  const std::size_t begin = std::min(text.find_first_not_of('0'), end);
  return text.substr(begin, end - begin);
}

bool digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string all;
  for (const std::string& word : words) {
    if (&word != &words.front()) {
      all += between;
    }
    all += word;
  }
  return all;
}

std::string counted(std::size_t count, std::string_view thing) {
  return std::to_string(count) + " " + std::string(thing) + (count == 1 ? "" : "s");
}

std::string in_quotes(const std::string& text) {
  std::string all = "\"";
  for (const char c : text) {
    all += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  }
  return all + "\"";
}

std::string xml_text(std::string_view text) {
  std::string all;
  for (const char c : as_utf8(text)) {
    switch (c) {
      case '&':
        all += "&amp;";
        break;
      case '<':
        all += "&lt;";
        break;
      case '>':
        all += "&gt;";
        break;
      case '"':
        all += "&quot;";
        break;
      default:
        all += static_cast<unsigned char>(c) < ' ' && c != '\n' ? ' ' : c;
    }
  }
  return all;
}

bool natural_less(std::string_view a, std::string_view b) {
  std::size_t in_a = 0;
  std::size_t in_b = 0;
  while (in_a < a.size() && in_b < b.size()) {
    if (digit(a[in_a]) && digit(b[in_b])) {
      const std::string_view number_a = number_at(a.substr(in_a));
      const std::string_view number_b = number_at(b.substr(in_b));
      if (number_a.size() != number_b.size()) {
        return number_a.size() < number_b.size();
      }
      if (number_a != number_b) {
        return number_a < number_b;
      }
      in_a = std::min(a.find_first_not_of("0123456789", in_a), a.size());
      in_b = std::min(b.find_first_not_of("0123456789", in_b), b.size());
    } else if (a[in_a] != b[in_b]) {
      return a[in_a] < b[in_b];
    } else {
      ++in_a;
      ++in_b;
    }
  }
  const std::size_t left_a = a.size() - in_a;
  const std::size_t left_b = b.size() - in_b;
  return left_a != left_b ? left_a < left_b : a < b;
}

}  // namespace panoptes
