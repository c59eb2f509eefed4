#pragma once

// What a tick does about section planes that change, so that no hand is kicked by them.

#include <span>

#include "haptics/tick.h"

namespace tandem::haptics {

/// Whether the sections differ from those of the last tick, or the proxy still finds its place among them.
bool sectionsChange(std::span<const Section> sections, const TickState::Data& data);

/// Cuts the scene by these sections from now on, for so many hands. False if they are not planes: nothing
/// changes then.
bool changeSections(std::span<const Section> sections, int hands, TickState::Data& data);

/// What sections that move change of the contact force, in this tick and while the proxy finds its new place,
/// is bridged by a spring of `spring` N/m.
void bridgeSections(const TickParameters& parameters, double spring, TickState::Data& data);

}  // namespace tandem::haptics
