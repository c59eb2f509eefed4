#include "assets/mesh/round_faces.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "assets/mesh/cut_facets.h"

namespace tandem::assets {
namespace {

constexpr double kWidestFacet = 2.0 * kPi / 12.0 + 0.03;  // rad
constexpr double kOff = 1e-5;                             // of the radius, that a corner may be off
constexpr double kLargest = 16.0;                         // mesh diagonals that a radius may measure
constexpr double kMostChecks = 1e9;         // pairs of a face and a corner that one mesh may cost
constexpr double kMerged = 0.02;            // of a segment: corners that are on one ruling
constexpr std::size_t kMostRulings = 4096;  // of a cylinder

double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

/// A cylinder with the facets that lie on it.
struct Barrel {
  explicit Barrel(const RoundFace& stretch) : face(stretch) {
    const glm::dvec3 least = std::abs(face.axis.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    x = glm::normalize(glm::cross(face.axis, least));
    y = glm::cross(face.axis, x);
  }
  double heightOf(const glm::dvec3& p) const { return glm::dot(p - face.point, face.axis); }
  glm::dvec3 across(const glm::dvec3& p) const { return p - face.point - heightOf(p) * face.axis; }
  double angleOf(const glm::dvec3& p) const {
    return std::atan2(glm::dot(p - face.point, y), glm::dot(p - face.point, x));
  }
  glm::dvec3 outward(double angle) const { return std::cos(angle) * x + std::sin(angle) * y; }
  glm::dvec3 at(double angle, double height) const {
    return face.point + cornerRadius() * outward(angle) + height * face.axis;
  }
  /// Where the corners of its facets go.
  double cornerRadius() const {
    if (!(cut.bound > 0.0)) return face.radius;
    return face.hollow ? cut.bound / std::cos(0.5 * widest) : cut.bound;
  }
  double sign() const { return face.hollow ? -1.0 : 1.0; }
  /// Whether both are stretches of one cylinder, which then counts as a whole.
  bool takes(const RoundFace& other, double off) {
    if (other.hollow != face.hollow || std::abs(other.radius - face.radius) > off) return false;
    if (glm::length(across(other.point)) > off) return false;
    const glm::dvec3 low = other.point + other.from * other.axis, high = other.point + other.to * other.axis;
    if (glm::length(across(low)) > off || glm::length(across(high)) > off) return false;
    face.from = std::min({face.from, heightOf(low), heightOf(high)});
    face.to = std::max({face.to, heightOf(low), heightOf(high)});
    return true;
  }

  RoundFace face;
  RoundCut cut;
  glm::dvec3 x, y;
  std::vector<std::size_t> of;                    // the faces that it stands for
  std::vector<double> rulings;                    // rad, ascending, along which facets meet
  std::map<std::uint32_t, std::size_t> rulingOf;  // of each corner, its ruling
  double widest = 0.0;                            // rad, of its facets
  bool usable = true;
  std::size_t triangles = 0;
};

/// Cuts one mesh.
class Rounder {
 public:
  Rounder(const Mesh& mesh, const RoundFaces& rounds, double rounding)
      : mesh_(mesh), rounds_(rounds), rounding_(rounding), owner_(mesh.triangles.size(), kNone) {
    size_ = glm::length(mesh.bounds.max - mesh.bounds.min);
    const glm::dvec3 far = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
    corner_ = 8.0 * std::max(rounding, std::ldexp(glm::length(far), -24));
  }

  RoundedMesh run() {
    gather();
    for (std::uint32_t b = 0; b < barrels_.size(); ++b) own(b);
    leaveCrossings();
    for (std::uint32_t b = 0; b < barrels_.size(); ++b) rule(b);
    RoundedMesh out;
    std::vector<std::uint32_t> failed;
    for (int pass = 0; pass < 4; ++pass) {
      failed.clear();
      out.soup = cut(failed);
      if (failed.empty()) break;
      for (const std::uint32_t b : failed) drop(b);
    }
    if (!failed.empty() || (out.soup.triangles.size() == mesh_.triangles.size() && shifts().empty()))
      out.soup = {};
    count(out, !failed.empty());
    return out;
  }

