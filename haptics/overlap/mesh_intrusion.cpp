#include "haptics/overlap/mesh_intrusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "assets/base/assert.h"
#include "assets/base/disjoint_sets.h"
#include "haptics/geometry/placed_bounds.h"
#include "haptics/overlap/intrusion_piece.h"
#include "haptics/overlap/peak_of_least.h"

namespace tandem::haptics {
namespace {

constexpr double kEverywhere = std::numeric_limits<double>::max();
constexpr std::uint32_t kLid = 0x80000000u;  // marks a facet that is a lid
/// Pieces that touch the surface everywhere are halved so often before they count as flush.
constexpr int kFlushHalvings = 2;

/// Pieces that are measured though the depth stays open.
constexpr int kMaxRoughSamples = 1 << 10;

/// What a triangle of the mesh is near.
enum Near : std::uint8_t { kFar, kNearLids, kNearSurface };

/// The facets of a solid: its surface, and its lids where they count.
class Facets {
 public:
  Facets(const Intrusion& in, bool countLids)
      : solid_(in.solid), count_(countLids && in.solid.lids() != nullptr), slit_(kSlit * in.tolerance) {}

  Triangle operator[](std::uint32_t index) const {
    return (index & kLid) != 0 ? solid_.lids()->triangle(index & ~kLid) : solid_.tree().triangle(index);
  }

  /// The nearest point of the solid's surface, in `exit`, and the nearest facet, lids included if they
  /// count.
  void locate(Place& place, glm::dvec3* exit = nullptr) const {
    MeshPoint at, lid;
    solid_.tree().closestPoint(place.point, kEverywhere, at);
    place.distance = at.distance;
    place.facet = at.triangle;
    if (exit != nullptr) *exit = at.point;
    if (!count_) return;
    const double nearer = at.distance - slit_;
    if (nearer <= 0.0 || !solid_.lids()->closestPoint(place.point, nearer, lid)) return;
    lidsMatter_ = true;
    place.distance = lid.distance;
    place.facet = lid.triangle | kLid;
  }

  /// Distance from the surface and from lids, whether or not these count.
  double clearance(const Place& place) const {
    MeshPoint lid;
    const bool lidIsNearer =
        solid_.lids() != nullptr && solid_.lids()->closestPoint(place.point, place.distance, lid);
    return lidIsNearer ? std::min(lid.distance, place.distance) : place.distance;
  }

  /// Whether a lid was nearer than the surface.
  bool lidsMatter() const { return lidsMatter_; }

 private:
  const MeshClosing& solid_;
  bool count_;
  double slit_;  // m
  mutable bool lidsMatter_ = false;
};

/// One mesh against the other, the solid, in whose frame everything is measured.
class Search {
 public:
  /// Whether lids count as surface, and only points that are certainly inside.
  enum class Lids { count, ignored };

  Search(const Intrusion& intrusion, Lids lids)
      : in_(intrusion),
        mesh_(intrusion.mesh.mesh()),
        open_(intrusion.solid.lids() != nullptr),
        lids_(lids),
        facets_(intrusion, lids == Lids::count),
        corners_(mesh_.positions.size()),
        inside_(mesh_.positions.size(), 0) {}

  void run(Deepest& best) {
    const std::vector<std::uint32_t> nearby = trianglesInReach();
    noteNear();
    findInside(nearby);
    measureCorners(best);
    if (done(best)) return;
    for (const std::uint32_t t : nearby) pushTriangle(t, best);
    for (int samples = 0, rough = 0; samples < kMaxSamples && !pieces_.empty() && !done(best); ++samples) {
      std::pop_heap(pieces_.begin(), pieces_.end());
      Piece piece = std::move(pieces_.back());
      pieces_.pop_back();
      if (piece.bound <= enough(best) || (staysOpen(piece, best) && rough++ >= kMaxRoughSamples)) break;
      if (piece.crossings.empty())
        measure(piece, best);
      else
        cut(piece, best);
    }
  }

  /// Whether lids bounded the depth of any place, or made it uncertain.
  bool lidsMatter() const { return facets_.lidsMatter() || droppedNearLids_ || uncertain_ > 0.0; }

