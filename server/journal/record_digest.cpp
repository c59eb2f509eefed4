#include "server/journal/record_digest.h"

#include <sodium.h>

#include <bit>
#include <cstring>

#include "assets/base/assert.h"
#include "sync/wire/document_codec.h"

namespace tandem::server {
namespace {

void append(Bytes& bytes, const sync::PartRecord& part) {
  const auto& p = part.worldFromPart.position;
  const auto& q = part.worldFromPart.orientation;
  bytes.text("part").number(part.part).number(part.owner).number(part.epoch);
  bytes.real(p.x).real(p.y).real(p.z).real(q.w).real(q.x).real(q.y).real(q.z);
}
void append(Bytes& bytes, const SiteRecord& site) {
  bytes.text("site").number(site.info.site).number(static_cast<std::uint64_t>(site.info.role));
  bytes.text(site.info.name);
  for (const std::uint8_t colour : site.info.colour) bytes.number(colour);
  bytes.number(site.left ? 1 : 0);
}
void append(Bytes& bytes, const UsedNonce& nonce) {
  bytes.text("nonce").text(nonce.nonce).number(static_cast<std::uint64_t>(nonce.expires));
}

void append(Bytes& bytes, const DocumentRecord& change) {
  const std::vector<std::uint8_t> entry = sync::encodeEntry(change.entry);
  bytes.text("entry").text({reinterpret_cast<const char*>(entry.data()), entry.size()});
}

void append(Bytes& bytes, const SaidRecord& said) {
  const sync::SaidLine& line = said.line;
  bytes.text("said").number(line.number).number(static_cast<std::uint64_t>(line.at)).number(line.site);
  bytes.text(line.name).text(line.said.text).number(line.said.parts.size());
  for (const PartId part : line.said.parts) bytes.number(part);
}

}  // namespace

Digest digestOf(std::string_view bytes) {
  Digest digest{};
  static_assert(sizeof digest >= crypto_generichash_BYTES_MIN);
  const int bad =
      crypto_generichash(digest.data(), digest.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                         bytes.size(), nullptr, 0);
  ASSERT(bad == 0);
  return digest;
}

Digest randomDigest() {
  static const int ready = sodium_init();
  ASSERT(ready >= 0);
  Digest digest{};
  randombytes_buf(digest.data(), digest.size());
  return digest;
}

Bytes& Bytes::number(std::uint64_t value) {
  char bytes[8];
  for (int i = 0; i < 8; ++i) bytes[i] = static_cast<char>(value >> (8 * i));
  bytes_.append(bytes, sizeof bytes);
  return *this;
}
Bytes& Bytes::real(double value) { return number(std::bit_cast<std::uint64_t>(value)); }
Bytes& Bytes::text(std::string_view value) {
  number(value.size());
  bytes_.append(value);
  return *this;
}
Bytes& Bytes::digest(const Digest& value) {
  bytes_.append(value.begin(), value.end());
  return *this;
}

Digest digestOf(const JournalRecord& record, std::uint64_t sequence, const Digest& session) {
  Bytes bytes;
  bytes.digest(session).number(sequence);
  std::visit([&](const auto& r) { append(bytes, r); }, record);
  return digestOf(bytes.view());
}

Digest DigestSum::value() const {
  Digest digest{};
  std::memcpy(digest.data(), halves_.data(), digest.size());
  return digest;
}

void DigestSum::change(const Digest& digest, bool remove) {
  std::array<std::uint64_t, 2> halves{};
  std::memcpy(halves.data(), digest.data(), digest.size());
  for (std::size_t i = 0; i < halves.size(); ++i)
    halves_[i] = remove ? halves_[i] - halves[i] : halves_[i] + halves[i];
}

}  // namespace tandem::server
