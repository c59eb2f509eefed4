#pragma once

// The geometry of a scene prepared for contact: one triangle BVH per mesh (shared by its instances), the
// parts and their materials. Immutable except for refitMesh(), so any number of hands in any threads may
// share one ContactScene.

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "assets/scene/scene.h"

namespace tandem::haptics {

struct PartModel;

/// Options of ContactScene::modelParts().
struct ModelOptions {
  std::string cacheDirectory;  // where distance fields are cached; empty: nowhere
  int threads = 0;             // 0 = all cores
  double fieldScale = 1.0;     // factor on the tolerance and smallest cell of the fields
  double sampleScale = 1.0;    // factor on the spacing of the contact samples
  bool onlyCached = false;     // a mesh whose field is not in the cache gets no model
  bool coarse = false;         // models that are there at once and cost more to feel, see ModelRefiner
  /// Receives the share done, 0..1, and a description, in the calling thread. False stops, possibly only
  /// after the current mesh.
  std::function<bool(double, const char*)> progress;
};

/// Least radius with which a tool is swept, as a share of the coordinates that place a part's surface. Files
/// state these as floats, which are off by up to 2^-24 of their size: no tool of this radius falls through
/// the cracks that rounding leaves between triangles and between parts.
inline constexpr double kLeastToolShare = 0x1p-20;

class ContactScene {
 public:
  /// Builds the BVHs on up to `threads` threads (0 = all cores). Keeps a reference to `scene`, which must
  /// outlive this object. `leastToolShare` is for tests.
  explicit ContactScene(const assets::Scene& scene, int threads = 0, double leastToolShare = kLeastToolShare);
  ~ContactScene();
  /// The same scene: trees and models are shared.
  ContactScene(const ContactScene& other);
  ContactScene(ContactScene&&) noexcept;
  ContactScene& operator=(ContactScene&&) noexcept;

  const assets::Scene& scene() const;
  /// Bytes held for contact: in total, including meshes kept alive here, or of one scene mesh's tree and
  /// model.
  std::size_t memory() const;
  std::size_t memory(std::uint32_t mesh) const;

  /// The same scene with the mesh of some part replaced: tessellated anew, deformed, or another shape. All
  /// other trees are shared. This builds a tree, so any thread may call it while other threads tick on this
  /// scene; the ticking thread then adopts the result, see TickState::adopt(). Keeps `replacement` alive. The
  /// new scene has no part model of this mesh: a held part of it passes through others
  /// (kFlagHeldWithoutContact) and others pass through it. Models of other meshes stay.
  ContactScene withMesh(std::uint32_t mesh, std::shared_ptr<const assets::Mesh> replacement,
                        int threads = 0) const;

  /// Refits the tree and the parts of a mesh (of the Scene, or of a replacement) after its positions have
  /// changed in place with the same triangles, see TriangleBvh::refit(). No tick of any hand may run on this
  /// scene or on another that shares the tree. Call it between ticks, followed by TickState::meshesChanged()
  /// for each hand, or on a spare made by withMesh(), which the hands adopt when ready while the other
  /// becomes the spare. Never call it within a tick: it takes a millisecond or more, and derives the shaded
  /// or textured surfaces of the whole scene again if a part of this mesh has one. Drops the mesh's part
  /// model, like withMesh().
  void refitMesh(std::uint32_t mesh, int threads = 0);

  /// Makes the models by which a held part collides with others, which takes seconds for large scenes and
  /// less with a cache. Without them a held part passes through others; a scene without movable parts needs
  /// none. False if `options.progress` stopped it, and no models exist then. Call it once, before any
  /// TickState is made for this scene and before any withMesh() or refitMesh().
  bool modelParts(const ModelOptions& options = {});

  /// The same scene with a model refined: that of tree `tree` is `model`, which has the features of the one
  /// before. Between ticks the ticking thread passes on to it, see TickState::refine(). Any thread.
  ContactScene withModel(std::size_t tree, std::shared_ptr<const PartModel> model) const;

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

}  // namespace tandem::haptics
