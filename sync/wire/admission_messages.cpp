#include "sync/wire/admission_messages.h"

namespace tandem::sync {

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
    case Refusal::removed:
      return "removed by the operator";
  }
  return "unknown refusal";
}

}  // namespace tandem::sync
