#pragma once

// What the parts' meshes lack to be closed (haptics/overlap/mesh_closing.h), found once for each mesh,
// when it is first needed.
//
// 1. Safe in every thread. The geometry must outlive it, and its meshes must not change.

#include <memory>
#include <vector>

#include "assets/base/ids.h"
#include "haptics/overlap/mesh_closing.h"

namespace tandem::haptics {
class ContactScene;
}

namespace tandem::client {

class PartClosings {
 public:
  explicit PartClosings(const haptics::ContactScene& contact);
  ~PartClosings();
  PartClosings(const PartClosings&) = delete;
  PartClosings& operator=(const PartClosings&) = delete;

  const haptics::ContactScene& contact() const { return contact_; }
  /// Of a part that has geometry.
  const haptics::MeshClosing& of(PartId part) const;

 private:
  struct Entry;
  const haptics::ContactScene& contact_;
  std::vector<std::size_t> entryOf_;  // a part; instances share one
  std::unique_ptr<Entry[]> entries_;
};

}  // namespace tandem::client
