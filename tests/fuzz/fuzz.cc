// SPDX-License-Identifier: BSD-3-Clause
// Changes inputs of a corpus at random, from a seed, and gives them to a reader. A finding is
// anything but a clean answer: another exception, a signal, more than 10 s, more than 4 GB. The
// input of a finding is left in the working folder and the exit status is 1.
#include "tests/fuzz/fuzz.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/rng.h"

namespace {

// One bit a basic block, by its address from the program's own start: the same in every run.
constexpr std::size_t kBlocks = 1U << 16U;
std::array<std::uint8_t, kBlocks> blocks_seen{};
bool block_is_new = false;

}  // namespace

extern "C" {
extern char __executable_start;    // NOLINT: the linker's name
void __sanitizer_cov_trace_pc();   // NOLINT: the compiler's name
void __sanitizer_cov_trace_pc() {  // NOLINT
  const auto at = static_cast<std::uint64_t>(static_cast<const char*>(__builtin_return_address(0)) -
                                             &__executable_start);
  std::uint8_t& seen = blocks_seen[(at * 0x9e3779b97f4a7c15ULL) >> 48U];
  block_is_new = block_is_new || seen == 0;
  seen = 1;
}
}

namespace panoptes::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kLongest_s = 10;
constexpr rlim_t kMostMemory_bytes = rlim_t{4} << 30U;
constexpr std::size_t kMostInput_bytes = 1U << 16U;

std::string current;  // the input being read, for the signal handler
constexpr const char* kFindingFile = "fuzz-finding";

void save_current() {
  const int file = ::open(kFindingFile, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0) {
    const ssize_t written = ::write(file, current.data(), current.size());
    static_cast<void>(written);
    ::close(file);
  }
}

void on_signal(int number) {
  save_current();
  const char* const text =
      number == SIGALRM ? "finding: takes more than 10 s\n" : "finding: crashes\n";
  const ssize_t written = ::write(STDERR_FILENO, text, std::strlen(text));
  static_cast<void>(written);
  ::_exit(1);
}

/// False for a finding.
bool reads_cleanly(const std::string& input) {
  current = input;
  ::alarm(kLongest_s);
  bool clean = true;
  try {
    read_input(current);
  } catch (const ConfigError& error) {
    clean = *error.what() != '\0';
  } catch (const IoError& error) {
    clean = *error.what() != '\0';
  } catch (const std::exception& error) {
    std::fprintf(stderr, "finding: throws %s\n", error.what());
    clean = false;
  }
  ::alarm(0);
  if (!clean) {
    save_current();
  }
  return clean;
}

std::size_t pick(Rng& rng, std::size_t count) {
  return static_cast<std::size_t>(rng.uniform() * static_cast<double>(count));
}

/// A number in the text, made another.
void change_number(std::string& input, Rng& rng) {
  static constexpr std::array<const char*, 14> kNumbers{
      "0",   "-1",  "1",          "1e9", "-1e-9",  "1e308",
      "nan", "inf", "2147483648", "0.5", "1e-320", "99999999999999999999",
      "3.",  "-0"};
  const std::size_t start = pick(rng, input.size());
  const std::size_t at = input.find_first_of("0123456789", start);
  if (at == std::string::npos) {
    return;
  }
  const std::size_t end = input.find_first_not_of("0123456789.eE+-", at);
  input.replace(at, (end == std::string::npos ? input.size() : end) - at,
                kNumbers[pick(rng, kNumbers.size())]);
}

void change_once(std::string& input, const std::vector<std::string>& corpus, Rng& rng) {
  static const std::vector<std::string> known = words();
  const std::size_t at = pick(rng, input.size() + 1);
  const std::size_t length = 1 + pick(rng, pick(rng, 4) == 0 ? 200 : 8);
  switch (pick(rng, 9)) {
    case 0:
      if (at < input.size()) {
        input[at] = static_cast<char>(input[at] ^ (1 << pick(rng, 8)));
      }
      break;
    case 1:
      if (at < input.size()) {
        input[at] = static_cast<char>(pick(rng, 256));
      }
      break;
    case 2:
      input.erase(std::min(at, input.size()), length);
      break;
    case 3:
      input.insert(at, input.substr(pick(rng, input.size() + 1), length));
      break;
    case 4:
    case 5:
      input.insert(at, known[pick(rng, known.size())]);
      break;
    case 6: {  // the beginning of this, the end of another
      const std::string& other = corpus[pick(rng, corpus.size())];
      input = input.substr(0, at) + other.substr(pick(rng, other.size() + 1));
      break;
    }
    case 7: {  // another line in place of one
      const std::size_t line = std::min(input.find('\n', at), input.size());
      const std::string& other = corpus[pick(rng, corpus.size())];
      const std::size_t from =
          std::min(other.find('\n', pick(rng, other.size() + 1)), other.size());
      const std::size_t to = std::min(other.find('\n', from + 1), other.size());
      input.insert(line, other.substr(from, to - from));
      break;
    }
    default:
      change_number(input, rng);
  }
  input.resize(std::min(input.size(), kMostInput_bytes));
}

