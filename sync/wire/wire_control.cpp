// Control messages: byte 0 is the kind, then the fields of the structs in their order, little-endian.
//
// One list of fields serves both directions: fields(archive, message) is run with a Writer or with a Reader,
// so what is written and what is read cannot drift apart.

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstring>
#include <type_traits>

#include "assets/base/printable.h"
#include "assets/document/entry_check.h"
#include "sync/wire/document_codec.h"
#include "sync/wire/voice_url.h"
#include "sync/wire/wire.h"

namespace tandem::sync {
namespace {

constexpr double kMaxCoordinate = 1e9;  // m

bool isCredential(const std::string& text) {
  for (const char c : text) {
    if (c <= 0x20 || c >= 0x7f) return false;
  }
  return true;
}

class Writer {
 public:
  std::vector<std::byte> bytes;

  template <std::unsigned_integral T>
  void number(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xffu));
  }
  void flag(bool value) { number<std::uint8_t>(value ? 1 : 0); }
  void time(Micros value) { number(static_cast<std::uint64_t>(value)); }
  void unixTime(std::int64_t value) { number(static_cast<std::uint64_t>(value)); }
  void real(double value) { number(std::bit_cast<std::uint64_t>(value)); }
  void share(double value) { real(value); }
  void length(double value) { real(value); }
  void part(PartId value) { number(value); }
  template <typename E>
  void enumeration(E value, E /*last*/) {
    number(static_cast<std::uint8_t>(value));
  }
  void text(const std::string& value, std::size_t limit) { string(printable(value, limit)); }
  void voiceUrl(const std::string& value) {
    ASSERT(value.empty() || isVoiceUrl(value));
    string(value);
  }
  void credential(const std::string& value) { string(value.substr(0, kMaxCredentialLength)); }
  template <std::size_t N>
  void raw(const std::array<std::uint8_t, N>& value) {
    for (const std::uint8_t byte : value) number(byte);
  }
  void blob(const std::vector<std::uint8_t>& value) {
    number(static_cast<std::uint32_t>(value.size()));
    for (const std::uint8_t byte : value) number(byte);
  }
  void body(const document::Body& value) { sized(encodeBody(value)); }
  void entry(const document::Entry& value) { sized(encodeEntry(value)); }
  /// `count` more elements follow.
  template <typename T>
  void count(const std::vector<T>& values, std::size_t limit, std::size_t /*smallest*/) {
    ASSERT(values.size() <= limit);
    number(static_cast<std::uint16_t>(values.size()));
  }
  void vector(const glm::dvec3& value) {
    for (int i = 0; i < 3; ++i) real(value[i]);
  }
  void pose(const Pose& value) {
    vector(value.position);
    const glm::dquat& q = value.orientation;
    for (const double x : {q.w, q.x, q.y, q.z}) real(x);
  }

 private:
  void sized(const std::vector<std::uint8_t>& value) {
    number(static_cast<std::uint16_t>(value.size()));
    for (const std::uint8_t byte : value) number(byte);
  }
  void string(const std::string& value) {
    number(static_cast<std::uint16_t>(value.size()));
    for (const char c : value) bytes.push_back(static_cast<std::byte>(c));
  }
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  const char* problem() const { return problem_; }
  bool ok() const { return problem_ == nullptr; }
  std::size_t remaining() const { return bytes_.size() - position_; }
  void fail(const char* problem) {
    if (problem_ == nullptr) problem_ = problem;
  }

