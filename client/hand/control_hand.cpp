#include "client/hand/control_hand.h"

#include <algorithm>
#include <cmath>

namespace tandem::client {

void ControlHand::set(PartId part, double value) {
  const assets::Control* control = assets::controlOf(scene_, part);
  if (control == nullptr || !std::isfinite(value)) return;
  Entry* entry = find(part);
  if (entry == nullptr) entry = add(part);
  if (entry == nullptr) return;
  if (entry->stage == Stage::denied) entry->stage = Stage::wanted;
  entry->hasValue = true;
  entry->value = assets::admissible(*control, value);
}

void ControlHand::place(PartId part, const Pose& worldFromPart, Epoch after) {
  if (part >= scene_.parts.size() || !scene_.parts[part].movable) return;
  Entry* entry = find(part);
  if (entry == nullptr) entry = add(part);
  if (entry == nullptr) return;
  if (entry->stage == Stage::denied) entry->stage = Stage::wanted;
  entry->placedIn = after + 1;
  entry->worldFromPart = worldFromPart;
}

void ControlHand::askLater(PartId part) {
  if (Entry* entry = find(part)) entry->stage = Stage::wanted;
}

bool ControlHand::asked(PartId part) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const Entry& e) { return e.part == part && e.stage == Stage::asked; });
}

void ControlHand::denied(PartId part) {
  Entry* entry = find(part);
  if (entry == nullptr && assets::controlOf(scene_, part) != nullptr) entry = add(part);
  if (entry != nullptr) *entry = {part, Stage::denied, false, 0.0, 0, {}};
}

void ControlHand::lost() { entries_.fill({}); }

std::optional<Pose> ControlHand::granted(PartId part, Epoch epoch) {
  Entry* entry = find(part);
  if (entry == nullptr) return std::nullopt;
  const Entry was = *entry;
  *entry = {};
  if (was.placedIn != 0 && was.placedIn == epoch) return was.worldFromPart;
  if (!was.hasValue) return std::nullopt;
  return assets::poseAt(*assets::controlOf(scene_, part), was.value);
}

bool ControlHand::any() const {
  return std::any_of(entries_.begin(), entries_.end(), [](const Entry& e) { return e.part != kNoPart; });
}

ControlHand::Pressed ControlHand::pressed(const haptics::TickOutput& last) const {
  Pressed parts;
  parts.fill(kNoPart);
  for (std::size_t i = 0; i < static_cast<std::size_t>(last.contactCount); ++i) {
    const haptics::Contact& contact = last.contacts[i];
    if (contact.force > 0.0 && assets::controlOf(scene_, contact.part) != nullptr) parts[i] = contact.part;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(last.pushedCount); ++i)
    parts[haptics::kMaxContacts + i] = last.pushed[i];
  return parts;
}

/// A denial holds for as long as the tool stays on the control.
void ControlHand::forgetUntouched(const haptics::TickOutput& last) {
  const auto touched = pressed(last);
  for (Entry& entry : entries_)
    if (entry.stage == Stage::denied &&
        std::find(touched.begin(), touched.end(), entry.part) == touched.end())
      entry = {};
}

PartId ControlHand::ask(Entry& entry) {
  entry.stage = Stage::asked;
  return entry.part;
}

ControlHand::Entry* ControlHand::find(PartId part) {
  for (Entry& entry : entries_)
    if (entry.part == part) return &entry;
  return nullptr;
}

ControlHand::Entry* ControlHand::add(PartId part) {
  Entry* entry = find(kNoPart);
  if (entry != nullptr) *entry = {part, Stage::wanted, false, 0.0, 0, {}};
  return entry;
}

}  // namespace tandem::client
