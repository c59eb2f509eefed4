#pragma once

// Draws the parts of a scene, whole or cut open by section planes: shaded surfaces, feature edges, marks of
// ownership and selection; answers which part is under a pixel. Needs the context that made it to be current.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "assets/document/entry.h"
#include "client/levels/triangle_runs.h"
#include "client/picture/camera.h"
#include "client/picture/drawn_levels.h"

namespace tandem::client {

/// How one part is drawn in this frame.
struct PartLook {
  bool visible = true;
  bool pickable = true;  // while it is visible
  float alpha = 1.0f;
  glm::vec3 tint{0.0f};        // linear
  float tintAmount = 0.0f;     // 0..1, of the surface
  float rimAmount = 0.0f;      // 0..1, of the silhouette's glow
  glm::vec3 edgeColour{0.0f};  // sRGB
  float edgeWidth = 0.0f;      // pixels; 0 = thin and dark, as all unmarked edges
  friend bool operator==(const PartLook&, const PartLook&) = default;
};

struct Background {
  glm::vec3 top{0.0f}, bottom{0.0f};  // sRGB
};

/// What is under a pixel.
struct Hit {
  PartId part = kNoPart;
  glm::dvec3 point{0.0, 0.0, 0.0};  // world
  double depth = 0.0;               // m, from the eye
};

class SceneRenderer {
 public:
  /// Uploads every mesh that is drawn as it is; `scene` must outlive this object.
  static Result<std::unique_ptr<SceneRenderer>> make(const assets::Scene& scene, const Detail& detail = {});

  /// Takes what has been made of the scene's levels since the last call.
  void receive();
  /// Changes when the same parts in the same view would be drawn by other levels.
  std::uint64_t detailVersion() const { return detailVersion_; }
  /// Pixels by which parts of the last picture may be off at most; meshes whose levels are still to come.
  double pixelsOff() const;
  std::size_t meshesLeft() const { return levels_ ? levels_->meshesLeft() : 0; }

  /// The largest distance from a point to anything of the parts at these poses, m.
  double reachFrom(const glm::dvec3& centre, std::span<const Pose> worldFromPart) const;
  /// The box around the chosen parts, world.
  assets::Bounds bounds(std::span<const Pose> worldFromPart, std::span<const PartId> parts) const;

  /// What lies in front of any of these planes (at most kMaxSections) is neither drawn nor picked from now
  /// on. The cut through a closed mesh is covered in the part's colour; that through an open one is not, for
  /// nothing says where its inside is.
  void setSections(std::span<const document::SectionPlane> sections);
  std::span<const document::SectionPlane> sections() const { return sections_; }

  void drawBackground(const Background& background) const;
  /// Draws these parts, opaque ones first, into the bound framebuffer.
  void draw(const View& view, std::span<const Pose> worldFromPart, std::span<const PartLook> looks,
            std::span<const PartId> parts, bool edges) const;
  /// The nearest visible part under a pixel. Draws only what a ray through the pixel may meet; waits for the
  /// GPU.
  std::optional<Hit> pick(const View& view, const glm::dvec2& pixel, std::span<const Pose> worldFromPart,
                          std::span<const PartLook> looks);

 private:
  struct DrawnMesh {
    GpuMesh gpu;  // empty where levels are drawn
    bool closed = false;
    Sphere sphere;          // part frame
    assets::Bounds bounds;  // part frame
  };
  struct Programs {
    GlProgram part, thinLine, wideLine, pick;
  };
  /// Which of the section planes cut what is drawn.
  enum class Cut { none, all, one, allButOne };

  SceneRenderer(const assets::Scene& scene, const Detail& detail, GlProgram background, Programs whole,
                Programs cut);
  static Result<Programs> makePrograms(const char* sections);
  /// The programs that draw parts as they are cut now.
  const Programs& programs() const { return sections_.empty() ? whole_ : cut_; }
  void useCut(Cut cut, std::size_t one = 0) const;
  void lookAround(std::span<const Pose> worldFromPart) const;
  void setPlanes(const GlProgram& program, const View& view) const;
  /// Covers the cuts through a part with what `program` draws; `drawMesh` draws its triangles with the same.
  template <typename DrawMesh>
  void drawCaps(const View& view, const GlProgram& program, PartId part, const Pose& worldFromPart,
                DrawMesh drawMesh) const;
  void addShapes(const assets::Part& part, double extent);
  const DrawnMesh* meshOf(PartId part) const;
  bool drawnByLevels(PartId part) const { return levels_ && levels_->has(meshOfPart_[part]); }
  /// What a part is drawn with in this view; `sphere` is its own.
  const GpuMesh& choose(const View& view, PartId part, const Sphere& sphere) const;
  bool isCut(const Sphere& sphere) const;
  Sphere worldSphere(PartId part, const Pose& worldFromPart) const;
  bool inView(const View& view, const Sphere& sphere) const;
  /// Draws those clusters of a run of indices for whose spheres (world) the test holds. Adjacent clusters are
  /// drawn in one call.
  template <typename Test>
  static void drawClusters(const GpuMesh& mesh, std::uint32_t first, std::uint32_t count,
                           const Pose& worldFromPart, Test visible);
  /// Whether the backs of a part's faces are all hidden: none is seen through a cut or from within.
  bool hidesBacks(const View& view, PartId part, const GpuMesh& mesh, const Pose& worldFromPart) const;
  void drawSurface(const View& view, PartId part, const GpuMesh& mesh, const Pose& worldFromPart,
                   const PartLook& look) const;
  void drawEdges(const View& view, PartId part, const GpuMesh& mesh, const Pose& worldFromPart,
                 const PartLook& look) const;
  /// Fills pickCorners_ with the exact triangles of a mesh near a ray; the test is for spheres in the world.
  template <typename Test>
  GLsizei gatherExact(std::uint32_t mesh, const Pose& worldFromPart, Test meetsRay);

  const assets::Scene& scene_;
  GlProgram background_;
  Programs whole_, cut_;
  std::vector<document::SectionPlane> sections_;  // normals are unit
  mutable Sphere around_;                         // all parts, in the present picture; world
  GlVertexArray cap_;
  GlBuffer capVertices_;
  std::vector<DrawnMesh> meshes_;  // the scene's, then one for each part that has only implicit shapes
  std::vector<std::uint32_t> meshOfPart_;  // into meshes_, or kNone
  GlVertexArray empty_;
  GlTarget pickTarget_;
  std::unique_ptr<DrawnLevels> levels_;  // null: everything is drawn as it is
  std::uint64_t detailVersion_ = 0;
  std::vector<std::unique_ptr<TriangleRuns>> runs_;  // of meshes with levels that a ray has come near
  GlVertexArray pickTriangles_;
  GlBuffer pickCorners_;
};

}  // namespace tandem::client
