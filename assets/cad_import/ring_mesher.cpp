#include "assets/cad_import/ring_mesher.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>

#include <glm/geometric.hpp>

#include "assets/cad_import/import_options.h"
#include "assets/cad_import/round_surface.h"

namespace tandem::cad_import {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kSameAngle = 1e-5;   // rad
constexpr double kSameLength = 1e-5;  // of the radius
constexpr double kStraight = 1e-6;    // of an edge's length in parameters
constexpr double kTiny = 1e-9;        // mm: deflection that the mesher never finds too coarse

glm::dvec3 vectorOf(const gp_XYZ& v) { return {v.X(), v.Y(), v.Z()}; }

/// One use of an edge by a face: a straight line in the angle and the height.
struct Side {
  TopoDS_Edge edge;
  bool across = false;             // the angle changes, the height does not
  double at = 0.0;                 // of the coordinate that does not change
  double from = 0.0, to = 0.0;     // of the other, where the edge's parameter begins and ends
  double first = 0.0, last = 0.0;  // the edge's parameter there
  Handle(Geom2d_Curve) curve;      // in the surface's parameters
  bool curveIsU = false;           // along the first of them
};

struct Patch {
  RoundSurface surface;
  TopLoc_Location location;  // of the face; the surface is without it
  std::vector<Side> sides;
  double left = 1e300, right = -1e300, bottom = 1e300, top = -1e300;
};

/// A straight edge in the surface's parameters: from and to by u where `across`, else by v.
std::optional<Side> sideOf(const TopoDS_Edge& edge, const TopoDS_Face& face) {
  if (BRep_Tool::Degenerated(edge) || !BRep_Tool::SameParameter(edge)) return std::nullopt;
  Side side;
  side.edge = edge;
  Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, side.first, side.last);
  if (curve.IsNull()) return std::nullopt;
  const gp_Pnt2d begin = curve->Value(side.first), end = curve->Value(side.last);
  const double width = std::abs(end.X() - begin.X()), height = std::abs(end.Y() - begin.Y());
  side.across = width > height;
  const double same = kStraight * std::max(width, height);
  double last = 0.0;  // how far along
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    const gp_Pnt2d at = curve->Value(side.first + share * (side.last - side.first));
    const double aside = side.across ? at.Y() - begin.Y() : at.X() - begin.X();
    const double ahead = side.across ? (at.X() - begin.X()) / (end.X() - begin.X())
                                     : (at.Y() - begin.Y()) / (end.Y() - begin.Y());
    if (std::abs(aside) > same || !(ahead > last)) return std::nullopt;
    last = ahead;
  }
  side.curve = curve;
  side.curveIsU = side.across;
  side.at = side.across ? begin.Y() : begin.X();
  side.from = side.across ? begin.X() : begin.Y();
  side.to = side.across ? end.X() : end.Y();
  return side;
}

