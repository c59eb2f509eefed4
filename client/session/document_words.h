#pragma once

// Entries of the session's document in words: for the window, the table in the terminal and notices.

#include <string>

#include "assets/document/document.h"
#include "client/session/view_model.h"

namespace tandem::client {

/// "note \"the bolt is loose\"", "view \"from below\"", "reply \"which one?\"": the kind, and what it says,
/// cut to some forty characters.
std::string inWords(const document::Body& body);

/// "12 entries, the last by ada: note \"the bolt is loose\""; "empty" without entries.
std::string inWords(const document::Document& document);

/// The name of this site's person; empty without a session.
std::string ownName(const ViewModel& model);

/// The first `most` bytes of a text at most, cut between characters, in one line.
std::string shortened(const std::string& text, std::size_t most);

}  // namespace tandem::client