std::vector<std::string> read_corpus(const std::vector<std::string>& names) {
  std::vector<fs::path> files;
  for (const std::string& name : names) {
    if (fs::is_directory(name)) {
      for (const auto& entry : fs::directory_iterator(name)) {
        files.push_back(entry.path());
      }
    } else {
      files.emplace_back(name);
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const fs::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
      throw IoError(file.string() + ": cannot be read");
    }
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return corpus;
}

int run(double seconds, std::uint64_t seed, const std::vector<std::string>& names) {
  std::vector<std::string> corpus = read_corpus(names);
  for (const std::string& input : corpus) {
    if (!reads_cleanly(input)) {
      return 1;
    }
  }
  if (corpus.empty()) {
    corpus.emplace_back();
  }
  Rng rng = Rng(seed).fork("fuzz");
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed_s = [&start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  long inputs = 0;
  const std::size_t given = corpus.size();
  for (; elapsed_s() < seconds; ++inputs) {
    std::string input = corpus[pick(rng, corpus.size())];
    for (std::size_t changes = 1 + pick(rng, 5); changes > 0; --changes) {
      change_once(input, corpus, rng);
    }
    block_is_new = false;
    if (!reads_cleanly(input)) {
      std::fprintf(stderr, "after %ld inputs of seed %llu; the input is in %s\n", inputs,
                   static_cast<unsigned long long>(seed), kFindingFile);
      return 1;
    }
    if (block_is_new) {
      corpus.push_back(std::move(input));
    }
  }
  std::printf("%ld inputs, no finding", inputs);
  const auto blocks = std::count(blocks_seen.begin(), blocks_seen.end(), 1);
  if (blocks > 0) {
    std::printf("; %ld basic blocks, %zu inputs kept", static_cast<long>(blocks),
                corpus.size() - given);
  }
  std::printf("\n");
  return 0;
}

}  // namespace

std::vector<std::string> with_yaml(std::vector<std::string> words) {
  for (const char* const word :
       {"null", "[", "]", "{", "}", "&a ", "*a", "\"", "'", "- ", "? ", "---\n"}) {
    words.emplace_back(word);
  }
  return words;
}

std::map<std::string, std::string> files_in(std::string_view bytes) {
  constexpr std::string_view kMark = "=== ";
  constexpr std::string_view kAllowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-/";
  std::map<std::string, std::string> files;
  std::size_t at = bytes.starts_with(kMark) ? 0 : std::string_view::npos;
  while (at != std::string_view::npos) {
    const std::size_t line_end = std::min(bytes.find('\n', at), bytes.size());
    const std::string name(bytes.substr(at + kMark.size(), line_end - at - kMark.size()));
    const std::size_t next = bytes.find("\n=== ", line_end);
    const std::size_t begin = std::min(line_end + 1, bytes.size());
    const std::size_t end = next == std::string_view::npos ? bytes.size() : next + 1;
    const bool leads_elsewhere = name.empty() || name.front() == '/' || name.back() == '/' ||
                                 name.size() > 60 || name.find("..") != std::string::npos ||
                                 name.find_first_not_of(kAllowed) != std::string::npos;
    if (!leads_elsewhere) {
      files[name] = std::string(bytes.substr(begin, std::max(begin, end) - begin));
    }
    at = next == std::string_view::npos ? next : next + 1;
  }
  return files;
}

fs::path written_files(std::string_view bytes) {
  static const fs::path kFolder = [] {
    std::string name = (fs::temp_directory_path() / "panoptes-fuzz-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw std::runtime_error("no temporary folder");
    }
    std::atexit([] { fs::remove_all(kFolder); });
    return fs::path(name);
  }();
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    fs::remove_all(entry.path(), ignored);
  }
  for (const auto& [name, text] : files_in(bytes)) {
    fs::create_directories((kFolder / name).parent_path(), ignored);
    std::ofstream(kFolder / name, std::ios::binary) << text;
  }
  return kFolder;
}

}  // namespace panoptes::fuzz

int main(int argc, char** argv) {
  double seconds = 5;
  std::uint64_t seed = 1;
  std::vector<std::string> names;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--seconds" && i + 1 < argc) {
      seconds = std::atof(argv[++i]);
    } else if (word == "--seed" && i + 1 < argc) {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (word.starts_with("--")) {
      std::fprintf(stderr, "usage: %s [--seconds 5] [--seed 1] [file or folder of inputs]...\n",
                   argv[0]);
      return 2;
    } else {
      names.push_back(word);
    }
  }
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGALRM}) {
    std::signal(number, panoptes::fuzz::on_signal);
  }
#ifndef __SANITIZE_ADDRESS__  // whose shadow is larger than any machine
  const rlimit memory{panoptes::fuzz::kMostMemory_bytes, panoptes::fuzz::kMostMemory_bytes};
  ::setrlimit(RLIMIT_AS, &memory);
#endif
  try {
    return panoptes::fuzz::run(seconds, seed, names);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
