#include "haptics/geometry/mesh_sides.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/slit_caps.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kPlaces = 1000;
/// Tolerance within which a winding number counts as whole; half way to where the side would be ambiguous.
constexpr double kWhole = 0.25;
/// Share of the surface with a sensible inside behind it, from which a mesh counts as solid.
constexpr double kSolidShare = 0.75;
/// At more than this many reaches from all open edges, the winding number changes by less than half a unit
/// within a reach. It is harmonic there, so its slope is at most three times its largest change over the
/// distance (here 1/2), which with the margin makes 0.45.
constexpr double kFarFromOpen = 6.0;
constexpr double kNearlyWhole = 0.2;
/// Share of the surface where closed holes must give the same sides as the winding number.
constexpr double kAgreedShare = 0.99;
/// Share from which a mesh with closed holes counts as free of overlaps; the rest is attributed to misplaced
/// caps.
constexpr double kAlikeShare = 0.998;
/// Share of a mesh's surface from which a hole is a mouth, as that of a cup or tube, rather than a defect.
constexpr double kMouthShare = 1.0 / 32.0;
/// Places along each side of a cap of one triangle where its two sides are compared; how far from it, as a
/// share of the surface's root.
constexpr double kAcrossCap = 16.0;
constexpr double kBesideCap = 0x1p-10;
/// Margin of distance comparisons.
constexpr double kNearly = 1.0 + 0x1p-30;

struct EdgeUse {
  std::uint64_t key = 0;     // lower corner, upper corner
  std::uint32_t place = 0;   // 3 * triangle + edge
  std::int32_t forward = 0;  // 1 from the lower to the upper corner, else -1
};

glm::dvec3 unitOrZero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0.0 ? v / length : glm::dvec3(0.0);
}

/// The uses of all edges, with those of the same edge adjacent.
std::vector<EdgeUse> sortedUses(const assets::Mesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t a = mesh.triangles[t][e], b = mesh.triangles[t][(e + 1) % 3];
      uses.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), 3 * t + e, a < b ? 1 : -1});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return a.key != b.key ? a.key < b.key : a.place < b.place;
  });
  return uses;
}

/// Interpretation of the winding numbers in front of and behind a face.
enum class Reading { solid, inner, reversed, senseless };
constexpr std::size_t kReadings = 4;

Reading readingOf(double front, double behind) {
  const double whole = std::round(front);
  if (std::abs(front - whole) > kWhole || std::abs(behind - whole - 1.0) > kWhole) return Reading::senseless;
  if (whole == 0.0) return Reading::solid;
  return whole == -1.0 ? Reading::reversed : Reading::inner;
}

}  // namespace

MeshSides::MeshSides(const TriangleBvh& tree, std::size_t firstCap, int threads)
    : tree_(tree), mesh_(tree.mesh()), firstCap_(std::min(firstCap, mesh_.triangles.size())) {
  findEdges();
  findNormals();
  if (anyOpen_) closeHoles(threads);
  ASSERT(edge_.size() == mesh_.triangles.size());
  judge();
  if (solid_ && kind_ == Kind::winding && anyOpen_) buildOpenEdges();
}

void MeshSides::findEdges() {
  const std::vector<EdgeUse> uses = sortedUses(mesh_);
  edge_.resize(mesh_.triangles.size());
  for (std::size_t first = 0, last = 0; first < uses.size(); first = last) {
    glm::dvec3 normal(0.0);
    int balance = 0;
    for (; last < uses.size() && uses[last].key == uses[first].key; ++last) {
      const std::uint32_t t = uses[last].place / 3;
      edge_[t][uses[last].place % 3] = static_cast<std::uint32_t>(edgeNormals_.size());
      if (t < firstCap_) normal += unitOrZero(areaVector(tree_.triangle(t)));
      balance += uses[last].forward;
    }
    edgeNormals_.push_back(normal);
    if (balance == 0) continue;
    anyOpen_ = true;
    open_.resize(mesh_.triangles.size(), 0);
    for (std::size_t i = first; i < last; ++i)
      open_[uses[i].place / 3] |= static_cast<std::uint8_t>(1u << (uses[i].place % 3));
  }
}

