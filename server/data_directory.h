#pragma once

// What a server keeps between runs: its signing key, its TLS identity, and the place of its journal. One
// server at a time may use a directory (a lock that the kernel drops with the process). Directories are made
// 0700, files 0600.

#include <string>
#include <utility>

#include "assets/base/result.h"
#include "server/admission.h"
#include "sync/transport/socket_transport.h"

namespace tandem::server {

class DataDirectory {
 public:
  /// Locks the directory, and makes the files that are missing in it. Errors name the file.
  static Result<DataDirectory> open(const std::string& path);
  DataDirectory(DataDirectory&& other) noexcept;
  DataDirectory& operator=(DataDirectory&&) = delete;
  ~DataDirectory();

  const SigningKey& signingKey() const { return signingKey_; }
  const SigningKey& linkKey() const { return linkKey_; }
  /// New keys for links, and for tickets if `all`; they are on the disk when this returns. After an error the
  /// old ones stay, on the disk or here.
  Status replaceKeys(bool all);
  const std::string& path() const { return path_; }
  const sync::TlsIdentity& identity() const { return identity_; }
  std::string journalPath() const { return path_ + "/session.db"; }

 private:
  DataDirectory(std::string path, int lock) : path_(std::move(path)), lock_(lock) {}
  Status loadSigningKey();
  Status loadLinkKey();
  Status loadIdentity();

  std::string path_;
  int lock_ = -1;          // file descriptor
  SigningKey signingKey_;  // of tickets
  SigningKey linkKey_;
  sync::TlsIdentity identity_;
};

}  // namespace tandem::server
