#pragma once

// What a server keeps between runs: its signing key, its TLS identity, and the place of its journal.
// Directories are made 0700, files 0600.
//
// 1. One server at a time may use a directory, and one at a time its path: the lock on the file `lock` goes
//    with the directory, a name in the abstract socket space with the path, also if the directory was
//    deleted and made anew. The kernel drops both with the process.
// 2. The signing key is written last, when the journal is there: a directory with a key held a session.

#include <string>
#include <utility>

#include "assets/base/result.h"
#include "server/admission.h"
#include "server/journal/record_digest.h"
#include "sync/transport/socket_transport.h"

namespace tandem::server {

class DataDirectory {
 public:
  /// Locks the directory, and makes the files that are missing in it. Errors name the file.
  static Result<DataDirectory> open(const std::string& path);
  DataDirectory(DataDirectory&& other) noexcept;
  DataDirectory& operator=(DataDirectory&&) = delete;
  ~DataDirectory();

  /// Whether a session was kept here before.
  bool used() const { return used_; }
  const SigningKey& signingKey() const { return signingKey_; }
  const SigningKey& linkKey() const { return linkKey_; }
  /// New keys for links, and for tickets if `all`; they are on the disk when this returns. After an error the
  /// old ones stay, on the disk or here.
  Status replaceKeys(bool all);
  const std::string& path() const { return path_; }
  /// Of the TLS identity, which stays when the keys are replaced.
  Digest fingerprint() const;
  /// Writes the signing key of a new session, once its journal is there.
  Status keepSigningKey();
  const sync::TlsIdentity& identity() const { return identity_; }
  std::string journalPath() const { return path_ + "/session.db"; }
  std::string lockPath() const { return path_ + "/lock"; }

 private:
  explicit DataDirectory(std::string path) : path_(std::move(path)) {}
  Status lock();
  Status lockPathName();
  Status loadSigningKey();
  Status loadLinkKey();
  Status loadIdentity();

  std::string path_;
  int lock_ = -1, name_ = -1;  // file descriptors
  bool used_ = false;
  SigningKey signingKey_;  // of tickets
  SigningKey linkKey_;
  sync::TlsIdentity identity_;
};

}  // namespace tandem::server
