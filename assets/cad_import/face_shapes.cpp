#include "assets/cad_import/face_shapes.h"

#include <algorithm>
#include <cmath>

#include <BRepAdaptor_Surface.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Pln.hxx>
#include <gp_Sphere.hxx>
#include <gp_Torus.hxx>

#include "assets/cad_import/round_surface.h"

namespace tandem::cad_import {
namespace {

/// Reads faces of one body.
class FaceReader {
 public:
  explicit FaceReader(double metres) : metres_(metres) {}

  bool read(const TopoDS_Face& face, ExactFace& out) const {
    const BRepAdaptor_Surface surface(face);
    const bool reversed = face.Orientation() == TopAbs_REVERSED;
    using Kind = ExactFace::Kind;
    switch (surface.GetType()) {
      case GeomAbs_Plane:
        out.kind = Kind::plane;
        place(surface.Plane().Position(), out);
        if (reversed == surface.Plane().Direct()) out.axis = -out.axis;
        return true;
      case GeomAbs_Cylinder:
        out.kind = Kind::cylinder;
        out.radius = surface.Cylinder().Radius() * metres_;
        round(surface, surface.Cylinder().Position(), reversed, 1.0, out);
        return true;
      case GeomAbs_Cone:
        out.kind = Kind::cone;
        out.radius = surface.Cone().RefRadius() * metres_;
        out.halfAngle = surface.Cone().SemiAngle();
        round(surface, surface.Cone().Position(), reversed, std::cos(out.halfAngle), out);
        return true;
      case GeomAbs_Sphere:
        out.kind = Kind::sphere;
        out.radius = surface.Sphere().Radius() * metres_;
        round(surface, surface.Sphere().Position(), reversed, 0.0, out);
        return true;
      case GeomAbs_Torus:
        out.kind = Kind::torus;
        out.radius = surface.Torus().MajorRadius() * metres_;
        out.minorRadius = surface.Torus().MinorRadius() * metres_;
        round(surface, surface.Torus().Position(), reversed, 0.0, out);
        return true;
      default:
        return spline(face, out);
    }
  }

 private:
  /// A cylinder that the file states as another kind of surface.
  bool spline(const TopoDS_Face& face, ExactFace& out) const {
    ParameterBox box;
    BRepTools::UVBounds(face, box.uFrom, box.uTo, box.vFrom, box.vTo);
    const auto round = RoundSurface::recognise(BRep_Tool::Surface(face), box);
    if (!round) return false;
    const bool u = round->roundIsU();
    const double low = round->heightAt(u ? box.vFrom : box.uFrom),
                 high = round->heightAt(u ? box.vTo : box.uTo);
    out.kind = ExactFace::Kind::cylinder;
    out.point = metres_ * round->origin();
    out.axis = round->axis();
    out.radius = metres_ * round->radius();
    out.from = metres_ * std::min(low, high);
    out.to = metres_ * std::max(low, high);
    out.turn = std::abs(round->angleAt(u ? box.uTo : box.vTo) - round->angleAt(u ? box.uFrom : box.vFrom));
    out.hollow = (face.Orientation() == TopAbs_REVERSED) == round->outward();
    return true;
  }

  void place(const gp_Ax3& frame, ExactFace& out) const {
    const gp_XYZ at = frame.Location().XYZ(), axis = frame.Direction().XYZ();
    out.point = metres_ * glm::dvec3(at.X(), at.Y(), at.Z());
    out.axis = {axis.X(), axis.Y(), axis.Z()};
  }

  /// `rise`: height along the axis for each unit of the second parameter.
  void round(const BRepAdaptor_Surface& surface, const gp_Ax3& frame, bool reversed, double rise,
             ExactFace& out) const {
    place(frame, out);
    out.hollow = reversed == frame.Direct();
    out.turn = surface.LastUParameter() - surface.FirstUParameter();
    out.from = surface.FirstVParameter() * rise * metres_;
    out.to = surface.LastVParameter() * rise * metres_;
  }

  double metres_;
};

}  // namespace

std::vector<ExactFace> exactFaces(const TopoDS_Shape& body, double metresPerMillimetre) {
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(body, TopAbs_FACE, faces);
  const FaceReader reader(metresPerMillimetre);
  std::vector<ExactFace> found;
  for (int i = 1; i <= faces.Extent(); ++i) {
    ExactFace face;
    if (reader.read(TopoDS::Face(faces.FindKey(i)), face)) found.push_back(face);
  }
  return found;
}

}  // namespace tandem::cad_import
