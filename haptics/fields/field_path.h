#pragma once

// A curve that a guide leads along, and where on it a point is nearest.

#include <vector>

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// Cubic pieces through given points: centripetal Catmull-Rom (Yuksel, Schaefer & Keyser 2011,
/// "Parameterization and applications of Catmull-Rom curves"), which has a continuous tangent, no cusps and
/// no loops of its own; or straight lines. The parameter runs from 0 to pieces(); whole numbers are the
/// points. Only the constructor allocates.
class FieldPath {
 public:
  /// At least two points, no two in a row alike.
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
  /// The place near `from` at which the distance to x is least: downhill along the curve, at most two pieces
  /// in a call. Following a hand with it never changes over to another strand of a curve that comes near
  /// itself, until the strand that it follows no longer has a nearest place.
  double follow(const glm::dvec3& x, double from) const;

 private:
  struct Piece {
    // c0 + u (c1 + u (c2 + u c3)), u in 0..1
    glm::dvec3 c0{0.0}, c1{0.0}, c2{0.0}, c3{0.0};
    glm::dvec3 centre{0.0};  // of a ball that holds the piece
    double radius = 0.0;
  };
  void addPiece(Piece piece);
  const Piece& pieceAt(double& at) const;
  /// Half of the derivative of the squared distance to x.
  double slope(const glm::dvec3& x, double at) const;
  double rootBetween(const glm::dvec3& x, double a, double b) const;
  double wrapped(double at) const;

  std::vector<Piece> pieces_;
  bool closed_ = false;
  double length_ = 0.0;
};

}  // namespace tandem::haptics
