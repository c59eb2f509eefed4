#pragma once

// The list of clashes apart from how it is drawn: its rows in words, which one is chosen, where its witness points are
// now, and the camera that shows it.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/viewer/glyphs.h"
#include "client/viewer/hand_glyphs.h"
#include "client/viewer/scene_renderer.h"

namespace tandem::client {

/// What the person set and chose.
struct ClashUi {
  bool open = false;   // the list is seen
  bool asked = false;  // for the first time
  ClashQuestion question;
  bool touches = false;             // list what touches, too
  PartId a = kNoPart, b = kNoPart;  // the chosen pair
  bool fly = false;                 // the camera shall go there
  bool choosesFirst = false;        // once there is one
};

/// One clash in words.
struct ClashRow {
  const FoundClash* found = nullptr;
  std::string first, second;  // names of its parts
  std::string measure;        // "0.412 mm deep", "touch", "0.080 mm apart"
  std::string note;  // "at rest too", "facets alone may explain it", ...; empty where there is nothing to say
};

/// How many there are of each kind, of pairs that may collide.
struct ClashCounts {
  std::size_t hard = 0, atRest = 0, touches = 0, near = 0, passThrough = 0;
};

ClashCounts countClashes(const ClashFindings& findings);

/// In the order of the findings; touches only if they are wanted. Points into `findings`.
std::vector<ClashRow> clashRows(const ClashFindings& findings, const assets::Scene& scene, bool touches);

/// Of the pair that was chosen; null if the findings have none of it.
const FoundClash* chosenClash(const ClashFindings* findings, const ClashUi& ui);

/// The points of both surfaces, which go with their parts.
struct ClashWitness {
  glm::dvec3 onA{0.0, 0.0, 0.0}, onB{0.0, 0.0, 0.0};  // m, world
  bool moved = false;  // the parts stand otherwise to each other than when they were measured
};
ClashWitness witnessOf(const ClashFindings& findings, const FoundClash& found,
                       std::span<const Pose> worldFromPart);

/// "0.412 mm deep", "touch" or "0.080 mm apart".
std::string measureOf(const Clash& clash);

/// A camera that shows the witness points from aside, and enough of the smaller part (its diagonal in m) to know where
/// that is.
Camera cameraFor(const Camera& from, const ClashWitness& witness, double smallerDiagonal, double aspect);

/// Both parts coloured, everything see-through so that the points are seen.
void markClash(const Clash& clash, std::vector<PartLook>& looks);

/// The witness points, a line between them, and its length in words.
void addClash(const Clash& clash, const ClashWitness& witness, GlyphBatch& batch, std::vector<Label>& labels);

/// A camera on its way.
class CameraFlight {
 public:
  void start(const Camera& from, const Camera& to);
  void stop() { left_ = 0.0; }
  bool flying() const { return left_ > 0.0; }
  /// Where it is `dt` s later.
  Camera step(double dt);

 private:
  Camera from_, to_;
  double left_ = 0.0;  // s
};

/// sRGB of the chosen clash's parts.
inline constexpr glm::vec3 kClashColourA{0.84f, 0.37f, 0.0f}, kClashColourB{0.0f, 0.45f, 0.70f};

}  // namespace tandem::client
