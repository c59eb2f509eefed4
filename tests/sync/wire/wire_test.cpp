#include "sync/wire/wire.h"

#include <gtest/gtest.h>

#include <limits>

#include <fstream>

#include "tests/support/source_file.h"
#include "tests/sync/wire/random_messages.h"

namespace tandem::sync {
namespace {

using testing::RandomMessages;
constexpr std::size_t kKinds = std::variant_size_v<ControlMessage>;
/// Those of kinds that messages have.
const std::vector<std::size_t> kAssigned = [] {
  std::vector<std::size_t> kinds;
  for (std::size_t kind = 0; kind < kKinds; ++kind)
    if (kind != 24 && kind != 25) kinds.push_back(kind);
  return kinds;
}();
const WireFrame kFrame{{0.3, -1.0, 2.0}, 4.0};

double angleBetween(const glm::dquat& a, const glm::dquat& b) {
  return glm::length(rotationVector(a * glm::conjugate(b)));
}

void expectClose(const Pose& a, const Pose& b, double factor = 1.0) {
  for (int i = 0; i < 3; ++i)
    EXPECT_LE(std::abs(a.position[i] - b.position[i]), factor * positionError(kFrame));
  EXPECT_LE(angleBetween(a.orientation, b.orientation), factor * kMaxAngleError);
  EXPECT_TRUE(isValid(b));
}
void expectClose(const glm::dvec3& a, const glm::dvec3& b, double most) {
  for (int i = 0; i < 3; ++i) EXPECT_LE(std::abs(a[i] - b[i]), most * 1.000001);
}
void expectClose(const StateUpdate& a, const StateUpdate& b) {
  EXPECT_EQ(a.site, b.site);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.presence.touched, b.presence.touched);
  expectClose(a.presence.worldFromTool, b.presence.worldFromTool);
  expectClose(a.presence.worldFromCamera, b.presence.worldFromCamera);
  ASSERT_EQ(a.presence.worldFromSecondTool.has_value(), b.presence.worldFromSecondTool.has_value());
  if (a.presence.worldFromSecondTool)
    expectClose(*a.presence.worldFromSecondTool, *b.presence.worldFromSecondTool);
  expectClose(a.presence.force, b.presence.force, kPresenceForceError);
  ASSERT_EQ(a.parts.size(), b.parts.size());
  for (std::size_t i = 0; i < a.parts.size(); ++i) {
    EXPECT_EQ(a.parts[i].part, b.parts[i].part);
    EXPECT_EQ(a.parts[i].epoch, b.parts[i].epoch);
    EXPECT_EQ(a.parts[i].sequence, b.parts[i].sequence);
    expectClose(a.parts[i].worldFromPart, b.parts[i].worldFromPart);
    expectClose(a.parts[i].twist.linear, b.parts[i].twist.linear, kLinearSpeedError);
    expectClose(a.parts[i].twist.angular, b.parts[i].twist.angular, kAngularSpeedError);
  }
}

std::vector<std::byte> encoded(const StateMessage& message) {
  std::vector<std::byte> bytes;
  encodeState(message, kFrame, bytes);
  return bytes;
}

TEST(ControlWire, EveryKindComesBackExactly) {
  RandomMessages random(1);
  for (int round = 0; round < 200; ++round) {
    for (const std::size_t kind : kAssigned) {
      const ControlMessage message = random.control(kind);
      ASSERT_EQ(message.index(), kind);
      const auto bytes = encodeControl(message);
      const auto back = decodeControl(bytes);
      ASSERT_TRUE(back.ok()) << kind << ": " << back.error().message;
      ASSERT_EQ(back->index(), kind);
      EXPECT_EQ(encodeControl(*back), bytes) << "kind " << kind;
    }
  }
}

TEST(ControlWire, RefusesKindsThatNoMessageHas) {
  for (const std::size_t kind : {0, 25, 26, 35})
    EXPECT_FALSE(decodeControl(std::vector{static_cast<std::byte>(kind)}).ok()) << kind;
}

TEST(ControlWire, RefusesAnEntryOutsideTheLimitsOfItsKind) {
  const auto decodes = [](const document::Body& body) {
    return decodeControl(encodeControl(PutEntry{1, {0, 0, body}})).ok();
  };
  document::Measure measure;
  measure.value = 0.5;
  EXPECT_TRUE(decodes(measure));
  measure.value = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(decodes(measure));
  document::Note note;
  note.text = "a \x1b[2J control character";
  EXPECT_FALSE(decodes(note));
  note.text = "no control character";
  EXPECT_TRUE(decodes(note));
  note.status = static_cast<document::NoteStatus>(4);
  EXPECT_FALSE(decodes(note));
  EXPECT_FALSE(decodes(document::ClashVerdict{})) << "of no parts";
}

TEST(ControlWire, RefusesAPresentationWithoutFiniteNumbersOrWithTooMuchOfAnything) {
  const auto decodes = [](const Presentation& shown) { return decodeControl(encodeControl(shown)).ok(); };
  Presentation full;
  full.shares = Shares::view;
  full.sections.resize(document::kMaxSections);
  full.hidden.resize(kMaxParts / 8);
  EXPECT_TRUE(decodes(full));
  EXPECT_LE(encodeControl(full).size(), kMaxRequestBytes);
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity(), 2e9}) {
    Presentation lie = full;
    lie.sections.back().normal.z = wrong;
    EXPECT_FALSE(decodes(lie));
    lie = full;
    lie.place.x = wrong;
    EXPECT_FALSE(decodes(lie));
  }
  auto bytes = encodeControl(Presentation{});
  bytes[3] = std::byte{3};  // shares
  EXPECT_FALSE(decodeControl(bytes).ok());
  bytes = encodeControl(full);
  bytes[4] = static_cast<std::byte>(document::kMaxSections + 1);
  EXPECT_FALSE(decodeControl(bytes).ok());
}

