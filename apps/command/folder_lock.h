// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

namespace panoptes {

/// While it lives no other lock of this folder can be had, by whichever process. It leaves nothing
/// in the folder, and nothing behind when the process is killed. Where the file system knows no
/// locks it holds nothing.
class FolderLock {
 public:
  /// `folder` is there. Empty where somebody else holds it, or has just removed it.
  static std::optional<FolderLock> take(const std::filesystem::path& folder);

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace panoptes
