#include "client/marks/hand_glyphs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/picture/colours.h"

namespace tandem::client {
namespace {

// Sizes in pixels: a hand must be visible whether the scene is a watch or a wing.
constexpr double kStylusLength = 120.0;
constexpr double kTipRadius = 3.2;  // of a point
constexpr double kLeastTip = 1.2;   // of a ball
constexpr double kBarrelRadius = 5.0;
constexpr double kArrowAtLimit = 130.0;  // length of the arrow of a force at the limit
constexpr double kDiscRadius = 9.0;
constexpr double kNormalLength = 26.0;
constexpr double kFrustumDepth = 46.0;
constexpr double kLargerFrustum =
    0.3;  // by which each further frustum at one place is larger, as a share of the first
constexpr double kSameEyes = 6.0;
constexpr double kLabelHeight = 22.0;
constexpr double kShortestMeasure = 4.0;

constexpr double kFaintestForce = 0.02;  // N; less is not drawn
constexpr double kGhostFrom = 1.5;       // pixels between device and proxy from which both are drawn

const GlyphColour kForceColour(0.80f, 0.07f, 0.03f, 1.0f);
const GlyphColour kContactColour(0.02f, 0.42f, 0.20f, 0.85f);
const GlyphColour kMeasureColour(0.01f, 0.08f, 0.42f, 1.0f);
const GlyphColour kSteel(0.45f, 0.47f, 0.50f, 1.0f);

GlyphColour withAlpha(const GlyphColour& colour, float alpha) {
  return {colour.x, colour.y, colour.z, alpha};
}

/// Radius with which a tip is drawn, m: that of the ball that it is, as long as that can be seen.
double drawnTip(double toolRadius, double px) {
  return toolRadius > 0.0 ? std::max(toolRadius, kLeastTip * px) : kTipRadius * px;
}

/// A pen whose tip is at the pose's position and whose barrel runs along its +z axis.
void addStylus(GlyphBatch& batch, const Pose& worldFromTool, double toolRadius, const GlyphColour& colour,
               float alpha) {
  const double px = batch.view().pixelAt(worldFromTool.position);
  const double tip = drawnTip(toolRadius, px), barrel = std::max(kBarrelRadius * px, 0.5 * tip);
  const auto along = [&](double pixels) { return transformPoint(worldFromTool, {0.0, 0.0, pixels * px}); };
  batch.sphere(worldFromTool.position, tip, withAlpha(colour, alpha));
  batch.cone(along(0.0), along(26.0), 0.45 * std::min(tip, barrel), barrel, withAlpha(kSteel, alpha));
  batch.cone(along(26.0), along(kStylusLength), barrel, barrel, withAlpha(colour, alpha));
  batch.cone(along(kStylusLength), along(kStylusLength + 5.0), barrel, 0.6 * barrel,
             withAlpha(kSteel, alpha));
}

void addArrow(GlyphBatch& batch, const glm::dvec3& from, const glm::dvec3& to, const GlyphColour& colour) {
  const double px = batch.view().pixelAt(from);
  const double length = glm::length(to - from), head = std::min(16.0 * px, 0.5 * length);
  const glm::dvec3 neck = to - (to - from) * (head / length);
  batch.cone(from, neck, 2.6 * px, 2.6 * px, colour);
  batch.cone(neck, to, 7.5 * px, 0.0, colour);
}

void addForce(const ToolView& hand, double limit, GlyphBatch& batch, std::vector<Label>& labels) {
  const double force = glm::length(hand.force);
  if (!(force > kFaintestForce)) return;
  const glm::dvec3 from = hand.worldFromProxy.position;
  const double px = batch.view().pixelAt(from);
  const double share = std::min(force / std::max(limit, 1e-3), 1.5);
  const double length = (18.0 + (kArrowAtLimit - 18.0) * share) * px;
  const glm::dvec3 to = from + hand.force * (length / force);
  addArrow(batch, from, to, kForceColour);
  char text[32];
  std::snprintf(text, sizeof text, "%.2f N", force);
  labels.push_back({to, {10.0, -8.0}, {0.80f, 0.16f, 0.08f}, text});
}

void addContacts(const ToolView& hand, GlyphBatch& batch) {
  const int count = std::clamp(hand.contactCount, 0, haptics::kMaxContacts);
  for (int i = 0; i < count; ++i) {
    const haptics::Contact& contact = hand.contacts[static_cast<std::size_t>(i)];
    if (!(glm::length(contact.normal) > 0.5)) continue;
    const double px = batch.view().pixelAt(contact.point);
    const glm::dvec3 lifted = contact.point + contact.normal * (0.8 * px);
    batch.ring(lifted, contact.normal, 0.62 * kDiscRadius * px, kDiscRadius * px, kContactColour);
    batch.disc(lifted, contact.normal, 0.25 * kDiscRadius * px, kContactColour);
    batch.line(lifted, lifted + contact.normal * (kNormalLength * px), 1.8, kContactColour);
  }
}

/// Draws the distance between the held part and its nearest neighbour, unless the line would be shorter than
/// it is thick.
void addClearance(const HandView& hand, GlyphBatch& batch, std::vector<Label>& labels) {
  const NearestView& nearest = hand.nearest;
  if (hand.held == kNoPart || nearest.part == kNoPart || !(nearest.clearance > 0.0)) return;
  const double px = batch.view().pixelAt(nearest.onHeld);
  if (nearest.clearance < kShortestMeasure * px) return;
  batch.line(nearest.onHeld, nearest.onOther, 2.0, kMeasureColour);
  batch.sphere(nearest.onHeld, 3.0 * px, kMeasureColour);
  batch.sphere(nearest.onOther, 3.0 * px, kMeasureColour);
  char text[32];
  std::snprintf(text, sizeof text, "%.2f mm", 1e3 * nearest.clearance);
  labels.push_back({0.5 * (nearest.onHeld + nearest.onOther), {8.0, -8.0}, {0.05f, 0.30f, 0.62f}, text});
}

/// A hand of this site: its stylus where the proxy is, its device where that is elsewhere, contacts and
/// force.
void addTool(const ToolView& hand, const ViewModel& model, GlyphBatch& batch, std::vector<Label>& labels) {
  const GlyphColour colour(linear(selfColour(model)), 1.0f);
  const Pose& proxy = hand.worldFromProxy;
  const Pose& device = hand.worldFromDevice;
  addStylus(batch, proxy, hand.toolRadius, colour, hand.valid ? 1.0f : 0.4f);
  const double apart = glm::length(device.position - proxy.position);
  const double px = batch.view().pixelAt(proxy.position);
  if (hand.valid && apart > kGhostFrom * px) {
    batch.line(proxy.position, device.position, 2.0, withAlpha(colour, 0.8f));
    batch.sphere(device.position, drawnTip(hand.toolRadius, px), withAlpha(colour, 0.35f));
  }
  addContacts(hand, batch);
  addForce(hand, model.settings.forceLimit, batch, labels);
}

void addOwnHands(const ViewModel& model, GlyphBatch& batch, std::vector<Label>& labels) {
  if (!model.hand.second.deviceName.empty()) addTool(model.hand.second, model, batch, labels);
  if (!model.hand.present) return;
  addTool(model.hand, model, batch, labels);
  addClearance(model.hand, batch, labels);
}

/// The number of people listed before this one whose camera is at the same place, as those of sites without a
/// window are.
int sameEyes(const ViewModel& model, const SiteView& site, const View& view) {
  const glm::dvec3& eye = site.presence.worldFromCamera.position;
  int count = 0;
  for (const SiteView& other : model.sites) {
    if (other.info.site == site.info.site) break;
    if (other.self || !other.seen || !other.info.connected) continue;
    const double apart = glm::length(other.presence.worldFromCamera.position - eye);
    count += apart < kSameEyes * view.pixelAt(eye) ? 1 : 0;
  }
  return count;
}

/// Draws a small pyramid that opens in the direction of the other person's view. Of several at one place,
/// each is larger than the one before it, and its name stands below that one's.
void addCamera(const Pose& worldFromCamera, const SiteView& site, int before, GlyphBatch& batch,
               std::vector<Label>& labels) {
  const View& view = batch.view();
  const double depth = view.depthOf(worldFromCamera.position);
  const double px = view.metresPerPixel(std::max(depth, view.near));
  // A camera that (nearly) coincides with this one would fill the view.
  if (depth < 0.08 * view.camera.distance) return;
  const double d = kFrustumDepth * (1.0 + kLargerFrustum * before) * px;
  const auto at = [&](double x, double y, double z) {
    return transformPoint(worldFromCamera, glm::dvec3(x, y, z) * d);
  };
  const glm::dvec3 eye = worldFromCamera.position;
  const glm::dvec3 corners[4] = {at(-0.55, -0.38, -1.0), at(0.55, -0.38, -1.0), at(0.55, 0.38, -1.0),
                                 at(-0.55, 0.38, -1.0)};
  const glm::vec3 colour = srgb(site.info.colour);
  const GlyphColour line(linear(colour), 0.9f);
  for (int i = 0; i < 4; ++i) {
    batch.line(eye, corners[i], 1.6, line);
    batch.line(corners[i], corners[(i + 1) % 4], 1.6, line);
  }
  batch.cone(at(-0.14, 0.38, -1.0), at(0.0, 0.58, -1.0), 0.02 * d, 0.02 * d, line);
  batch.cone(at(0.0, 0.58, -1.0), at(0.14, 0.38, -1.0), 0.02 * d, 0.02 * d, line);
  batch.sphere(eye, 3.0 * px, line);
  labels.push_back({eye, {8.0, -18.0 + kLabelHeight * before}, colour, site.info.name});
}

}  // namespace

void addPeople(const ViewModel& model, GlyphBatch& batch, std::vector<Label>& labels) {
  for (const SiteView& site : model.sites) {
    if (site.self || !site.seen || !site.info.connected) continue;
    addCamera(site.presence.worldFromCamera, site, sameEyes(model, site, batch.view()), batch, labels);
    if (site.info.role == sync::Role::observer) continue;
    const glm::vec3 colour = srgb(site.info.colour);
    const Pose& tool = site.presence.worldFromTool;
    addStylus(batch, tool, 0.0, GlyphColour(linear(colour), 1.0f), 1.0f);
    if (site.presence.worldFromSecondTool)
      addStylus(batch, *site.presence.worldFromSecondTool, 0.0, GlyphColour(linear(colour), 1.0f), 1.0f);
    const double px = batch.view().pixelAt(tool.position);
    const glm::dvec3 top = transformPoint(tool, {0.0, 0.0, (kStylusLength + 8.0) * px});
    labels.push_back({top, {6.0, -10.0}, colour, site.info.name});
  }
  addOwnHands(model, batch, labels);
}

void includePeople(const ViewModel& model, assets::Bounds& bounds) {
  if (!(bounds.min.x <= bounds.max.x)) return;
  const glm::dvec3 centre = 0.5 * (bounds.min + bounds.max);
  const double reach = glm::length(bounds.max - bounds.min);
  const auto include = [&](const glm::dvec3& tip) {
    if (!(glm::length(tip - centre) < reach)) return;
    bounds.include(tip);
  };
  if (model.hand.present && model.hand.valid) include(model.hand.worldFromProxy.position);
  for (const SiteView& site : model.sites)
    if (site.seen && !site.self && site.info.connected && site.info.role != sync::Role::observer)
      include(site.presence.worldFromTool.position);
}

Label nameAt(const ViewModel& model, PartId part, const glm::dvec3& place) {
  constexpr glm::vec3 kFixedColour(0.42f, 0.46f, 0.51f);
  constexpr glm::dvec2 kBesideCursor(14.0, 18.0);  // pixels
  const assets::Part& shown = model.scene->parts[part];
  if (shown.movable) return {place, kBesideCursor, selfColour(model), shown.name};
  return {place, kBesideCursor, kFixedColour, shown.name + " (fixed)"};
}

}  // namespace tandem::client