TEST(ControlWire, ADoubtHasTheBytesThatTheTableSays) {
  const auto bytes = encodeControl(Doubt{258, 3, true});
  const std::vector<std::uint8_t> golden{34, 2, 1, 3, 0, 1};
  ASSERT_EQ(bytes.size(), golden.size());
  for (std::size_t i = 0; i < golden.size(); ++i) EXPECT_EQ(std::to_integer<int>(bytes[i]), golden[i]) << i;
  auto flag = bytes;
  flag[5] = std::byte{2};
  EXPECT_FALSE(decodeControl(flag).ok());
}

TEST(ControlWire, FieldsKeepTheirValues) {
  RandomMessages random(2);
  for (int round = 0; round < 100; ++round) {
    const Welcome sent = random.welcome();
    const auto message = decodeControl(encodeControl(sent));
    ASSERT_TRUE(message.ok());
    const auto& got = std::get<Welcome>(*message);
    EXPECT_EQ(sent.site, got.site);
    EXPECT_EQ(sent.role, got.role);
    EXPECT_EQ(sent.resumeTicket, got.resumeTicket);
    EXPECT_EQ(sent.sceneHash, got.sceneHash);
    EXPECT_EQ(sent.sceneBytes, got.sceneBytes);
    EXPECT_EQ(sent.sessionTime, got.sessionTime);
    EXPECT_EQ(sent.lease, got.lease);
    EXPECT_EQ(sent.sites, got.sites);
    ASSERT_EQ(sent.parts.size(), got.parts.size());
    for (std::size_t i = 0; i < sent.parts.size(); ++i) {
      EXPECT_EQ(sent.parts[i].part, got.parts[i].part);
      EXPECT_EQ(sent.parts[i].owner, got.parts[i].owner);
      EXPECT_EQ(sent.parts[i].epoch, got.parts[i].epoch);
      EXPECT_EQ(sent.parts[i].worldFromPart.position, got.parts[i].worldFromPart.position);
      EXPECT_EQ(sent.parts[i].worldFromPart.orientation, got.parts[i].worldFromPart.orientation);
    }
  }
}

