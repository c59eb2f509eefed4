// State datagrams: bit-packed and quantised, each decodable alone. sync/WIRE.md has the table of bits.

#include <algorithm>
#include <cmath>
#include <optional>

#include "sync/bits.h"
#include "sync/wire.h"

namespace tandem::sync {
namespace {

enum class Kind : std::uint8_t { update = 1, ping = 2, pong = 3, link = 4 };
constexpr std::uint8_t kVersion = kProtocolVersion;

constexpr int kPositionBits = 24, kQuaternionBits = 18, kSpeedBits = 16, kPartBits = 14, kTimeBits = 56,
              kLinkTimeBits = 24, kWaveBits = 24;
constexpr int kPoseBits = 3 * kPositionBits + 2 + 3 * kQuaternionBits;
constexpr int kTwistBits = 6 * kSpeedBits;
constexpr int kUpdateHeaderBits =
    8 + 8 + 16 + 32 + kTimeBits + 2 * kPoseBits + 3 * kSpeedBits + 1 + kPartBits + 8;
constexpr int kSmallestPartBits = kPartBits + 8 + 8 + kPoseBits + 1;
constexpr double kSmallestThreeRange = 0.70710678118654752;
constexpr std::int64_t kQuaternionMax = (1 << (kQuaternionBits - 1)) - 1;
constexpr std::int64_t kSpeedMax = (1 << (kSpeedBits - 1)) - 1;
static_assert(kMaxParts == 1u << kPartBits);

/// A number as a signed code in steps of `quantum`; zero is exact. Not a number becomes zero.
std::int64_t toCode(double value, double quantum, std::int64_t min, std::int64_t max, int& clamped) {
  const double code = value / quantum;
  if (!(code >= static_cast<double>(min) - 0.5)) {
    ++clamped;
    return std::isnan(code) ? 0 : min;
  }
  if (code > static_cast<double>(max) + 0.5) {
    ++clamped;
    return max;
  }
  return std::min(max, std::max(min, std::int64_t{std::llround(code)}));
}

struct PoseCode {
  std::int64_t position[3];
  int largest;
  std::int64_t three[3];
};
struct TwistCode {
  std::int64_t linear[3], angular[3];
  bool still() const {
    for (int i = 0; i < 3; ++i) {
      if (linear[i] != 0 || angular[i] != 0) return false;
    }
    return true;
  }
};

PoseCode toCode(const Pose& pose, const WireFrame& frame, int& clamped) {
  PoseCode code{};
  constexpr std::int64_t kMax = 1 << (kPositionBits - 1);
  for (int i = 0; i < 3; ++i) {
    code.position[i] =
        toCode(pose.position[i] - frame.centre[i], frame.halfExtent / kMax, -kMax, kMax - 1, clamped);
  }
  const glm::dquat& q = pose.orientation;
  const double w[4] = {q.w, q.x, q.y, q.z};
  for (int i = 1; i < 4; ++i) {
    if (std::abs(w[i]) > std::abs(w[code.largest])) code.largest = i;
  }
  const double sign = w[code.largest] < 0.0 ? -1.0 : 1.0;
  int ignored = 0;  // a unit quaternion is never out of range by more than rounding
  for (int i = 0, k = 0; i < 4; ++i) {
    if (i == code.largest) continue;
    code.three[k++] =
        toCode(sign * w[i], kSmallestThreeRange / kQuaternionMax, -kQuaternionMax, kQuaternionMax, ignored);
  }
  return code;
}

/// False if the three are not those of a unit quaternion whose largest component was left out.
bool fromCode(const PoseCode& code, const WireFrame& frame, Pose& pose) {
  for (int i = 0; i < 3; ++i) {
    pose.position[i] = frame.centre[i] + static_cast<double>(code.position[i]) *
                                             (frame.halfExtent / (1 << (kPositionBits - 1)));
  }
  double w[4] = {}, sum = 0.0;
  for (int i = 0, k = 0; i < 4; ++i) {
    if (i == code.largest) continue;
    w[i] = static_cast<double>(code.three[k++]) * (kSmallestThreeRange / kQuaternionMax);
    sum += w[i] * w[i];
  }
  if (sum > 0.75 + 1e-4) return false;
  w[code.largest] = std::sqrt(1.0 - sum);
  pose.orientation = glm::dquat(w[0], w[1], w[2], w[3]);
  return true;
}

void speedCode(const glm::dvec3& value, double range, std::int64_t (&code)[3], int& clamped) {
  for (int i = 0; i < 3; ++i) code[i] = toCode(value[i], range / kSpeedMax, -kSpeedMax, kSpeedMax, clamped);
}
glm::dvec3 fromSpeedCode(const std::int64_t (&code)[3], double range) {
  return glm::dvec3(static_cast<double>(code[0]), static_cast<double>(code[1]),
                    static_cast<double>(code[2])) *
         (range / kSpeedMax);
}
TwistCode toCode(const Twist& twist, int& clamped) {
  TwistCode code{};
  speedCode(twist.linear, kMaxLinearSpeed, code.linear, clamped);
  speedCode(twist.angular, kMaxAngularSpeed, code.angular, clamped);
  return code;
}

void put(BitWriter& writer, const PoseCode& code) {
  for (const std::int64_t x : code.position) writer.putSigned(x, kPositionBits);
  writer.put(static_cast<std::uint64_t>(code.largest), 2);
  for (const std::int64_t x : code.three) writer.putSigned(x, kQuaternionBits);
}
void put(BitWriter& writer, const std::int64_t (&code)[3]) {
  for (const std::int64_t x : code) writer.putSigned(x, kSpeedBits);
}
void putTime(BitWriter& writer, Micros time) {
  writer.putSigned(std::min(kMaxMicros, std::max(-kMaxMicros, time)), kTimeBits);
}

void getPose(BitReader& reader, const WireFrame& frame, Pose& pose) {
  PoseCode code{};
  for (std::int64_t& x : code.position) x = reader.getSigned(kPositionBits);
  code.largest = static_cast<int>(reader.get(2));
  for (std::int64_t& x : code.three) x = reader.getSigned(kQuaternionBits);
  if (!fromCode(code, frame, pose)) reader.fail();
}
glm::dvec3 getSpeed(BitReader& reader, double range) {
  std::int64_t code[3] = {};
  for (std::int64_t& x : code) {
    x = reader.getSigned(kSpeedBits);
    if (x < -kSpeedMax) reader.fail();  // no encoder writes this one
  }
  return fromSpeedCode(code, range);
}

Twist getTwist(BitReader& reader) {
  const glm::dvec3 linear = getSpeed(reader, kMaxLinearSpeed);
  return {linear, getSpeed(reader, kMaxAngularSpeed)};
}

bool sendable(const PartState& state) { return state.part < kMaxParts && isValid(state.worldFromPart); }

int partBits(const PartState& state) {
  int ignored = 0;
  const bool still = toCode(state.twist, ignored).still();
  return kPartBits + varintBits(state.epoch) + varintBits(state.sequence) + kPoseBits + 1 +
         (still ? 0 : kTwistBits);
}

void putPart(BitWriter& writer, const PartState& state, const WireFrame& frame, int& clamped) {
  const TwistCode twist = toCode(state.twist, clamped);
  writer.put(state.part, kPartBits);
  writer.putVarint(state.epoch);
  writer.putVarint(state.sequence);
  put(writer, toCode(state.worldFromPart, frame, clamped));
  writer.put(twist.still() ? 1 : 0, 1);
  if (twist.still()) return;
  put(writer, twist.linear);
  put(writer, twist.angular);
}

void getPart(BitReader& reader, const WireFrame& frame, PartState& state) {
  state.part = static_cast<PartId>(reader.get(kPartBits));
  state.epoch = reader.getVarint();
  state.sequence = reader.getVarint();
  getPose(reader, frame, state.worldFromPart);
  state.twist = Twist{};
  if (reader.get(1) == 1) return;
  state.twist = getTwist(reader);
}

void putPresence(BitWriter& writer, const Presence& presence, const WireFrame& frame, int& clamped) {
  // A pose that is no pose (a device that failed) is shown at the centre rather than sent as nonsense.
  const Pose fallback{frame.centre, glm::dquat(1.0, 0.0, 0.0, 0.0)};
  for (const Pose* pose : {&presence.worldFromTool, &presence.worldFromCamera}) {
    put(writer, toCode(isValid(*pose) ? *pose : fallback, frame, clamped));
  }
  std::int64_t force[3] = {};
  speedCode(presence.force, kMaxPresenceForce, force, clamped);
  put(writer, force);
  const bool touches = presence.touched < kMaxParts;
  writer.put(touches ? 1 : 0, 1);
  writer.put(touches ? presence.touched : 0, kPartBits);
}

void getPresence(BitReader& reader, const WireFrame& frame, Presence& presence) {
  getPose(reader, frame, presence.worldFromTool);
  getPose(reader, frame, presence.worldFromCamera);
  presence.force = getSpeed(reader, kMaxPresenceForce);
  const bool touches = reader.get(1) == 1;
  const auto part = static_cast<PartId>(reader.get(kPartBits));
  if (!touches && part != 0) reader.fail();
  presence.touched = touches ? part : kNoPart;
}

void encodeUpdate(const StateUpdate& update, const WireFrame& frame, std::vector<std::byte>& bytes,
                  EncodeLosses& losses) {
  int bits = kUpdateHeaderBits, count = 0;
  std::size_t end = 0;  // the parts in front of this one fit
  for (; end < update.parts.size() && count < static_cast<int>(kMaxStateParts); ++end) {
    if (!sendable(update.parts[end])) continue;
    const int more = partBits(update.parts[end]);
    if (bits + more > static_cast<int>(kMaxStateBytes) * 8) break;
    bits += more;
    ++count;
  }
  losses.leftOut += static_cast<int>(update.parts.size()) - count;

  bytes.resize(static_cast<std::size_t>((bits + 7) / 8));
  BitWriter writer(bytes);
  writer.put(kVersion, 8);
  writer.put(static_cast<std::uint8_t>(Kind::update), 8);
  writer.put(update.site, 16);
  writer.put(update.sequence, 32);
  putTime(writer, update.time);
  putPresence(writer, update.presence, frame, losses.clamped);
  writer.put(static_cast<std::uint64_t>(count), 8);
  for (std::size_t i = 0; i < end; ++i) {
    if (sendable(update.parts[i])) putPart(writer, update.parts[i], frame, losses.clamped);
  }
  ASSERT(!writer.overflowed() && writer.bitCount() == static_cast<std::size_t>(bits));
}

void put(BitWriter& writer, const Twist& twist, int& clamped) {
  const TwistCode code = toCode(twist, clamped);
  put(writer, code.linear);
  put(writer, code.angular);
}

/// 1..255 of them.
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
    put(writer, link.twist, clamped);
    writer.put(inSteps(link.terms.impedance, kImpedanceQuantum), 8);
    writer.put(inSteps(link.terms.softImpedance, kImpedanceQuantum), 8);
    writer.put(inSteps(link.terms.packetPeriod, kPacketPeriodQuantum), 8);
  }
  ASSERT(!writer.overflowed());
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

Micros getTime(BitReader& reader) {
  const Micros time = reader.getSigned(kTimeBits);
  if (time < -kMaxMicros) reader.fail();
  return time;
}

void decodeUpdate(BitReader& reader, const WireFrame& frame, StateUpdate& update) {
  update.site = static_cast<SiteId>(reader.get(16));
  update.sequence = static_cast<std::uint32_t>(reader.get(32));
  update.time = getTime(reader);
  getPresence(reader, frame, update.presence);
  update.presence.site = update.site;
  update.parts.clear();
  const std::size_t count = reader.get(8);
  // A count is believed only as far as the bits for it are there.
  if (count * kSmallestPartBits > reader.remaining()) return reader.fail();
  update.parts.resize(count);
  for (std::size_t i = 0; i < count && !reader.failed(); ++i) {
    getPart(reader, frame, update.parts[i]);
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
  link.terms = LineTerms{};
  if (!link.posed) return;
  getPose(reader, frame, link.worldFromDrawn);
  link.twist = getTwist(reader);
  link.terms.impedance = getSteps(reader, kImpedanceQuantum);
  link.terms.softImpedance = getSteps(reader, kImpedanceQuantum);
  link.terms.packetPeriod = getSteps(reader, kPacketPeriodQuantum);
}

/// The alternative T of the message, kept with its storage if it is there already.
template <typename T>
T& as(StateMessage& message) {
  T* kept = std::get_if<T>(&message);
  return kept != nullptr ? *kept : message.emplace<T>();
}

}  // namespace

WireFrame wireFrame(const assets::Bounds& sceneBounds) {
  const glm::dvec3 size = sceneBounds.max - sceneBounds.min;
  const double largest = std::max({size.x, size.y, size.z});
  if (!(size.x >= 0.0 && size.y >= 0.0 && size.z >= 0.0) || !(largest < 1e6)) return {};
  WireFrame frame;
  frame.centre = 0.5 * (sceneBounds.min + sceneBounds.max);
  // Eight times the scene, and never less than an arm's reach: hands move in metres even where parts are
  // small.
  const double wanted = std::max(4.0 * largest, 0.5);
  frame.halfExtent = std::exp2(std::ceil(std::log2(wanted)));
  return frame;
}

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
  }
  if (losses != nullptr) *losses = counted;
}

bool isStateUpdate(std::span<const std::byte> bytes) {
  return bytes.size() > 1 && bytes[1] == static_cast<std::byte>(Kind::update);
}

Status decodeState(std::span<const std::byte> bytes, const WireFrame& frame, StateMessage& message) {
  if (bytes.size() > kMaxStateBytes) return Error{"state datagram: too long"};
  BitReader reader(bytes);
  const std::uint64_t version = reader.get(8), kind = reader.get(8);
  if (reader.failed()) return Error{"state datagram: cut off"};
  if (version != kVersion) return Error{"state datagram: unknown version"};
  switch (static_cast<Kind>(kind)) {
    case Kind::update:
      decodeUpdate(reader, frame, as<StateUpdate>(message));
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
  const TwistCode twist = toCode(state.twist, ignored);
  out.twist.linear = fromSpeedCode(twist.linear, kMaxLinearSpeed);
  out.twist.angular = fromSpeedCode(twist.angular, kMaxAngularSpeed);
  return out;
}

}  // namespace tandem::sync
