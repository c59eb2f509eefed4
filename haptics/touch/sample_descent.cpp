#include "haptics/touch/sample_descent.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/geometry/segment.h"

namespace tandem::haptics {
namespace {

constexpr int kMaxDescentRounds = 4, kMaxMoves = 64, kMaxTrianglesAround = 24, kMaxHalvings = 6,
              kMaxHumps = 3;
// Share of an interval that a step leaves at both of its ends.
constexpr double kEnd = 0.02;
// Allowances by which a move over a plane goes lower.
constexpr double kLowerBy = 0.25;
// A place is on an edge if it is nearer to it than this share of the reach of a move.
constexpr double kOnEdge = 1e-9;
// m from a surface below which the direction to it is that of the face.
constexpr double kOnSurface = 1e-10;

/// Height over the target, below 0 inside, with the direction in which it grows.
struct Height {
  double height = 1e300;         // m
  glm::dvec3 up{0.0, 0.0, 0.0};  // unit
};

class Descent {
 public:
  Descent(const SampledModels& models, const ContactSample& sample, const DescentBounds& bounds,
          std::uint32_t hint)
      : models_(models),
        sample_(sample),
        bounds_(bounds),
        hint_(hint),
        place_{sample.edge, sample.point},
        height_(heightAt(sample.point)),
        least_(height_.height) {}

  Seat run();
  /// From a known place, after run() has ended at `other`: the deeper of both ends.
  Seat runFrom(const EdgePlace& known, const Seat& other);
  /// m over the target, of a place of the sample's part.
  static double heightOf(const SampledModels& models, const ContactSample& sample, const glm::dvec3& place) {
    return Descent(models, sample, 0.0, glm::dvec3(0.0)).heightAt(place).height;
  }
  /// The place at an edge near by that is lowest over the plane of `up`, which is in the frame of the target.
  static glm::dvec3 lowestPlace(const SampledModels& models, const ContactSample& sample, double slack,
                                const glm::dvec3& up) {
    Descent descent(models, sample, slack, up);
    return descent.lowestOver(descent.place_, descent.ownDirection(up)).point;
  }

 private:
  Descent(const SampledModels& models, const ContactSample& sample, double slack, const glm::dvec3& up)
      : models_(models),
        sample_(sample),
        bounds_{slack, 0.0},
        hint_(kNoTriangle),
        place_{sample.edge, sample.point},
        height_{0.0, up},
        reach_(furthest()) {}
  Height heightAt(const glm::dvec3& ownPoint);
  /// Moves over a smooth surface.
  bool descend();
  // Places along the present edge are in m from its first end. Each search moves to the lowest place it sees,
  // and returns whether it has moved, or `moved`.

  struct EdgeEnd {
    double t, height, slope;  // m along the edge, m, m a m
  };
  EdgeEnd endAt(double t, const Height& height) const;
  EdgePlace placeAt(double t) const { return {place_.edge, edgeStart() + t * edgeDirection()}; }
  /// Within reach of the sample.
  bool searchNear();
  /// Between `low` and `high`.
  bool searchEdge(double low, double high);
  /// From `far` back to where the search started, for a lower place beyond a hump: over a hollow target.
  bool searchFrom(double far, EdgeEnd start);
  /// Between two places from both of which it falls to the other one.
  bool searchBetween(EdgeEnd a, EdgeEnd b, bool moved);
  /// The place that is lowest over the plane of `up` (own frame), from edge to edge near the sample.
  EdgePlace lowestOver(EdgePlace from, const glm::dvec3& up) const;
  /// The lowest place at the edges of one triangle; `best` where none is lower.
  EdgePlace lowestAround(std::uint32_t triangle, const glm::dvec3& from, const glm::dvec3& up,
                         EdgePlace best) const;
  /// The same of all triangles that meet in the corner of `edge` where `best` is, up to a border.
  EdgePlace lowestAtCorner(const EdgeLine& edge, const glm::dvec3& up, EdgePlace best) const;
  Seat seatHere(double least) const;
  /// Takes a place if it is deeper than the present one.
  bool take(const EdgePlace& place, const Height& height);

  const MeshEdges& ownEdges() const { return models_.from->edges; }
  glm::dvec3 edgeStart() const { return ownEdges().line(place_.edge).a; }
  glm::dvec3 edgeDirection() const {
    const EdgeLine edge = ownEdges().line(place_.edge);
    return glm::normalize(edge.b - edge.a);
  }
  double edgeLength() const {
    const EdgeLine edge = ownEdges().line(place_.edge);
    return glm::length(edge.b - edge.a);
  }
  double along() const { return glm::dot(edgeDirection(), place_.point - edgeStart()); }
  glm::dvec3 ownDirection(const glm::dvec3& direction) const {
    return glm::conjugate(models_.toFromSamples.orientation) * direction;
  }
  bool smooth() const { return ContactSamples::isSmooth(sample_); }
  double furthest() const { return models_.from->samples.extent(sample_); }

