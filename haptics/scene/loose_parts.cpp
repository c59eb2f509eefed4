#include "haptics/scene/loose_parts.h"

namespace tandem::haptics {

LooseParts::LooseParts(std::size_t parts) : reach_(parts, -1.0), movedIn_(parts, 0), slot_(parts, 0) {
  ids_.reserve(parts);
  near_.reserve(parts);
}

void LooseParts::loosen(PartId part) {
  slot_[part] = static_cast<std::uint32_t>(ids_.size());
  ids_.push_back(part);
}

void LooseParts::drop(PartId part) {
  if (!isLoose(part)) return;
  listed_ -= movedIn_[part] == now_ ? 1u : 0u;
  movedIn_[part] = 0;
  ids_[slot_[part]] = ids_.back();
  slot_[ids_.back()] = slot_[part];
  ids_.pop_back();
}

}  // namespace tandem::haptics
