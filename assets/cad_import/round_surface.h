#pragma once

// A cylinder by any of the formulas that CAD files use: as such, swept, revolved, or as a rational spline.

#include <optional>
#include <vector>

#include <Geom_Surface.hxx>
#include <glm/vec3.hpp>

namespace tandem::cad_import {

/// Parameter bounds of a surface.
struct ParameterBox {
  double uFrom = 0.0, uTo = 0.0, vFrom = 0.0, vTo = 0.0;
};

/// A cylindrical surface in its own coordinates: an angle about the axis and a height along it, each growing
/// or falling with one of the surface's two parameters. Lengths in the surface's unit.
class RoundSurface {
 public:
  /// Nothing if the surface within the box is no cylinder to a hundred-thousandth of its radius.
  static std::optional<RoundSurface> recognise(const Handle(Geom_Surface) & surface, const ParameterBox& box);

  glm::dvec3 origin() const { return origin_; }  // on the axis, at height 0
  glm::dvec3 axis() const { return axis_; }      // unit; angles grow right-handed about it
  glm::dvec3 zero() const { return zero_; }      // unit, towards angle 0
  double radius() const { return radius_; }
  bool roundIsU() const { return roundIsU_; }  // the first parameter goes around, the second along
  bool outward() const { return outward_; }    // its own normal points away from the axis

  /// Of the parameter that goes around, rad; and back.
  double angleAt(double parameter) const;
  double parameterAtAngle(double angle) const;
  /// Of the parameter that goes along; and back.
  double heightAt(double parameter) const { return height_ + rise_ * parameter; }
  double parameterAtHeight(double height) const { return (height - height_) / rise_; }

  glm::dvec3 point(double around, double along) const;  // by the two parameters

 private:
  bool readExact();
  bool readSamples(const ParameterBox& box, bool roundIsU);
  bool fitCircle(const std::vector<glm::dvec3>& points);

  Handle(Geom_Surface) surface_;
  glm::dvec3 origin_{0.0}, axis_{0.0, 0.0, 1.0}, zero_{1.0, 0.0, 0.0};
  double radius_ = 0.0, height_ = 0.0, rise_ = 1.0;
  bool roundIsU_ = true, outward_ = true;
  std::vector<double> parameters_, angles_;  // samples, both ascending; none where the angle is the parameter
};

}  // namespace tandem::cad_import