 private:
  /// What a piece must promise to be measured.
  double enough(const Deepest& best) const { return std::max(best.depth + in_.precision, in_.tolerance); }
  /// Whether the depth stays open whatever a piece holds: deeper points were met that are not certainly
  /// inside. What the depth is at least need not be exact.
  bool staysOpen(const Piece& piece, const Deepest& best) const {
    return uncertain_ > best.depth + in_.tolerance && piece.bound < uncertain_ - in_.tolerance;
  }
  bool done(const Deepest& best) const { return lids_ == Lids::ignored && best.found; }

  Triangle placed(std::uint32_t triangle) const {
    const auto& t = mesh_.triangles[triangle];
    return {placedCorner(t[0]), placedCorner(t[1]), placedCorner(t[2])};
  }
  glm::dvec3 placedCorner(std::uint32_t vertex) const {
    return transformPoint(in_.solidFromMesh, mesh_.positions[vertex]);
  }
  std::vector<std::uint32_t> trianglesInReach() const {
    assets::Bounds reach = boundsAt(in_.solid.tree().bounds(), inverse(in_.solidFromMesh));
    reach.min -= in_.tolerance;
    reach.max += in_.tolerance;
    std::vector<std::uint32_t> found(in_.mesh.gather(reach, {}));
    in_.mesh.gather(reach, found);
    return found;
  }

  /// Sorts the near pairs by the mesh's triangles, and marks these.
  void noteNear() {
    near_ = in_.near;
    std::sort(near_.begin(), near_.end(), [](const NearTriangles& l, const NearTriangles& r) {
      if (l.own != r.own) return l.own < r.own;
      return l.lid != r.lid ? r.lid : l.other < r.other;
    });
    isNear_.assign(mesh_.triangles.size(), kFar);
    for (const NearTriangles& pair : near_)
      isNear_[pair.own] = std::max(isNear_[pair.own], pair.lid ? kNearLids : kNearSurface);
  }

  /// Finds the vertices of the mesh that are inside. A triangle that is not near is wholly inside or
  /// outside, and so is each group connected by such triangles: one test a group.
  void findInside(const std::vector<std::uint32_t>& nearby) {
    DisjointSets groups(mesh_.positions.size());
    std::vector<std::uint8_t> matters(mesh_.positions.size(), 0);
    for (const std::uint32_t t : nearby) {
      const auto& corners = mesh_.triangles[t];
      for (const std::uint32_t v : corners) matters[v] = 1;
      if (isNear_[t] != kFar) continue;
      groups.join(corners[0], corners[1]);
      groups.join(corners[1], corners[2]);
    }
    // The root of a group is its lowest vertex, so it is tested before the others.
    for (std::uint32_t v = 0; v < matters.size(); ++v) {
      if (matters[v] == 0) continue;
      const std::uint32_t root = groups.find(v);
      inside_[v] =
          root == v ? static_cast<std::uint8_t>(in_.solid.contains(placedCorner(v)) ? 1 : 0) : inside_[root];
      if (inside_[v] != 0) vertices_.push_back(v);
    }
  }

  const Place& cornerOf(std::uint32_t vertex) {
    Place& place = corners_[vertex];
    if (place.distance < 0.0) {
      place.point = placedCorner(vertex);
      facets_.locate(place);
    }
    return place;
  }

  /// Whether a point that is inside counts.
  bool counts(const glm::dvec3& p) const {
    return !open_ || lids_ == Lids::ignored || in_.solid.isCertain(p);
  }

  void keepDeepest(Place place, Deepest& best) const {
    glm::dvec3 exit;
    facets_.locate(place, &exit);
    best = {place.distance, place.point, exit - place.point, true};
  }

  void measureCorners(Deepest& best) {
    for (const std::uint32_t v : vertices_) {
      const Place& place = cornerOf(v);
      if (place.distance <= best.depth) continue;
      if (counts(place.point))
        keepDeepest(place, best);
      else
        uncertain_ = std::max(uncertain_, place.distance);
      if (done(best)) return;
    }
  }

