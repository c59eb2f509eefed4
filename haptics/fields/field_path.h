#pragma once

// Path of a guide: a curve, and the point on it nearest to a place.

#include <vector>

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// Cubic pieces through given points by centripetal Catmull-Rom (Yuksel, Schaefer & Keyser 2011,
/// "Parameterization and applications of Catmull-Rom curves"), with a continuous tangent and without cusps or
/// loops of its own; or straight lines. The parameter runs from 0 to pieces(); whole numbers are the points.
/// Only the constructor allocates.
class FieldPath {
 public:
  /// Needs at least two points; consecutive points must differ.
  FieldPath(const std::vector<glm::dvec3>& points, bool smooth, bool closed);

  double pieces() const { return static_cast<double>(pieces_.size()); }
  glm::dvec3 point(double at) const;
  /// Unit, in the direction of growing parameter.
  glm::dvec3 tangent(double at) const;
  bool closed() const { return closed_; }
  /// Length of the polygon through samples of the curve, m.
  double length() const { return length_; }

  /// Parameter of the place nearest to x on the whole curve.
  double nearest(const glm::dvec3& x) const;
  /// Parameter of the local minimum of the distance to x reached from `from` by descent along the curve, at
  /// most two pieces per call. Following a hand with it never jumps to another strand of a curve that comes
  /// near itself, until the present strand no longer has a local minimum.
  double follow(const glm::dvec3& x, double from) const;

 private:
  struct Piece {
    // c0 + u (c1 + u (c2 + u c3)), u in 0..1
    glm::dvec3 c0{0.0}, c1{0.0}, c2{0.0}, c3{0.0};
    glm::dvec3 centre{0.0};  // of a ball that contains the piece
    double radius = 0.0;

    glm::dvec3 point(double u) const { return c0 + u * (c1 + u * (c2 + u * c3)); }
    /// The derivative of point().
    glm::dvec3 rate(double u) const { return c1 + u * (2.0 * c2 + u * 3.0 * c3); }
  };
  void addPiece(Piece piece);
  const Piece& pieceAt(double& at) const;
  /// Half the derivative of the squared distance to x.
  double slope(const glm::dvec3& x, double at) const;
  double rootBetween(const glm::dvec3& x, double a, double b) const;
  double wrapped(double at) const;

  std::vector<Piece> pieces_;
  bool closed_ = false;
  double length_ = 0.0;
};

}  // namespace tandem::haptics
