#pragma once

// What an instructor may command, and the answer.

#include <string>

#include "sync/wire/ownership_messages.h"

namespace tandem::sync {

/// An instructor takes a part away from its owner. Answered by a CommandReply.
struct Revoke {
  RequestId request = 0;
  PartId part = kNoPart;
};
/// An instructor puts every part that nobody owns back to its pose in the scene. Answered by a CommandReply.
struct ResetParts {
  RequestId request = 0;
};
struct CommandReply {
  RequestId request = 0;
  bool done = false;
  std::string reason;
};

}  // namespace tandem::sync
