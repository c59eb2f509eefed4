#pragma once

// The geometry of a scene made ready for contact: one triangle BVH a mesh (shared by its instances), the parts, their
// materials. Immutable but for refitMesh(): any number of hands, in any threads, may feel one
// ContactScene.

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

  /// After positions of Scene::meshes[mesh] have changed in place, the triangles being the same: fits its tree and its
  /// parts anew, see TriangleBvh::refit(). Between ticks: while no tick of any hand on this scene runs. Then
  /// TickState::meshesChanged() for each of those hands, before its next tick. Shading and textures keep what they
  /// derived from the mesh as it was.
  void refitMesh(std::uint32_t mesh, int threads = 0);

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

}  // namespace tandem::haptics
