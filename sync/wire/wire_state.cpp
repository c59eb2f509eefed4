// State datagrams: bit-packed and quantised, each decodable alone. sync/WIRE.md has the table of bits.

#include <algorithm>
#include <cmath>
#include <optional>

#include "sync/wire/bits.h"
#include "sync/wire/state_code.h"
#include "sync/wire/wire.h"

namespace tandem::sync {
namespace {

constexpr std::uint8_t kVersion = kStateVersion;
using Kind = StateKind;

constexpr int kLinkTimeBits = 24, kWaveBits = 24;
constexpr int kUpdateHeaderBits = 8 + 8 + 16 + 32 + kTimeBits + kPresenceBits + 8;

void encodeUpdate(const StateUpdate& update, const WireFrame& frame, std::vector<std::byte>& bytes,
                  EncodeLosses& losses) {
  const bool twoHands = update.presence.worldFromSecondTool.has_value();
  int bits = kUpdateHeaderBits + (twoHands ? kPoseBits : 0), count = 0, ignored = 0;
  std::size_t end = 0;  // the parts in front of this one fit
  for (; end < update.parts.size() && count < static_cast<int>(kMaxStateParts); ++end) {
    if (!sendable(update.parts[end])) continue;
    const int more = wholeBits(toCode(update.parts[end], frame, ignored));
    if (bits + more > static_cast<int>(kMaxStateBytes) * 8) break;
    bits += more;
    ++count;
  }
  losses.leftOut += static_cast<int>(update.parts.size()) - count;

  bytes.resize(static_cast<std::size_t>((bits + 7) / 8));
  BitWriter writer(bytes);
  writer.put(kVersion, 8);
  writer.put(static_cast<std::uint8_t>(twoHands ? Kind::updateOfTwoHands : Kind::update), 8);
  writer.put(update.site, 16);
  writer.put(update.sequence, 32);
  putTime(writer, update.time);
  putPresence(writer, update.presence, true, frame, losses.clamped);
  if (twoHands) putSecondTool(writer, update.presence, frame, losses.clamped);
  writer.put(static_cast<std::uint64_t>(count), 8);
  for (std::size_t i = 0; i < end; ++i) {
    if (sendable(update.parts[i])) putWhole(writer, toCode(update.parts[i], frame, losses.clamped));
  }
  ASSERT(!writer.overflowed() && writer.bitCount() == static_cast<std::size_t>(bits));
}

/// The number of steps, 1..255.
std::uint64_t inSteps(double value, double quantum) {
  return static_cast<std::uint64_t>(std::clamp(std::round(value / quantum), 1.0, 255.0));
}

double getSteps(BitReader& reader, double quantum) {
  const std::uint64_t steps = reader.get(8);
  if (steps == 0) reader.fail();
  return quantum * static_cast<double>(steps);
}

void encodeLink(const LinkUpdate& link, const WireFrame& frame, std::vector<std::byte>& bytes, int& clamped) {
  constexpr std::size_t kBits =
      8 + 8 + 16 + kPartBits + 32 + 16 + kLinkTimeBits + 6 * kWaveBits + 32 + 8 + 1 + 1 + 2 + 1;
  const bool posed = link.posed && isValid(link.worldFromDrawn);
  bytes.resize((kBits + (posed ? kPoseBits + kTwistBits + 3 * 8 : 0) + 7) / 8);
  BitWriter writer(bytes);
  writer.put(kVersion, 8);
  writer.put(static_cast<std::uint8_t>(Kind::link), 8);
  writer.put(link.peer, 16);
  writer.put(link.part, kPartBits);
  writer.put(link.epoch, 32);
  writer.put(link.sequence, 16);
  writer.put(link.time, kLinkTimeBits);
  for (const std::uint32_t x : link.wave) writer.put(x, kWaveBits);
  writer.put(link.energy, 32);
  writer.put(link.fade, 8);
  writer.put(link.on ? 1 : 0, 1);
  writer.put(link.asks ? 1 : 0, 1);
  writer.put(link.regime, 2);
  writer.put(posed ? 1 : 0, 1);
  if (posed) {
    put(writer, toCode(link.worldFromDrawn, frame, clamped));
    put(writer, toCode(link.twist, clamped));
    writer.put(inSteps(link.terms.impedance, kImpedanceQuantum), 8);
    writer.put(inSteps(link.terms.softImpedance, kImpedanceQuantum), 8);
    writer.put(inSteps(link.terms.packetPeriod, kPacketPeriodQuantum), 8);
  }
  ASSERT(!writer.overflowed());
}

void encodeAck(const StateAck& ack, std::vector<std::byte>& bytes) {
  ASSERT(ack.count <= StateAck::kMax);
  bytes.resize(3 + 4 * std::size_t{ack.count});
  BitWriter writer(bytes);
  writer.put(kVersion, 8);
  writer.put(static_cast<std::uint8_t>(Kind::ack), 8);
  writer.put(ack.count, 8);
  for (std::size_t i = 0; i < ack.count; ++i) writer.put(ack.sequences[i], 32);
}

void encodeClock(Kind kind, std::uint32_t sequence, std::initializer_list<Micros> times,
                 std::optional<std::uint32_t> received, std::vector<std::byte>& bytes) {
  const std::size_t bits = 16 + 32 + times.size() * kTimeBits + (received ? 32 : 0);
  bytes.resize((bits + 7) / 8);
  BitWriter writer(bytes);
  writer.put(kVersion, 8);
  writer.put(static_cast<std::uint8_t>(kind), 8);
  writer.put(sequence, 32);
  for (const Micros time : times) putTime(writer, time);
  if (received) writer.put(*received, 32);
  ASSERT(!writer.overflowed());
}

void decodeUpdate(BitReader& reader, const WireFrame& frame, bool twoHands, StateUpdate& update) {
  update.site = static_cast<SiteId>(reader.get(16));
  update.sequence = static_cast<std::uint32_t>(reader.get(32));
  update.time = getTime(reader);
  getPresence(reader, frame, true, update.presence);
  update.presence.worldFromSecondTool.reset();
  if (twoHands) getSecondTool(reader, frame, update.presence);
  update.presence.site = update.site;
  update.newPresence = update.presenceKnown = true;
  update.parts.clear();
  const std::size_t count = reader.get(8);
  // A count is trusted only as far as the bits for it are there.
  if (count * kSmallestPartBits > reader.remaining()) return reader.fail();
  update.parts.resize(count);
  for (std::size_t i = 0; i < count && !reader.failed(); ++i) {
    if (!fromCode(getWhole(reader), frame, update.parts[i])) reader.fail();
    for (std::size_t k = 0; k < i; ++k) {
      if (update.parts[k].part == update.parts[i].part) reader.fail();
    }
  }
}

void decodeLink(BitReader& reader, const WireFrame& frame, LinkUpdate& link) {
  link.peer = static_cast<SiteId>(reader.get(16));
  link.part = static_cast<PartId>(reader.get(kPartBits));
  link.epoch = static_cast<std::uint32_t>(reader.get(32));
  link.sequence = static_cast<std::uint16_t>(reader.get(16));
  link.time = static_cast<std::uint32_t>(reader.get(kLinkTimeBits));
  for (std::uint32_t& x : link.wave) x = static_cast<std::uint32_t>(reader.get(kWaveBits));
  link.energy = static_cast<std::uint32_t>(reader.get(32));
  link.fade = static_cast<std::uint8_t>(reader.get(8));
  link.on = reader.get(1) == 1;
  link.asks = reader.get(1) == 1;
  link.regime = static_cast<std::uint8_t>(reader.get(2));
  if (link.regime > 2) reader.fail();
  link.posed = reader.get(1) == 1;
  link.worldFromDrawn = Pose{};
  link.twist = Twist{};
  link.terms = LinkAgreement{};
  if (!link.posed) return;
  getPose(reader, frame, link.worldFromDrawn);
  link.twist = getTwist(reader);
  link.terms.impedance = getSteps(reader, kImpedanceQuantum);
  link.terms.softImpedance = getSteps(reader, kImpedanceQuantum);
  link.terms.packetPeriod = getSteps(reader, kPacketPeriodQuantum);
}

void decodeAck(BitReader& reader, StateAck& ack) {
  ack.count = static_cast<std::uint8_t>(reader.get(8));
  if (ack.count == 0 || ack.count > StateAck::kMax) {
    ack.count = 0;
    return reader.fail();
  }
  for (std::size_t i = 0; i < ack.count; ++i) ack.sequences[i] = static_cast<std::uint32_t>(reader.get(32));
}

/// The alternative T of the message, kept with its storage if it is there already.
template <typename T>
T& as(StateMessage& message) {
  T* kept = std::get_if<T>(&message);
  return kept != nullptr ? *kept : message.emplace<T>();
}

}  // namespace

void encodeState(const StateMessage& message, const WireFrame& frame, std::vector<std::byte>& bytes,
                 EncodeLosses* losses) {
  EncodeLosses counted;
  if (const auto* update = std::get_if<StateUpdate>(&message)) {
    encodeUpdate(*update, frame, bytes, counted);
  } else if (const auto* ping = std::get_if<Ping>(&message)) {
    encodeClock(Kind::ping, ping->sequence, {ping->siteTime}, std::nullopt, bytes);
  } else if (const auto* pong = std::get_if<Pong>(&message)) {
    encodeClock(Kind::pong, pong->sequence, {pong->siteTime, pong->serverTime}, pong->received, bytes);
  } else if (const auto* link = std::get_if<LinkUpdate>(&message)) {
    encodeLink(*link, frame, bytes, counted.clamped);
  } else if (const auto* ack = std::get_if<StateAck>(&message)) {
    encodeAck(*ack, bytes);
  }
  if (losses != nullptr) *losses = counted;
}

bool isStateUpdate(std::span<const std::byte> bytes) {
  return bytes.size() > 1 && (bytes[1] == static_cast<std::byte>(Kind::update) ||
                              bytes[1] == static_cast<std::byte>(Kind::updateOfTwoHands) ||
                              bytes[1] == static_cast<std::byte>(Kind::streamed));
}

bool isLinkUpdate(std::span<const std::byte> bytes) {
  return bytes.size() > 1 && bytes[1] == static_cast<std::byte>(Kind::link);
}

Status decodeState(std::span<const std::byte> bytes, const WireFrame& frame, StateMessage& message) {
  if (bytes.size() > kMaxStateBytes) return Error{"state datagram: too long"};
  BitReader reader(bytes);
  const std::uint64_t version = reader.get(8), kind = reader.get(8);
  if (reader.failed()) return Error{"state datagram: cut off"};
  if (version != kVersion) return Error{"state datagram: unknown version"};
  switch (static_cast<Kind>(kind)) {
    case Kind::update:
    case Kind::updateOfTwoHands:
      decodeUpdate(reader, frame, kind == static_cast<std::uint64_t>(Kind::updateOfTwoHands),
                   as<StateUpdate>(message));
      break;
    case Kind::ping: {
      Ping& ping = as<Ping>(message);
      ping.sequence = static_cast<std::uint32_t>(reader.get(32));
      ping.siteTime = getTime(reader);
      break;
    }
    case Kind::pong: {
      Pong& pong = as<Pong>(message);
      pong.sequence = static_cast<std::uint32_t>(reader.get(32));
      pong.siteTime = getTime(reader);
      pong.serverTime = getTime(reader);
      pong.received = static_cast<std::uint32_t>(reader.get(32));
      break;
    }
    case Kind::link:
      decodeLink(reader, frame, as<LinkUpdate>(message));
      break;
    case Kind::ack:
      decodeAck(reader, as<StateAck>(message));
      break;
    default:
      return Error{"state datagram: unknown kind"};
  }
  if (reader.failed()) return Error{"state datagram: cut off or out of range"};
  if (!reader.atEnd()) return Error{"state datagram: bytes are left over"};
  return {};
}

PartState quantised(const PartState& state, const WireFrame& frame) {
  PartState out = state;
  int ignored = 0;
  if (isValid(state.worldFromPart)) {
    const bool valid = fromCode(toCode(state.worldFromPart, frame, ignored), frame, out.worldFromPart);
    ASSERT(valid);
  }
  out.twist = fromCode(toCode(state.twist, ignored));
  return out;
}

}  // namespace tandem::sync
