#pragma once

// Names of parts in a message to all: each in square brackets is a link to the part that bears it.

#include <string>
#include <vector>

#include "assets/scene/scene.h"
#include "sync/wire/presentation_messages.h"

namespace tandem::client {

/// A piece of a message, in its order: plain text, or a link to a part.
struct SaidPiece {
  std::string text;
  PartId part = kNoPart;  // none: plain text
};

/// The message with the parts that its bracketed names name; a name that no part bears is no link.
sync::Say saidWithLinks(const std::string& text, const assets::Scene& scene);
/// The pieces of a message. A link is what has a part of the scene, and shows that part's name.
std::vector<SaidPiece> piecesOf(const sync::Say& said, const assets::Scene& scene);
/// The message without the brackets around its links, as a line of text has it.
std::string inWords(const sync::Say& said);

}  // namespace tandem::client