TEST(ControlWire, RefusesEveryTruncationAndTrailingByte) {
  RandomMessages random(3);
  for (const std::size_t kind : kAssigned) {
    auto bytes = encodeControl(random.control(kind));
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      EXPECT_FALSE(decodeControl(std::span(bytes).first(length)).ok()) << kind << " cut to " << length;
    }
    bytes.push_back(std::byte{0});
    EXPECT_FALSE(decodeControl(bytes).ok()) << kind << " with a byte too many";
  }
}

TEST(ControlWire, SurvivesFlippedBitsAndDecodesOnlyWhatItWouldEncode) {
  RandomMessages random(4);
  for (int round = 0; round < 20000; ++round) {
    auto bytes =
        encodeControl(random.control(kAssigned[random.number(static_cast<std::uint32_t>(kAssigned.size()))]));
    for (std::uint32_t flips = 1 + random.number(3); flips > 0; --flips) {
      bytes[random.number(static_cast<std::uint32_t>(bytes.size()))] ^=
          static_cast<std::byte>(1u << random.number(8));
    }
    const auto message = decodeControl(bytes);
    const auto* hello = message.ok() ? std::get_if<Hello>(&*message) : nullptr;
    if (message.ok() && (hello == nullptr || hello->protocolVersion == kProtocolVersion)) {
      EXPECT_EQ(encodeControl(*message), bytes);
    }
  }
}

TEST(ControlWire, RefusesCountsWithoutTheirBytes) {
  auto bytes = encodeControl(Welcome{});
  bytes[bytes.size() - 2] = std::byte{0xff};  // announces 255 parts that are not there
  EXPECT_FALSE(decodeControl(bytes).ok());
}

TEST(ControlWire, RefusesUnknownKindsAndBadNumbers) {
  EXPECT_FALSE(decodeControl({}).ok());
  for (const int kind : {0, 19, 255})
    EXPECT_FALSE(decodeControl(std::vector{static_cast<std::byte>(kind)}).ok());
  Release release{1, 2, 3, {}};
  release.worldFromPart.position.y = std::nan("");
  EXPECT_FALSE(decodeControl(encodeControl(release)).ok());
  release.worldFromPart = {{0, 0, 0}, glm::dquat(0.9, 0.0, 0.0, 0.0)};
  EXPECT_FALSE(decodeControl(encodeControl(release)).ok());
}

TEST(ControlWire, DecodesTheVersionOfAHelloThatItCannotRead) {
  Hello hello;
  hello.protocolVersion = 77;
  auto bytes = encodeControl(hello);
  bytes.push_back(std::byte{0x5a});  // whatever fields that version may have
  const auto message = decodeControl(bytes);
  ASSERT_TRUE(message.ok());
  EXPECT_EQ(std::get<Hello>(*message).protocolVersion, 77);
}

TEST(ControlWire, CleansTextThatCouldHarmATerminal) {
  const auto message = decodeControl(encodeControl(Refused{Refusal::malformed, "a\x1b[2Jb\xff\xc3"}));
  ASSERT_TRUE(message.ok());
  EXPECT_EQ(std::get<Refused>(*message).reason, "a?[2Jb??");
  const auto cut = decodeControl(encodeControl(Refused{Refusal::malformed, std::string(600, 'x')}));
  EXPECT_EQ(std::get<Refused>(*cut).reason.size(), kMaxTextLength);
}

std::string hex(const std::vector<std::byte>& bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (const std::byte byte : bytes) {
    if (!out.empty()) out += ' ';
    out += kDigits[std::to_integer<unsigned>(byte) >> 4];
    out += kDigits[std::to_integer<unsigned>(byte) & 15u];
  }
  return out;
}