  template <std::unsigned_integral T>
  void number(T& value) {
    value = 0;
    if (!need(sizeof(T))) return;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      value = static_cast<T>(value | static_cast<T>(std::to_integer<T>(bytes_[position_++])) << (8 * i));
    }
  }
  void flag(bool& value) {
    std::uint8_t byte = 0;
    number(byte);
    if (byte > 1) fail("a flag is neither 0 nor 1");
    value = byte == 1;
  }
  void time(Micros& value) {
    std::uint64_t raw = 0;
    number(raw);
    value = static_cast<Micros>(raw);
    if (value > kMaxMicros || value < -kMaxMicros) {
      value = 0;
      fail("a time is out of range");
    }
  }
  void unixTime(std::int64_t& value) {
    std::uint64_t raw = 0;
    number(raw);
    value = static_cast<std::int64_t>(raw);
    if (value >= 0 && value <= kMaxUnixTime) return;
    value = 0;
    fail("a Unix time is out of range");
  }
  void real(double& value) {
    std::uint64_t raw = 0;
    number(raw);
    value = std::bit_cast<double>(raw);
  }
  void share(double& value) {
    real(value);
    if (value >= 0.0 && value <= 1.0) return;
    value = 0.0;
    fail("a share is not 0 to 1");
  }
  void length(double& value) {
    real(value);
    if (value >= 0.0 && value <= kMaxCoordinate) return;
    value = 0.0;
    fail("a length is negative or out of range");
  }
  void part(PartId& value) {
    number(value);
    if (value >= kMaxParts && value != kNoPart) fail("a part id is out of range");
  }
  template <typename E>
  void enumeration(E& value, E last) {
    std::uint8_t byte = 0;
    number(byte);
    if (byte > static_cast<std::uint8_t>(last)) {
      byte = 0;
      fail("an enumeration is out of range");
    }
    value = static_cast<E>(byte);
  }
  void text(std::string& value, std::size_t limit) {
    string(value, limit);
    if (!isPrintable(value)) fail("text is not printable UTF-8");
  }
  void voiceUrl(std::string& value) {
    string(value, kMaxVoiceUrl);
    if (!value.empty() && !isVoiceUrl(value)) fail("a voice URL is not one");
  }
  void credential(std::string& value) {
    string(value, kMaxCredentialLength);
    if (!isCredential(value)) fail("a credential is not printable ASCII");
  }
  template <std::size_t N>
  void raw(std::array<std::uint8_t, N>& value) {
    for (std::uint8_t& byte : value) number(byte);
  }
  void blob(std::vector<std::uint8_t>& value) {
    std::uint32_t size = 0;
    number(size);
    if (size == 0 || size > kMaxChunkBytes) fail("a chunk is empty or too long");
    if (!ok() || !need(size)) return;
    value.resize(size);
    std::memcpy(value.data(), bytes_.data() + position_, size);
    position_ += size;
  }
  void body(document::Body& value) {
    if (Result<document::Body> body = decodeBody(sized()))
      value = std::move(*body);
    else
      fail("the body of an entry is malformed");
  }
  void entry(document::Entry& value) {
    if (Result<document::Entry> entry = decodeEntry(sized()))
      value = std::move(*entry);
    else
      fail("an entry is malformed");
  }
  template <typename T>
  void count(std::vector<T>& values, std::size_t limit, std::size_t smallest) {
    std::uint16_t size = 0;
    number(size);
    if (size > limit) fail("a list is too long");
    // A count is trusted only as far as the bytes for it are there.
    if (!ok() || !need(size * smallest)) return;
    values.resize(size);
  }
  void vector(glm::dvec3& value) {
    for (int i = 0; i < 3; ++i) real(value[i]);
    const glm::dvec3 size = glm::abs(value);
    const bool near = size.x <= kMaxCoordinate && size.y <= kMaxCoordinate && size.z <= kMaxCoordinate;
    if (!near) fail("a coordinate is not finite or too large");
  }
  void pose(Pose& value) {
    vector(value.position);
    glm::dquat& q = value.orientation;
    for (double* x : {&q.w, &q.x, &q.y, &q.z}) real(*x);
    if (!isValid(value)) fail("a pose is not finite or its quaternion not a unit one");
  }

 private:
  bool need(std::size_t count) {
    if (count > remaining()) {
      fail("the message is cut off");
      position_ = bytes_.size();
      return false;
    }
    return ok();
  }
  /// The bytes behind a length; none after a failure.
  std::vector<std::uint8_t> sized() {
    std::uint16_t size = 0;
    number(size);
    std::vector<std::uint8_t> bytes;
    if (!ok() || !need(size)) return bytes;
    bytes.resize(size);
    for (std::uint8_t& byte : bytes) byte = std::to_integer<std::uint8_t>(bytes_[position_++]);
    return bytes;
  }
  void string(std::string& value, std::size_t limit) {
    value.clear();
    std::uint16_t size = 0;
    number(size);
    if (size > limit) fail("text is too long");
    if (!ok() || !need(size)) return;
    for (std::size_t i = 0; i < size; ++i) value.push_back(std::to_integer<char>(bytes_[position_++]));
  }

  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
  const char* problem_ = nullptr;
};