  /// Bounds a piece; false if it promises nothing.
  bool bound(Piece& piece, const Deepest& best) const {
    const double least = enough(best);
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3& p = piece.corners[i].point;
      const double reach = std::max(glm::length(piece.corners[(i + 1) % 3].point - p),
                                    glm::length(piece.corners[(i + 2) % 3].point - p));
      if (piece.corners[i].distance + reach <= least) return false;
    }
    std::array<std::uint32_t, 4> facets{piece.corners[0].facet, piece.corners[1].facet,
                                        piece.corners[2].facet, piece.extra};
    std::array<glm::dvec3, 4> distances;
    std::size_t count = 0;
    for (std::size_t f = 0; f < facets.size(); ++f) {
      if (facets[f] == kNoTriangle ||
          std::find(facets.begin(), facets.begin() + f, facets[f]) != facets.begin() + f)
        continue;
      const Triangle t = facets_[facets[f]];
      for (int i = 0; i < 3; ++i) {
        const Place& corner = piece.corners[static_cast<std::size_t>(i)];
        distances[count][i] = corner.facet == facets[f]
                                  ? corner.distance
                                  : glm::length(closestPointOnTriangle(corner.point, t).point - corner.point);
      }
      ++count;
    }
    const Peak peak = peakOfLeast({distances.data(), count});
    piece.bound = std::min(piece.bound, peak.value);
    piece.peak = peak.shares;
    return piece.bound > least;
  }

  void push(Piece&& piece, const Deepest& best) {
    if (!bound(piece, best)) return;
    piece.order = order_++;
    pieces_.push_back(std::move(piece));
    std::push_heap(pieces_.begin(), pieces_.end());
  }

  void pushTriangle(std::uint32_t t, const Deepest& best) {
    const auto& corners = mesh_.triangles[t];
    const bool near = isNear_[t] != kFar;
    if (!near && inside_[corners[0]] == 0) return;
    const std::array<glm::dvec3, 3> p{placedCorner(corners[0]), placedCorner(corners[1]),
                                      placedCorner(corners[2])};
    const double longest =
        std::max({glm::length(p[1] - p[0]), glm::length(p[2] - p[1]), glm::length(p[0] - p[2])});
    Piece piece;
    // Of a triangle that is near the surface, or a lid that counts, no point is farther from it than this.
    piece.bound = near && lids_ == Lids::count ? in_.tolerance + longest : kEverywhere;
    if (piece.bound <= enough(best)) return;
    piece.inside = piece.untouched = !near;
    for (std::size_t i = 0; i < 3; ++i) {
      piece.corners[i] = cornerOf(corners[i]);
      piece.corners[i].shares = {i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
    }
    if (near) findCrossings(t, piece);
    push(std::move(piece), best);
  }

  void findCrossings(std::uint32_t t, Piece& piece) {
    const Triangle own = placed(t);
    const auto first =
        std::lower_bound(near_.begin(), near_.end(), t,
                         [](const NearTriangles& pair, std::uint32_t i) { return pair.own < i; });
    for (auto pair = first; pair != near_.end() && pair->own == t; ++pair) {
      if (!pair->crosses) continue;
      const std::optional<Crossing> crossing =
          crossingOf(own, facets_[pair->other | (pair->lid ? kLid : 0u)]);
      if (!crossing || !(shareWithin(*crossing, piece) > 0.0)) continue;
      piece.crossings.push_back(static_cast<std::uint32_t>(crossings_.size()));
      crossings_.push_back(*crossing);
    }
  }

  Place between(const Place& from, const Place& to, double share) const {
    Place place;
    place.point = from.point + (to.point - from.point) * share;
    place.shares = from.shares + (to.shares - from.shares) * share;
    facets_.locate(place);
    return place;
  }

  /// Cuts a piece along the line of the longest crossing.
  void cut(Piece& piece, const Deepest& best) {
    std::size_t chosen = 0;
    double longest = -1.0;
    for (std::size_t i = 0; i < piece.crossings.size(); ++i) {
      const Crossing& crossing = crossings_[piece.crossings[i]];
      const double length = glm::length(crossing.to - crossing.from) * shareWithin(crossing, piece);
      if (length > longest) longest = length, chosen = i;
    }
    const Crossing line = crossings_[piece.crossings[chosen]];
    piece.crossings.erase(piece.crossings.begin() + static_cast<std::ptrdiff_t>(chosen));
    for (Piece& part : partsBeside(piece, heightsOver(line, piece))) {
      for (const std::uint32_t crossing : piece.crossings)
        if (shareWithin(crossings_[crossing], part) > 0.0) part.crossings.push_back(crossing);
      push(std::move(part), best);
    }
  }

  /// The parts of a piece on both sides of a line, given the signed heights of its corners over it.
  std::vector<Piece> partsBeside(const Piece& piece, const Heights& above) const {
    const auto& corners = piece.corners;
    const auto where = [&](std::size_t i, std::size_t j) {
      return between(corners[i], corners[j], above[i] / (above[i] - above[j]));
    };
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      if (above[i] == 0.0 && above[j] * above[k] < 0.0) {
        const Place middle = where(j, k);
        return {piece.part(corners[i], corners[j], middle), piece.part(corners[i], middle, corners[k])};
      }
      if (above[i] * above[j] < 0.0 && above[i] * above[k] < 0.0) {
        const Place left = where(i, j), right = where(i, k);
        return {piece.part(corners[i], left, right), piece.part(left, corners[j], corners[k]),
                piece.part(left, corners[k], right)};
      }
    }
    return {piece.part(corners[0], corners[1], corners[2])};
  }

