#include "client/levels/decimation.h"

#include <algorithm>
#include <array>
#include <utility>

#include <glm/geometric.hpp>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <OpenMesh/Tools/Decimater/Observer.hh>

#include "assets/base/assert.h"
#include "assets/base/disjoint_sets.h"

namespace tandem::client {
namespace {

using assets::kNone;

constexpr std::uint8_t kMaterialBorder = 8;  // beside assets::EdgeFlag
constexpr double kBorderWeight = 4.0;        // of the planes that stand on lines, against those of faces
constexpr double kEvenness = 1e-6;           // weight of short edges first where nothing else decides
constexpr float kMostTurn = 80.0f;           // degrees, of a triangle's normal in one collapse
constexpr double kShareAtOnce = 0.2;         // of the triangles
constexpr std::size_t kCollapsesBetweenLooks = 2000;

struct DecimationTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::VectorT<double, 3>;
  using Normal = OpenMesh::VectorT<double, 3>;
  VertexAttributes(OpenMesh::Attributes::Status);
  HalfedgeAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
};

/// The questions that the decimater asks most often, answered here: those of the library, where it is built
/// with assertions as Debian's is, take most of a decimation's time.
class CollapsingMesh : public OpenMesh::TriMesh_ArrayKernelT<DecimationTraits> {
 public:
  HalfedgeHandle find_halfedge(VertexHandle from, VertexHandle to) const {
    const HalfedgeHandle first = halfedge_handle(from);
    HalfedgeHandle h = first;
    if (!first.is_valid()) return h;
    do {
      if (to_vertex_handle(h) == to) return h;
      h = cw_rotated_halfedge_handle(h);
    } while (h != first);
    return HalfedgeHandle();
  }

  /// Whether the mesh stays manifold: the ends share no neighbour but the corners opposite to the edge (link
  /// condition, Dey et al. 1999), and an edge between two borders is one.
  bool is_collapse_ok(HalfedgeHandle v0v1) const {
    const HalfedgeHandle v1v0 = opposite_halfedge_handle(v0v1);
    const VertexHandle v0 = to_vertex_handle(v1v0), v1 = to_vertex_handle(v0v1);
    if (status(edge_handle(v0v1)).deleted() || status(v0).deleted() || status(v1).deleted()) return false;
    VertexHandle left, right;
    if (!is_boundary(v0v1)) {
      left = to_vertex_handle(next_halfedge_handle(v0v1));
      if (bothAtBorders(next_halfedge_handle(v0v1))) return false;
    }
    if (!is_boundary(v1v0)) {
      right = to_vertex_handle(next_halfedge_handle(v1v0));
      if (bothAtBorders(next_halfedge_handle(v1v0))) return false;
    }
    if (left == right) return false;
    if (is_boundary(v0) && is_boundary(v1) && !is_boundary(v0v1) && !is_boundary(v1v0)) return false;
    return !shareNeighbour(v0, v1, left, right);
  }

 private:
  /// Whether the second and third edge of a triangle are borders: it would become a line.
  bool bothAtBorders(HalfedgeHandle second) const {
    return is_boundary(opposite_halfedge_handle(second)) &&
           is_boundary(opposite_halfedge_handle(next_halfedge_handle(second)));
  }
  bool shareNeighbour(VertexHandle v0, VertexHandle v1, VertexHandle left, VertexHandle right) const {
    const HalfedgeHandle first = halfedge_handle(v0);
    HalfedgeHandle h = first;
    do {
      const VertexHandle v = to_vertex_handle(h);
      if (v != v1 && v != left && v != right && find_halfedge(v1, v).is_valid()) return true;
      h = cw_rotated_halfedge_handle(h);
    } while (h != first);
    return false;
  }
};
using Line = OpenMesh::EPropHandleT<std::uint8_t>;  // EdgeFlag bits and kMaterialBorder; 0: no line
using Locked = OpenMesh::VPropHandleT<bool>;

/// Priorities by error quadrics (Garland and Heckbert 1997). Vertices on lines stay on them: they collapse
/// only along a line that runs on, and planes that stand on the line and on the face beside it keep its
/// course, also where the faces are flat.
template <typename MeshT>
class LineQuadrics : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(LineQuadrics, MeshT, LineQuadrics);
  using Point = typename MeshT::Point;

  explicit LineQuadrics(MeshT& mesh) : Base(mesh, false) { Base::mesh().add_property(quadrics_); }
  ~LineQuadrics() override { Base::mesh().remove_property(quadrics_); }

  void follow(Line line, Locked locked) {
    line_ = line;
    locked_ = locked;
  }

