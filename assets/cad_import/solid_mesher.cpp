#include "assets/cad_import/solid_mesher.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <IMeshTools_Parameters.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>

#include <glm/geometric.hpp>

#include "assets/cad_import/face_shapes.h"
#include "assets/cad_import/import_options.h"

namespace tandem::cad_import {
namespace {

constexpr double kRelativeDeflection = 1e-3;  // of the body's diagonal
constexpr double kLeastDeflection = 1e-5;     // mm

/// Collects the faces of one body.
class MeshBuilder {
 public:
  MeshBuilder(const Body& body, double metres) : metres_(metres) {
    mesh_.name = body.name;
    mesh_.faces = exactFaces(body.shape, metres);
  }

  bool add(const TopoDS_Face& face, std::uint32_t colour) {
    TopLoc_Location location;
    const Handle(Poly_Triangulation) facets = BRep_Tool::Triangulation(face, location);
    if (facets.IsNull() || facets->NbTriangles() == 0) return false;
    const bool reversed = face.Orientation() == TopAbs_REVERSED;
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    const gp_Trsf& bodyFromFace = location.Transformation();
    for (int i = 1; i <= facets->NbNodes(); ++i) {
      const gp_Pnt p = facets->Node(i).Transformed(bodyFromFace);
      mesh_.positions.push_back(metres_ * glm::dvec3(p.X(), p.Y(), p.Z()));
    }
    std::vector<std::uint32_t>& corners = cornersOf(colour);
    const std::size_t firstCorner = corners.size();
    const bool flip = reversed != (bodyFromFace.IsNegative() == Standard_True);
    for (int i = 1; i <= facets->NbTriangles(); ++i) {
      int a = 0, b = 0, c = 0;
      facets->Triangle(i).Get(a, b, c);
      if (flip) std::swap(b, c);
      const std::array<std::uint32_t, 3> triangle{first + static_cast<std::uint32_t>(a) - 1,
                                                  first + static_cast<std::uint32_t>(b) - 1,
                                                  first + static_cast<std::uint32_t>(c) - 1};
      if (!flat(triangle)) corners.insert(corners.end(), triangle.begin(), triangle.end());
    }
    addNormals(face, *facets, reversed, first,
               {corners.begin() + static_cast<std::ptrdiff_t>(firstCorner), corners.end()});
    return true;
  }

  CadMesh take() { return std::move(mesh_); }

 private:
  std::vector<std::uint32_t>& cornersOf(std::uint32_t colour) {
    const auto [it, isNew] = group_.emplace(colour, mesh_.triangles.size());
    if (isNew) mesh_.triangles.push_back({colour, {}});
    return mesh_.triangles[it->second].corners;
  }

  /// Whether two corners are the same in the file's precision.
  bool flat(const std::array<std::uint32_t, 3>& triangle) const {
    const glm::vec3 a(mesh_.positions[triangle[0]]), b(mesh_.positions[triangle[1]]),
        c(mesh_.positions[triangle[2]]);
    return a == b || b == c || c == a;
  }

  /// Of the exact surface; where that has none, at the tip of a cone, the mean of the facets'.
  void addNormals(const TopoDS_Face& face, const Poly_Triangulation& facets, bool reversed,
                  std::uint32_t first, const std::vector<std::uint32_t>& corners) {
    std::vector<glm::dvec3> mean(static_cast<std::size_t>(facets.NbNodes()), glm::dvec3(0.0));
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      const glm::dvec3 &a = mesh_.positions[corners[i]], &b = mesh_.positions[corners[i + 1]],
                       &c = mesh_.positions[corners[i + 2]];
      for (std::size_t k = 0; k < 3; ++k) mean[corners[i + k] - first] += glm::cross(b - a, c - a);
    }
    const BRepAdaptor_Surface surface(face, false);
    for (int i = 1; i <= facets.NbNodes(); ++i) {
      glm::dvec3 normal(0.0);
      if (facets.HasUVNodes()) {
        gp_Pnt at;
        gp_Vec du, dv;
        surface.D1(facets.UVNode(i).X(), facets.UVNode(i).Y(), at, du, dv);
        const gp_Vec n = du.Crossed(dv);
        const double size = n.Magnitude();
        if (size > 1e-9 * du.Magnitude() * dv.Magnitude() && size > 0.0)
          normal = (reversed ? -1.0 : 1.0) / size * glm::dvec3(n.X(), n.Y(), n.Z());
      }
      if (normal == glm::dvec3(0.0)) normal = mean[static_cast<std::size_t>(i) - 1];
      const double length = glm::length(normal);
      mesh_.normals.emplace_back(length > 0.0 ? normal / length : glm::dvec3(0.0, 0.0, 1.0));
    }
  }

  double metres_;
  CadMesh mesh_;
  std::map<std::uint32_t, std::size_t> group_;  // by colour
};

}  // namespace

double deflectionOf(const Body& body, double asked) {
  if (asked > 0.0) return asked;
  Bnd_Box box;
  BRepBndLib::Add(body.shape, box, false);
  if (box.IsVoid()) return kLeastDeflection;
  return std::max(kLeastDeflection, kRelativeDeflection * std::sqrt(box.SquareExtent()));
}

CadMesh meshBody(const Body& body, double deflection, double metresPerMillimetre, std::size_t& lost) {
  IMeshTools_Parameters parameters;
  parameters.Deflection = deflection;
  parameters.Angle = kFacetAngle;
  parameters.InParallel = false;
  parameters.AllowQualityDecrease = false;  // facets that are there are kept, however fine
  BRepMesh_IncrementalMesh mesher(body.shape, parameters);
  MeshBuilder builder(body, metresPerMillimetre);
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(body.shape, TopAbs_FACE, faces);
  for (int i = 1; i <= faces.Extent(); ++i) {
    const std::uint32_t own = body.faceColours[static_cast<std::size_t>(i) - 1];
    if (!builder.add(TopoDS::Face(faces.FindKey(i)), own == kNone ? body.colour : own)) ++lost;
  }
  return builder.take();
}

}  // namespace tandem::cad_import