  /// Whether a piece that nothing crosses is seen outside at its centre and at its peak.
  bool isOutside(const Piece& piece, const Place& peak) const {
    return !piece.inside && !in_.solid.contains(piece.at(glm::dvec3(1.0 / 3.0)).point) &&
           !in_.solid.contains(peak.point);
  }

  /// Whether the peak of a piece that counts as inside is not. Where surfaces nearly coincide, rounding may
  /// hide where they cross. Tested just off the peak, which may be a place where a lid crosses.
  bool isMistaken(const Piece& piece) const {
    constexpr double kOff = 0x1p-10;
    return !piece.untouched &&
           !in_.solid.contains(piece.at((1.0 - kOff) * piece.peak + glm::dvec3(kOff / 3.0)).point);
  }

  /// Tells on which side a piece is that nothing crosses, from that of its two points that is farther from
  /// the surface. False if it is outside, or flush with the surface.
  bool isWorthwhile(Piece& piece, const Place& peak) const {
    if (piece.inside) return true;
    Place centre = piece.at(glm::dvec3(1.0 / 3.0));
    facets_.locate(centre);
    const double ofCentre = facets_.clearance(centre), ofPeak = facets_.clearance(peak);
    if (std::max(ofCentre, ofPeak) <= in_.tolerance) return piece.flush++ < kFlushHalvings;
    if (!in_.solid.contains(ofCentre > ofPeak ? centre.point : peak.point)) return false;
    piece.inside = true;
    return true;
  }

  /// Measures the peak of a piece that nothing crosses, and divides the piece if it still promises more.
  void measure(Piece& piece, Deepest& best) {
    Place peak = piece.at(piece.peak);
    if (isOutside(piece, peak)) return;
    if (peak.distance < 0.0) facets_.locate(peak);
    if (!isWorthwhile(piece, peak)) return;
    if (piece.inside && peak.distance > best.depth && isMistaken(piece)) {
      piece.inside = false;
      if (isOutside(piece, peak)) return;
    }
    if (piece.inside && peak.distance > best.depth) {
      if (counts(peak.point)) {
        keepDeepest(peak, best);
        if (done(best)) return;
      } else {
        uncertain_ = std::max(uncertain_, peak.distance);
        if (isUncertain(piece, peak)) return;
      }
    }
    piece.extra = peak.facet;
    if (!bound(piece, best)) return;
    const std::optional<Heights> above = heightsOverSide(facets_[peak.facet], piece);
    if (!above) return halve(piece, best);
    for (Piece& part : partsBeside(piece, *above)) push(std::move(part), best);
  }