  void initialize() override {
    MeshT& mesh = Base::mesh();
    for (const auto v : mesh.vertices()) mesh.property(quadrics_, v).clear();
    for (const auto f : mesh.faces()) {
      const double area = mesh.calc_face_area(f);
      const Point n = mesh.normal(f);
      auto h = mesh.halfedge_handle(f);
      for (int k = 0; k < 3; ++k, h = mesh.next_halfedge_handle(h)) {
        addPlane(mesh.to_vertex_handle(h), n, mesh.point(mesh.to_vertex_handle(h)), area);
        if (mesh.property(line_, mesh.edge_handle(h)) == 0) continue;
        const auto from = mesh.from_vertex_handle(h), to = mesh.to_vertex_handle(h);
        const Point along = mesh.point(to) - mesh.point(from), side = along % n;
        const double length = side.norm();
        if (!(length > 0.0)) continue;
        for (const auto v : {from, to})
          addPlane(v, side / length, mesh.point(to), kBorderWeight * length * length);
      }
    }
  }

  float collapse_priority(const CollapseInfo& c) override {
    const MeshT& mesh = Base::mesh();
    if (mesh.property(locked_, c.v0) || !keepsLines(c)) return float(Base::ILLEGAL_COLLAPSE);
    Quadric sum = mesh.property(quadrics_, c.v0);
    sum += mesh.property(quadrics_, c.v1);
    const double length2 = (c.p1 - c.p0).sqrnorm();
    return static_cast<float>(std::max(sum(c.p1), 0.0) + kEvenness * length2 * length2);
  }

  /// Of the two edges that become one, either may have been a line.
  void preprocess_collapse(const CollapseInfo& c) override {
    left_ = lineBetween(c.v1, c.vl);
    right_ = lineBetween(c.v1, c.vr);
  }
  void postprocess_collapse(const CollapseInfo& c) override {
    Base::mesh().property(quadrics_, c.v1) += Base::mesh().property(quadrics_, c.v0);
    keepLine(c.v1, c.vl, left_);
    keepLine(c.v1, c.vr, right_);
  }

 private:
  using Quadric = OpenMesh::Geometry::QuadricT<double>;

  void addPlane(typename MeshT::VertexHandle v, const Point& normal, const Point& point, double weight) {
    Quadric plane(normal[0], normal[1], normal[2], -(normal | point));
    plane *= weight;
    Base::mesh().property(quadrics_, v) += plane;
  }

  bool keepsLines(const CollapseInfo& c) {
    const MeshT& mesh = Base::mesh();
    const std::uint8_t along = mesh.property(line_, mesh.edge_handle(c.v0v1));
    int lines = 0;
    for (auto h = mesh.cvoh_iter(c.v0); h.is_valid(); ++h) {
      const std::uint8_t line = mesh.property(line_, mesh.edge_handle(*h));
      if (line == 0) continue;
      ++lines;
      const auto end = mesh.to_vertex_handle(*h);
      if (line != along || end == c.vl || end == c.vr) return false;
    }
    return lines == 0 || lines == 2;
  }

  std::uint8_t lineBetween(typename MeshT::VertexHandle a, typename MeshT::VertexHandle b) {
    if (!b.is_valid()) return 0;
    const auto h = Base::mesh().find_halfedge(a, b);
    return h.is_valid() ? Base::mesh().property(line_, Base::mesh().edge_handle(h)) : std::uint8_t{0};
  }
  void keepLine(typename MeshT::VertexHandle a, typename MeshT::VertexHandle b, std::uint8_t line) {
    if (!b.is_valid()) return;
    const auto h = Base::mesh().find_halfedge(a, b);
    if (h.is_valid()) Base::mesh().property(line_, Base::mesh().edge_handle(h)) = line;
  }

  OpenMesh::VPropHandleT<Quadric> quadrics_;
  Line line_;
  Locked locked_;
  std::uint8_t left_ = 0, right_ = 0;
};

class StopObserver final : public OpenMesh::Decimater::Observer {
 public:
  explicit StopObserver(const std::function<bool()>& stopped)
      : Observer(kCollapsesBetweenLooks), stopped_(stopped) {}
  void notify(std::size_t) override { abort_ = stopped_ && stopped_(); }
  bool abort() const override { return abort_; }

 private:
  const std::function<bool()>& stopped_;
  bool abort_ = false;
};

