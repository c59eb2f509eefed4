#include "assets/cad_import/fit_rings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include <glm/geometric.hpp>

namespace tandem::cad_import {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kSameAngle = 1e-6;        // rad
constexpr double kSameRadius = 0.01;       // of the radius: twice the sag of facets of 0.2 rad
constexpr double kSameAxis = 1e-4;         // rad between axes
constexpr std::size_t kMostCorners = 360;  // of a ring

double wrapped(double angle) {
  angle = std::fmod(angle, kTurn);
  if (angle < 0.0) angle += kTurn;
  return kTurn - angle < kSameAngle ? 0.0 : angle;
}

/// angle -> sign * angle + offset.
struct AngleMap {
  double sign = 1.0, offset = 0.0;

  double operator()(double angle) const { return wrapped(sign * angle + offset); }
  AngleMap after(const AngleMap& first) const { return {sign * first.sign, sign * first.offset + offset}; }
  AngleMap inverted() const { return {sign, -sign * offset}; }
};

struct PlacedRing {
  std::uint32_t ring, placement;
  glm::dvec3 from, to, axis, zero;
  double low, high;  // along x
};

std::vector<PlacedRing> place(const std::vector<Ring>& rings, const std::vector<Placement>& placements) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> ofBody;
  for (std::uint32_t i = 0; i < rings.size(); ++i) ofBody[rings[i].body].push_back(i);
  std::vector<PlacedRing> placed;
  for (std::uint32_t at = 0; at < placements.size(); ++at) {
    const glm::dmat4& map = placements[at].worldFromBody;
    for (const std::uint32_t index : ofBody[placements[at].body]) {
      const Ring& ring = rings[index];
      const auto world = [&](double along) {
        return glm::dvec3(map * glm::dvec4(ring.origin + along * ring.axis, 1.0));
      };
      PlacedRing out{index,
                     at,
                     world(ring.from),
                     world(ring.to),
                     glm::dmat3(map) * ring.axis,
                     glm::dmat3(map) * ring.zero,
                     0.0,
                     0.0};
      out.low = std::min(out.from.x, out.to.x) - ring.radius;
      out.high = std::max(out.from.x, out.to.x) + ring.radius;
      placed.push_back(out);
    }
  }
  std::sort(placed.begin(), placed.end(), [](const PlacedRing& a, const PlacedRing& b) {
    return std::tie(a.low, a.ring, a.placement) < std::tie(b.low, b.ring, b.placement);
  });
  return placed;
}

bool isFit(const std::vector<Ring>& rings, const PlacedRing& a, const PlacedRing& b) {
  const Ring &ringA = rings[a.ring], &ringB = rings[b.ring];
  const double radius = std::max(ringA.radius, ringB.radius);
  if (ringA.hollow == ringB.hollow || a.placement == b.placement) return false;
  if (std::abs(ringA.radius - ringB.radius) > kSameRadius * radius) return false;
  if (glm::length(glm::cross(a.axis, b.axis)) > kSameAxis) return false;
  if (glm::length(glm::cross(b.from - a.from, a.axis)) > kSameRadius * radius) return false;
  const double length = glm::dot(a.to - a.from, a.axis);
  const double first = glm::dot(b.from - a.from, a.axis), second = glm::dot(b.to - a.from, a.axis);
  const double overlap = std::min(length, std::max(first, second)) - std::max(0.0, std::min(first, second));
  return overlap > 1e-6 * radius;
}

/// Maps angles of ring a to those of ring b.
AngleMap bFromA(const PlacedRing& a, const PlacedRing& b) {
  const double sign = glm::dot(a.axis, b.axis) > 0.0 ? 1.0 : -1.0;
  return {sign, std::atan2(glm::dot(a.zero, glm::cross(b.axis, b.zero)), glm::dot(a.zero, b.zero))};
}

struct Link {
  std::uint32_t other;
  AngleMap otherFromThis;
};

void sortAndMerge(std::vector<double>& angles) {
  for (double& angle : angles) angle = wrapped(angle);
  std::sort(angles.begin(), angles.end());
  const auto same = [](double a, double b) { return b - a < kSameAngle; };
  angles.erase(std::unique(angles.begin(), angles.end(), same), angles.end());
}

