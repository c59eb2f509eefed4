#include "client/session/shown_clash.h"

namespace tandem::client {

using sync::ClashMark;

void putClash(const Clash& clash, const Pose& worldFromA, const Pose& worldFromB, sync::Inspection& looks) {
  looks.a = clash.a;
  looks.b = clash.b;
  looks.onA = transformPoint(inverse(worldFromA), clash.onA);
  looks.onB = transformPoint(inverse(worldFromB), clash.onB);
  looks.moved = false;
  looks.amount = 0.0;
  if (clash.kind == ClashKind::touch) {
    looks.mark = ClashMark::touch;
  } else if (clash.kind == ClashKind::clearance) {
    looks.mark = ClashMark::clearance;
    looks.amount = clash.distance;
  } else {
    looks.mark = clash.open ? ClashMark::unknownDepth : ClashMark::depth;
    if (!clash.open) looks.amount = clash.depth;
  }
}

Clash clashIn(const sync::Inspection& looks) {
  Clash clash;
  clash.a = looks.a;
  clash.b = looks.b;
  clash.open = looks.mark == ClashMark::unknownDepth;
  clash.kind = looks.mark == ClashMark::touch       ? ClashKind::touch
               : looks.mark == ClashMark::clearance ? ClashKind::clearance
                                                    : ClashKind::hard;
  (clash.kind == ClashKind::clearance ? clash.distance : clash.depth) = looks.amount;
  return clash;
}

}  // namespace tandem::client