/// The triangle's edge e, as its neighbour across it sees it; kNone where no neighbour continues the surface.
std::uint32_t edgeAcross(const assets::Mesh& mesh, std::uint32_t t, std::uint32_t e) {
  const std::uint32_t other = mesh.neighbours[t][e];
  if (other == kNone || (mesh.edgeFlags[t][e] & (assets::kEdgeBoundary | assets::kEdgeNonManifold)) != 0)
    return kNone;
  for (std::uint32_t o = 0; o < 3; ++o)
    if (mesh.triangles[other][o] == mesh.triangles[t][(e + 1) % 3] &&
        mesh.triangles[other][(o + 1) % 3] == mesh.triangles[t][e])
      return 3 * other + o;
  return kNone;
}

}  // namespace

struct Decimation::Data {
  using Decimater = OpenMesh::Decimater::DecimaterT<CollapsingMesh>;

  CollapsingMesh mesh;
  std::vector<std::uint32_t> point;  // of each vertex, in the exact mesh
  Line line;
  Locked locked;
  std::unique_ptr<Decimater> decimater;  // of `mesh`; what it collapses stays there, marked as deleted
  std::size_t faces = 0;                 // that are left

  bool fill(const assets::Mesh& exact);
  bool addFaces(const assets::Mesh& exact);
  void nameLines(const assets::Mesh& exact);
  void prepare();
  void countFaces();
};

/// Corners of a point that no surface connects become vertices of their own, as OpenMesh wants it; they are
/// locked, so that what touches there goes on doing so.
bool Decimation::Data::addFaces(const assets::Mesh& exact) {
  const auto count = static_cast<std::uint32_t>(exact.triangles.size());
  DisjointSets corners(3 * exact.triangles.size());
  for (std::uint32_t t = 0; t < count; ++t)
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t across = edgeAcross(exact, t, e);
      if (across == kNone) continue;
      const std::uint32_t o = across % 3, first = across - o;
      corners.join(3 * t + e, first + (o + 1) % 3);
      corners.join(3 * t + (e + 1) % 3, first + o);
    }
  const glm::dvec3 centre = 0.5 * (exact.bounds.min + exact.bounds.max);
  const double size = glm::length(exact.bounds.max - exact.bounds.min);
  std::vector<int> vertexOf(3 * exact.triangles.size(), -1), firstOfPoint(exact.positions.size(), -1);
  mesh.reserve(exact.positions.size(), 2 * exact.triangles.size(), exact.triangles.size());
  mesh.add_property(line);
  mesh.add_property(locked);
  for (std::uint32_t t = 0; t < count; ++t) {
    std::array<CollapsingMesh::VertexHandle, 3> vertices;
    for (std::uint32_t k = 0; k < 3; ++k) {
      int& vertex = vertexOf[corners.find(3 * t + k)];
      const std::uint32_t p = exact.triangles[t][k];
      if (vertex < 0) {
        const glm::dvec3 at = (exact.positions[p] - centre) / size;
        const auto added = mesh.add_vertex({at.x, at.y, at.z});
        vertex = added.idx();
        point.push_back(p);
        mesh.property(locked, added) = firstOfPoint[p] >= 0;
        if (firstOfPoint[p] >= 0) mesh.property(locked, CollapsingMesh::VertexHandle(firstOfPoint[p])) = true;
        firstOfPoint[p] = vertex;
      }
      vertices[k] = CollapsingMesh::VertexHandle(vertex);
    }
    if (!mesh.add_face(vertices[0], vertices[1], vertices[2]).is_valid()) return false;
  }
  return true;
}

void Decimation::Data::nameLines(const assets::Mesh& exact) {
  for (const auto e : mesh.edges()) {
    std::uint8_t flags = 0;
    for (unsigned side = 0; side < 2; ++side) {
      const auto h = mesh.halfedge_handle(e, side);
      if (mesh.is_boundary(h)) {
        flags |= assets::kEdgeBoundary;
        continue;
      }
      const auto t = static_cast<std::size_t>(mesh.face_handle(h).idx());
      const std::uint32_t start = point[static_cast<std::size_t>(mesh.from_vertex_handle(h).idx())];
      for (std::size_t k = 0; k < 3; ++k)
        if (exact.triangles[t][k] == start) flags |= exact.edgeFlags[t][k];
    }
    if (!mesh.is_boundary(e)) {
      const auto face = [&](unsigned side) {
        return static_cast<std::size_t>(mesh.face_handle(mesh.halfedge_handle(e, side)).idx());
      };
      if (exact.triangleMaterial[face(0)] != exact.triangleMaterial[face(1)]) flags |= kMaterialBorder;
    }
    mesh.property(line, e) = flags;
  }
}

