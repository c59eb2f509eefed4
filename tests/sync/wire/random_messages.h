#pragma once

// Random valid messages of every kind, for round trips.

#include <random>

#include "sync/wire/wire.h"

namespace tandem::sync::testing {

class RandomMessages {
 public:
  explicit RandomMessages(std::uint64_t seed) : random_(seed) {}

  double real(double min, double max) {
    return min + (max - min) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  std::uint32_t number(std::uint32_t below) { return static_cast<std::uint32_t>(random_() % below); }
  bool chance(double p) { return real(0.0, 1.0) < p; }
  std::uint64_t bits() { return random_(); }

  glm::dvec3 vector(double range) { return {real(-range, range), real(-range, range), real(-range, range)}; }
  glm::dquat rotation() {
    if (chance(0.1)) return glm::dquat(0.5, 0.5, chance(0.5) ? -0.5 : 0.5, 0.5);  // four equal components
    if (chance(0.1)) return glm::dquat(1.0, 0.0, 0.0, 0.0);
    return fromRotationVector(vector(3.2));
  }
  Pose pose(double range) { return {vector(range), rotation()}; }
  std::string text(std::size_t longest) {
    static const char* const kPieces[] = {"a", "Z", " ", "9", "\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x94\xa7"};
    std::string out;
    for (std::uint32_t n = number(20); n > 0; --n) {
      const std::string piece = kPieces[number(7)];
      if (out.size() + piece.size() <= longest) out += piece;
    }
    return out;
  }
  std::string credential() {
    std::string out;
    for (std::uint32_t n = number(200); n > 0; --n) out += static_cast<char>(0x21 + number(94));
    return out;
  }
  SiteInfo site() {
    return {static_cast<SiteId>(number(65536)),
            static_cast<Role>(number(3)),
            text(kMaxNameLength),
            {static_cast<std::uint8_t>(number(256)), static_cast<std::uint8_t>(number(256)), 7},
            chance(0.5)};
  }
  PartId partId() { return chance(0.1) ? kNoPart : static_cast<PartId>(number(kMaxParts)); }
  PartRecord record() { return {partId(), static_cast<SiteId>(number(65536)), number(~0u), pose(5.0)}; }
  CoHolderRecord coHolders() {
    CoHolderRecord m{partId(), number(~0u), number(~0u), {}};
    for (std::uint32_t n = number(6); n > 0; --n) m.sites.push_back(static_cast<SiteId>(number(65536)));
    return m;
  }
  Micros time() { return static_cast<Micros>(random_() >> 9) - (Micros{1} << 54); }

  /// A message of the kind with this index in ControlMessage.
  ControlMessage control(std::size_t kind) {
    switch (kind) {
      case 0:
        return Hello{kProtocolVersion, chance(0.5), credential(), text(kMaxNameLength), {1, 2, 3}};
      case 1:
        return SceneRequest{random_()};
      case 2:
        return Ready{};
      case 3:
        return Grab{number(~0u), partId()};
      case 4:
        return Release{number(~0u), partId(), number(~0u), pose(5.0)};
      case 5:
        return Reclaim{number(~0u), partId(), number(~0u), pose(5.0)};
      case 6:
        return Revoke{number(~0u), partId()};
      case 7:
        return ResetParts{number(~0u)};
      case 8:
        return Goodbye{};
      case 9:
        return welcome();
      case 10:
        return Refused{static_cast<Refusal>(number(8)), text(kMaxTextLength)};
      case 11:
        return SceneChunk{random_(), std::vector<std::uint8_t>(1 + number(300), 0xab)};
      case 12:
        return SiteChanged{site()};
      case 13:
        return SiteLeft{static_cast<SiteId>(number(65536))};
      case 14:
        return GrabReply{number(~0u), static_cast<Denial>(number(7)), record()};
      case 15:
        return ReleaseReply{number(~0u), static_cast<Denial>(number(7)), record()};
      case 16:
        return CommandReply{number(~0u), chance(0.5), text(kMaxTextLength)};
      case 17:
        return OwnershipChanged{record()};
      case 18:
        return Engage{number(~0u), partId()};
      case 19:
        return Disengage{number(~0u), partId()};
      case 20:
        return EngageReply{number(~0u), static_cast<Denial>(number(8)), coHolders()};
      case 21:
        return MembersChanged{coHolders()};
      case 22:
        return NewTicket{credential()};
      case 26:
        return PutEntry{number(~0u), {random_() >> 1, random_() >> 1, body()}};
      case 27:
        return PutReply{number(~0u), static_cast<document::Refusal>(number(8)), text(kMaxTextLength),
                        random_(), random_()};
      case 28:
        return DocumentChanged{entry()};
      case 29:
        return DocumentRequest{random_()};
      case 30: {
        DocumentChunk m{chance(0.5), chance(0.5), random_(), {}};
        for (std::uint32_t n = number(5); n > 0; --n) m.entries.push_back(entry());
        return m;
      }
      case 31:
        return presentation();
      case 32:
        return Say{text(kMaxSayLength), {partId(), partId()}};
      case 33:
        return Doubt{static_cast<SiteId>(number(65536)), static_cast<SiteId>(number(65536)), chance(0.5)};
      case 34: {
        Said m{chance(0.5), {}};
        for (std::uint32_t n = number(4); n > 0; --n)
          m.lines.push_back({random_(), static_cast<std::int64_t>(number(~0u)),
                             static_cast<SiteId>(number(65536)), text(kMaxNameLength),
                             Say{text(kMaxSayLength), {partId()}}});
        return m;
      }
      default:
        return SiteReport{number(~0u), number(~0u), number(~0u), number(~0u),
                          number(~0u), number(~0u), number(~0u)};
    }
  }
  Presentation presentation() {
    Presentation m;
    m.site = static_cast<SiteId>(number(65536));
    m.shares = static_cast<Shares>(number(3));
    for (std::uint32_t n = number(9); n > 0; --n) m.sections.push_back({vector(1.0), vector(1.0)});
    m.selected = partId();
    for (std::uint32_t n = number(20); n > 0; --n) m.hidden.push_back(static_cast<std::uint8_t>(number(256)));
    for (std::uint32_t n = number(20); n > 0; --n)
      m.transparent.push_back(static_cast<std::uint8_t>(number(256)));
    m.style = style();
    m.inspection = inspection();
    m.pointedAt = partId();
    m.place = vector(1.0);
    return m;
  }
  Inspection inspection() {
    Inspection looks;
    looks.a = partId();
    looks.b = partId();
    looks.mark = static_cast<ClashMark>(number(5));
    looks.amount = static_cast<double>(number(100)) * 1e-3;
    looks.moved = number(2) == 1;
    looks.onA = vector(1.0);
    looks.onB = vector(1.0);
    looks.measuring = number(2) == 1;
    for (std::uint32_t n = number(3); n > 0; --n) looks.marks.push_back({partId(), vector(1.0)});
    return looks;
  }
  document::PartStyle style() {
    document::PartStyle style;
    style.explode = static_cast<double>(number(5)) / 4.0;
    for (std::uint32_t n = number(5); n > 0; --n) style.apart.push_back(static_cast<PartId>(number(99)));
    style.colouring = static_cast<document::PartColouring>(number(4));
    style.ghosts = number(2) == 1;
    return style;
  }
  document::Body body() {
    switch (number(5)) {
      case 0:
        return document::Removed{};
      case 1:
        return document::NamedView{text(40),    pose(5.0), 0.5,    {{vector(1.0), vector(1.0)}},
                                   chance(0.5), {3, 4},    style()};
      case 2:
        return document::Comment{1 + random_(), text(200)};
      case 3:
        return document::SavedPoses{text(40), {{PartId{7}, pose(5.0)}, {PartId{8}, pose(5.0)}}};
      default:
        return document::Note{text(200), partId(), vector(1.0), text(40),
                              static_cast<document::NoteStatus>(number(4))};
    }
  }
  document::Entry entry() {
    document::Entry m;
    m.id = 1 + number(~0u);
    m.revision = 1 + number(~0u);
    m.author = static_cast<SiteId>(number(65536));
    m.creation = number(~0u);
    m.authorName = text(document::kMaxName);
    m.made = number(~0u);
    m.editor = static_cast<SiteId>(number(65536));
    m.request = number(~0u);
    m.changed = number(~0u);
    m.body = body();
    return m;
  }
  Welcome welcome() {
    Welcome m;
    m.site = static_cast<SiteId>(number(65536));
    m.role = static_cast<Role>(number(3));
    m.resumeTicket = credential();
    for (auto& byte : m.sceneHash) byte = static_cast<std::uint8_t>(number(256));
    m.sceneBytes = random_();
    m.sessionTime = time();
    m.lease = time();
    if (chance(0.5)) m.voiceUrl = "mumble://voice.example.org:" + std::to_string(number(65536));
    for (std::uint32_t n = number(5); n > 0; --n) m.sites.push_back(site());
    for (std::uint32_t n = number(5); n > 0; --n) m.parts.push_back(record());
    return m;
  }
  LinkUpdate link(bool posed) {
    LinkUpdate m;
    m.peer = static_cast<SiteId>(number(65536));
    m.part = static_cast<PartId>(number(kMaxParts));
    m.epoch = number(~0u);
    m.sequence = static_cast<std::uint16_t>(number(65536));
    m.time = number(1u << 24);
    for (std::uint32_t& x : m.wave) x = number(1u << 24);
    m.energy = number(~0u);
    m.fade = static_cast<std::uint8_t>(number(256));
    m.on = chance(0.5);
    m.asks = chance(0.5);
    m.regime = static_cast<std::uint8_t>(number(3));
    m.posed = posed;
    if (posed) {
      m.worldFromDrawn = pose(0.4);
      m.terms = {kImpedanceQuantum * (1 + number(255)), kImpedanceQuantum * (1 + number(255)),
                 kPacketPeriodQuantum * (1 + number(255))};
    }
    return m;
  }
  /// An update with `parts` parts of distinct ids inside the frame.
  StateUpdate update(std::size_t parts, const WireFrame& frame) {
    StateUpdate m;
    const double range = 0.99 * frame.halfExtent;
    m.site = m.presence.site = static_cast<SiteId>(number(65536));
    m.sequence = number(~0u);
    m.time = time();
    m.presence.worldFromTool = within(frame, range);
    m.presence.worldFromCamera = within(frame, range);
    m.presence.force = vector(60.0);
    m.presence.touched = partId();
    if (chance(0.3)) m.presence.worldFromSecondTool = within(frame, range);
    const std::uint32_t first = number(16000);
    for (std::size_t i = 0; i < parts; ++i) {
      PartState state;
      state.part = static_cast<PartId>(first + i);
      state.epoch = number(1u << (1 + number(31)));
      state.sequence = number(1u << (1 + number(31)));
      state.worldFromPart = within(frame, range);
      if (chance(0.7)) state.twist = {vector(7.9), vector(63.0)};
      m.parts.push_back(state);
    }
    return m;
  }

 private:
  Pose within(const WireFrame& frame, double range) {
    Pose p = pose(range);
    p.position += frame.centre;
    return p;
  }
  std::mt19937_64 random_;
};

}  // namespace tandem::sync::testing