 private:
  double offOf(const RoundFace& face) const { return corner_ + kOff * std::min(face.radius, size_); }

  void gather() {
    double checks = 0.0;
    for (std::size_t i = 0; i < rounds_.faces.size(); ++i) {
      if (rounds_.cuts[i].segments == 0) continue;
      const RoundFace& face = rounds_.faces[i];
      const auto same = std::find_if(barrels_.begin(), barrels_.end(),
                                     [&](Barrel& known) { return known.takes(face, offOf(face)); });
      checks += static_cast<double>(barrels_.size() + mesh_.positions.size());
      if (checks > kMostChecks || face.radius > kLargest * size_) {
        ++unread_;
        continue;
      }
      Barrel& barrel = same != barrels_.end() ? *same : barrels_.emplace_back(face);
      barrel.cut.segments = std::max(barrel.cut.segments, rounds_.cuts[i].segments);
      barrel.cut.bound = std::max(barrel.cut.bound, rounds_.cuts[i].bound);
      barrel.of.push_back(i);
    }
  }

  bool lies(const Barrel& barrel, const glm::dvec3& p) const {
    const double off = offOf(barrel.face), height = barrel.heightOf(p);
    return height > barrel.face.from - off && height < barrel.face.to + off &&
           std::abs(glm::length(barrel.across(p)) - barrel.face.radius) < off;
  }

  /// Finds the triangles that stand for a cylinder.
  void own(std::uint32_t b) {
    Barrel& barrel = barrels_[b];
    std::vector<bool> on(mesh_.positions.size());
    for (std::size_t v = 0; v < on.size(); ++v) on[v] = lies(barrel, mesh_.positions[v]);
    for (std::size_t t = 0; t < owner_.size(); ++t) {
      const auto& c = mesh_.triangles[t];
      if (owner_[t] == kNone && on[c[0]] && on[c[1]] && on[c[2]] && standsFor(barrel, c)) {
        owner_[t] = b;
        ++barrel.triangles;
      }
    }
  }

  bool standsFor(const Barrel& barrel, const std::array<std::uint32_t, 3>& c) const {
    const glm::dvec3 &p = mesh_.positions[c[0]], &q = mesh_.positions[c[1]], &r = mesh_.positions[c[2]];
    const glm::dvec3 normal = glm::cross(q - p, r - p), out = barrel.across((p + q + r) / 3.0);
    const double length = glm::length(normal), a = barrel.angleOf(p), b = barrel.angleOf(q),
                 d = barrel.angleOf(r);
    return std::abs(wrapped(b - a)) < kWidestFacet && std::abs(wrapped(d - a)) < kWidestFacet &&
           std::abs(wrapped(d - b)) < kWidestFacet &&
           std::abs(glm::dot(normal, barrel.face.axis)) < 0.2 * length &&
           barrel.sign() * glm::dot(normal, out) > 0.8 * length * glm::length(out);
  }

  /// Where two cylinders meet, the facets of the one beside the other stay as they are, as their common edge
  /// can follow only one of both.
  void leaveCrossings() {
    const std::vector<std::uint32_t> owner = owner_;
    for (std::size_t t = 0; t < owner.size(); ++t) {
      if (owner[t] == kNone) continue;
      for (const std::uint32_t beside : mesh_.neighbours[t])
        if (beside != kNone && owner[beside] != kNone && owner[beside] != owner[t]) owner_[t] = kNone;
    }
  }