void MeshSides::findNormals() {
  if (firstCap_ < mesh_.triangles.size()) besideSlit_.assign(mesh_.positions.size(), false);
  for (std::size_t t = firstCap_; t < mesh_.triangles.size(); ++t)
    for (const std::uint32_t vertex : mesh_.triangles[t]) besideSlit_[vertex] = true;
  cornerNormals_.assign(mesh_.positions.size(), glm::dvec3(0.0));
  for (std::uint32_t t = 0; t < firstCap_; ++t) {
    const glm::dvec3 normal = unitOrZero(areaVector(tree_.triangle(t)));
    for (std::size_t c = 0; c < 3; ++c) {
      const glm::dvec3& corner = mesh_.positions[mesh_.triangles[t][c]];
      const glm::dvec3 ab = mesh_.positions[mesh_.triangles[t][(c + 1) % 3]] - corner;
      const glm::dvec3 ac = mesh_.positions[mesh_.triangles[t][(c + 2) % 3]] - corner;
      const double angle = std::atan2(glm::length(glm::cross(ab, ac)), glm::dot(ab, ac));
      cornerNormals_[mesh_.triangles[t][c]] += angle * normal;
    }
  }
}

int MeshSides::crossingsFrom(const glm::dvec3& p) const {
  // Skew directions, because CAD has edges along the axes. A ray that hits an edge exactly is outvoted.
  constexpr double kFar = 4.0;
  const double reach = kFar * glm::distance(mesh_.bounds.min, mesh_.bounds.max);
  const TriangleBvh& closed = closedTree_ != nullptr ? *closedTree_ : tree_;
  std::array<int, 3> counts;
  const std::array<glm::dvec3, 3> directions = {glm::dvec3(0.5377, 0.2913, 0.7912),
                                                glm::dvec3(-0.6121, 0.7413, -0.2757),
                                                glm::dvec3(0.1733, -0.8347, -0.5227)};
  for (std::size_t i = 0; i < 3; ++i) {
    counts[i] = closed.signedCrossings(p, p + reach * directions[i]);
    if (i == 1 && counts[0] == counts[1]) return counts[0];
  }
  std::sort(counts.begin(), counts.end());
  return counts[1];
}

void MeshSides::closeHoles(int threads) {
  const SlitCaps caps = capSlits(mesh_, std::numeric_limits<double>::max());
  if (!caps.complete) return;
  holeMesh_.positions = closedMesh_.positions = mesh_.positions;
  holeMesh_.bounds = closedMesh_.bounds = mesh_.bounds;
  holeMesh_.triangles = caps.triangles;
  loopOfCap_ = caps.loop;
  closedMesh_.triangles = mesh_.triangles;
  closedMesh_.triangles.insert(closedMesh_.triangles.end(), caps.triangles.begin(), caps.triangles.end());
  holeTree_ = std::make_unique<TriangleBvh>(holeMesh_, threads);
  closedTree_ = std::make_unique<TriangleBvh>(closedMesh_, threads);
}

