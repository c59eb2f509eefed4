#include "haptics/geometry/triangle_sweep.h"

#include "haptics/geometry/cut_triangle.h"

namespace tandem::haptics {
namespace {

/// Four vectors one by one.
class Directions {
 public:
  explicit Directions(const Vec4& v) {
    v.x.store(x_);
    v.y.store(y_);
    v.z.store(z_);
  }
  glm::dvec3 operator[](std::size_t i) const { return {x_[i], y_[i], z_[i]}; }

 private:
  alignas(16) float x_[4], y_[4], z_[4];
};

/// Whether a point that moves from `from` along `path` certainly stays further than `reach` from a triangle:
/// the bound of triangle_filter.h in double along `away`, which need not be a unit vector.
bool passesBy(const glm::dvec3& away, const glm::dvec3& from, const glm::dvec3& path, double reach,
              const Triangle& t) {
  const double least =
      std::min({glm::dot(away, from - t.a), glm::dot(away, from - t.b), glm::dot(away, from - t.c)}) +
      std::min(0.0, glm::dot(away, path));
  return least > 0.0 && least * least > reach * reach * glm::dot(away, away);
}

/// passesBy() along the triangle's normal, which excludes the neighbours in a plane along which a point
/// glides.
bool passesAbove(const glm::dvec3& from, const glm::dvec3& path, double reach, const Triangle& t) {
  const glm::dvec3 normal = areaVector(t);
  return passesBy(glm::dot(normal, from - t.a) > 0.0 ? normal : -normal, from, path, reach, t);
}

float latestOf(double t) { return roundUp(t * (1.0 + 0x1p-20)); }

}  // namespace

TriangleSweep::TriangleSweep(const TriangleBvh& tree, const glm::dvec3& from, const glm::dvec3& motion,
                             double radius, double tolerance, double rounding, const Sections* cut,
                             MeshBallHit& hit)
    : tree_(tree),
      from_(from),
      way_(motion),
      radius_(radius),
      tolerance_(tolerance),
      closest_(radius + tolerance + rounding),
      motion4_{Float4(static_cast<float>(motion.x)), Float4(static_cast<float>(motion.y)),
               Float4(static_cast<float>(motion.z))},
      reach_(roundUp(closest_)),
      cut_(cut),
      hit_(hit),
      latest_(latestOf(hit.t)) {}

void TriangleSweep::test(const Triangles4& corners, const std::uint32_t* triangles, std::uint32_t count,
                         Vec4& away, Float4& distance) {
  away = awayFrom(corners);
  const DistanceBound4 bound = boundDistance(corners, away, motion4_);
  distance = bound.distance - bound.error;
  const Float4 least = bound.distance + min(bound.slope * Float4(latest_), Float4());
  const int missed = lessMask(reach_, least - bound.error);
  if (missed == 15) return;
  const Directions passing(awayInPassing(corners, away, motion4_, Float4(latest_)));
  for (std::uint32_t i = 0; i < count; ++i) {
    if ((missed >> i & 1) == 0) testOne(triangles[i], passing[i]);
  }
}

void TriangleSweep::testOne(std::uint32_t index, const glm::dvec3& away) {
  const Triangle t = tree_.triangle(index);
  const glm::dvec3 path = way_ * double{latest_};
  if (passesBy(away, from_, path, closest_, t) || passesAbove(from_, path, closest_, t)) return;
  ++tested_;
  BallHit candidate;
  candidate.t = hit_.t;
  const bool met = cut_ == nullptr ? haptics::sweepBall(from_, way_, radius_, tolerance_, t, candidate)
                                   : sweepBallOnCut(from_, way_, radius_, tolerance_, t, *cut_, candidate);
  if (!met) return;
  if (found_ && candidate.t == hit_.t) {
    const double now = glm::dot(candidate.normal, way_), best = glm::dot(hit_.normal, way_);
    if (now > best || (now == best && index > hit_.triangle)) return;
  }
  found_ = true;
  static_cast<BallHit&>(hit_) = candidate;
  hit_.triangle = index;
  latest_ = latestOf(hit_.t);
}

}  // namespace tandem::haptics
