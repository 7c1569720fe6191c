// SPDX-License-Identifier: BSD-3-Clause
// The program itself, in which one thing goes wrong at a chosen instant. In the environment:
//   PANOPTES_FAULT=KIND@AFTER+COUNT   KIND is memory, bug, end (std::terminate), TERM, HUP, INT2
//                                     (twice) or INT3 (three at once); AFTER is start, or the end
//                                     of a file's name, from whose making on COUNT allocations are
//                                     counted
//   PANOPTES_FAULT_IN=COMMAND         of the processes it starts, too, only those that do this
//   PANOPTES_FAULT_MARK=FILE          made when it has happened
//   PANOPTES_DISK_BYTES=N             so much room is on the disk
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "apps/run_app.h"

namespace {

enum class Kind { kNone, kMemory, kBug, kTerm, kHangUp, kTwice, kThrice, kEnd };

// Plain values: they are used before anything else is made.
Kind g_kind = Kind::kNone;
std::string_view g_after;
long g_count = 0;
const char* g_mark = nullptr;
std::atomic<long> g_left{0};  // allocations until it happens
std::atomic<int> g_fired{0};
std::atomic<long long> g_room_bytes{-1};

void mark() {
  if (g_mark != nullptr) {
    const int made = static_cast<int>(
        ::syscall(SYS_openat, AT_FDCWD, g_mark, O_WRONLY | O_CREAT | O_CLOEXEC, 0644));
    ::syscall(SYS_close, made);
  }
}

void arm() { g_left = g_count; }

void fire() {
  mark();
  const int times = ++g_fired;
  switch (g_kind) {
    case Kind::kMemory:
      throw std::bad_alloc();
    case Kind::kBug:
      throw std::logic_error("injected");
    case Kind::kTerm:
      ::kill(::getpid(), SIGTERM);
      break;
    case Kind::kHangUp:
      ::kill(::getpid(), SIGHUP);
      break;
    case Kind::kTwice:
      ::kill(::getpid(), SIGINT);
      if (times < 2) {
        arm();
      }
      break;
    case Kind::kThrice:
      for (int i = 0; i < 3; ++i) {
        ::syscall(SYS_tgkill, ::getpid(), ::gettid(), SIGINT);
      }
      break;
    case Kind::kEnd:
      std::terminate();
    case Kind::kNone:
      break;
  }
}

void count() {
  if (g_left.load(std::memory_order_relaxed) > 0 && --g_left == 0) {
    fire();
  }
}

bool ends_with_after(std::string_view path) {
  constexpr std::string_view kPart = ".part";
  if (path.ends_with(kPart)) {
    path.remove_suffix(kPart.size());
  }
  return !g_after.empty() && path.ends_with(g_after);
}

void give_back(const char* path) {
  struct stat there {};
  if (g_room_bytes >= 0 && ::stat(path, &there) == 0 && S_ISREG(there.st_mode)) {
    g_room_bytes += there.st_size;
  }
}

bool is_file(int descriptor) {
  struct stat there {};
  return ::fstat(descriptor, &there) == 0 && S_ISREG(there.st_mode) && descriptor > STDERR_FILENO;
}

void read_orders(std::string_view command) {
  const char* in = std::getenv("PANOPTES_FAULT_IN");
  if (in != nullptr && command != in) {
    return;
  }
  g_mark = std::getenv("PANOPTES_FAULT_MARK");
  if (const char* room = std::getenv("PANOPTES_DISK_BYTES")) {
    g_room_bytes = std::atoll(room);
  }
  const char* fault = std::getenv("PANOPTES_FAULT");
  if (fault == nullptr) {
    return;
  }
  const std::string_view order(fault);
  const auto at = order.find('@');
  const auto plus = order.find('+');
  const std::string_view kind = order.substr(0, at);
  g_kind = kind == "memory" ? Kind::kMemory
           : kind == "bug"  ? Kind::kBug
           : kind == "TERM" ? Kind::kTerm
           : kind == "HUP"  ? Kind::kHangUp
           : kind == "INT2" ? Kind::kTwice
           : kind == "INT3" ? Kind::kThrice
           : kind == "end"  ? Kind::kEnd
                            : Kind::kNone;
  g_after = order.substr(at + 1, plus - at - 1);
  g_count = std::atol(order.data() + plus + 1);
  if (g_after == "start") {
    g_after = {};
    arm();
  }
}

}  // namespace

void* operator new(std::size_t size) {
  count();
  void* made = std::malloc(size > 0 ? size : 1);
  if (made == nullptr) {
    throw std::bad_alloc();
  }
  return made;
}
void operator delete(void* made) noexcept { std::free(made); }
void operator delete(void* made, std::size_t /*size*/) noexcept { std::free(made); }

extern "C" int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const int mode = (flags & O_CREAT) != 0 ? va_arg(rest, int) : 0;
  va_end(rest);
  if ((flags & O_CREAT) != 0 && g_fired == 0 && ends_with_after(path)) {
    g_after = {};
    arm();
  }
  if ((flags & O_TRUNC) != 0) {
    give_back(path);
  }
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

extern "C" ssize_t write(int descriptor, const void* bytes, size_t size) {
  if (g_room_bytes >= 0 && is_file(descriptor)) {
    if (g_room_bytes == 0 && size > 0) {
      mark();
      errno = ENOSPC;
      return -1;
    }
    size = std::min<size_t>(size, static_cast<size_t>(g_room_bytes.load()));
    g_room_bytes -= static_cast<long long>(size);
  }
  return ::syscall(SYS_write, descriptor, bytes, size);
}

// No fault may make it signal processes that are not its own: all of the user's, or a group.
extern "C" int kill(pid_t process, int signal) noexcept {
  if (process <= 0) {
    std::fprintf(stderr, "kill(%d, %d) would reach other processes\n", process, signal);
    std::_Exit(99);
  }
  return static_cast<int>(::syscall(SYS_kill, process, signal));
}

extern "C" int unlink(const char* path) noexcept {
  give_back(path);
  return static_cast<int>(::syscall(SYS_unlink, path));
}

extern "C" int unlinkat(int folder, const char* path, int flags) noexcept {
  struct stat there {};
  if (g_room_bytes >= 0 && ::fstatat(folder, path, &there, AT_SYMLINK_NOFOLLOW) == 0 &&
      S_ISREG(there.st_mode)) {
    g_room_bytes += there.st_size;
  }
  return static_cast<int>(::syscall(SYS_unlinkat, folder, path, flags));
}

extern "C" int remove(const char* path) noexcept {
  struct stat there {};
  const bool folder = ::lstat(path, &there) == 0 && S_ISDIR(there.st_mode);
  return folder ? static_cast<int>(::syscall(SYS_rmdir, path)) : unlink(path);
}

extern "C" int truncate(const char* path, off_t size) noexcept {
  struct stat there {};
  if (g_room_bytes >= 0 && ::stat(path, &there) == 0) {
    g_room_bytes += std::max<off_t>(0, there.st_size - size);
  }
  return static_cast<int>(::syscall(SYS_truncate, path, size));
}

extern "C" int rename(const char* from, const char* to) noexcept {
  give_back(to);
  return static_cast<int>(::syscall(SYS_rename, from, to));
}

int main(int argc, char** argv) {
  read_orders(argc > 1 ? argv[1] : "");
  return panoptes::run_app(argc, argv);
}
