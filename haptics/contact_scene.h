#pragma once

// The geometry of a scene made ready for contact: one triangle BVH a mesh (shared by its instances), the
// parts, their materials. Immutable but for refitMesh(): any number of hands, in any threads, may feel one
// ContactScene.

#include <cstddef>
#include <memory>

#include "assets/scene.h"

namespace tandem::haptics {

class ContactScene {
 public:
  /// Builds the BVHs on up to `threads` threads (0 = all cores). Keeps a reference to `scene`, which must
  /// outlive this.
  explicit ContactScene(const assets::Scene& scene, int threads = 0);
  ~ContactScene();
  ContactScene(ContactScene&&) noexcept;
  ContactScene& operator=(ContactScene&&) noexcept;

  const assets::Scene& scene() const;
  /// Bytes held for contact: in all, with the meshes that are kept alive here, or of one scene mesh's tree.
  std::size_t memory() const;
  std::size_t memory(std::uint32_t mesh) const;

  /// The same scene with one of its meshes, used by some part, replaced: tessellated anew, deformed, or
  /// another shape. All other trees are shared. Builds a tree, so that any thread may call it while ticks of
  /// other threads run on this one; the thread that ticks then takes the result over, see TickState::adopt().
  /// Keeps `replacement` alive.
  ContactScene withMesh(std::uint32_t mesh, std::shared_ptr<const assets::Mesh> replacement,
                        int threads = 0) const;

  /// After positions of a mesh (of the Scene, or of a replacement) have changed in place, the triangles being
  /// the same: fits its tree and its parts anew, see TriangleBvh::refit(). While no tick of any hand runs on
  /// this scene or on another that shares the tree: either between ticks, then TickState::meshesChanged() for
  /// each hand; or on a spare made by withMesh(), which the hands adopt when it is ready while the other
  /// becomes the spare. Not from within a tick: it takes a millisecond or more, and if a part of this mesh
  /// has a shaded or textured surface it derives those of the whole scene anew.
  void refitMesh(std::uint32_t mesh, int threads = 0);

  struct Data;
  const Data& data() const { return *data_; }

 private:
  ContactScene();

  std::unique_ptr<Data> data_;
};

}  // namespace tandem::haptics