template <typename M, typename T>
concept Is = std::same_as<std::remove_const_t<M>, T>;

void fields(auto& a, Is<SiteInfo> auto& m) {
  a.number(m.site);
  a.enumeration(m.role, Role::instructor);
  a.text(m.name, kMaxNameLength);
  a.raw(m.colour);
  a.flag(m.connected);
}
constexpr std::size_t kSmallestSiteInfo = 2 + 1 + 2 + 3 + 1;

void fields(auto& a, Is<PartRecord> auto& m) {
  a.part(m.part);
  a.number(m.owner);
  a.number(m.epoch);
  a.pose(m.worldFromPart);
}
constexpr std::size_t kPartRecordBytes = 2 + 2 + 4 + 7 * 8;

void fields(auto& a, Is<CoHolderRecord> auto& m) {
  a.part(m.part);
  a.number(m.epoch);
  a.number(m.version);
  a.count(m.sites, kMaxCoHolders, sizeof(SiteId));
  for (auto& site : m.sites) a.number(site);
}

template <typename A>
void fields(A& a, Is<Hello> auto& m) {
  a.number(m.protocolVersion);
  if (m.protocolVersion != kProtocolVersion) return;
  a.flag(m.resume);
  a.credential(m.credential);
  a.text(m.name, kMaxNameLength);
  a.raw(m.colour);
}
void fields(auto& a, Is<SceneRequest> auto& m) { a.number(m.offset); }
void fields(auto&, Is<Ready> auto&) {}
void fields(auto& a, Is<Grab> auto& m) {
  a.number(m.request);
  a.part(m.part);
}
/// Release and Reclaim have the same fields.
void holding(auto& a, auto& m) {
  a.number(m.request);
  a.part(m.part);
  a.number(m.epoch);
  a.pose(m.worldFromPart);
}
void fields(auto& a, Is<Release> auto& m) { holding(a, m); }
void fields(auto& a, Is<Reclaim> auto& m) { holding(a, m); }
void fields(auto& a, Is<Revoke> auto& m) {
  a.number(m.request);
  a.part(m.part);
}
void fields(auto& a, Is<ResetParts> auto& m) { a.number(m.request); }
void fields(auto&, Is<Goodbye> auto&) {}

