#include "tests/server/journal/faulty_disk.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <new>

namespace tandem::server {
namespace {

constexpr std::int64_t kSector = 512;

/// What SQLite has for a file; the real one follows in memory.
struct File {
  sqlite3_file base;
  FaultyDisk* disk;
  std::string* path;  // null: a temporary file without a name
};
sqlite3_file* realOf(sqlite3_file* file) {
  return reinterpret_cast<sqlite3_file*>(reinterpret_cast<char*>(file) + sizeof(File));
}
File& of(sqlite3_file* file) { return *reinterpret_cast<File*>(file); }
sqlite3_vfs* realVfs() { return sqlite3_vfs_find("unix"); }

int close(sqlite3_file* file) {
  delete of(file).path;
  return realOf(file)->pMethods->xClose(realOf(file));
}
int read(sqlite3_file* file, void* bytes, int size, sqlite3_int64 at) {
  const int code = realOf(file)->pMethods->xRead(realOf(file), bytes, size, at);
  if (code == SQLITE_OK) of(file).disk->onRead(bytes, size);
  return code;
}
int write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 at) {
  File& mine = of(file);
  sqlite3_file* real = realOf(file);
  int done = size;
  const int code = mine.disk->onWrite(size, done);
  for (std::int64_t sector = at / kSector; done > 0 && sector * kSector < at + done; ++sector) {
    std::string content(kSector, '\0');  // what is beyond the end reads as zeros
    if (!mine.disk->isDirty(*mine.path, sector))
      real->pMethods->xRead(real, content.data(), static_cast<int>(kSector), sector * kSector);
    mine.disk->onDirty(*mine.path, sector, content);
  }
  if (done > 0)
    if (const int written = real->pMethods->xWrite(real, bytes, done, at); written != SQLITE_OK)
      return written;
  return code;
}
int truncate(sqlite3_file* file, sqlite3_int64 size) {
  File& mine = of(file);
  if (const int code = mine.disk->onDelete(); code != SQLITE_OK) return code;
  mine.disk->forget(*mine.path, (size + kSector - 1) / kSector);
  return realOf(file)->pMethods->xTruncate(realOf(file), size);
}
/// The disk below is real and need not be synced for the test.
int sync(sqlite3_file* file, int) { return of(file).disk->onSync(*of(file).path); }
int fileSize(sqlite3_file* file, sqlite3_int64* size) {
  return realOf(file)->pMethods->xFileSize(realOf(file), size);
}
int lock(sqlite3_file* file, int level) { return realOf(file)->pMethods->xLock(realOf(file), level); }
int unlock(sqlite3_file* file, int level) { return realOf(file)->pMethods->xUnlock(realOf(file), level); }
int checkReservedLock(sqlite3_file* file, int* result) {
  return realOf(file)->pMethods->xCheckReservedLock(realOf(file), result);
}
int fileControl(sqlite3_file* file, int operation, void* argument) {
  return realOf(file)->pMethods->xFileControl(realOf(file), operation, argument);
}
int sectorSize(sqlite3_file* file) { return realOf(file)->pMethods->xSectorSize(realOf(file)); }
/// Nothing that would let SQLite leave a sync out.
int deviceCharacteristics(sqlite3_file*) { return 0; }
int shmMap(sqlite3_file* file, int page, int size, int extend, void volatile** memory) {
  return realOf(file)->pMethods->xShmMap(realOf(file), page, size, extend, memory);
}
int shmLock(sqlite3_file* file, int offset, int n, int flags) {
  return realOf(file)->pMethods->xShmLock(realOf(file), offset, n, flags);
}
void shmBarrier(sqlite3_file* file) { realOf(file)->pMethods->xShmBarrier(realOf(file)); }
int shmUnmap(sqlite3_file* file, int remove) {
  return realOf(file)->pMethods->xShmUnmap(realOf(file), remove);
}

constexpr sqlite3_io_methods kMethods{2,
                                      close,
                                      read,
                                      write,
                                      truncate,
                                      sync,
                                      fileSize,
                                      lock,
                                      unlock,
                                      checkReservedLock,
                                      fileControl,
                                      sectorSize,
                                      deviceCharacteristics,
                                      shmMap,
                                      shmLock,
                                      shmBarrier,
                                      shmUnmap,
                                      nullptr,
                                      nullptr};

int open(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* outFlags) {
  File& mine = of(file);
  mine.base.pMethods = nullptr;
  const int code = realVfs()->xOpen(realVfs(), name, realOf(file), flags, outFlags);
  if (code != SQLITE_OK) return code;
  mine.base.pMethods = &kMethods;
  mine.disk = static_cast<FaultyDisk*>(vfs->pAppData);
  mine.path = new std::string(name == nullptr ? "" : name);
  return SQLITE_OK;
}
int remove(sqlite3_vfs* vfs, const char* name, int syncDirectory) {
  auto& disk = *static_cast<FaultyDisk*>(vfs->pAppData);
  if (const int code = disk.onDelete(); code != SQLITE_OK) return code;
  disk.forget(name, 0);
  return realVfs()->xDelete(realVfs(), name, syncDirectory);
}

}  // namespace