TEST(Wire, WritesTheExamplesOfItsDescription) {
  std::ifstream in(sourceFile("sync/WIRE.md"));
  const std::string description{std::istreambuf_iterator<char>(in), {}};
  const std::string grab = hex(encodeControl(Grab{258, 3})), ping = hex(encoded(Ping{7, 1000}));
  EXPECT_NE(description.find("`" + grab + "`"), std::string::npos) << grab;
  EXPECT_NE(description.find("`" + ping + "`"), std::string::npos) << ping;
}

TEST(ControlWire, AWelcomeWithEverySiteAndPartFits) {
  Welcome welcome;
  SiteInfo site;
  site.name.assign(kMaxNameLength, 'n');
  welcome.sites.assign(kMaxSites, site);
  welcome.resumeTicket.assign(kMaxCredentialLength, 't');
  welcome.parts.resize(kMaxParts);
  EXPECT_LE(encodeControl(welcome).size(), kMaxControlBytes);
}

TEST(StateWire, ErrorsStayWithinTheStatedBounds) {
  RandomMessages random(5);
  for (int round = 0; round < 5000; ++round) {
    const StateUpdate sent = random.update(random.number(20), kFrame);
    StateMessage message;
    const Status status = decodeState(encoded(sent), kFrame, message);
    ASSERT_TRUE(status.ok()) << status.error().message;
    expectClose(sent, std::get<StateUpdate>(message));
  }
}

TEST(StateWire, TheReceiverGetsExactlyWhatQuantisedReturns) {
  RandomMessages random(6);
  const StateUpdate sent = random.update(15, kFrame);
  StateMessage message;
  ASSERT_TRUE(decodeState(encoded(sent), kFrame, message).ok());
  for (std::size_t i = 0; i < sent.parts.size(); ++i) {
    const PartState expected = quantised(sent.parts[i], kFrame);
    const PartState& got = std::get<StateUpdate>(message).parts[i];
    EXPECT_EQ(expected.worldFromPart.position, got.worldFromPart.position);
    EXPECT_EQ(expected.worldFromPart.orientation, got.worldFromPart.orientation);
    EXPECT_EQ(expected.twist.linear, got.twist.linear);
    EXPECT_EQ(expected.twist.angular, got.twist.angular);
  }
}

TEST(StateWire, RelayingAddsAtMostOneMoreQuantum) {
  RandomMessages random(7);
  for (int round = 0; round < 500; ++round) {
    const PartState once = quantised(random.update(1, kFrame).parts[0], kFrame);
    const PartState twice = quantised(once, kFrame);
    EXPECT_EQ(once.worldFromPart.position, twice.worldFromPart.position);
    EXPECT_EQ(once.twist.linear, twice.twist.linear);
    EXPECT_LE(angleBetween(once.worldFromPart.orientation, twice.worldFromPart.orientation), kMaxAngleError);
  }
}

TEST(StateWire, PingAndPongComeBack) {
  StateMessage message;
  ASSERT_TRUE(decodeState(encoded(Ping{7, -123456789}), kFrame, message).ok());
  EXPECT_EQ(std::get<Ping>(message).siteTime, -123456789);
  EXPECT_EQ(std::get<Ping>(message).sequence, 7u);
  ASSERT_TRUE(decodeState(encoded(Pong{8, 1, 2, 3}), kFrame, message).ok());
  const auto& pong = std::get<Pong>(message);
  EXPECT_EQ(pong.sequence, 8u);
  EXPECT_EQ(pong.siteTime, 1);
  EXPECT_EQ(pong.serverTime, 2);
  EXPECT_EQ(pong.received, 3u);
}

TEST(StateWire, RefusesEveryTruncationAndTrailingByte) {
  RandomMessages random(8);
  for (const StateMessage& sent :
       {StateMessage(random.update(9, kFrame)), StateMessage(Ping{1, 2}), StateMessage(Pong{1, 2, 3, 4}),
        StateMessage(random.link(false)), StateMessage(random.link(true))}) {
    auto bytes = encoded(sent);
    StateMessage message;
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      EXPECT_FALSE(decodeState(std::span(bytes).first(length), kFrame, message).ok()) << length;
    }
    bytes.push_back(std::byte{0});
    EXPECT_FALSE(decodeState(bytes, kFrame, message).ok());
  }
}

