#include "sync/transport/knock.h"

#include <sodium.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "sync/wire/limits.h"

namespace tandem::sync {
namespace {

constexpr std::string_view kPrefix = "tandem-knock-";
constexpr std::size_t kKnockAt = 13;  // in a credential
constexpr std::size_t kRecordHeader = 5, kHandshakeHeader = 4;
constexpr std::size_t kVersionAndRandom = 2 + 32;
constexpr std::uint8_t kHandshakeRecord = 22, kClientHello = 1;
constexpr std::size_t kProtocolsExtension = 16;

/// Reads big-endian fields; what goes beyond the end makes it fail and gives zeros.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::size_t number(std::size_t size) {
    std::size_t value = 0;
    for (const std::uint8_t byte : take(size)) value = value << 8 | byte;
    return value;
  }
  std::span<const std::uint8_t> take(std::size_t size) {
    ok_ = ok_ && size <= bytes_.size();
    if (!ok_) return {};
    const auto taken = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return taken;
  }
  /// A field that begins with its own length.
  Reader field(std::size_t lengthBytes) { return Reader(take(number(lengthBytes))); }
  bool more() const { return ok_ && !bytes_.empty(); }

 private:
  std::span<const std::uint8_t> bytes_;
  bool ok_ = true;
};

std::optional<Knock> parseProtocolName(std::span<const std::uint8_t> name) {
  Knock knock{};
  const std::string text(name.begin(), name.end());
  if (text.size() != kPrefix.size() + 2 * knock.size() || !text.starts_with(kPrefix)) return std::nullopt;
  std::size_t length = 0;
  const int bad = sodium_hex2bin(knock.data(), knock.size(), text.data() + kPrefix.size(), 2 * knock.size(),
                                 nullptr, &length, nullptr);
  if (bad != 0 || length != knock.size()) return std::nullopt;
  return knock;
}

std::optional<Knock> knockIn(std::span<const std::uint8_t> clientHello) {
  Reader hello(clientHello);
  hello.take(kVersionAndRandom);
  hello.field(1);  // session id
  hello.field(2);  // cipher suites
  hello.field(1);  // compression
  Reader extensions = hello.field(2);
  while (extensions.more()) {
    const std::size_t type = extensions.number(2);
    Reader extension = extensions.field(2);
    if (type != kProtocolsExtension) continue;
    Reader names = extension.field(2);
    while (names.more()) {
      if (const auto knock = parseProtocolName(names.take(names.number(1)))) return knock;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Knock> knockOf(const std::string& credential) {
  if (credential.empty() || credential.size() > kMaxCredentialLength) return std::nullopt;
  std::vector<std::uint8_t> bytes(credential.size());
  std::size_t length = 0;
  if (sodium_base642bin(bytes.data(), bytes.size(), credential.data(), credential.size(), nullptr, &length,
                        nullptr, sodium_base64_VARIANT_URLSAFE_NO_PADDING) != 0)
    return std::nullopt;
  Knock knock{};
  if (length < kKnockAt + knock.size()) return std::nullopt;
  std::copy_n(bytes.begin() + kKnockAt, knock.size(), knock.begin());
  return knock;
}

std::string protocolName(const Knock& knock) {
  std::array<char, 2 * std::tuple_size_v<Knock> + 1> hex{};
  sodium_bin2hex(hex.data(), hex.size(), knock.data(), knock.size());
  return std::string(kPrefix) + hex.data();
}

FirstBytes readFirstBytes(std::span<const std::uint8_t> bytes) {
  using Kind = FirstBytes::Kind;
  if (bytes.empty()) return {};
  if (bytes[0] != kHandshakeRecord) return {Kind::foreign, {}};
  if (bytes.size() < kRecordHeader + kHandshakeHeader) return {};
  Reader record(bytes.subspan(3));
  const std::size_t length = record.number(2);
  if (bytes[1] != 3 || record.number(1) != kClientHello) return {Kind::foreign, {}};
  // One that does not fit is a handshake like any other, without a knock.
  if (kRecordHeader + length > kMaxFirstBytes) return {Kind::clientHello, {}};
  if (bytes.size() < kRecordHeader + length) return {};
  const std::size_t helloLength = record.number(3);
  if (kHandshakeHeader + helloLength > length) return {Kind::clientHello, {}};
  return {Kind::clientHello, knockIn(record.take(helloLength))};
}

}  // namespace tandem::sync