/// The edge's parameter where the surface's is `at`, by halving.
double edgeParameter(const Side& side, double at) {
  const auto value = [&](double t) {
    const gp_Pnt2d p = side.curve->Value(t);
    return side.curveIsU ? p.X() : p.Y();
  };
  const bool rises = value(side.last) > value(side.first);
  const double same = 1e-9 * std::abs(value(side.last) - value(side.first));
  if (std::abs(at - value(side.first)) <= same) return side.first;
  if (std::abs(at - value(side.last)) <= same) return side.last;
  double low = side.first, high = side.last;
  for (int halving = 0; halving < 52; ++halving) {
    const double middle = 0.5 * (low + high);
    ((value(middle) < at) == rises ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The sides of a face all of whose edges are straight in its parameters; none otherwise.
std::vector<Side> sidesOf(const TopoDS_Face& face) {
  std::vector<Side> sides;
  for (TopExp_Explorer at(face.Oriented(TopAbs_FORWARD), TopAbs_EDGE); at.More(); at.Next()) {
    const std::optional<Side> side = sideOf(TopoDS::Edge(at.Current()), face);
    if (!side) return {};
    sides.push_back(*side);
  }
  return sides;
}

ParameterBox boxOf(const std::vector<Side>& sides) {
  ParameterBox box{1e300, -1e300, 1e300, -1e300};
  for (const Side& side : sides) {
    double &low = side.across ? box.uFrom : box.vFrom, &high = side.across ? box.uTo : box.vTo;
    low = std::min({low, side.from, side.to});
    high = std::max({high, side.from, side.to});
  }
  return box;
}

/// Turns the side's surface parameters into angle and height.
void convert(Side& side, const RoundSurface& surface) {
  side.across = side.across == surface.roundIsU();
  const auto other = [&](double p) { return side.across ? surface.heightAt(p) : surface.angleAt(p); };
  const auto own = [&](double p) { return side.across ? surface.angleAt(p) : surface.heightAt(p); };
  side.at = other(side.at);
  side.from = own(side.from);
  side.to = own(side.to);
}

/// Whether the sides bound a rectangle of angle and height, once around.
bool isRectangle(Patch& patch) {
  double across = 0.0, along = 0.0;
  for (const Side& side : patch.sides) {
    double &low = side.across ? patch.left : patch.bottom, &high = side.across ? patch.right : patch.top;
    low = std::min({low, side.from, side.to});
    high = std::max({high, side.from, side.to});
    (side.across ? across : along) += std::abs(side.to - side.from);
  }
  const double same = kSameLength * patch.surface.radius();
  const double width = patch.right - patch.left, height = patch.top - patch.bottom;
  if (!(width > kSameAngle && height > same) || width > kTurn + kSameAngle) return false;
  if (std::abs(across - 2.0 * width) > kSameAngle || std::abs(along - 2.0 * height) > same) return false;
  return std::all_of(patch.sides.begin(), patch.sides.end(), [&](const Side& side) {
    const double low = side.across ? patch.bottom : patch.left, high = side.across ? patch.top : patch.right;
    const double off = std::min(std::abs(side.at - low), std::abs(side.at - high));
    return off <= (side.across ? same : kSameAngle);
  });
}

/// The face as a rectangle of angle and height; nothing if it is not one.
std::optional<Patch> patchOf(const TopoDS_Face& face) {
  std::vector<Side> sides = sidesOf(face);
  if (sides.empty()) return std::nullopt;
  TopLoc_Location location;
  const auto surface = RoundSurface::recognise(BRep_Tool::Surface(face, location), boxOf(sides));
  if (!surface) return std::nullopt;
  for (Side& side : sides) convert(side, *surface);
  Patch patch{*surface, location, std::move(sides)};
  if (!isRectangle(patch)) return std::nullopt;
  return patch;
}

glm::dvec3 placed(const gp_Trsf& map, const glm::dvec3& point) {
  return vectorOf(gp_Pnt(point.x, point.y, point.z).Transformed(map).XYZ());
}

glm::dvec3 turned(const gp_Trsf& map, const glm::dvec3& direction) {
  return vectorOf(gp_Vec(direction.x, direction.y, direction.z).Transformed(map).XYZ());
}

Ring ringOf(const Patch& patch, const TopoDS_Face& face) {
  const gp_Trsf& bodyFromFace = patch.location.Transformation();
  Ring ring;
  ring.origin = placed(bodyFromFace, patch.surface.origin());
  ring.zero = turned(bodyFromFace, patch.surface.zero());
  ring.axis = turned(bodyFromFace, patch.surface.axis());
  ring.from = patch.bottom;
  ring.to = patch.top;
  ring.radius = patch.surface.radius();
  ring.hollow = (face.Orientation() == TopAbs_REVERSED) == patch.surface.outward();
  for (const Side& side : patch.sides) {
    if (!side.across) continue;
    ring.corners.push_back(side.from);
    ring.corners.push_back(side.to);
  }
  return ring;
}

/// Adds the ring to one of its body that it continues, or as a new one; fills in which.
void merge(std::vector<Ring>& rings, std::size_t first, const Ring& ring, RingFace& out) {
  const double same = kSameLength * ring.radius;
  for (std::size_t i = first; i < rings.size(); ++i) {
    Ring& other = rings[i];
    if (other.hollow != ring.hollow || std::abs(other.radius - ring.radius) > same) continue;
    if (glm::length(glm::cross(other.axis, ring.axis)) > kSameLength) continue;
    if (glm::length(glm::cross(ring.origin - other.origin, other.axis)) > same) continue;
    out.ring = static_cast<std::uint32_t>(i);
    out.mirrored = glm::dot(other.axis, ring.axis) < 0.0;
    out.ringFromFace =
        std::atan2(glm::dot(ring.zero, glm::cross(other.axis, other.zero)), glm::dot(ring.zero, other.zero));
    for (const double end : {ring.from, ring.to}) {
      const double along = glm::dot(ring.origin + end * ring.axis - other.origin, other.axis);
      other.from = std::min(other.from, along);
      other.to = std::max(other.to, along);
    }
    for (const double corner : ring.corners)
      other.corners.push_back((out.mirrored ? -corner : corner) + out.ringFromFace);
    return;
  }
  out.ring = static_cast<std::uint32_t>(rings.size());
  rings.push_back(ring);
}

/// Ascending, without neighbours nearer than `same`.
void sortAndMerge(std::vector<double>& values, double same) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end(), [&](double a, double b) { return b - a < same; }),
               values.end());
}