FaultyDisk::FaultyDisk(unsigned seed) : random_(seed), vfs_(std::make_unique<sqlite3_vfs>(*realVfs())) {
  vfs_->szOsFile += static_cast<int>(sizeof(File));
  vfs_->pNext = nullptr;
  vfs_->zName = "faulty-disk";
  vfs_->pAppData = this;
  vfs_->xOpen = open;
  vfs_->xDelete = remove;
  sqlite3_vfs_register(vfs_.get(), 1);
}

FaultyDisk::~FaultyDisk() {
  sqlite3_vfs_unregister(vfs_.get());
  sqlite3_vfs_register(realVfs(), 1);
}

void FaultyDisk::failAfter(int operations, Fault fault) {
  const std::lock_guard lock(mutex_);
  left_ = operations;
  fault_ = fault;
  hasFailed_ = false;
}

bool FaultyDisk::hasFailed() const {
  const std::lock_guard lock(mutex_);
  return hasFailed_;
}

bool FaultyDisk::strikes() {
  if (fault_ == Fault::none || left_-- > 0) return false;
  left_ = 0;
  hasFailed_ = true;
  return true;
}

int FaultyDisk::onWrite(int size, int& done) {
  const std::lock_guard lock(mutex_);
  if (fault_ == Fault::rotsOnRead || fault_ == Fault::syncFails || fault_ == Fault::syncLies)
    return SQLITE_OK;
  if (!strikes()) return SQLITE_OK;
  done = fault_ == Fault::full         ? size / 2
         : fault_ == Fault::shortWrite ? static_cast<int>(random_() % static_cast<unsigned>(size))
                                       : 0;
  return fault_ == Fault::full ? SQLITE_FULL : SQLITE_IOERR_WRITE;
}

int FaultyDisk::onSync(const std::string& path) {
  const std::lock_guard lock(mutex_);
  auto& sectors = files_[path];
  const bool meant = fault_ != Fault::rotsOnRead && fault_ != Fault::full && fault_ != Fault::shortWrite;
  if (!meant || !strikes()) {
    std::erase_if(sectors, [](const auto& entry) { return !entry.second.clean; });
    return SQLITE_OK;
  }
  if (fault_ == Fault::syncLies) return SQLITE_OK;
  if (fault_ == Fault::syncFails)
    for (auto& entry : sectors) entry.second.clean = true;
  return SQLITE_IOERR_FSYNC;
}

int FaultyDisk::onDelete() {
  const std::lock_guard lock(mutex_);
  return fault_ == Fault::dead && left_ <= 0 ? SQLITE_IOERR_DELETE : SQLITE_OK;
}

void FaultyDisk::onRead(void* bytes, int size) {
  const std::lock_guard lock(mutex_);
  if (fault_ != Fault::rotsOnRead || hasFailed_ || !strikes()) return;
  const unsigned bit = random_() % (static_cast<unsigned>(size) * 8);
  static_cast<unsigned char*>(bytes)[bit / 8] ^= static_cast<unsigned char>(1u << (bit % 8));
}

bool FaultyDisk::isDirty(const std::string& path, std::int64_t sector) const {
  const std::lock_guard lock(mutex_);
  const auto file = files_.find(path);
  return file != files_.end() && file->second.contains(sector);
}

void FaultyDisk::onDirty(const std::string& path, std::int64_t sector, const std::string& content) {
  const std::lock_guard lock(mutex_);
  files_[path].try_emplace(sector, Sector{content, false}).first->second.clean = false;
}

void FaultyDisk::forget(const std::string& path, std::int64_t fromSector) {
  const std::lock_guard lock(mutex_);
  auto& sectors = files_[path];
  sectors.erase(sectors.lower_bound(fromSector), sectors.end());
}

void FaultyDisk::losePower() {
  const std::lock_guard lock(mutex_);
  for (auto& [path, sectors] : files_) {
    const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    for (const auto& [sector, content] : sectors)
      if (file >= 0 && random_() % 2 == 0)
        (void)!::pwrite(file, content.durable.data(), content.durable.size(), sector * kSector);
    if (file >= 0) ::close(file);
  }
  files_.clear();
}

}  // namespace tandem::server