TEST(StateWire, FlippedBitsGiveValidMessagesOrNone) {
  RandomMessages random(9);
  StateMessage message;
  int accepted = 0;
  for (int round = 0; round < 20000; ++round) {
    auto bytes = encoded(random.update(random.number(12), kFrame));
    for (std::uint32_t flips = 1 + random.number(4); flips > 0; --flips) {
      bytes[random.number(static_cast<std::uint32_t>(bytes.size()))] ^=
          static_cast<std::byte>(1u << random.number(8));
    }
    if (!decodeState(bytes, kFrame, message).ok()) continue;
    ++accepted;
    const auto* update = std::get_if<StateUpdate>(&message);
    if (update == nullptr) continue;
    for (const PartState& state : update->parts) {
      EXPECT_TRUE(isValid(state.worldFromPart));
      EXPECT_LE(glm::length(state.twist.linear), 14.0);
      EXPECT_LT(state.part, kMaxParts);
    }
  }
  EXPECT_GT(accepted, 1000);
}

TEST(StateWire, RefusesAPartThatAppearsTwiceAndOtherVersions) {
  RandomMessages random(10);
  StateUpdate update = random.update(2, kFrame);
  StateMessage message;
  update.parts[1].part = update.parts[0].part;
  EXPECT_FALSE(decodeState(encoded(update), kFrame, message).ok());
  auto bytes = encoded(Ping{});
  bytes[0] = std::byte{kStateVersion + 1};
  EXPECT_FALSE(decodeState(bytes, kFrame, message).ok());
  bytes[0] = std::byte{kStateVersion};
  bytes[1] = std::byte{9};
  EXPECT_FALSE(decodeState(bytes, kFrame, message).ok());
}

TEST(StateWire, LeavesOutFromTheBackAndClampsAndCounts) {
  RandomMessages random(11);
  StateUpdate update = random.update(100, kFrame);
  update.parts[0].worldFromPart.position.x = 1e5;
  update.parts[1].worldFromPart.position.x = std::nan("");
  std::vector<std::byte> bytes;
  EncodeLosses losses;
  encodeState(update, kFrame, bytes, &losses);
  EXPECT_LE(bytes.size(), kMaxStateBytes);
  EXPECT_GT(bytes.size(), kMaxStateBytes - 40);
  EXPECT_EQ(losses.clamped, 1);
  StateMessage message;
  ASSERT_TRUE(decodeState(bytes, kFrame, message).ok());
  const auto& parts = std::get<StateUpdate>(message).parts;
  EXPECT_EQ(parts.size() + static_cast<std::size_t>(losses.leftOut), 100u);
  EXPECT_EQ(parts[1].part, update.parts[2].part) << "the invalid one is left out, its successors stay";
}

TEST(StateWire, ReusesItsBuffer) {
  RandomMessages random(12);
  const StateUpdate update = random.update(12, kFrame);
  std::vector<std::byte> bytes;
  bytes.reserve(kMaxStateBytes);
  const std::byte* const storage = bytes.data();
  encodeState(update, kFrame, bytes);
  EXPECT_EQ(bytes.data(), storage);
}

TEST(WireFrame, HoldsTheSceneWithRoomAround) {
  const WireFrame frame = wireFrame({{-1, -2, 0}, {3, 2, 1}});
  EXPECT_EQ(frame.centre, glm::dvec3(1.0, 0.0, 0.5));
  EXPECT_GE(frame.halfExtent, 16.0);
  EXPECT_EQ(wireFrame({}).halfExtent, WireFrame{}.halfExtent) << "an empty scene";
  EXPECT_GE(wireFrame({{0, 0, 0}, {0.01, 0.01, 0.01}}).halfExtent, 0.5) << "an arm's reach";
}

}  // namespace
}  // namespace tandem::sync
