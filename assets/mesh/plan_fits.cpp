#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>

#include "assets/mesh/round_faces.h"

namespace tandem::assets {
namespace {

constexpr double kSagOfPlay = 0.1;  // of the radial play, the sag of a facet
constexpr int kMostSegments = 320;
constexpr double kWidestPlay = 0.05;               // of the radius: the play above which no facets matter
constexpr std::size_t kMostTriangles = 2'000'000;  // that cutting may add to all meshes

// Fits of equal radii. A play below kCloser is none, as 320 facets do not leave it.
constexpr double kCloser = 1e-4;                       // of the radius, by which the bore may be wider
constexpr double kOneRadius = 2e-5;                    // of the radius, by which a file may round it
constexpr double kRoom = 4e-6;                         // m, by which the axis may go aside
constexpr double kLeastRoom = 6e-5, kMostRoom = 1e-3;  // of the radius
constexpr double kBetween = 0.75;              // of the room, between a corner and the middle of a facet
constexpr double kSagOfBore = 0.75;            // of the room
constexpr double kLeastTurn = 0.99 * kPi;      // rad, of a cylinder; less is a rounded edge
constexpr std::size_t kMostPairs = 4'000'000;  // of the faces of a mesh that are compared

int segmentsWithSag(double radius, double sag) {
  return static_cast<int>(std::ceil(kPi / std::sqrt(2.0 * sag / radius) / 8.0)) * 8;
}

int segmentsForPlay(double radius, double play) {
  if (!(play < kWidestPlay * radius) || play < kOneRadius * radius) return 0;
  return std::min(kMostSegments, segmentsWithSag(radius, kSagOfPlay * play));
}

/// Faces of one kind, sorted by radius.
class ByRadius {
 public:
  void add(const RoundFace& face) { radii_.push_back(face.radius); }
  void sort() { std::sort(radii_.begin(), radii_.end()); }
  /// How far the nearest radius is that is not within an interval; infinite if there is none.
  double nearest(double radius, double low, double high) const {
    const auto above = std::upper_bound(radii_.begin(), radii_.end(), high),
               below = std::lower_bound(radii_.begin(), radii_.end(), low);
    double least = 1e300;
    if (above != radii_.end()) least = *above - radius;
    if (below != radii_.begin()) least = std::min(least, radius - *(below - 1));
    return least;
  }
  double nearest(double radius) const {
    return largestWithin(radius, radius) ? 0.0 : nearest(radius, radius, radius);
  }
  /// The largest radius within an interval.
  std::optional<double> largestWithin(double low, double high) const {
    const auto above = std::upper_bound(radii_.begin(), radii_.end(), high);
    if (above == radii_.begin() || *(above - 1) < low) return std::nullopt;
    return *(above - 1);
  }

 private:
  std::vector<double> radii_;
};

/// Whether two faces of a mesh are parts of one cylinder.
bool areOne(const RoundFace& a, const RoundFace& b) {
  const double off = kOneRadius * a.radius;
  const glm::dvec3 apart = b.point - a.point;
  return a.hollow == b.hollow && std::abs(a.radius - b.radius) < off &&
         glm::length(glm::cross(a.axis, b.axis)) < kOneRadius && glm::length(glm::cross(a.axis, apart)) < off;
}

/// Which faces of a mesh belong to cylinders that go around half a turn or more. Others are rounded edges, of
/// which a file may have thousands of one radius.
std::vector<bool> wholeFaces(const std::vector<RoundFace>& faces) {
  std::vector<double> turn(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) turn[i] = faces[i].turn;
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (std::size_t k = 0; faces[i].turn < kLeastTurn && k < faces.size() && ++pairs < kMostPairs; ++k)
      if (k != i && areOne(faces[i], faces[k])) turn[i] += faces[k].turn;
  std::vector<bool> whole(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) whole[i] = turn[i] >= kLeastTurn;
  return whole;
}

/// The faces of all meshes, or of those that move.
struct Counterparts {
  std::array<ByRadius, 2> any, whole;  // shafts, bores
  void add(const RoundFace& face, bool isWhole) {
    any[face.hollow].add(face);
    if (isWhole) whole[face.hollow].add(face);
  }
  void sort() {
    for (auto* lists : {&any, &whole})
      for (ByRadius& list : *lists) list.sort();
  }
};

RoundCut cutFor(const RoundFace& face, bool isWhole, const Counterparts& others) {
  const double r = face.radius, low = r * (1.0 - (face.hollow ? kCloser : kOneRadius)),
               high = r * (1.0 + (face.hollow ? kOneRadius : kCloser));
  const ByRadius &any = others.any[!face.hollow], &whole = others.whole[!face.hollow];
  const std::optional<double> equal = isWhole ? whole.largestWithin(low, high) : std::nullopt;
  if (!equal) return {segmentsForPlay(r, any.nearest(r)), 0.0};
  const EqualFitRoom room = equalFitRoom(r);
  const int own = segmentsWithSag(r, face.hollow ? room.sag : room.most - room.least);
  return {std::max(own, segmentsForPlay(r, any.nearest(r, low, high))),
          face.hollow ? std::max(r, *equal) + room.least : r};
}

}  // namespace

EqualFitRoom equalFitRoom(double radius) {
  const double most = std::clamp(kRoom, kLeastRoom * radius, kMostRoom * radius);
  return {kBetween * most, most, kSagOfBore * most};
}

void planFits(std::vector<RoundFaces>& meshes) {
  Counterparts all, moving;
  std::vector<std::vector<bool>> whole;
  for (const RoundFaces& mesh : meshes) {
    whole.push_back(wholeFaces(mesh.faces));
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      all.add(mesh.faces[i], whole.back()[i]);
      if (mesh.movable) moving.add(mesh.faces[i], whole.back()[i]);
    }
  }
  all.sort();
  moving.sort();
  std::size_t cut = 0;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    RoundFaces& mesh = meshes[m];
    mesh.cuts.assign(mesh.faces.size(), {});
    for (std::size_t i = 0; i < mesh.faces.size(); ++i)
      mesh.cuts[i] = cutFor(mesh.faces[i], whole[m][i], mesh.movable ? all : moving);
    cut += mesh.anyCut() ? 1 : 0;
  }
  for (RoundFaces& mesh : meshes) mesh.most = kMostTriangles / std::max<std::size_t>(cut, 1);
}

}  // namespace tandem::assets
