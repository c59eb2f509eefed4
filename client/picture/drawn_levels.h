#pragma once

// What is drawn in place of the large meshes of a large scene: a stand-in at once, levels as the worker has
// made them, the exact mesh where nothing less will do. Needs the context that made it to be current.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/levels/level_maker.h"
#include "client/picture/gpu_mesh.h"

namespace tandem::client {

/// How finely a scene is drawn.
struct Detail {
  bool levels = false;         // large meshes of a large scene by levels; else everything as it is
  std::string cacheDirectory;  // for levels; empty: none is used
};

class DrawnLevels {
 public:
  /// Nothing for a scene that is drawn as it is: one of fewer triangles than kLargeScene, counting instances,
  /// or without a large mesh.
  static std::unique_ptr<DrawnLevels> of(const assets::Scene& scene, const Detail& detail);

  bool has(std::uint32_t mesh) const { return mesh < owner_.size() && owner_[mesh] != assets::kNone; }
  /// Begins a frame: uploads what has been made, a few ms of it. Whether pictures change by it.
  bool receive();
  /// What part `part`, of a mesh that this has, is drawn with where a pixel is `pixel` m; `exact`: nothing
  /// else but the exact mesh will do, as soon as it is there.
  const GpuMesh& meshFor(std::uint32_t part, std::uint32_t mesh, double pixel, bool exact);

  void notShown(std::uint32_t part) { pixelsOff_[part] = 0.0; }
  /// Pixels by which what meshFor() last gave for a part may be off. 0: it was the exact mesh.
  double pixelsOff(std::uint32_t part) const { return pixelsOff_[part]; }
  std::size_t meshesLeft() const { return maker_->left(); }

 private:
  /// A distinct mesh. Levels: finest first, the stand-in last until there are others.
  struct Shape {
    std::vector<GpuMesh> levels;
    std::vector<double> errors;
    std::optional<GpuMesh> exact;
    std::uint64_t exactUsed = 0;  // the frame in which it was drawn last
    bool exactAsked = false, standsIn = true;
    std::uint64_t urgentIn = 0;  // the frame in which `urgency` was found
    double urgency = 0.0;        // pixels off, of the worst part
  };

  DrawnLevels(const assets::Scene& scene, std::vector<std::uint32_t> large, const Detail& detail);
  void makeStandIns(const std::vector<LevelMaker::Source>& meshes);
  void add(LevelMaker::Made made);
  void dropOldExact();
  void askExact(Shape& shape, std::uint32_t mesh);

  const assets::Scene& scene_;
  std::vector<std::uint32_t> owner_;  // of each mesh of the scene: the one whose shape it shares, or kNone
  std::vector<Shape> shapes_;         // of each mesh of the scene; those of owners are filled
  std::vector<std::uint8_t> last_;    // of each part: the level drawn last
  std::vector<double> pixelsOff_;     // of each part
  std::uint64_t frame_ = 0;
  std::unique_ptr<LevelMaker> maker_;
};

}  // namespace tandem::client
