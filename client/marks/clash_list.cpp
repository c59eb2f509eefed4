#include "client/marks/clash_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <glm/gtc/constants.hpp>

#include "assets/base/assert.h"
#include "client/picture/colours.h"
#include "client/session/shown_clash.h"

namespace tandem::client {
namespace {

constexpr double kFlight = 0.5;  // s
// Half of the view's height, in lengths of the gap and in diagonals of the smaller part.
constexpr double kGapsShown = 14.0, kMinShown = 0.06, kMaxShown = 0.5;
constexpr double kSeenFromAside = 0.6;  // sine between the line and the line of sight
constexpr float kOthersAlpha = 0.08f, kClashAlpha = 0.62f;
constexpr double kPoint = 4.0, kHalo = 9.0;  // pixels
const GlyphColour kHardColour(0.60f, 0.02f, 0.01f, 1.0f), kNearColour(0.01f, 0.08f, 0.42f, 1.0f);

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, metres < 1e-6 ? "%.2g mm" : "%.3f mm", 1e3 * metres);
  return text;
}

std::string noteOf(const FoundClash& found) {
  const Clash& clash = found.clash;
  std::string note;
  const auto add = [&](const std::string& words) { note += (note.empty() ? "" : "; ") + words; };
  if (!clash.mayCollide) add("may pass through each other");
  if (found.overlapsAtRest) add("overlap at rest");
  if (clash.contained) add("one holds the other");
  if (clash.sheets)
    add("open surfaces");
  else if (clash.open)
    add("a shell is open: " + millimetres(clash.depth) + " at least");
  if (clash.kind == ClashKind::hard && !clash.open && clash.facetSag >= clash.depth)
    add("no deeper than facets may be off");
  return note;
}

/// Unit vector from the eye into the picture.
glm::dvec3 sightOf(const Camera& camera) {
  return worldFromCamera(camera).orientation * glm::dvec3(0.0, 0.0, -1.0);
}

bool seenFromAside(const Camera& camera, const glm::dvec3& line) {
  return glm::length(glm::cross(sightOf(camera), line)) >= kSeenFromAside;
}

/// Turns the camera by the first of a few angles, the smallest first, from which the unit vector `line` is
/// seen from the side.
void turnAside(Camera& camera, const glm::dvec3& line) {
  constexpr std::array<double, 5> kTurns{0.0, 0.7, -0.7, 1.4, -1.4};
  const Camera before = camera;
  for (const double pitch : kTurns) {
    for (const double yaw : kTurns) {
      camera.yaw = std::remainder(before.yaw + yaw, glm::two_pi<double>());
      camera.pitch = before.pitch + pitch;
      if (std::abs(camera.pitch) < glm::half_pi<double>() && seenFromAside(camera, line)) return;
    }
  }
  camera = before;
}

void colourPart(PartLook& look, const glm::vec3& srgbColour) {
  look.visible = look.pickable = true;
  look.alpha = kClashAlpha;
  look.tint = linear(srgbColour);
  look.tintAmount = 0.8f;
  look.rimAmount = 0.5f;
  look.edgeColour = 0.8f * srgbColour;
  look.edgeWidth = 1.6f;
}

}  // namespace

std::string measureOf(const Clash& clash) {
  switch (clash.kind) {
    case ClashKind::hard:
      return clash.open ? "depth unknown" : millimetres(clash.depth) + " deep";
    case ClashKind::touch:
      return "touch";
    case ClashKind::clearance:
      return millimetres(clash.distance) + " apart";
  }
  return "";
}

ClashCounts countClashes(const ClashFindings& findings) {
  ClashCounts counts;
  for (const FoundClash& found : findings.found) {
    if (!found.clash.mayCollide)
      ++counts.passThrough;
    else if (found.clash.kind == ClashKind::hard)
      ++(found.overlapsAtRest ? counts.atRest : counts.hard);
    else
      ++(found.clash.kind == ClashKind::touch ? counts.touches : counts.near);
  }
  return counts;
}

std::vector<ClashRow> clashRows(const ClashFindings& findings, const assets::Scene& scene, bool touches) {
  std::vector<ClashRow> rows;
  const auto nameOf = [&](PartId part) {
    return scene.parts[part].name.empty() ? "part " + std::to_string(part) : scene.parts[part].name;
  };
  for (const FoundClash& found : findings.found) {
    ASSERT(found.clash.a < scene.parts.size() && found.clash.b < scene.parts.size());
    if (found.clash.kind == ClashKind::touch && !touches) continue;
    rows.push_back(
        {&found, nameOf(found.clash.a), nameOf(found.clash.b), measureOf(found.clash), noteOf(found)});
  }
  return rows;
}

const FoundClash* chosenClash(const ClashFindings* findings, const ClashUi& ui) {
  if (findings == nullptr || ui.a == kNoPart) return nullptr;
  const auto at = std::find_if(findings->found.begin(), findings->found.end(), [&](const FoundClash& found) {
    return found.clash.a == ui.a && found.clash.b == ui.b;
  });
  return at == findings->found.end() ? nullptr : &*at;
}

