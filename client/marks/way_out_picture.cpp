#include "client/marks/way_out_picture.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "client/picture/colours.h"

namespace tandem::client {
namespace {

constexpr glm::vec3 kWayColour(0.10f, 0.52f, 0.42f), kStuckColour(0.83f, 0.42f, 0.02f);  // sRGB
constexpr float kWayAlpha = 0.14f;                                                       // faint edges, too
constexpr float kBlockerAlpha = 0.4f;             // what is stuck is seen through it
constexpr double kWayWidth = 2.5, kWayEnd = 5.0;  // pixels

}  // namespace

std::vector<Pose> posesAlong(const std::vector<Pose>& path, std::size_t most) {
  std::vector<Pose> poses;
  if (path.size() < 2 || most == 0) return poses;
  double length = 0.0, gone = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    length += glm::distance(path[i - 1].position, path[i].position);
  const double step = length / static_cast<double>(most);
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    gone += glm::distance(path[i - 1].position, path[i].position);
    if (poses.size() + 1 >= most || gone < step * static_cast<double>(poses.size() + 1)) continue;
    poses.push_back(path[i]);
  }
  poses.push_back(path.back());
  return poses;
}

PartLook wayLook(bool free) {
  PartLook look;
  look.alpha = kWayAlpha;
  look.tint = linear(free ? kWayColour : kStuckColour);
  look.tintAmount = 0.7f;
  look.pickable = false;
  return look;
}

void addWayOut(const ViewModel& model, GlyphBatch& batch) {
  const WayOutView& wayOut = model.wayOut;
  if (wayOut.path.size() < 2 || wayOut.part >= model.scene->parts.size()) return;
  const std::uint32_t mesh = model.scene->parts[wayOut.part].mesh;
  if (mesh >= model.scene->meshes.size()) return;
  const assets::Bounds& bounds = model.scene->meshes[mesh].bounds;
  const glm::dvec3 middle = 0.5 * (bounds.min + bounds.max);
  const GlyphColour colour(linear(wayOut.free ? kWayColour : kStuckColour), 1.0f);
  for (std::size_t i = 1; i < wayOut.path.size(); ++i)
    batch.line(transformPoint(wayOut.path[i - 1], middle), transformPoint(wayOut.path[i], middle), kWayWidth,
               colour);
  const glm::dvec3 end = transformPoint(wayOut.path.back(), middle);
  batch.sphere(end, kWayEnd * batch.view().pixelAt(end), colour);
}

void markBlockers(const WayOutView& wayOut, std::vector<PartLook>& looks) {
  for (const PartId part : wayOut.blockedBy) {
    if (part >= looks.size()) continue;
    looks[part].alpha = std::min(looks[part].alpha, kBlockerAlpha);
    looks[part].tint = linear(kStuckColour);
    looks[part].tintAmount = 0.55f;
    looks[part].edgeColour = 0.8f * kStuckColour;
    looks[part].edgeWidth = 1.8f;
  }
}

}  // namespace tandem::client
