#include "server/data_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>

namespace tandem::server {
namespace {

constexpr std::size_t kMaxFileBytes = 64 * 1024;

Error failed(const std::string& path, int error) {
  return Error{path + ": " + std::generic_category().message(error)};
}

/// The content of a small file; nothing if there is no such file.
Result<std::optional<std::string>> readFile(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0 && errno == ENOENT) return std::optional<std::string>();
  if (file < 0) return failed(path, errno);
  std::string content(kMaxFileBytes, '\0');
  const ssize_t size = ::read(file, content.data(), content.size());
  const int error = errno;
  ::close(file);
  if (size < 0) return failed(path, error);
  content.resize(static_cast<std::size_t>(size));
  return std::optional<std::string>(std::move(content));
}

/// Writes a file with mode 0600 whole or not at all: it is synced to the disk under another name, then
/// renamed.
Status writePrivateFile(const std::string& path, const std::string& content) {
  const std::string temporary = path + ".new";
  ::unlink(temporary.c_str());
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return failed(temporary, errno);
  const bool written =
      ::write(file, content.data(), content.size()) == static_cast<ssize_t>(content.size()) &&
      ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  if (!written) return failed(temporary, error);
  if (::rename(temporary.c_str(), path.c_str()) != 0) return failed(path, errno);
  return {};
}

std::string toHex(const SigningKey& key) {
  constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : key.seed) text += {digits[byte >> 4], digits[byte & 15]};
  return text;
}

std::optional<SigningKey> keyFromHex(const std::string& text) {
  SigningKey key;
  if (text.size() < 2 * key.seed.size()) return std::nullopt;
  for (std::size_t i = 0; i < key.seed.size(); ++i) {
    const std::string digits = text.substr(2 * i, 2);
    if (digits.find_first_not_of("0123456789abcdef") != std::string::npos) return std::nullopt;
    key.seed[i] = static_cast<std::uint8_t>(std::stoi(digits, nullptr, 16));
  }
  return key;
}

/// A key's file; nothing if there is none.
Result<std::optional<SigningKey>> readKey(const std::string& path) {
  const auto text = readFile(path);
  if (!text) return text.error();
  if (!text->has_value()) return std::optional<SigningKey>();
  const auto key = keyFromHex(**text);
  if (!key) return Error{path + ": not a key of 64 hexadecimal digits"};
  return key;
}

}  // namespace

Result<DataDirectory> DataDirectory::open(const std::string& path) {
  const auto parent = std::filesystem::path(path).parent_path();
  std::error_code error;
  if (!parent.empty()) std::filesystem::create_directories(parent, error);
  if (error) return Error{parent.string() + ": " + error.message()};
  if (::mkdir(path.c_str(), 0700) != 0 && errno != EEXIST) return failed(path, errno);

  const std::string lockPath = path + "/lock";
  const int lock = ::open(lockPath.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (lock < 0) return failed(lockPath, errno);
  DataDirectory directory(path, lock);
  if (::flock(lock, LOCK_EX | LOCK_NB) != 0) return Error{path + ": in use by another tandem-server"};
  if (Status key = directory.loadSigningKey(); !key) return key.error();
  if (Status key = directory.loadLinkKey(); !key) return key.error();
  if (Status identity = directory.loadIdentity(); !identity) return identity.error();
  return directory;
}

DataDirectory::DataDirectory(DataDirectory&& other) noexcept
    : path_(std::move(other.path_)),
      lock_(std::exchange(other.lock_, -1)),
      signingKey_(other.signingKey_),
      linkKey_(other.linkKey_),
      identity_(std::move(other.identity_)) {}

DataDirectory::~DataDirectory() {
  if (lock_ >= 0) ::close(lock_);
}

Status DataDirectory::loadSigningKey() {
  const std::string path = path_ + "/signing.key";
  const auto kept = readKey(path);
  if (!kept) return kept.error();
  signingKey_ = kept->value_or(makeSigningKey());
  return kept->has_value() ? Status{} : writePrivateFile(path, toHex(signingKey_) + "\n");
}

/// Links had no key of their own once, and those that are open stay good.
Status DataDirectory::loadLinkKey() {
  const auto kept = readKey(path_ + "/links.key");
  if (!kept) return kept.error();
  linkKey_ = kept->value_or(signingKey_);
  return {};
}

Status DataDirectory::replaceKeys(bool all) {
  const SigningKey links = makeSigningKey(), tickets = makeSigningKey();
  if (Status written = writePrivateFile(path_ + "/links.key", toHex(links) + "\n"); !written) return written;
  linkKey_ = links;
  if (!all) return {};
  if (Status written = writePrivateFile(path_ + "/signing.key", toHex(tickets) + "\n"); !written)
    return written;
  signingKey_ = tickets;
  return {};
}

Status DataDirectory::loadIdentity() {
  const std::string keyPath = path_ + "/tls.key", certificatePath = path_ + "/tls.crt";
  const auto key = readFile(keyPath);
  if (!key) return key.error();
  const auto certificate = readFile(certificatePath);
  if (!certificate) return certificate.error();
  if (key->has_value() && certificate->has_value()) {
    identity_ = {**key, **certificate};
    const Result<std::string> pin = sync::pinOf(identity_);
    if (!pin) return Error{certificatePath + " with " + keyPath + ": " + pin.error().message};
    return {};
  }
  if (certificate->has_value()) return Error{keyPath + ": missing, but " + certificatePath + " is there"};
  // A key without a certificate is left over from a first start that was cut off: no site has its pin yet.
  Result<sync::TlsIdentity> made = sync::makeTlsIdentity();
  if (!made) return made.error();
  identity_ = std::move(*made);
  if (Status written = writePrivateFile(keyPath, identity_.privateKey); !written) return written;
  return writePrivateFile(certificatePath, identity_.certificate);
}

}  // namespace tandem::server
