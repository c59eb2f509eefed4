#include "haptics/section_change.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/tick_data.h"

namespace tandem::haptics {
namespace {

using Data = TickState::Data;

// The proxy may take some ticks to find its place after sections have moved; it has when the force differs by
// less than kSettled from tick to tick.
constexpr int kSettleTicks = 50;
constexpr double kSettled = 1e-4;  // N

bool areSame(const Sections& last, std::span<const Section> sections) {
  return std::equal(last.begin(), last.end(), sections.begin(), sections.end());
}

bool arePlanes(std::span<const Section> sections) {
  return sections.size() <= kMaxSections &&
         std::all_of(sections.begin(), sections.end(), [](const Section& section) {
           return std::abs(glm::length(section.normal) - 1.0) < 1e-6 && std::isfinite(section.offset);
         });
}

void cut(std::span<const Section> sections, Data& data) {
  Sections now;
  for (const Section& section : sections) now.push_back(section);
  data.tool.cut(now);
  data.bridging = kSettleTicks;
}

/// A part that pressed where the scene is cut away now is held anew where it is, or the hand's spring would
/// shoot it forward; the force of the old grasp fades.
void cutHeldParts(int hands, Data& data) {
  for (const SimulatedPart& entry : data.held.parts())
    if (entry.moved.control == nullptr) data.partContact->sectionsMoved(entry.part, entry.body.centreOfMass);
  for (int h = 0; h < hands; ++h) {
    const PartId held = data.held.held(h);
    if (held == kNoPart || !data.partContact->pressesWhereCut(held)) continue;
    Hand& hand = data.hands[static_cast<std::size_t>(h)];
    hand.endCoupling(data.held.letGo(hand.parameters(), h) ? 2.0 : 1.0);
    data.held.grasp(held, hand.device().worldFromDevice, hand.parameters(), h);
  }
}

}  // namespace

bool sectionsChange(std::span<const Section> sections, const Data& data) {
  return data.bridging > 0 || !areSame(data.world.sections(), sections);
}

bool changeSections(std::span<const Section> sections, int hands, Data& data) {
  const bool moved = !areSame(data.world.sections(), sections), usable = arePlanes(sections);
  if (moved && usable) cut(sections, data);
  if (moved && data.partContact != nullptr) cutHeldParts(hands, data);
  if (data.bridging > 0) data.tool.noteNewGround();
  data.bridging = std::max(0, data.bridging - 1);
  return usable;
}

void bridgeSections(const TickParameters& parameters, double spring, Data& data) {
  const glm::dvec3 last = data.tool.contactWrench().force, now = data.tool.contactAnew(parameters).force;
  if (glm::length(now - last) >= kSettled) data.hands[0].bridge(last, now, spring);
}

}  // namespace tandem::haptics
