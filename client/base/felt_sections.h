#pragma once

// Section planes as the document and the window have them, for the haptic tick.

#include <span>

#include "assets/document/entry.h"
#include "haptics/base/section.h"

namespace tandem::client {

/// At most kMaxSections. Planes without a direction are left out.
haptics::Sections feltSections(std::span<const document::SectionPlane> planes);

}  // namespace tandem::client
