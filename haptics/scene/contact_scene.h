#pragma once

// The geometry of a scene made ready for contact: one triangle BVH a mesh (shared by its instances), the
// parts, their materials. Immutable but for refitMesh(): any number of hands, in any threads, may feel one
// ContactScene.

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// How ContactScene::modelParts() works.
struct ModelOptions {
  std::string cacheDirectory;  // where distance fields are kept; empty: nowhere, all are made anew
  int threads = 0;             // 0 = all cores
  double fieldScale = 1.0;     // tolerance and smallest cell of the fields, times what the scene asks for
  double sampleScale = 1.0;    // spacing of the contact samples, times what the mesh asks for
  bool onlyCached = false;     // makes nothing: a mesh whose field is not in the cache gets no model
  /// Told the share done, 0..1, and what is being done, from the calling thread; false stops, which may take
  /// as long as the mesh that is under way.
  std::function<bool(double, const char*)> progress;
};

class ContactScene {
 public:
  /// Builds the BVHs on up to `threads` threads (0 = all cores). Keeps a reference to `scene`, which must
  /// outlive this.
  explicit ContactScene(const assets::Scene& scene, int threads = 0);
  ~ContactScene();
  ContactScene(ContactScene&&) noexcept;
  ContactScene& operator=(ContactScene&&) noexcept;

  const assets::Scene& scene() const;
  /// Bytes held for contact: in all, with the meshes that are kept alive here, or of one scene mesh's tree and
  /// model.
  std::size_t memory() const;
  std::size_t memory(std::uint32_t mesh) const;

  /// The same scene with one of its meshes, used by some part, replaced: tessellated anew, deformed, or
  /// another shape. All other trees are shared. Builds a tree, so that any thread may call it while ticks of
  /// other threads run on this one; the thread that ticks then takes the result over, see TickState::adopt().
  /// Keeps `replacement` alive. The new scene has no part model of this mesh: a part of it in the hand passes
  /// through others (kFlagHeldWithoutContact), and others in the hand through it. Models of other meshes stay.
  ContactScene withMesh(std::uint32_t mesh, std::shared_ptr<const assets::Mesh> replacement,
                        int threads = 0) const;

  /// After positions of a mesh (of the Scene, or of a replacement) have changed in place, the triangles being
  /// the same: fits its tree and its parts anew, see TriangleBvh::refit(). While no tick of any hand runs on
  /// this scene or on another that shares the tree: either between ticks, then TickState::meshesChanged() for
  /// each hand; or on a spare made by withMesh(), which the hands adopt when it is ready while the other
  /// becomes the spare. Not from within a tick: it takes a millisecond or more, and if a part of this mesh
  /// has a shaded or textured surface it derives those of the whole scene anew. Drops the mesh's part model, as
  /// withMesh() does.
  void refitMesh(std::uint32_t mesh, int threads = 0);

  /// Makes the models by which a part in the hand collides with others: seconds for large scenes, a share of
  /// that from the cache. Without them it passes through; a scene without movable parts needs none. False if
  /// `options.progress` stopped it: there are none then. Once, before any TickState is made for this scene and
  /// before any withMesh() or refitMesh().
  bool modelParts(const ModelOptions& options = {});

  struct Data;
  const Data& data() const { return *data_; }

 private:
  ContactScene();

  std::unique_ptr<Data> data_;
};

}  // namespace tandem::haptics
