#pragma once

// The list of clashes apart from how it is drawn: its rows in words, which one is chosen, where its witness
// points are now, and the camera that shows it.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/marks/hand_glyphs.h"
#include "client/picture/glyphs.h"
#include "client/picture/scene_renderer.h"

namespace tandem::client {

/// What the person set and chose.
struct ClashUi {
  bool open = false;       // the list is shown
  bool requested = false;  // the list has requested a search at least once
  ClashQuestion question;
  bool touches = false;             // touching pairs are listed too
  bool byPart = false;              // the list goes by part, else by status
  PartId a = kNoPart, b = kNoPart;  // the chosen pair
  bool fly = false;                 // the camera is to move to the chosen pair
  bool choosesFirst = false;        // the first pair that is found becomes the chosen one
  document::Revision remarkOf = 0;  // the verdict's revision whose remark `remark` began as
  std::array<char, document::kMaxText / 2 + 1> remark{};
};

/// One clash in words.
struct ClashRow {
  const FoundClash* found = nullptr;
  std::string first, second;  // names of its parts
  std::string measure;        // "0.412 mm deep", "touch", "0.080 mm apart"
  std::string note;  // "at rest too", "facets alone may explain it", ...; empty where there is nothing to say
};

/// The number of clashes of each kind. Pairs that may not collide count as passThrough alone.
struct ClashCounts {
  std::size_t hard = 0, atRest = 0, touches = 0, near = 0, passThrough = 0;
};

ClashCounts countClashes(const ClashFindings& findings);

/// In the order of the findings; touches only if they are wanted. Points into `findings`.
std::vector<ClashRow> clashRows(const ClashFindings& findings, const assets::Scene& scene, bool touches);

/// The clash of the chosen pair; null if the findings hold none.
const FoundClash* chosenClash(const ClashFindings* findings, const ClashUi& ui);

/// The witness points on both surfaces, carried along with the parts.
struct ClashWitness {
  glm::dvec3 onA{0.0, 0.0, 0.0}, onB{0.0, 0.0, 0.0};  // m, world
  bool moved = false;  // the pose of one part relative to the other has changed since the measurement
};
ClashWitness witnessOf(const ClashFindings& findings, const FoundClash& found,
                       std::span<const Pose> worldFromPart);

/// "0.412 mm deep", "depth unknown", "touch" or "0.080 mm apart".
std::string measureOf(const Clash& clash);

/// The chosen pair as the others are shown it, with its place where `findings` have it; none unless the list
/// is open.
sync::Inspection inspectionOf(const ClashFindings* findings, const ClashUi& ui,
                              std::span<const Pose> worldFromPart);
/// Marks the two parts that an inspection looks at, and where they clash unless `apart`: drawn elsewhere than
/// they are.
void addInspection(const sync::Inspection& looks, const ViewModel& model, bool apart,
                   std::vector<PartLook>& looksOfParts, GlyphBatch& batch, std::vector<Label>& labels);

/// A camera that looks across the line between the witness points, and shows enough of the smaller part (its
/// diagonal in m) to recognise the place.
Camera cameraFor(const Camera& from, const ClashWitness& witness, double smallerDiagonal, double aspect);

/// Colours two parts, and makes all parts transparent so that the witness points are visible.
void markPair(PartId a, PartId b, std::vector<PartLook>& looks);

/// Adds the witness points, the line between them, and a label with its length.
void addClash(const Clash& clash, const ClashWitness& witness, GlyphBatch& batch, std::vector<Label>& labels);

/// An animated change from one camera to another.
class CameraFlight {
 public:
  void start(const Camera& from, const Camera& to);
  void stop() { left_ = 0.0; }
  bool flying() const { return left_ > 0.0; }
  /// Advances by `dt` s and returns the camera there.
  Camera step(double dt);

 private:
  Camera from_, to_;
  double left_ = 0.0;  // s
};

/// sRGB of the chosen clash's parts.
inline constexpr glm::vec3 kClashColourA{0.84f, 0.37f, 0.0f}, kClashColourB{0.0f, 0.45f, 0.70f};

}  // namespace tandem::client