void fields(auto& a, Is<Welcome> auto& m) {
  a.number(m.site);
  a.enumeration(m.role, Role::instructor);
  a.credential(m.resumeTicket);
  a.raw(m.sceneHash);
  a.number(m.sceneBytes);
  a.time(m.sessionTime);
  a.time(m.lease);
  a.voiceUrl(m.voiceUrl);
  a.count(m.sites, kMaxSites, kSmallestSiteInfo);
  for (auto& site : m.sites) fields(a, site);
  a.count(m.parts, kMaxParts, kPartRecordBytes);
  for (auto& part : m.parts) fields(a, part);
}
void fields(auto& a, Is<Refused> auto& m) {
  a.enumeration(m.refusal, Refusal::removed);
  a.text(m.reason, kMaxTextLength);
}
void fields(auto& a, Is<SceneChunk> auto& m) {
  a.number(m.offset);
  a.blob(m.bytes);
}
void fields(auto& a, Is<SiteChanged> auto& m) { fields(a, m.site); }
void fields(auto& a, Is<SiteLeft> auto& m) { a.number(m.site); }
/// GrabReply and ReleaseReply have the same fields.
void reply(auto& a, auto& m) {
  a.number(m.request);
  a.enumeration(m.denial, Denial::crowded);
  fields(a, m.part);
}
void fields(auto& a, Is<GrabReply> auto& m) { reply(a, m); }
void fields(auto& a, Is<ReleaseReply> auto& m) { reply(a, m); }
void fields(auto& a, Is<CommandReply> auto& m) {
  a.number(m.request);
  a.flag(m.done);
  a.text(m.reason, kMaxTextLength);
}
void fields(auto& a, Is<OwnershipChanged> auto& m) { fields(a, m.part); }
void fields(auto& a, Is<Engage> auto& m) {
  a.number(m.request);
  a.part(m.part);
}
void fields(auto& a, Is<Disengage> auto& m) {
  a.number(m.request);
  a.part(m.part);
}
void fields(auto& a, Is<EngageReply> auto& m) {
  a.number(m.request);
  a.enumeration(m.denial, Denial::crowded);
  fields(a, m.coHolders);
}
void fields(auto& a, Is<MembersChanged> auto& m) { fields(a, m.coHolders); }
void fields(auto& a, Is<NewTicket> auto& m) { a.credential(m.resumeTicket); }
void fields(auto& a, Is<SiteReport> auto& m) {
  a.number(m.ticks);
  a.number(m.missed);
  a.number(m.forceLimited);
  a.number(m.tick50);
  a.number(m.tick99);
  a.number(m.tickMax);
  a.number(m.roundTrip);
}

template <typename A>
void fields(A& a, Is<Unassigned> auto&) {
  if constexpr (requires { a.fail(""); }) a.fail("no message has this kind");
}
void fields(auto& a, Is<PutEntry> auto& m) {
  a.number(m.request);
  a.number(m.change.id);
  a.number(m.change.base);
  a.body(m.change.body);
}
static_assert(1 + 4 + 8 + 8 + 2 + document::kMaxBodyBytes <= kMaxRequestBytes);
void fields(auto& a, Is<PutReply> auto& m) {
  a.number(m.request);
  a.enumeration(m.refusal, document::Refusal::notNow);
  a.text(m.reason, kMaxTextLength);
  a.number(m.entry);
  a.number(m.revision);
}
void fields(auto& a, Is<DocumentChanged> auto& m) { a.entry(m.entry); }
void fields(auto& a, Is<DocumentRequest> auto& m) { a.number(m.known); }
void fields(auto& a, Is<DocumentChunk> auto& m) {
  a.flag(m.first);
  a.flag(m.last);
  a.number(m.revision);
  a.count(m.entries, kMaxChunkEntries, 2 + kMinEntryBytes);
  for (auto& entry : m.entries) a.entry(entry);
}
void fields(auto& a, Is<Presentation> auto& m) {
  a.number(m.site);
  a.enumeration(m.shares, Shares::view);
  a.count(m.sections, document::kMaxSections, 2 * 3 * 8);
  for (auto& plane : m.sections) {
    a.vector(plane.point);
    a.vector(plane.normal);
  }
  a.part(m.selected);
  a.count(m.hidden, kMaxParts / 8, 1);
  for (auto& byte : m.hidden) a.number(byte);
  a.count(m.transparent, kMaxParts / 8, 1);
  for (auto& byte : m.transparent) a.number(byte);
  a.share(m.style.explode);
  a.count(m.style.apart, document::kMaxApart, sizeof(PartId));
  for (auto& part : m.style.apart) a.part(part);
  a.enumeration(m.style.colouring, document::PartColouring::byOwner);
  a.flag(m.style.ghosts);
  a.part(m.inspection.a);
  a.part(m.inspection.b);
  a.enumeration(m.inspection.mark, ClashMark::clearance);
  a.length(m.inspection.amount);
  a.flag(m.inspection.moved);
  a.vector(m.inspection.onA);
  a.vector(m.inspection.onB);
  a.flag(m.inspection.measuring);
  a.count(m.inspection.marks, kMaxMarks, sizeof(PartId) + 3 * 8);
  for (auto& mark : m.inspection.marks) {
    a.part(mark.part);
    a.vector(mark.point);
  }
  a.part(m.pointedAt);
  a.vector(m.place);
}
static_assert(1 + 2 + 1 + 2 + document::kMaxSections * 48 + 2 + 2 * (2 + kMaxParts / 8) + 8 + 2 +
                  document::kMaxApart * sizeof(PartId) + 2 + 2 + 24 + (2 + 2 + 1 + 8 + 1 + 48 + 1 + 2) +
                  kMaxMarks * 26 <=
              kMaxRequestBytes);