int nearest(const std::vector<double>& values, double to) {
  const auto closer = [&](double a, double b) { return std::abs(a - to) < std::abs(b - to); };
  return static_cast<int>(std::min_element(values.begin(), values.end(), closer) - values.begin());
}

/// Columns of angles and rows of heights, with a node at each crossing.
class Grid {
 public:
  Grid(const RingFace& ringFace, const Patch& patch, const std::vector<double>& angles)
      : face_(ringFace.face), patch_(patch) {
    for (const Side& side : patch.sides)
      for (const double end : {side.from, side.to}) (side.across ? columns_ : rows_).push_back(end);
    sortAndMerge(columns_, kSameAngle);
    sortAndMerge(rows_, kSameLength * patch.surface.radius());
    const std::vector<double> corners = columns_;
    for (double angle : angles) {
      angle = ringFace.mirrored ? ringFace.ringFromFace - angle : angle - ringFace.ringFromFace;
      angle -= std::floor((angle - patch.left) / kTurn) * kTurn;  // into [left, left + a turn)
      const bool there = std::any_of(corners.begin(), corners.end(),
                                     [&](double c) { return std::abs(c - angle) < kSameAngle; });
      if (!there && angle < patch.right) columns_.push_back(angle);
    }
    std::sort(columns_.begin(), columns_.end());
  }

  void lay() const {
    const int across = static_cast<int>(columns_.size()), along = static_cast<int>(rows_.size());
    const Handle(Poly_Triangulation) facets =
        new Poly_Triangulation(across * along, 2 * (across - 1) * (along - 1), true);
    for (int j = 0; j < along; ++j)
      for (int i = 0; i < across; ++i) {
        const double u = columns_[static_cast<std::size_t>(i)], v = rows_[static_cast<std::size_t>(j)];
        const double around = patch_.surface.parameterAtAngle(u),
                     height = patch_.surface.parameterAtHeight(v);
        const glm::dvec3 p = patch_.surface.point(around, height);
        facets->SetNode(node(i, j), gp_Pnt(p.x, p.y, p.z));
        facets->SetUVNode(node(i, j),
                          patch_.surface.roundIsU() ? gp_Pnt2d(around, height) : gp_Pnt2d(height, around));
      }
    // Facets are wound as the surface's own normal says, and these columns and rows as one away from the
    // axis.
    const bool turned = !patch_.surface.outward();
    int triangle = 0;
    const auto add = [&](int a, int b, int c) {
      facets->SetTriangle(++triangle, turned ? Poly_Triangle(a, c, b) : Poly_Triangle(a, b, c));
    };
    for (int j = 0; j + 1 < along; ++j)
      for (int i = 0; i + 1 < across; ++i) {
        add(node(i, j), node(i + 1, j), node(i + 1, j + 1));
        add(node(i, j), node(i + 1, j + 1), node(i, j + 1));
      }
    for (const Side& side : patch_.sides) placeVertices(side, facets);
    facets->Deflection(kTiny);
    BRep_Builder().UpdateFace(face_, facets);
    for (const Side& side : patch_.sides) addEdge(side, facets);
  }

 private:
  int node(int column, int row) const { return row * static_cast<int>(columns_.size()) + column + 1; }

  int nodeAt(const Side& side, double along) const {
    return side.across ? node(nearest(columns_, along), nearest(rows_, side.at))
                       : node(nearest(columns_, side.at), nearest(rows_, along));
  }

