#pragma once

// Which parts of the scene this hand asks for on its own: controls that the tool presses on or that are to be
// set to a value, parts that are to be moved back to where they stood, and parts that would give way to what
// it pushes. They are owned without a grasp, and
// released like every part once they rest.
//
// Runs in the haptic thread; allocates nothing.

#include <array>
#include <optional>
#include <span>

#include "assets/scene/scene.h"
#include "client/session/exchange.h"
#include "haptics/tick.h"

namespace tandem::client {

class ControlHand {
 public:
  explicit ControlHand(const assets::Scene& scene) : scene_(scene) {}

  /// Notes the value that a control is to have, clamped to its range. No effect if the part is not a
  /// control's, or for a ninth at once.
  void set(PartId part, double value);

  /// Notes the pose at which a part is to be released again. It stays where it is if it is granted in another
  /// epoch than the next one after `after`: somebody has had it meanwhile.
  void place(PartId part, const Pose& worldFromPart, Epoch after);

  /// The part to ask the server for now, one a call: the last tick pressed on it, or it is to be set, and it
  /// is neither owned here nor asked for. A denied part is asked for again when the tool comes back to it.
  /// `owned(part)`: whether this site owns the part.
  template <typename Owned>
  PartId wanted(const haptics::TickOutput& last, const Owned& owned) {
    if (scene_.controls.empty() && last.pushedCount == 0 && !any()) return kNoPart;
    forgetUntouched(last);
    for (Entry& entry : entries_)
      if (entry.part != kNoPart && entry.stage == Stage::wanted && !owned(entry.part)) return ask(entry);
    for (const PartId part : pressed(last))
      if (part != kNoPart && !find(part) && !owned(part))
        if (Entry* entry = add(part)) return ask(*entry);
    return kNoPart;
  }
  /// The request could not be sent: it is repeated.
  void askLater(PartId part);

  /// Whether this hand asked for the part.
  bool asked(PartId part) const;
  /// The server has denied or revoked the part: it is not asked for again until the tool has left it.
  void denied(PartId part);
  /// The connection is lost: no request will be answered.
  void lost();
  /// The part is granted in this epoch, or owned already (0). Returns the pose at which to own it, if a value
  /// is to be set or it is to be placed, and drops the part from the list.
  std::optional<Pose> granted(PartId part, Epoch epoch = 0);
  /// A control that is owned here and is to be set.
  template <typename Owned>
  std::optional<PartId> toSet(const Owned& owned) const {
    for (const Entry& entry : entries_)
      if (entry.part != kNoPart && entry.hasValue && owned(entry.part)) return entry.part;
    return std::nullopt;
  }

 private:
  enum class Stage : std::uint8_t { wanted, asked, denied };
  struct Entry {
    PartId part = kNoPart;
    Stage stage = Stage::wanted;
    bool hasValue = false;
    double value = 0.0;
    Epoch placedIn = 0;  // the epoch in which it is to be moved to worldFromPart; 0: it is not
    Pose worldFromPart{};
  };
  static constexpr std::size_t kAtOnce = 8;

  using Pressed = std::array<PartId, haptics::kMaxContacts + haptics::kMaxPushed>;
  bool any() const;
  Pressed pressed(const haptics::TickOutput& last) const;
  void forgetUntouched(const haptics::TickOutput& last);
  PartId ask(Entry& entry);
  Entry* find(PartId part);
  Entry* add(PartId part);

  const assets::Scene& scene_;
  std::array<Entry, kAtOnce> entries_;
};

}  // namespace tandem::client