  /// Whether no point of a piece is certainly inside. The generalised winding number is harmonic off the
  /// surface and takes values of a unit's width, so within r of a point whose distance to the surface is d
  /// it changes by at most 3/2 r / (d - r).
  bool isUncertain(const Piece& piece, const Place& peak) const {
    double radius = 0.0;
    for (const Place& corner : piece.corners)
      radius = std::max(radius, glm::length(corner.point - peak.point));
    if (!(radius < peak.distance)) return false;
    const double needed = MeshClosing::kMaxLidShare + 1.5 * radius / (peak.distance - radius);
    const MeshClosing::RoughShare rough = in_.solid.roughLidShare(peak.point);
    if (std::abs(std::abs(rough.value) - needed) > rough.error) return std::abs(rough.value) > needed;
    return std::abs(in_.solid.lidShare(peak.point)) > needed;
  }

  void halve(const Piece& piece, const Deepest& best) {
    std::size_t longest = 0;
    for (std::size_t i = 1; i < 3; ++i) longest = piece.side(i) > piece.side(longest) ? i : longest;
    const Place &a = piece.corners[longest], &b = piece.corners[(longest + 1) % 3],
                &c = piece.corners[(longest + 2) % 3];
    const Place middle = between(a, b, 0.5);
    push(piece.part(a, middle, c), best);
    push(piece.part(middle, b, c), best);
  }

  const Intrusion& in_;
  const assets::Mesh& mesh_;
  bool open_;  // the solid has lids
  Lids lids_;
  Facets facets_;
  std::vector<NearTriangles> near_;      // by own
  std::vector<Near> isNear_;             // one a triangle of the mesh: Near
  std::vector<Place> corners_;           // one a vertex of the mesh
  std::vector<std::uint8_t> inside_;     // one a vertex of the mesh
  std::vector<std::uint32_t> vertices_;  // inside, ascending
  std::vector<Crossing> crossings_;
  std::vector<Piece> pieces_;  // a heap
  std::uint64_t order_ = 0;
  bool droppedNearLids_ = false;  // a triangle near lids alone was left out
  double uncertain_ = 0.0;        // m, depth of the deepest point met that is not certainly inside
};

}  // namespace

bool containsPoint(const TriangleBvh& tree, const glm::dvec3& p) {
  const assets::Bounds& box = tree.bounds();
  if (tree.empty() || glm::any(glm::lessThan(p, box.min)) || glm::any(glm::greaterThan(p, box.max))) {
    return false;
  }
  // Directions without zero or equal components, because CAD faces are axis-parallel and their edges often
  // at 45 degrees.
  static constexpr double kRays[3][3] = {{1.0, 0.137, 0.271}, {-0.193, 1.0, -0.311}, {0.229, -0.173, -1.0}};
  const double length = 1.5 * glm::length(box.max - box.min);
  int inside = 0, outside = 0;
  for (const auto& ray : kRays) {
    for (const double side : {length, -length}) {
      const glm::dvec3 path = glm::dvec3(ray[0], ray[1], ray[2]) * side;
      ++(tree.signedCrossings(p, p + path) != 0 ? inside : outside);
      if (outside > 1) return false;
    }
  }
  return inside >= 5;
}

bool findDeepest(const Intrusion& intrusion, Deepest& best) {
  ASSERT(intrusion.tolerance >= 0.0 && intrusion.precision > 0.0);
  for (const NearTriangles& pair : intrusion.near) ASSERT(pair.own < intrusion.mesh.mesh().triangles.size());
  Search search(intrusion, Search::Lids::count);
  search.run(best);
  return search.lidsMatter();
}

bool anyDeeperWithoutLids(const Intrusion& intrusion, double depth) {
  if (intrusion.solid.lids() == nullptr) return false;
  Deepest deeper;
  deeper.depth = std::max(depth, intrusion.tolerance);
  Search(intrusion, Search::Lids::ignored).run(deeper);
  return deeper.found;
}

}  // namespace tandem::haptics
