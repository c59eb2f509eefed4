#pragma once

// Who holds which part with whom, in words for a person: for the window, the table in the terminal and
// replays. Only sites that the session knows are named.

#include <string>

#include "client/session/view_model.h"

namespace tandem::client {

/// Name of a part; empty for none.
std::string partName(const ViewModel& model, PartId part);

/// "ada", "ada with ben" or "ada with ben and cy", the owner first; empty for a part that nobody has.
std::string holdersInWords(const ViewModel& model, PartId part);

/// What a site has: "holds block", "holds block with ben" or "holds 3 parts, block with ben and lid with ben
/// and cy"; empty for nothing. A co-holder counts like an owner, unless its tool pushes the part: "pushes
/// block, which ada holds".
std::string holdingInWords(const ViewModel& model, const SiteView& site);

/// With whom this site's hand holds its part, and how stiffly they feel each other: "with ben: stiff
/// (27 ms)"; empty while nobody else has it.
std::string sharingInWords(const ViewModel& model);

}  // namespace tandem::client
