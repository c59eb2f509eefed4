#pragma once

// A disk with faults below SQLite, as its default VFS while an object of this class lives. It passes all on
// to the real one, and remembers what is durable of every sector of 512 bytes that was not synced.
// Locks and the shared memory of the write-ahead log are the real ones. One at a time.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <string>

struct sqlite3_vfs;

namespace tandem::server {

class FaultyDisk {
 public:
  enum class Fault : std::uint8_t {
    none,
    ioError,     // writes and syncs fail, and change nothing
    full,        // half of a write is done, then the disk is full
    shortWrite,  // some of a write is done, then it fails
    syncFails,   // and what was to be synced counts as clean afterwards, as Linux has it
    syncLies,    // says that it is done, and does nothing
    rotsOnRead,  // one bit of one read is another
    dead,        // as seen by a process that was killed: nothing reaches the disk any more
  };

  explicit FaultyDisk(unsigned seed);
  ~FaultyDisk();
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;

  /// From the write, sync or (for rotsOnRead) read after so many more on.
  void failAfter(int operations, Fault fault);
  void heal() { failAfter(0, Fault::none); }
  /// Whether a fault has met an operation since failAfter().
  bool hasFailed() const;
  /// Every sector that was not synced holds what was written, or what was durable. No file may be open.
  void losePower();

  /// Called by the VFS. `done` of a write: how many bytes are to be written.
  int onWrite(int size, int& done);
  int onSync(const std::string& path);
  int onDelete();
  void onRead(void* bytes, int size);
  /// Keeps what is durable of a sector before its first write; `content` reads it.
  void onDirty(const std::string& path, std::int64_t sector, const std::string& content);
  bool isDirty(const std::string& path, std::int64_t sector) const;
  void forget(const std::string& path, std::int64_t fromSector);

 private:
  struct Sector {
    std::string durable;
    bool clean = false;  // counts as synced, and is not
  };
  bool strikes();

  mutable std::mutex mutex_;
  std::mt19937 random_;
  std::unique_ptr<sqlite3_vfs> vfs_;
  std::map<std::string, std::map<std::int64_t, Sector>> files_;
  Fault fault_ = Fault::none;
  int left_ = 0;
  bool hasFailed_ = false;
};

}  // namespace tandem::server
