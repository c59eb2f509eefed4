#include "haptics/measure/face_depth.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr double kPrecision = 1e-2;  // of the depth
constexpr int kMaxSplits = 4000;     // of one search

}  // namespace

/// A piece of a triangle with an upper bound of its depth.
struct FaceDepth::Piece {
  std::array<glm::dvec3, 3> corners;  // body frame
  double bound = 0.0;

  bool operator<(const Piece& other) const { return bound < other.bound; }
};

DeepestPoint FaceDepth::depthAt(const glm::dvec3& inBody, std::uint32_t& facet) const {
  MeshPoint nearest;
  const bool found = body_.tree().closestPoint(inBody, 1e300, nearest);
  ASSERT(found);
  facet = body_.facetOf(nearest.triangle);
  return {body_.inside(inBody, nearest) ? nearest.distance : -nearest.distance, inBody, nearest.point, true};
}

void FaceDepth::searchBetween(std::vector<CrossedFacet>& crossed, DeepestPoint& deepest) const {
  if (!body_.solid()) return;
  std::sort(crossed.begin(), crossed.end(),
            [](const CrossedFacet& x, const CrossedFacet& y) { return x.facet < y.facet; });
  for (auto begin = crossed.cbegin(); begin != crossed.cend();) {
    auto end = begin;
    glm::dvec3 middle(0.0);
    for (; end != crossed.cend() && end->facet == begin->facet; ++end) middle += end->point;
    middle /= static_cast<double>(end - begin);
    double spread = 0.0;
    for (auto c = begin; c != end; ++c) spread = std::max(spread, glm::length(c->point - middle));
    const bool worthALook = end - begin >= 3 && spread > deepest.depth;
    begin = end;
    if (!worthALook) continue;
    std::uint32_t facet = 0;
    const DeepestPoint place = depthAt(transformPoint(bodyFromFaces_, middle), facet);
    if (place.depth > deepest.depth + body_.tolerance()) deepest = place;
  }
}

/// The depth has slope 1 at most, and the distance to one facet is a convex function, which is largest at a
/// corner.
void FaceDepth::measure(Piece& piece, DeepestPoint& deepest) const {
  const glm::dvec3 middle = (piece.corners[0] + piece.corners[1] + piece.corners[2]) / 3.0;
  double radius = 0.0, toFacet = 0.0;
  for (const glm::dvec3& corner : piece.corners) radius = std::max(radius, glm::length(corner - middle));
  std::uint32_t facet = 0;
  const DeepestPoint place = depthAt(middle, facet);
  if (place.depth > deepest.depth + body_.tolerance()) deepest = place;
  for (const glm::dvec3& corner : piece.corners) {
    toFacet = std::max(toFacet, body_.distanceToFacet(facet, corner));
  }
  piece.bound = std::min({piece.bound, place.depth + radius, toFacet});
}

void FaceDepth::search(DeepestPoint& deepest) const {
  if (!body_.solid()) return;
  const auto enough = [&] { return deepest.depth * (1.0 + kPrecision) + body_.tolerance(); };
  std::vector<Piece> open;
  const assets::Mesh& surface = faces_.tree().mesh();
  for (const auto& t : surface.triangles) {
    Piece piece;
    for (std::size_t i = 0; i < 3; ++i) {
      piece.corners[i] = transformPoint(bodyFromFaces_, surface.positions[t[i]]);
    }
    piece.bound = body_.size();
    measure(piece, deepest);
    if (piece.bound > enough()) open.push_back(piece);
  }
  std::make_heap(open.begin(), open.end());
  for (int split = 0; split < kMaxSplits && !open.empty(); ++split) {
    std::pop_heap(open.begin(), open.end());
    const Piece worst = open.back();
    open.pop_back();
    if (worst.bound <= enough()) break;
    std::size_t longest = 0;
    const auto side = [&](std::size_t i) {
      return glm::length(worst.corners[(i + 1) % 3] - worst.corners[i]);
    };
    for (std::size_t i = 1; i < 3; ++i) longest = side(i) > side(longest) ? i : longest;
    const glm::dvec3 half = 0.5 * (worst.corners[longest] + worst.corners[(longest + 1) % 3]);
    for (const std::size_t replaced : {longest, (longest + 1) % 3}) {
      Piece piece = worst;
      piece.corners[replaced] = half;
      measure(piece, deepest);
      if (piece.bound <= enough()) continue;
      open.push_back(piece);
      std::push_heap(open.begin(), open.end());
    }
  }
}

}  // namespace tandem::haptics
