#include "sync/wire/participant_messages.h"

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

}  // namespace tandem::sync
