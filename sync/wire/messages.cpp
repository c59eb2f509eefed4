#include "sync/wire/messages.h"

namespace tandem::sync {

const char* toString(Role role) {
  switch (role) {
    case Role::observer:
      return "observer";
    case Role::participant:
      return "participant";
    case Role::instructor:
      return "instructor";
  }
  return "unknown role";
}

const char* toString(Refusal refusal) {
  switch (refusal) {
    case Refusal::protocolVersion:
      return "other protocol version";
    case Refusal::badCredential:
      return "credential not valid";
    case Refusal::expired:
      return "credential expired";
    case Refusal::alreadyUsed:
      return "credential already used";
    case Refusal::sessionFull:
      return "session full";
    case Refusal::unexpectedMessage:
      return "unexpected message";
    case Refusal::malformed:
      return "malformed message";
  }
  return "unknown refusal";
}

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
  }
  return "unknown denial";
}

}  // namespace tandem::sync
