#pragma once

// The session's document on its way to what a person sees, and a person's changes on their way back.

#include <cstddef>
#include <string>
#include <vector>

#include "assets/document/document.h"

namespace tandem::client {

/// What this person wants done to the document.
struct DocumentWish {
  enum class Kind : std::uint8_t { change, undo, redo };
  Kind kind = Kind::change;
  document::Change change;  // of the kind `change`
};

/// Entries that were told since the last news, oldest change first.
struct DocumentNews {
  bool anew = false;  // what was told before is void
  std::vector<document::Entry> entries;
};

/// How this site stands to the document.
struct DocumentStanding {
  bool complete = false;   // all is there that the server has told
  std::size_t unsent = 0;  // wishes that are not answered yet
  std::string undo, redo;  // what would be undone and done again, in words; empty: nothing
};

}  // namespace tandem::client