  const SampledModels& models_;
  const ContactSample& sample_;
  const DescentBounds bounds_;
  std::uint32_t hint_;
  EdgePlace place_;
  Height height_;
  double reach_ = 0.0;  // m that a move may go
  double least_ = 0.0;  // m, the lowest height seen
};

/// Whether the nearest point of a mesh to p, which is on an edge or corner of `triangle`, belongs to a convex
/// edge: then p is outside.
bool nearestIsConvex(const MeshEdges& edges, std::uint32_t triangle, const glm::dvec3& nearest, double size) {
  for (const std::uint32_t i : edges.around(triangle)) {
    if (!edges.isConvex(i)) continue;
    const EdgeLine edge = edges.line(i);
    if (glm::length(nearest - closestPointOnSegment(nearest, edge.a, edge.b)) <= size) return true;
  }
  return false;
}

Height Descent::heightAt(const glm::dvec3& ownPoint) {
  const TriangleBvh& tree = *models_.to->tree;
  const MeshEdges& edges = models_.to->edges;
  const glm::dvec3 p = transformPoint(models_.toFromSamples, ownPoint);
  MeshPoint nearest;
  DistanceField::Triangles near;
  static_cast<void>(models_.to->field.read(glm::vec3(p - models_.to->field.origin()), near));
  if (!nearestPoint(tree, near, p, 1e300, hint_, nearest)) return {};
  hint_ = nearest.triangle;
  const glm::dvec3 offset = p - nearest.point, face = edges.normal(nearest.triangle);
  bool outside = !models_.to->field.solid() || glm::dot(offset, face) >= 0.0;
  if (!nearest.onFace && !outside)
    outside = nearestIsConvex(edges, nearest.triangle, nearest.point, 1e-9 * (1e-3 + nearest.distance));
  const double sign = outside ? 1.0 : -1.0;
  return {sign * nearest.distance, nearest.distance > kOnSurface ? sign / nearest.distance * offset : face};
}

EdgePlace Descent::lowestAround(std::uint32_t triangle, const glm::dvec3& from, const glm::dvec3& up,
                                EdgePlace best) const {
  double least = glm::dot(up, best.point) - bounds_.slack;
  const auto consider = [&](std::uint32_t edge, const glm::dvec3& point) {
    const double height = glm::dot(up, point);
    if (!(height < least) || glm::length(point - sample_.point) > furthest() ||
        glm::length(point - place_.point) > reach_)
      return;
    least = height;
    best = {edge, point};
  };
  for (const std::uint32_t i : ownEdges().around(triangle)) {
    if (!ownEdges().isConvex(i)) continue;
    const EdgeLine edge = ownEdges().line(i);
    const glm::dvec3 nearest = closestPointOnSegment(from, edge.a, edge.b);
    consider(i, nearest);
    // Along an edge through the present place a move may end before the corner.
    const bool through = from == place_.point && glm::length(nearest - from) <= kOnEdge * reach_;
    for (const glm::dvec3& end : {edge.a, edge.b}) {
      const double length = glm::length(end - from);
      const bool clipped = through && length > reach_;
      consider(i, clipped ? from + (1.0 - 1e-9) * reach_ / length * (end - from) : end);
    }
  }
  return best;
}

EdgePlace Descent::lowestAtCorner(const EdgeLine& edge, const glm::dvec3& up, EdgePlace best) const {
  const glm::dvec3 from = best.point;
  if (from != edge.a && from != edge.b) return best;
  const std::uint32_t vertex = edge.ends[from == edge.a ? 0 : 1];
  const assets::Mesh& mesh = models_.from->tree->mesh();
  std::uint32_t at = edge.triangles[0];
  for (int k = 0; k < kMaxTrianglesAround; ++k) {
    const auto& corners = mesh.triangles[at];
    std::uint32_t e = 0;
    while (e < 3 && corners[(e + 1) % 3] != vertex) ++e;
    if (e == 3) break;
    at = mesh.neighbours[at][e];
    if (at == assets::kNone || at == edge.triangles[0]) break;
    best = lowestAround(at, from, up, best);
  }
  return best;
}

EdgePlace Descent::lowestOver(EdgePlace from, const glm::dvec3& up) const {
  for (int k = 0; k < kMaxMoves; ++k) {
    const EdgeLine edge = ownEdges().line(from.edge);
    EdgePlace best = from;
    for (const std::uint32_t triangle : edge.triangles) best = lowestAround(triangle, from.point, up, best);
    if (best == from) best = lowestAtCorner(edge, up, best);
    if (best == from) break;
    from = best;
  }
  return from;
}

bool Descent::take(const EdgePlace& place, const Height& height) {
  if (!(height.height < height_.height - bounds_.slack)) return false;
  place_ = place;
  height_ = height;
  return true;
}

bool Descent::descend() {
  bool moved = false;
  reach_ = furthest();
  for (int round = 0; round < kMaxDescentRounds; ++round) {
    const EdgePlace next = lowestOver(place_, ownDirection(height_.up));
    if (next == place_) break;
    // Where the target curves away, the place that is lowest over its plane is too far.
    if (take(next, heightAt(next.point)))
      moved = true;
    else
      reach_ = 0.5 * glm::length(next.point - place_.point);
  }
  return moved;
}

Descent::EdgeEnd Descent::endAt(double t, const Height& height) const {
  return {t, height.height, glm::dot(ownDirection(height.up), edgeDirection())};
}

bool Descent::searchEdge(double low, double high) {
  const EdgeEnd start = endAt(along(), height_);
  const double far = start.slope > 0.0 ? low : high, back = start.slope > 0.0 ? high : low;
  bool moved = false;
  if (std::abs(start.slope) * std::abs(far - start.t) > bounds_.slack) {
    const EdgePlace end = placeAt(far);
    const Height height = heightAt(end.point);
    least_ = std::min(least_, height.height);
    const EdgeEnd b = endAt(far, height);
    // Where it falls all the way, the next sample of a sharp edge stands at the end.
    if (start.slope * b.slope > 0.0)
      moved = smooth() && take(end, height);
    else
      moved = searchBetween(start, b, take(end, height));
  }
  return smooth() ? moved : searchFrom(back, start) || moved;
}

bool Descent::searchFrom(double far, EdgeEnd start) {
  EdgeEnd b = endAt(far, heightAt(placeAt(far).point));
  const double inwards = start.t < far ? 1.0 : -1.0;
  bool moved = false;
  for (int k = 0; k < kMaxHumps; ++k) {
    const double width = std::abs(b.t - start.t);
    if (!(b.height - inwards * b.slope * width < height_.height - bounds_.slack)) break;
    const double t = 0.5 * (start.t + b.t);
    const EdgePlace place = placeAt(t);
    const Height height = heightAt(place.point);
    moved = take(place, height) || moved;
    const EdgeEnd c = endAt(t, height);
    if (c.slope * b.slope < 0.0) return searchBetween(c, b, moved);
    b = c;
  }
  return moved;
}

bool Descent::searchBetween(EdgeEnd a, EdgeEnd b, bool moved) {
  bool halved = false;
  for (int k = 0; k < kMaxHalvings; ++k) {
    // The tangents of a convex function meet below its minimum. Over a hollow target the distance is not
    // convex, and may be lower: it is evaluated once in the middle, if the slope at an end reaches so low.
    const double width = std::abs(b.t - a.t);
    const double meet = (b.height - a.height + a.slope * a.t - b.slope * b.t) / (a.slope - b.slope),
                 lowest = height_.height - bounds_.slack;
    const bool lower = a.height + a.slope * (meet - a.t) < lowest;
    if (!lower) {
      const auto fallsTo = [&](const EdgeEnd& end) { return end.height - 0.5 * width * std::abs(end.slope); };
      if (halved || !(std::min(fallsTo(a), fallsTo(b)) < lowest)) break;
      halved = true;
    }
    const double t =
        lower ? std::clamp(meet, std::min(a.t, b.t) + kEnd * width, std::max(a.t, b.t) - kEnd * width)
              : 0.5 * (a.t + b.t);
    const EdgePlace place = placeAt(t);
    const Height height = heightAt(place.point);
    moved = take(place, height) || moved;
    const EdgeEnd c = endAt(t, height);
    (c.slope * a.slope > 0.0 ? a : b) = c;
  }
  return moved;
}

Seat Descent::run() {
  Seat seat;
  seat.triangle = hint_;
  seat.least = height_.height - models_.from->samples.dip(sample_);
  if (seat.least > bounds_.range) return seat;
  bool moved = smooth() && descend();
  moved = searchNear() || moved;
  seat.least = std::min(least_, height_.height);
  seat.triangle = hint_;
  return moved ? seatHere(seat.least) : seat;
}

Seat Descent::runFrom(const EdgePlace& known, const Seat& other) {
  const double least = height_.height;
  const Height height = heightAt(known.point);
  if (height.height > bounds_.range) return other;
  place_ = known;
  height_ = height;
  descend();
  searchNear();
  return height_.height < least - bounds_.slack ? seatHere(std::min(other.least, height_.height)) : other;
}

bool Descent::searchNear() {
  const double from = along(), reach = furthest();
  return searchEdge(std::max(0.0, from - reach), std::min(edgeLength(), from + reach));
}

Seat Descent::seatHere(double least) const {
  Seat seat;
  seat.edge = place_.edge;
  seat.point = transformPoint(models_.toFromSamples, place_.point);
  seat.along = std::max(0.0, std::min(along(), edgeLength() - along()));
  seat.least = least;
  seat.triangle = hint_;
  return seat;
}

/// m, how much lower than at its start a convex function may be on a way before it rises again, by its values
/// and slopes (m, along the whole way) at both ends.
double convexDip(double start, double down, double end, double up) {
  if (down <= 0.0) return 0.0;
  return up <= 0.0 ? 0.0 : down * (start - end + up) / (down + up);
}

DistanceField::Reading readAt(const SampledModels& models, const glm::dvec3& ownPoint) {
  const DistanceField& field = models.to->field;
  return field.read(glm::vec3(transformPoint(models.toFromSamples, ownPoint) - field.origin()));
}

/// Whether the field says so of the way from a sample to another place (own frame).
bool isLevelUpTo(const SampledModels& models, const DistanceField::Reading& here, const glm::dvec3& way,
                 const glm::dvec3& end, const LevelBounds& bounds) {
  const DistanceField::Reading there = readAt(models, end);
  if (static_cast<double>(there.error) > bounds.trusted) return false;
  const glm::dvec3 turned = models.toFromSamples.orientation * way;
  const double down = -glm::dot(glm::dvec3(here.gradient), turned),
               up = glm::dot(glm::dvec3(there.gradient), turned);
  return convexDip(here.distance, down, there.distance, up) <= bounds.allowance;
}

}  // namespace

double smoothDip(const ContactSamples& all, const ContactSample& sample, const glm::dvec3& ownUp) {
  const auto normals = all.normals(sample);
  const glm::dvec3 across = normals[1] - normals[0], from = -ownUp - normals[0];
  const double square = glm::dot(across, across);
  const double at = square > 0.0 ? std::clamp(glm::dot(from, across) / square, 0.0, 1.0) : 0.0;
  const double slope = std::min(glm::length(from - at * across), static_cast<double>(sample.turn));
  return all.smoothSpacing() * slope;
}

bool isLevel(const SampledModels& models, const ContactSample& sample, const LevelBounds& bounds,
             const glm::dvec3& up, bool alone) {
  const bool smooth = ContactSamples::isSmooth(sample);
  const glm::dvec3 ownUp = glm::conjugate(models.toFromSamples.orientation) * up;
  if (smooth && smoothDip(models.from->samples, sample, ownUp) <= bounds.allowance) return true;
  const EdgeLine edge = models.from->edges.line(sample.edge);
  const glm::dvec3 along = static_cast<double>(sample.along) * glm::normalize(edge.b - edge.a);
  if (!smooth && alone && std::abs(glm::dot(ownUp, along)) <= bounds.allowance) return true;
  const DistanceField::Reading here = readAt(models, sample.point);
  if (static_cast<double>(here.error) > bounds.trusted) return false;
  if (smooth) {
    const glm::dvec3 lowest =
        Descent::lowestPlace(models, sample, kLowerBy * bounds.allowance, glm::dvec3(here.gradient));
    const double least = bounds.height - bounds.allowance;
    const DistanceField::Reading there = readAt(models, lowest);
    if (static_cast<double>(there.distance) < least) return false;
    if (static_cast<double>(there.distance - there.error) < least &&
        Descent::heightOf(models, sample, lowest) < least)
      return false;
    return isLevelUpTo(models, here, lowest - sample.point, lowest, bounds);
  }
  const auto isLevelAlong = [&](const glm::dvec3& way) {
    return isLevelUpTo(models, here, way, sample.point + way, bounds);
  };
  return isLevelAlong(along) && isLevelAlong(-along);
}

Seat deepestNear(const SampledModels& models, const ContactSample& sample, const DescentBounds& bounds,
                 std::uint32_t hint, const EdgePlace& known) {
  Descent descent(models, sample, bounds, hint);
  const Seat seat = descent.run();
  return known.edge == assets::kNone ? seat : descent.runFrom(known, seat);
}

}  // namespace tandem::haptics
