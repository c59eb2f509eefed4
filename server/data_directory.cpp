#include "server/data_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>

#include "server/journal/durable_file.h"

namespace tandem::server {
namespace {

constexpr char kHex[] = "0123456789abcdef";

Error failed(const std::string& path, int error) {
  return Error{path + ": " + std::generic_category().message(error)};
}

std::string toHex(const SigningKey& key) {
  std::string text;
  for (const std::uint8_t byte : key.seed()) text += {kHex[byte >> 4], kHex[byte & 15]};
  return text;
}

std::optional<SigningKey> keyFromHex(const std::string& text) {
  SigningKey::Seed seed{};
  if (text.size() < 2 * seed.size()) return std::nullopt;
  for (std::size_t i = 0; i < seed.size(); ++i) {
    const std::string digits = text.substr(2 * i, 2);
    if (digits.find_first_not_of("0123456789abcdef") != std::string::npos) return std::nullopt;
    seed[i] = static_cast<std::uint8_t>(std::stoi(digits, nullptr, 16));
  }
  return SigningKey(seed);
}

/// A key's file; nothing if there is none.
Result<std::optional<SigningKey>> readKey(const std::string& path) {
  const auto text = readSmallFile(path);
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

  DataDirectory directory(path);
  if (Status locked = directory.lock(); !locked) return locked.error();
  if (Status key = directory.loadSigningKey(); !key) return key.error();
  if (Status key = directory.loadLinkKey(); !key) return key.error();
  if (Status identity = directory.loadIdentity(); !identity) return identity.error();
  return directory;
}

DataDirectory::DataDirectory(DataDirectory&& other) noexcept
    : path_(std::move(other.path_)),
      lock_(std::exchange(other.lock_, -1)),
      name_(std::exchange(other.name_, -1)),
      used_(other.used_),
      signingKey_(other.signingKey_),
      linkKey_(other.linkKey_),
      identity_(std::move(other.identity_)) {}

DataDirectory::~DataDirectory() {
  if (lock_ >= 0) ::close(lock_);
  if (name_ >= 0) ::close(name_);
}

Status DataDirectory::lock() {
  if (Status named = lockPathName(); !named) return named;
  lock_ = ::open(lockPath().c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (lock_ < 0) return failed(lockPath(), errno);
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) return Error{path_ + ": in use by another tandem-server"};
  return {};
}

Status DataDirectory::lockPathName() {
  std::error_code error;
  const auto absolute = std::filesystem::weakly_canonical(path_, error);
  if (error) return Error{path_ + ": " + error.message()};
  const Digest hash = digestOf(absolute.string());
  std::string name = "tandem-server-" + std::to_string(::geteuid()) + "-";
  for (const std::uint8_t byte : hash) name += {kHex[byte >> 4], kHex[byte & 15]};
  name_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (name_ < 0) return failed(path_, errno);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());  // the leading zero: no file
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (::bind(name_, reinterpret_cast<const sockaddr*>(&address), size) == 0) return {};
  if (errno != EADDRINUSE) return failed(path_, errno);
  return Error{path_ + ": in use by another tandem-server"};
}

Digest DataDirectory::fingerprint() const { return digestOf(identity_.certificate); }

Status DataDirectory::keepSigningKey() {
  if (used_) return {};
  if (Status kept = writeDurably(path_ + "/signing.key", toHex(signingKey_) + "\n"); !kept) return kept;
  used_ = true;
  return {};
}

Status DataDirectory::loadSigningKey() {
  const std::string path = path_ + "/signing.key";
  const auto kept = readKey(path);
  if (!kept) return kept.error();
  signingKey_ = kept->value_or(makeSigningKey());
  used_ = kept->has_value();
  return {};
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
  if (Status written = writeDurably(path_ + "/links.key", toHex(links) + "\n"); !written) return written;
  linkKey_ = links;
  if (!all) return {};
  if (Status written = writeDurably(path_ + "/signing.key", toHex(tickets) + "\n"); !written) return written;
  signingKey_ = tickets;
  return {};
}

Status DataDirectory::loadIdentity() {
  const std::string keyPath = path_ + "/tls.key", certificatePath = path_ + "/tls.crt";
  const auto key = readSmallFile(keyPath);
  if (!key) return key.error();
  const auto certificate = readSmallFile(certificatePath);
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
  if (Status written = writeDurably(keyPath, identity_.privateKey); !written) return written;
  return writeDurably(certificatePath, identity_.certificate);
}

}  // namespace tandem::server
