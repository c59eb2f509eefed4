#pragma once

// Makes the levels of a scene's large meshes in threads of their own, that which is furthest off on the
// screen first, and exact meshes for the GPU as they are asked for.
//
// 1. It is given each mesh with the hash of its content, and one of those that are equal.
// 2. Levels come from the cache where it has them, and go there when they are made.
// 3. What is begun goes on while other things become more urgent; only the destructor stops it, after some
//    ms of processor time.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "client/levels/level_file.h"

namespace tandem::client {

class LevelMaker {
 public:
  struct Source {
    std::uint32_t mesh = 0;         // of the scene
    assets::ContentHash content{};  // its levelContent()
  };
  struct Made {
    std::uint32_t mesh = 0;     // of the scene
    std::vector<Level> levels;  // finest first; empty: none can be made
    bool exact = false;         // the exact mesh instead, as the one level
  };

  /// Has the levels of `meshes` to make, equally urgent ones in this order. `scene` outlives this.
  /// `threads` 0: all cores but two, which are the hand's and the window's, and one at least.
  LevelMaker(const assets::Scene& scene, std::span<const Source> meshes, std::string cacheDirectory,
             unsigned threads = 0);
  ~LevelMaker();
  LevelMaker(const LevelMaker&) = delete;
  LevelMaker& operator=(const LevelMaker&) = delete;

  /// Work begins with the first call. Any thread.
  void begin();
  /// How far off a mesh is shown now, pixels. Any thread.
  void setUrgency(std::uint32_t mesh, float pixels);
  /// Asks for the exact mesh; a second time has no effect before the first is begun. Any thread.
  void askExact(std::uint32_t mesh);
  /// The next result, oldest first. Any thread.
  std::optional<Made> take();
  /// Meshes whose levels are not done.
  std::size_t left() const { return left_.load(std::memory_order_relaxed); }
  /// Meshes whose levels were made here rather than read.
  std::size_t made() const { return made_.load(std::memory_order_relaxed); }

 private:
  struct Order {
    Source source;
    bool exact = false;
  };

  void run();
  /// Waits for the most urgent thing to do; nothing once it has to stop.
  std::optional<Order> next();
  void work(const Order& order);

  const assets::Scene& scene_;
  const std::string cacheDirectory_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool begun_ = false;                      // guarded by mutex_
  std::vector<float> urgency_;              // of each mesh of the scene; guarded by mutex_
  std::vector<Source> levelsWanted_;        // guarded by mutex_
  std::vector<std::uint32_t> exactWanted_;  // guarded by mutex_
  std::deque<Made> results_;                // guarded by mutex_
  std::atomic<std::size_t> left_{0}, made_{0};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> workers_;
};

}  // namespace tandem::client
