#include "haptics/fields/field_path.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr int kSamples = 8;         // per piece, for the search over the whole curve
constexpr double kStep = 1.0 / 16;  // of a piece, per step of descent
constexpr int kSteps = 32;
constexpr int kRootSteps = 60;
constexpr double kRootTolerance = 1e-13;  // of a piece

}  // namespace

FieldPath::FieldPath(const std::vector<glm::dvec3>& points, bool smooth, bool closed) : closed_(closed) {
  ASSERT(points.size() >= 2);
  const int n = static_cast<int>(points.size());
  const auto at = [&](int i) {
    if (closed) return points[static_cast<std::size_t>((i % n + n) % n)];
    if (i < 0) return 2.0 * points.front() - points[1];
    if (i >= n) return 2.0 * points.back() - points[static_cast<std::size_t>(n - 2)];
    return points[static_cast<std::size_t>(i)];
  };
  const auto knot = [](const glm::dvec3& a, const glm::dvec3& b) { return std::sqrt(glm::distance(a, b)); };
  for (int i = 0; i < (closed ? n : n - 1); ++i) {
    const glm::dvec3 p0 = at(i - 1), p1 = at(i), p2 = at(i + 1), p3 = at(i + 2);
    if (!smooth) {
      addPiece({p1, p2 - p1});
      continue;
    }
    const double t01 = knot(p0, p1), t12 = knot(p1, p2), t23 = knot(p2, p3);
    const glm::dvec3 m1 = p2 - p1 + t12 * ((p1 - p0) / t01 - (p2 - p0) / (t01 + t12));
    const glm::dvec3 m2 = p2 - p1 + t12 * ((p3 - p2) / t23 - (p3 - p1) / (t12 + t23));
    addPiece({p1, m1, 3.0 * (p2 - p1) - 2.0 * m1 - m2, 2.0 * (p1 - p2) + m1 + m2});
  }
  ASSERT(pieces_.size() == points.size() - (closed ? 0 : 1));
  const int samples = kSamples * static_cast<int>(pieces_.size());
  for (int i = 0; i < samples; ++i)
    length_ += glm::distance(point(static_cast<double>(i) / kSamples), point((i + 1.0) / kSamples));
}

/// Adds the ball around its corners as a Bezier curve, which contains the piece.
void FieldPath::addPiece(Piece p) {
  const glm::dvec3 end = p.c0 + p.c1 + p.c2 + p.c3;
  p.centre = 0.5 * (p.c0 + end);
  for (const glm::dvec3& corner : {p.c0, p.c0 + p.c1 / 3.0, p.c0 + (2.0 * p.c1 + p.c2) / 3.0, end})
    p.radius = std::max(p.radius, glm::distance(p.centre, corner));
  p.radius *= 1.0 + 1e-9;  // margin for rounding
  pieces_.push_back(p);
}

double FieldPath::wrapped(double at) const {
  if (!closed_) return std::clamp(at, 0.0, pieces());
  at = std::fmod(at, pieces());
  return at < 0.0 ? at + pieces() : at;
}

/// The piece that contains a parameter, which becomes the parameter within that piece.
const FieldPath::Piece& FieldPath::pieceAt(double& at) const {
  ASSERT(!pieces_.empty());
  at = wrapped(at);
  const auto i = std::min(static_cast<std::size_t>(at), pieces_.size() - 1);
  at -= static_cast<double>(i);
  return pieces_[i];
}

glm::dvec3 FieldPath::point(double at) const {
  const Piece& piece = pieceAt(at);
  return piece.point(at);
}

glm::dvec3 FieldPath::tangent(double at) const {
  const Piece& piece = pieceAt(at);
  const glm::dvec3 d = piece.rate(at);
  const double length = glm::length(d);
  return length > 0.0 ? d / length : glm::dvec3(0.0);
}

double FieldPath::slope(const glm::dvec3& x, double at) const {
  const Piece& piece = pieceAt(at);
  return glm::dot(piece.point(at) - x, piece.rate(at));
}

double FieldPath::nearest(const glm::dvec3& x) const {
  // A piece whose ball begins beyond the far end of another's cannot hold the nearest place.
  double reach = 1e300;
  for (const Piece& piece : pieces_) reach = std::min(reach, glm::distance(piece.centre, x) + piece.radius);
  double best = 0.0, least = 1e300;
  const auto consider = [&](double at, const glm::dvec3& away) {
    const double square = glm::dot(away, away);
    if (!(square < least)) return;
    least = square;
    best = at;
  };
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    if (glm::distance(piece.centre, x) - piece.radius > reach) continue;
    double slopeBefore = 0.0;
    for (int k = 0; k <= kSamples; ++k) {
      const double within = static_cast<double>(k) / kSamples, at = static_cast<double>(i) + within;
      const glm::dvec3 away = piece.point(within) - x;
      const double slopeHere = glm::dot(away, piece.rate(within));
      consider(at, away);
      // All local minima are compared: every sample around the nearest place may be further away from x than
      // a sample near another minimum. The end of a piece may be a corner, beyond which the slope is another.
      if (slopeBefore < 0.0 && slopeHere > 0.0) {
        const double root = rootBetween(x, at - 1.0 / kSamples, std::nextafter(at, 0.0));
        consider(root, point(root) - x);
      }
      slopeBefore = slopeHere;
    }
  }
  return wrapped(best);
}

/// Zero of the slope between two parameters with opposite signs: the Illinois variant of the false position
/// method (Dowell & Jarratt 1971).
double FieldPath::rootBetween(const glm::dvec3& x, double a, double b) const {
  double atA = slope(x, a), atB = slope(x, b), last = a;
  int side = 0;
  for (int k = 0; k < kRootSteps; ++k) {
    double at = b - atB * (b - a) / (atB - atA);
    if (!(at >= std::min(a, b) && at <= std::max(a, b))) at = 0.5 * (a + b);
    const double value = slope(x, at);
    if (value == 0.0 || std::abs(at - last) < kRootTolerance) return at;
    last = at;
    if ((value > 0.0) == (atA > 0.0)) {
      a = at, atA = value;
      if (side == -1) atB *= 0.5;
      side = -1;
    } else {
      b = at, atB = value;
      if (side == 1) atA *= 0.5;
      side = 1;
    }
  }
  return last;
}

double FieldPath::follow(const glm::dvec3& x, double from) const {
  double here = wrapped(from);
  const double first = slope(x, here);
  if (first == 0.0) return here;
  const double step = first > 0.0 ? -kStep : kStep;
  // A closed curve continues past its first point; its parameter may leave 0..pieces() during the search.
  for (int i = 0; i < kSteps; ++i) {
    double next = here + step;
    if (!closed_) next = std::clamp(next, 0.0, pieces());
    if (next == here) return here;
    if (slope(x, next) * first > 0.0) {
      here = next;
      continue;
    }
    return wrapped(rootBetween(x, here, next));
  }
  return wrapped(here);
}

}  // namespace tandem::haptics