  /// Lays the rulings of a cylinder: through all corners of its facets, and closely enough between these.
  void rule(std::uint32_t b) {
    Barrel& barrel = barrels_[b];
    std::vector<std::pair<double, std::uint32_t>> corners;
    for (std::size_t t = 0; t < owner_.size(); ++t)
      if (owner_[t] == b)
        for (const std::uint32_t v : mesh_.triangles[t])
          corners.emplace_back(barrel.angleOf(mesh_.positions[v]), v);
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    const double step = 2.0 * kPi / barrel.cut.segments, merged = kMerged * step;
    for (const auto& [angle, v] : corners) {
      if (barrel.rulings.empty() || angle - barrel.rulings.back() > merged) {
        if (!barrel.rulings.empty()) fill(barrel, angle, step);
        barrel.rulings.push_back(angle);
      }
      barrel.rulingOf[v] = barrel.rulings.size() - 1;
      if (barrel.rulings.size() > kMostRulings) return drop(b);
    }
    if (barrel.rulings.empty()) return;
    const double whole = barrel.rulings.front() + 2.0 * kPi;
    if (whole - barrel.rulings.back() > merged) {
      fill(barrel, whole, step);
    } else {
      // The last corners are on the first ruling.
      const std::size_t last = barrel.rulings.size() - 1;
      for (auto& [v, at] : barrel.rulingOf) at = at == last ? 0 : at;
      barrel.rulings.pop_back();
    }
    measureWidest(barrel, merged);
  }

  /// Corners up to `merged` rad beside their ruling make a facet wider.
  static void measureWidest(Barrel& barrel, double merged) {
    for (std::size_t i = 0; i < barrel.rulings.size(); ++i) {
      const double next =
          i + 1 < barrel.rulings.size() ? barrel.rulings[i + 1] : barrel.rulings[0] + 2.0 * kPi;
      const double width = next - barrel.rulings[i] + 2.0 * merged;
      if (width < kWidestFacet + 2.0 * merged) barrel.widest = std::max(barrel.widest, width);
    }
  }

  static void fill(Barrel& barrel, double to, double step) {
    const double from = barrel.rulings.back(), gap = to - from;
    if (gap > kWidestFacet) return;
    const int pieces = static_cast<int>(std::ceil(gap / step - 1e-6));
    for (int k = 1; k < pieces; ++k) barrel.rulings.push_back(from + gap * k / pieces);
  }

  void drop(std::uint32_t b) {
    barrels_[b].usable = false;
    for (std::uint32_t& owner : owner_) owner = owner == b ? kNone : owner;
  }

  /// The points at which the edge from corner e of triangle t is cut.
  void cutEdge(FacetCutter& cutter, std::size_t t, std::size_t e) const {
    const Barrel& barrel = barrels_[owner_[t]];
    const auto& c = mesh_.triangles[t];
    const std::uint32_t a = std::min(c[e], c[(e + 1) % 3]), b = std::max(c[e], c[(e + 1) % 3]);
    if (cutter.isCut(a, b)) return;
    const std::size_t count = barrel.rulings.size(), from = barrel.rulingOf.at(a), to = barrel.rulingOf.at(b);
    if (from == to) return;
    const glm::dvec3 &p = mesh_.positions[a], &q = mesh_.positions[b];
    const double start = barrel.angleOf(p), turn = wrapped(barrel.angleOf(q) - start);
    const std::uint32_t beside = mesh_.neighbours[t][e];
    for (std::size_t at = from;;) {
      at = turn > 0.0 ? (at + 1) % count : (at + count - 1) % count;
      if (at == to) break;
      const double angle = barrel.rulings[at], share = wrapped(angle - start) / turn;
      if (!(share > 0.0 && share < 1.0)) break;
      const double height = heightAt(barrel, p, q, share, angle, beside);
      cutter.addPoint(a, b, barrel.at(angle, height), share, at);
    }
  }

  /// The height at which an edge crosses a ruling: in the plane of a flat face beside the cylinder.
  double heightAt(const Barrel& barrel, const glm::dvec3& p, const glm::dvec3& q, double share, double angle,
                  std::uint32_t beside) const {
    const double low = barrel.heightOf(p), high = barrel.heightOf(q), line = low + share * (high - low);
    if (std::abs(high - low) < offOf(barrel.face)) return line;
    if (beside == kNone || owner_[beside] != kNone) return line;
    const auto& c = mesh_.triangles[beside];
    const glm::dvec3 origin = mesh_.positions[c[0]];
    const glm::dvec3 normal =
        glm::normalize(glm::cross(mesh_.positions[c[1]] - origin, mesh_.positions[c[2]] - origin));
    const double along = glm::dot(normal, barrel.face.axis);
    if (!(std::abs(along) > 0.3)) return line;
    const double height = glm::dot(normal, origin - barrel.at(angle, 0.0)) / along;
    return std::abs(height - line) < std::abs(high - low) ? height : line;
  }