ClashWitness witnessOf(const ClashFindings& findings, const FoundClash& found,
                       std::span<const Pose> worldFromPart) {
  const auto& [a, b] = std::pair{found.clash.a, found.clash.b};
  const auto now = [&](PartId part, const glm::dvec3& then) {
    return transformPoint(worldFromPart[part], transformPoint(inverse(findings.worldFromPart[part]), then));
  };
  ASSERT(findings.worldFromPart.size() == worldFromPart.size());
  ClashWitness witness{now(a, found.clash.onA), now(b, found.clash.onB), false};
  // Both parts may have moved together: then either part carries each point to the same place.
  const double off =
      glm::length(now(b, found.clash.onA) - witness.onA) + glm::length(now(a, found.clash.onB) - witness.onB);
  const double scale = 1.0 + glm::length(witness.onA) + glm::length(witness.onB);
  witness.moved = off > 1e-9 * scale;
  return witness;
}

sync::Inspection inspectionOf(const ClashFindings* findings, const ClashUi& ui,
                              std::span<const Pose> worldFromPart) {
  sync::Inspection looks;
  if (!ui.open || ui.a == kNoPart) return looks;
  const FoundClash* found = chosenClash(findings, ui);
  if (found != nullptr) {
    putClash(found->clash, findings->worldFromPart[ui.a], findings->worldFromPart[ui.b], looks);
    looks.moved = witnessOf(*findings, *found, worldFromPart).moved;
  } else {
    looks.a = ui.a;
    looks.b = ui.b;
  }
  return looks;
}

void addInspection(const sync::Inspection& looks, const ViewModel& model, bool apart,
                   std::vector<PartLook>& looksOfParts, GlyphBatch& batch, std::vector<Label>& labels) {
  if (looks.a == kNoPart) return;
  markPair(looks.a, looks.b, looksOfParts);
  if (looks.mark == sync::ClashMark::pair || apart) return;
  const ClashWitness witness{transformPoint(model.worldFromPart[looks.a], looks.onA),
                             transformPoint(model.worldFromPart[looks.b], looks.onB), looks.moved};
  addClash(clashIn(looks), witness, batch, labels);
}

Camera cameraFor(const Camera& from, const ClashWitness& witness, double smallerDiagonal, double aspect) {
  Camera camera = from;
  const glm::dvec3 line = witness.onB - witness.onA;
  const double gap = glm::length(line);
  if (gap > 0.0) turnAside(camera, line / gap);
  const double half = std::max(
      0.6 * gap, std::clamp(kGapsShown * gap, kMinShown * smallerDiagonal, kMaxShown * smallerDiagonal));
  const glm::dvec3 middle = 0.5 * (witness.onA + witness.onB);
  camera.target = middle;
  if (half > 0.0) {
    const double tangent = std::tan(0.5 * camera.fieldOfView) * std::min(1.0, std::max(aspect, 1e-3));
    camera.distance = half / tangent;
  }
  return camera;
}

void markPair(PartId a, PartId b, std::vector<PartLook>& looks) {
  ASSERT(a < looks.size() && b < looks.size());
  for (PartLook& look : looks) look.alpha = std::min(look.alpha, kOthersAlpha);
  colourPart(looks[a], kClashColourA);
  colourPart(looks[b], kClashColourB);
}

void addClash(const Clash& clash, const ClashWitness& witness, GlyphBatch& batch,
              std::vector<Label>& labels) {
  const View& view = batch.view();
  const GlyphColour colour = clash.kind == ClashKind::clearance ? kNearColour : kHardColour;
  const glm::dvec3 middle = 0.5 * (witness.onA + witness.onB);
  const double px = view.pixelAt(middle);
  batch.line(witness.onA, witness.onB, 2.5, colour);
  batch.sphere(witness.onA, kPoint * px, GlyphColour(linear(0.6f * kClashColourA), 1.0f));
  batch.sphere(witness.onB, kPoint * px, GlyphColour(linear(0.6f * kClashColourB), 1.0f));
  const glm::dvec3 towardsEye = glm::normalize(view.worldFromEye.position - middle);
  batch.ring(middle, towardsEye, kHalo * px + 0.5 * glm::length(witness.onB - witness.onA),
             (kHalo + 2.0) * px + 0.5 * glm::length(witness.onB - witness.onA), colour);
  const glm::vec3 shade =
      clash.kind == ClashKind::clearance ? glm::vec3(0.05f, 0.30f, 0.62f) : glm::vec3(0.80f, 0.16f, 0.08f);
  labels.push_back(
      {middle, {14.0, -24.0}, shade, measureOf(clash) + (witness.moved ? ", before they moved" : "")});
}

void CameraFlight::start(const Camera& from, const Camera& to) {
  from_ = from;
  to_ = to;
  from_.yaw = to.yaw + std::remainder(from.yaw - to.yaw, glm::two_pi<double>());  // by the smaller angle
  left_ = kFlight;
}

Camera CameraFlight::step(double dt) {
  ASSERT(dt >= 0.0);
  left_ = std::max(0.0, left_ - dt);
  const double t = 1.0 - left_ / kFlight, s = t * t * (3.0 - 2.0 * t);
  Camera camera = to_;
  if (left_ <= 0.0) return camera;
  camera.target = from_.target + s * (to_.target - from_.target);
  camera.distance = from_.distance * std::pow(to_.distance / from_.distance, s);
  camera.yaw = from_.yaw + s * (to_.yaw - from_.yaw);
  camera.pitch = from_.pitch + s * (to_.pitch - from_.pitch);
  return camera;
}

}  // namespace tandem::client