void MeshSides::judge() {
  if (anyOpen_) winding_ = std::make_unique<WindingTree>(mesh_);
  const bool closed = !anyOpen_ || closedTree_ != nullptr;
  std::array<double, kReadings> area{};  // m^2 of samples, by reading
  double agreed = 0.0, alike = 0.0,
         all = 0.0;  // m^2: holes closed or not, all sides the same; outside in front
  const std::size_t step = std::max<std::size_t>(1, firstCap_ / kPlaces);
  for (std::size_t t = 0; t < firstCap_; t += step) {
    const Triangle corners = tree_.triangle(static_cast<std::uint32_t>(t));
    const glm::dvec3 normal = areaVector(corners);
    const double size = glm::length(normal);
    const double around = glm::distance(corners.a, corners.b) + glm::distance(corners.b, corners.c) +
                          glm::distance(corners.c, corners.a);
    if (size <= 0.0 || around <= 0.0) continue;
    // An uneven sample point, because CAD puts many edges over the centres of others, and so near that
    // nothing is likely to lie between.
    const glm::dvec3 place = 0.41 * corners.a + 0.35 * corners.b + 0.24 * corners.c;
    const glm::dvec3 off = 0x1p-10 / around * normal;
    Reading reading = Reading::senseless, whole = Reading::senseless;
    if (closed) reading = whole = readingOf(crossingsFrom(place + off), crossingsFrom(place - off));
    if (winding_ != nullptr) reading = readingOf(winding_->at(place + off), winding_->at(place - off));
    area[static_cast<std::size_t>(reading)] += size;
    all += size;
    if (reading == whole || reading == Reading::senseless) agreed += size;
    if (whole == Reading::solid || whole == Reading::reversed) alike += size;
  }
  const auto areaOf = [&area](Reading reading) { return area[static_cast<std::size_t>(reading)]; };
  const double outer = std::max(areaOf(Reading::solid), areaOf(Reading::reversed));
  solid_ = all > 0.0 && outer + areaOf(Reading::inner) >= kSolidShare * all;
  if (!solid_) return;
  facing_ = areaOf(Reading::reversed) > areaOf(Reading::solid) ? -1.0 : 1.0;
  kind_ = !closed || agreed < kAgreedShare * all          ? Kind::winding
          : alike >= (anyOpen_ ? kAlikeShare : 1.0) * all ? Kind::clean
                                                          : Kind::crossings;
  mouth_ = winding_ != nullptr && holeTree_ != nullptr && findMouth();
  if (kind_ != Kind::winding) winding_.reset();
  ASSERT((kind_ == Kind::winding) == (winding_ != nullptr) && (closed || kind_ == Kind::winding));
}

double MeshSides::enteredArea(const Triangle& cap, int across, double beside) const {
  const glm::dvec3 normal = areaVector(cap);
  const double size = glm::length(normal);
  if (!(size > 0.0)) return 0.0;
  const glm::dvec3 off = beside / size * normal;
  int all = 0, entered = 0;
  for (int i = 0; i < across; ++i) {
    for (int j = 0; j < across - i; ++j) {
      const glm::dvec3 place =
          cap.a + (i + 1.0 / 3.0) / across * (cap.b - cap.a) + (j + 1.0 / 3.0) / across * (cap.c - cap.a);
      ++all;
      // Where a hole was closed rightly, the cap is half way between outside and inside.
      if (std::abs(facing_ * winding_->at(place) - 0.5) <= kWhole &&
          (crossingsFrom(place + off) == 0) != (crossingsFrom(place - off) == 0))
        ++entered;
    }
  }
  return 0.5 * size * entered / all;
}

bool MeshSides::findMouth() const {
  double surface = 0.0;  // m^2
  for (std::uint32_t t = 0; t < firstCap_; ++t) surface += 0.5 * glm::length(areaVector(tree_.triangle(t)));
  const auto capAt = [this](std::size_t t) { return holeTree_->triangle(static_cast<std::uint32_t>(t)); };
  const std::size_t count = holeMesh_.triangles.size();
  for (std::size_t first = 0, last = 0; first < count; first = last) {
    double area = 0.0, entered = 0.0;  // m^2, of the cap; where outside turns into inside
    for (; last < count && loopOfCap_[last] == loopOfCap_[first]; ++last)
      area += 0.5 * glm::length(areaVector(capAt(last)));
    if (area < kMouthShare * surface) continue;
    for (std::size_t t = first; t < last; ++t) {
      const double share = 0.5 * glm::length(areaVector(capAt(t))) / area;
      entered += enteredArea(capAt(t), static_cast<int>(std::ceil(kAcrossCap * std::sqrt(share))),
                             kBesideCap * std::sqrt(surface));
    }
    if (entered >= kAgreedShare * area) return true;
  }
  return false;
}

