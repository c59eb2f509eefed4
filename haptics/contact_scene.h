#pragma once

// The geometry of a scene made ready for contact: one triangle BVH a mesh (shared by its instances), the parts, their
// materials. Built once, then immutable: any number of hands, in any threads, may feel one ContactScene.

#include <cstddef>
#include <functional>
#include <memory>

#include "assets/scene.h"

namespace tandem::haptics {

class ContactScene {
 public:
  /// Builds the BVHs on up to `threads` threads (0 = all cores). Keeps a reference to `scene`, which must outlive this.
  explicit ContactScene(const assets::Scene& scene, int threads = 0);
  ~ContactScene();
  ContactScene(ContactScene&&) noexcept;
  ContactScene& operator=(ContactScene&&) noexcept;

  const assets::Scene& scene() const;
  /// Bytes held for contact, of one part's mesh or in all.
  std::size_t memory() const;
  std::size_t memory(std::uint32_t mesh) const;

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

}  // namespace tandem::haptics