bool Decimation::Data::fill(const assets::Mesh& exact) {
  const std::size_t count = exact.triangles.size();
  if (count == 0 || exact.neighbours.size() != count || exact.edgeFlags.size() != count ||
      exact.triangleMaterial.size() != count)
    return false;
  if (!(glm::length(exact.bounds.max - exact.bounds.min) > 0.0) || !addFaces(exact)) return false;
  mesh.update_face_normals();
  nameLines(exact);
  return true;
}

void Decimation::Data::prepare() {
  OpenMesh::Decimater::ModHandleT<LineQuadrics<CollapsingMesh>> quadrics;
  OpenMesh::Decimater::ModHandleT<OpenMesh::Decimater::ModNormalFlippingT<CollapsingMesh>> flipping;
  decimater = std::make_unique<Decimater>(mesh);
  decimater->add(quadrics);
  decimater->add(flipping);
  decimater->module(quadrics).follow(line, locked);
  decimater->module(flipping).set_max_normal_deviation(kMostTurn);
  const bool ready = decimater->initialize();
  ASSERT(ready);
  countFaces();
}

void Decimation::Data::countFaces() {
  faces = 0;
  for (const auto f : mesh.all_faces()) faces += mesh.status(f).deleted() ? 0 : 1;
}

Decimation::Decimation(std::unique_ptr<Data> data) : data_(std::move(data)) {}
Decimation::~Decimation() = default;
Decimation::Decimation(Decimation&&) noexcept = default;

std::optional<Decimation> Decimation::of(const assets::Mesh& mesh) {
  auto data = std::make_unique<Data>();
  if (!data->fill(mesh)) return std::nullopt;
  data->prepare();
  return Decimation(std::move(data));
}

std::size_t Decimation::reduceTo(std::size_t triangles, const std::function<bool()>& stopped) {
  StopObserver observer(stopped);
  data_->decimater->set_observer(&observer);
  while (data_->faces > triangles && !(stopped && stopped())) {
    // A collapse takes two faces, one at an open border. The decimater computes a cost anew only beside the
    // collapses that it makes. The cost of an edge grows with the quadrics of its ends, so that older costs
    // are too low after a while: all are computed again after each share of the triangles.
    const auto few = static_cast<std::size_t>(kShareAtOnce * static_cast<double>(data_->faces));
    const std::size_t collapses = (std::min(data_->faces - triangles, few) + 1) / 2;
    if (data_->decimater->decimate(collapses) == 0) break;
    data_->countFaces();
  }
  data_->decimater->set_observer(nullptr);
  return data_->faces;
}

DecimatedMesh Decimation::mesh(const assets::Mesh& exact) const {
  const CollapsingMesh& from = data_->mesh;
  DecimatedMesh out;
  assets::Mesh& to = out.mesh;
  std::vector<std::uint32_t> placeOfPoint(exact.positions.size(), kNone), placeOfFace(from.n_faces(), kNone);
  for (const auto f : from.all_faces())
    if (!from.status(f).deleted()) {
      placeOfFace[static_cast<std::size_t>(f.idx())] = static_cast<std::uint32_t>(to.triangleMaterial.size());
      to.triangleMaterial.push_back(exact.triangleMaterial[static_cast<std::size_t>(f.idx())]);
    }
  for (const auto f : from.all_faces()) {
    if (from.status(f).deleted()) continue;
    std::array<std::uint32_t, 3> corners{}, neighbours{};
    std::array<std::uint8_t, 3> flags{};
    auto h = from.halfedge_handle(f);
    for (std::size_t k = 0; k < 3; ++k, h = from.next_halfedge_handle(h)) {
      const std::uint32_t p = data_->point[static_cast<std::size_t>(from.from_vertex_handle(h).idx())];
      if (placeOfPoint[p] == kNone) {
        placeOfPoint[p] = static_cast<std::uint32_t>(to.positions.size());
        to.positions.push_back(exact.positions[p]);
        out.exactPoint.push_back(p);
      }
      corners[k] = placeOfPoint[p];
      const auto across = from.opposite_halfedge_handle(h);
      neighbours[k] = from.is_boundary(across)
                          ? kNone
                          : placeOfFace[static_cast<std::size_t>(from.face_handle(across).idx())];
      flags[k] = from.property(data_->line, from.edge_handle(h)) & (kMaterialBorder - 1);
    }
    to.triangles.push_back(corners);
    to.neighbours.push_back(neighbours);
    to.edgeFlags.push_back(flags);
  }
  for (const glm::dvec3& p : to.positions) {
    to.bounds.include(p);
  }
  to.closed = exact.closed;
  return out;
}

}  // namespace tandem::client