void MeshSides::buildOpenEdges() {
  openMesh_.positions = mesh_.positions;
  openMesh_.bounds = mesh_.bounds;
  for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    for (std::size_t e = 0; e < 3; ++e) {
      if (!openEdge(t, e)) continue;
      const std::uint32_t a = mesh_.triangles[t][e], b = mesh_.triangles[t][(e + 1) % 3];
      openMesh_.triangles.push_back({a, b, b});
      openMesh_.triangleMaterial.push_back(0);
    }
  }
  openTree_ = std::make_unique<TriangleBvh>(openMesh_, 1);
}

glm::dvec3 MeshSides::outwards(const MeshPoint& at) const {
  ASSERT(at.triangle < edge_.size());
  const auto& t = mesh_.triangles[at.triangle];
  const std::array<glm::dvec3, 3> corners = {mesh_.positions[t[0]], mesh_.positions[t[1]],
                                             mesh_.positions[t[2]]};
  if (at.onFace) return facing_ * glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  std::size_t edge = 0;
  double least = 1e300;
  for (std::size_t e = 0; e < 3; ++e) {
    if (at.point == corners[e]) return facing_ * cornerNormals_[t[e]];
    const glm::dvec3 along = corners[(e + 1) % 3] - corners[e];
    const double off = glm::length(glm::cross(along, at.point - corners[e])) / glm::length(along);
    if (!(off < least)) continue;
    least = off;
    edge = e;
  }
  return facing_ * edgeNormals_[edge_[at.triangle][edge]];
}

MeshSides::Side MeshSides::sideAt(const glm::dvec3& p, double reach) const {
  if (!solid_) return {};
  if (kind_ != Kind::winding) {
    MeshPoint hole;
    const bool certain = holeTree_ == nullptr || !holeTree_->closestPoint(p, kNearly * reach, hole);
    return {facing_ * crossingsFrom(p) > 0.0 ? -1.0 : 1.0, certain};
  }
  const double winding = facing_ * winding_->at(p);
  // Away from all open edges the winding number is smooth except for its unit steps at the surface.
  MeshPoint open;
  const bool certain = std::abs(winding - std::round(winding)) <= kNearlyWhole &&
                       !(openTree_ != nullptr && openTree_->closestPoint(p, kFarFromOpen * reach, open));
  return {winding > 0.5 ? -1.0 : 1.0, certain};
}

MeshSides::Side MeshSides::sideOf(const glm::dvec3& p, const MeshPoint& nearest, double reach) const {
  if (!solid_ || kind_ != Kind::clean) return sideAt(p, reach);
  const double searched = kNearly * std::max(nearest.distance, reach);
  MeshPoint cap;
  double hole = std::numeric_limits<double>::max();
  if (holeTree_ != nullptr && holeTree_->closestPoint(p, searched, cap)) hole = cap.distance;
  const bool certain = hole > kNearly * reach;
  // Caps may fold where the rim of a hole does, so the nearest feature of a cap says nothing.
  if (hole <= kNearly * nearest.distance || isBesideSlit(nearest))
    return {facing_ * crossingsFrom(p) > 0.0 ? -1.0 : 1.0, certain};
  return {glm::dot(outwards(nearest), p - nearest.point) >= 0.0 ? 1.0 : -1.0, certain};
}

bool MeshSides::isCertain(const glm::dvec3& p, double reach) const {
  if (!solid_) return true;
  if (kind_ == Kind::winding) return sideAt(p, reach).certain;
  MeshPoint hole;
  return holeTree_ == nullptr || !holeTree_->closestPoint(p, kNearly * reach, hole);
}

bool MeshSides::isBesideSlit(const MeshPoint& at) const {
  if (at.triangle >= firstCap_) return true;
  if (at.onFace || besideSlit_.empty()) return false;
  const auto& t = mesh_.triangles[at.triangle];
  return besideSlit_[t[0]] || besideSlit_[t[1]] || besideSlit_[t[2]];
}

bool MeshSides::isRegular(const glm::dvec3& p, double reach) const {
  MeshPoint hole;
  return solid_ && kind_ == Kind::clean &&
         (holeTree_ == nullptr || !holeTree_->closestPoint(p, kNearly * reach, hole));
}

}  // namespace tandem::haptics
