#include "sync/wire/ownership_messages.h"

namespace tandem::sync {

const char* toString(Denial denial) {
  switch (denial) {
    case Denial::none:
      return "granted";
    case Denial::ownedByOther:
      return "somebody else holds it";
    case Denial::roleForbids:
      return "this role may not move it";
    case Denial::notMovable:
      return "the part cannot be moved";
    case Denial::unknownPart:
      return "there is no such part";
    case Denial::recovering:
      return "the server waits for earlier owners to come back";
    case Denial::stale:
      return "that ownership is over";
    case Denial::notOwned:
      return "nobody else owns it";
    case Denial::crowded:
      return "as many hold it as may";
  }
  return "unknown denial";
}

}  // namespace tandem::sync
