#include "client/review/part_closings.h"

#include <map>
#include <mutex>
#include <optional>

#include "assets/base/assert.h"
#include "haptics/scene/contact_scene_data.h"

namespace tandem::client {

struct PartClosings::Entry {
  std::once_flag made;
  std::optional<haptics::MeshClosing> closing;
};

PartClosings::PartClosings(const haptics::ContactScene& contact) : contact_(contact) {
  std::map<const haptics::TriangleBvh*, std::size_t> known;
  for (const haptics::Collider& collider : contact.data().colliders)
    entryOf_.push_back(known.emplace(collider.tree, known.size()).first->second);
  entries_ = std::make_unique<Entry[]>(known.size());
}
PartClosings::~PartClosings() = default;

const haptics::MeshClosing& PartClosings::of(PartId part) const {
  ASSERT(part < entryOf_.size() && contact_.data().colliders[part].tree != nullptr);
  Entry& entry = entries_[entryOf_[part]];
  std::call_once(entry.made, [&] { entry.closing.emplace(*contact_.data().colliders[part].tree); });
  return *entry.closing;
}

}  // namespace tandem::client