void fields(auto& a, Is<Say> auto& m) {
  a.text(m.text, kMaxSayLength);
  a.count(m.parts, kMaxSaidParts, sizeof(PartId));
  for (auto& part : m.parts) a.part(part);
}

void fields(auto& a, Is<Doubt> auto& m) {
  a.number(m.site);
  a.number(m.about);
  a.flag(m.holds);
}

void fields(auto& a, Is<SaidLine> auto& m) {
  a.number(m.number);
  a.unixTime(m.at);
  a.number(m.site);
  a.text(m.name, kMaxNameLength);
  fields(a, m.said);
}
constexpr std::size_t kSmallestSaidLine = 8 + 8 + 2 + 2 + 2 + 2;
constexpr std::size_t kLargestSaidLine =
    kSmallestSaidLine + kMaxNameLength + kMaxSayLength + kMaxSaidParts * sizeof(PartId);
void fields(auto& a, Is<Said> auto& m) {
  a.flag(m.earlier);
  a.count(m.lines, kMaxSaidLines, kSmallestSaidLine);
  for (auto& line : m.lines) fields(a, line);
}
static_assert(1 + 1 + 2 + kMaxSaidLines * kLargestSaidLine <= kMaxControlBytes);

constexpr std::size_t kKinds = std::variant_size_v<ControlMessage>;
static_assert(kKinds == 35, "sync/WIRE.md numbers the kinds by their place in ControlMessage, from 1");

using DecodeFunction = ControlMessage (*)(Reader&);
template <std::size_t... I>
constexpr std::array<DecodeFunction, kKinds> decodeTable(std::index_sequence<I...>) {
  return {+[](Reader& reader) {
    ControlMessage message(std::in_place_index<I>);
    fields(reader, std::get<I>(message));
    return message;
  }...};
}

}  // namespace

std::vector<std::byte> encodeControl(const ControlMessage& message) {
  Writer writer;
  if (const auto* chunk = std::get_if<SceneChunk>(&message)) {
    ASSERT(!chunk->bytes.empty() && chunk->bytes.size() <= kMaxChunkBytes);
    writer.bytes.reserve(chunk->bytes.size() + 16);
  }
  writer.number(static_cast<std::uint8_t>(message.index() + 1));
  std::visit([&](const auto& m) { fields(writer, m); }, message);
  return std::move(writer.bytes);
}

Result<ControlMessage> decodeControl(std::span<const std::byte> bytes) {
  if (bytes.empty()) return Error{"control message: empty"};
  if (bytes.size() > kMaxControlBytes) return Error{"control message: too long"};
  const auto kind = std::to_integer<std::size_t>(bytes[0]);
  if (kind < 1 || kind > kKinds) return Error{"control message: unknown kind " + std::to_string(kind)};
  static constexpr auto kDecode = decodeTable(std::make_index_sequence<kKinds>{});
  Reader reader(bytes.subspan(1));
  ControlMessage message = kDecode[kind - 1](reader);
  if (const auto* hello = std::get_if<Hello>(&message);
      hello != nullptr && reader.ok() && hello->protocolVersion != kProtocolVersion) {
    return message;
  }
  if (reader.ok() && reader.remaining() > 0) reader.fail("bytes are left over");
  if (!reader.ok()) {
    return Error{"control message of kind " + std::to_string(kind) + ": " + reader.problem()};
  }
  return message;
}

}  // namespace tandem::sync
