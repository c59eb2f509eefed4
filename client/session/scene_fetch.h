#pragma once

// Receives the bytes of the scene package. A transfer that breaks off is continued by a later one that starts
// with the bytes of the earlier one.
//
// 1. There are never more bytes than the Welcome announced, and none out of order.
//
// Network thread.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "sync/wire/scene_messages.h"

namespace tandem::client {

class SceneFetch {
 public:
  /// A Welcome arrived: the package has `total` bytes, and no chunk is on its way.
  void expect(std::uint64_t total);
  /// Continues after `have`, which is dropped if it is longer than the package; the returned request is to be
  /// sent unless the package is complete().
  sync::SceneRequest start(std::vector<std::byte> have);
  /// Chunks are not expected any more.
  void stop() { running_ = false; }
  /// False for a chunk that was not asked for.
  [[nodiscard]] bool handle(const sync::SceneChunk& message);

  bool complete() const { return package_.size() == total_; }
  double progress() const;  // 0..1
  const std::vector<std::byte>& package() const { return package_; }
  /// The package, which is not held here any more.
  std::vector<std::byte> take() { return std::exchange(package_, {}); }

 private:
  bool running_ = false;
  std::uint64_t total_ = 0;  // bytes
  std::vector<std::byte> package_;
};

}  // namespace tandem::client