  /// The other faces of an edge end at its vertices, which may be off the surface by their tolerance.
  void placeVertices(const Side& side, const Handle(Poly_Triangulation) & facets) const {
    const TopoDS_Edge forward = TopoDS::Edge(side.edge.Oriented(TopAbs_FORWARD));
    const gp_Trsf faceFromBody = patch_.location.Transformation().Inverted();
    const std::pair<TopoDS_Vertex, double> ends[] = {{TopExp::FirstVertex(forward), side.from},
                                                     {TopExp::LastVertex(forward), side.to}};
    for (const auto& [vertex, along] : ends)
      if (!vertex.IsNull())
        facets->SetNode(nodeAt(side, along), BRep_Tool::Pnt(vertex).Transformed(faceFromBody));
  }

  Handle(Poly_PolygonOnTriangulation) polygon(const Side& side) const {
    const std::vector<double>& stops = side.across ? columns_ : rows_;
    const double low = std::min(side.from, side.to), high = std::max(side.from, side.to);
    const double same = side.across ? kSameAngle : kSameLength * patch_.surface.radius();
    std::vector<double> along;
    for (const double stop : stops)
      if (stop > low - same && stop < high + same) along.push_back(stop);
    if (side.from > side.to) std::reverse(along.begin(), along.end());
    TColStd_Array1OfInteger nodes(1, static_cast<int>(along.size()));
    TColStd_Array1OfReal parameters(1, static_cast<int>(along.size()));
    for (std::size_t k = 0; k < along.size(); ++k) {
      const double p = side.across ? patch_.surface.parameterAtAngle(along[k])
                                   : patch_.surface.parameterAtHeight(along[k]);
      nodes.SetValue(static_cast<int>(k) + 1, nodeAt(side, along[k]));
      parameters.SetValue(static_cast<int>(k) + 1, edgeParameter(side, p));
    }
    const Handle(Poly_PolygonOnTriangulation) out = new Poly_PolygonOnTriangulation(nodes, parameters);
    out->Deflection(kTiny);
    return out;
  }

  void addEdge(const Side& side, const Handle(Poly_Triangulation) & facets) const {
    const auto twin = std::find_if(patch_.sides.begin(), patch_.sides.end(), [&](const Side& other) {
      return &other != &side && other.edge.IsSame(side.edge);
    });
    BRep_Builder builder;
    if (twin == patch_.sides.end())
      return builder.UpdateEdge(side.edge, polygon(side), facets, patch_.location);
    const bool forward = side.edge.Orientation() == TopAbs_FORWARD;
    if (forward) builder.UpdateEdge(side.edge, polygon(side), polygon(*twin), facets, patch_.location);
  }

  TopoDS_Face face_;
  const Patch& patch_;
  std::vector<double> columns_, rows_;  // rad, mm; ascending
};

}  // namespace

std::vector<RingFace> findRingFaces(const Body& body, std::uint32_t index, double deflection,
                                    std::vector<Ring>& rings, std::size_t& trimmed) {
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(body.shape, TopAbs_FACE, faces);
  std::vector<RingFace> found;
  const std::size_t first = rings.size();
  for (int i = 1; i <= faces.Extent(); ++i) {
    RingFace ringFace;
    ringFace.face = TopoDS::Face(faces.FindKey(i));
    const std::optional<Patch> patch = patchOf(ringFace.face);
    if (!patch) {
      TopLoc_Location location;
      trimmed += BRep_Tool::Surface(ringFace.face, location)->IsKind(STANDARD_TYPE(Geom_CylindricalSurface));
      continue;
    }
    Ring ring = ringOf(*patch, ringFace.face);
    ring.body = index;
    const double chord = std::clamp(1.0 - deflection / ring.radius, -1.0, 1.0);
    ring.step = std::min(kFacetAngle, 2.0 * std::acos(chord));
    merge(rings, first, ring, ringFace);
    found.push_back(ringFace);
  }
  return found;
}

void layRingFacets(const RingFace& ringFace, const std::vector<double>& angles) {
  if (const std::optional<Patch> patch = patchOf(ringFace.face)) Grid(ringFace, *patch, angles).lay();
}

}  // namespace tandem::cad_import