  TriangleSoup cut(std::vector<std::uint32_t>& failed) const {
    FacetCutter cutter(mesh_, rounding_);
    for (const auto& [v, by] : shifts()) cutter.movePoint(v, by);
    for (std::size_t t = 0; t < owner_.size(); ++t) {
      for (std::size_t e = 0; owner_[t] != kNone && e < 3; ++e) cutEdge(cutter, t, e);
      if (cutter.points() > mesh_.positions.size() + rounds_.most) return allUnsound(failed);
    }
    std::map<std::uint32_t, bool> unsound;
    for (std::size_t t = 0; t < owner_.size(); ++t) {
      if (owner_[t] != kNone) {
        const Barrel& barrel = barrels_[owner_[t]];
        const RulingOf ruling{&barrel.rulingOf, barrel.rulings.size()};
        cutter.addRound(t, ruling, [&](const glm::dvec3& p) {
          return glm::vec3(barrel.sign() * glm::normalize(barrel.across(p)));
        });
      } else if (!cutter.addFlat(t)) {
        bool known = false;
        for (const std::uint32_t beside : mesh_.neighbours[t])
          if (beside != kNone && owner_[beside] != kNone) known = unsound[owner_[beside]] = true;
        if (!known) return allUnsound(failed);
      }
      if (cutter.size() > mesh_.triangles.size() + rounds_.most) return allUnsound(failed);
    }
    for (const auto& [b, is] : unsound) failed.push_back(b);
    return cutter.finish();
  }

  /// By how much the corners of fits of equal radii are moved.
  std::map<std::uint32_t, glm::dvec3> shifts() const {
    std::map<std::uint32_t, glm::dvec3> by;
    for (const Barrel& barrel : barrels_) {
      if (!(barrel.cut.bound > 0.0) || !barrel.usable) continue;
      for (const auto& [v, ruling] : barrel.rulingOf) {
        const glm::dvec3 across = barrel.across(mesh_.positions[v]);
        by[v] += (barrel.cornerRadius() / glm::length(across) - 1.0) * across;
      }
    }
    return by;
  }

  TriangleSoup allUnsound(std::vector<std::uint32_t>& failed) const {
    for (std::uint32_t b = 0; b < barrels_.size(); ++b) failed.push_back(b);
    return {};
  }

  void count(RoundedMesh& out, bool none) const {
    out.unbelieved = unread_;
    for (const Barrel& barrel : barrels_) {
      if (barrel.triangles == 0) out.unbelieved += barrel.of.size();
      if (barrel.triangles == 0 || none || !barrel.usable) continue;
      out.felt += barrel.of.size();
      if (barrel.cut.bound > 0.0) {
        out.equal += barrel.of.size();
        out.room = std::max(out.room, equalFitRoom(barrel.face.radius).most);
      }
      out.sag = std::max(out.sag, barrel.face.radius * (1.0 - std::cos(kPi / barrel.cut.segments)));
    }
  }

  const Mesh& mesh_;
  const RoundFaces& rounds_;
  const double rounding_;
  double size_ = 0.0, corner_ = 0.0;  // m: the diagonal; by how much a corner may be off by rounding
  std::vector<Barrel> barrels_;
  std::vector<std::uint32_t> owner_;  // of each triangle, its cylinder or kNone
  std::uint64_t unread_ = 0;
};

}  // namespace

RoundedMesh roundFaces(const Mesh& mesh, const RoundFaces& rounds, double rounding) {
  if (!rounds.anyCut()) return {};
  return Rounder(mesh, rounds, rounding).run();
}

}  // namespace tandem::assets