/// Adds the images of the angles under the maps until they are closed. False if there are too many.
bool close(std::vector<double>& angles, const std::vector<AngleMap>& maps) {
  for (std::size_t before = 0; before != angles.size();) {
    before = angles.size();
    std::vector<double> more = angles;
    for (const AngleMap& map : maps)
      for (const double angle : angles) more.push_back(map(angle));
    sortAndMerge(more);
    if (more.size() > kMostCorners) return false;
    angles = std::move(more);
  }
  return true;
}

/// Divides each gap evenly, so that a symmetry of the corners is one of the result.
std::vector<double> divided(const std::vector<double>& corners, double step) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double next = i + 1 < corners.size() ? corners[i + 1] : corners.front() + kTurn;
    const double gap = next - corners[i];
    const int count = std::max(1, static_cast<int>(std::ceil(gap / step - 1e-6)));
    for (int k = 0; k < count; ++k) angles.push_back(corners[i] + gap * k / count);
  }
  return angles;
}

/// The rings that fits join, directly or through others, cut by one set of angles.
class Chooser {
 public:
  Chooser(const std::vector<Ring>& rings, const std::vector<Placement>& placements)
      : rings_(rings), links_(rings.size()), rootFromRing_(rings.size()), reached_(rings.size(), false) {
    const std::vector<PlacedRing> placed = place(rings, placements);
    for (std::size_t i = 0; i < placed.size(); ++i)
      for (std::size_t k = i + 1; k < placed.size() && placed[k].low <= placed[i].high; ++k)
        if (isFit(rings, placed[i], placed[k])) {
          const AngleMap map = bFromA(placed[i], placed[k]);
          links_[placed[i].ring].push_back({placed[k].ring, map});
          links_[placed[k].ring].push_back({placed[i].ring, map.inverted()});
        }
  }

  RingAngles run() {
    out_.angles.resize(rings_.size());
    for (std::uint32_t i = 0; i < rings_.size(); ++i)
      if (!reached_[i]) cut(i);
    return std::move(out_);
  }

 private:
  void cut(std::uint32_t root) {
    std::vector<std::uint32_t> members{root};
    std::vector<AngleMap> symmetries;
    reached_[root] = true;
    std::size_t fits = 0;
    for (std::size_t at = 0; at < members.size(); ++at)
      for (const Link& link : links_[members[at]]) {
        ++fits;
        const AngleMap otherFromRoot = link.otherFromThis.after(rootFromRing_[members[at]].inverted());
        if (!reached_[link.other]) {
          reached_[link.other] = true;
          rootFromRing_[link.other] = otherFromRoot.inverted();
          members.push_back(link.other);
        } else {
          addSymmetry(symmetries, rootFromRing_[link.other].after(otherFromRoot));
        }
      }
    std::vector<double> corners;
    double step = kTurn / 6.0;
    for (const std::uint32_t ring : members) {
      step = std::min(step, rings_[ring].step);
      for (const double corner : rings_[ring].corners) corners.push_back(rootFromRing_[ring](corner));
    }
    if (corners.empty()) corners.push_back(0.0);
    sortAndMerge(corners);
    const bool alike = close(corners, symmetries);
    (alike ? out_.fits : out_.unlike) += fits / 2;
    const std::vector<double> angles = divided(corners, step);
    for (const std::uint32_t ring : members) {
      const AngleMap ringFromRoot = rootFromRing_[ring].inverted();
      for (const double angle : angles) out_.angles[ring].push_back(ringFromRoot(angle));
      sortAndMerge(out_.angles[ring]);
    }
  }

  static void addSymmetry(std::vector<AngleMap>& symmetries, AngleMap map) {
    map.offset = wrapped(map.offset);
    const auto same = [&](const AngleMap& other) {
      return map.sign == other.sign && std::abs(map.offset - other.offset) < kSameAngle;
    };
    if (!same(AngleMap{}) && std::none_of(symmetries.begin(), symmetries.end(), same))
      symmetries.push_back(map);
  }

  const std::vector<Ring>& rings_;
  std::vector<std::vector<Link>> links_;
  std::vector<AngleMap> rootFromRing_;
  std::vector<bool> reached_;
  RingAngles out_;
};

}  // namespace

RingAngles chooseAngles(const std::vector<Ring>& rings, const std::vector<Placement>& placements) {
  return Chooser(rings, placements).run();
}

}  // namespace tandem::cad_import
