#include "tests/bench/part_peers/part_peer.h"

#ifdef TANDEM_PEER_ODE

#include <ode/ode.h>

#include <cstdarg>
#include <vector>

#include <glm/gtc/quaternion.hpp>

namespace tandem::bench {
namespace {

/// The library's own state, once a process.
class Ode {
 public:
  Ode() {
    dInitODE2(0);
    // It says a line for each query whose contacts are too many for its table of near ones.
    dSetMessageHandler([](int, const char*, va_list) {});
  }
  ~Ode() { dCloseODE(); }
};

/// A mesh as ODE wants it, in mm: its tolerances are made for lengths about 1.
class OdeMesh {
 public:
  explicit OdeMesh(const assets::Mesh& mesh) : data_(dGeomTriMeshDataCreate()) {
    for (const glm::dvec3& p : mesh.positions)
      for (int i = 0; i < 3; ++i) corners_.push_back(1e3 * p[i]);
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t v : t) indices_.push_back(static_cast<dTriIndex>(v));
    dGeomTriMeshDataBuildDouble(data_, corners_.data(), 3 * sizeof(double),
                                static_cast<int>(corners_.size() / 3), indices_.data(),
                                static_cast<int>(indices_.size()), 3 * sizeof(dTriIndex));
    geometry_ = dCreateTriMesh(nullptr, data_, nullptr, nullptr, nullptr);
  }
  ~OdeMesh() {
    dGeomDestroy(geometry_);
    dGeomTriMeshDataDestroy(data_);
  }
  OdeMesh(const OdeMesh&) = delete;

  dGeomID geometry() const { return geometry_; }

 private:
  std::vector<double> corners_;
  std::vector<dTriIndex> indices_;
  dTriMeshDataID data_;
  dGeomID geometry_ = nullptr;
};

class OdePartPeer final : public PartPeer {
 public:
  OdePartPeer(const assets::Mesh& held, const assets::Mesh& other)
      : held_(held), other_(other), found_(kMaxContacts) {}

  std::string id() const override { return "ode"; }
  std::string name() const override { return "ODE dCollide"; }
  std::string version() const override { return "ODE " TANDEM_PEER_ODE; }

  PeerContacts contacts(const Pose& worldFromHeld) override {
    const glm::dvec3 p = 1e3 * worldFromHeld.position;
    const glm::dquat& q = worldFromHeld.orientation;
    const dQuaternion turn{q.w, q.x, q.y, q.z};
    dGeomSetPosition(held_.geometry(), p.x, p.y, p.z);
    dGeomSetQuaternion(held_.geometry(), turn);
    const int count =
        dCollide(held_.geometry(), other_.geometry(), kMaxContacts, found_.data(), sizeof(dContactGeom));
    PeerContacts all;
    all.count = count;
    for (int i = 0; i < count; ++i) {
      const dContactGeom& c = found_[static_cast<std::size_t>(i)];
      const double depth = 1e-3 * c.depth;
      all.depth = std::max(all.depth, depth);
      // Along its normals the first object gets free.
      all.normal += depth * glm::dvec3(c.normal[0], c.normal[1], c.normal[2]);
    }
    return all;
  }

 private:
  static constexpr int kMaxContacts = 0xffff;  // what fits its flags

  Ode ode_;
  OdeMesh held_, other_;
  std::vector<dContactGeom> found_;
};

}  // namespace

std::unique_ptr<PartPeer> odePartPeer(const assets::Mesh& held, const assets::Mesh& other) {
  return std::make_unique<OdePartPeer>(held, other);
}

}  // namespace tandem::bench

#else

namespace tandem::bench {
std::unique_ptr<PartPeer> odePartPeer(const assets::Mesh&, const assets::Mesh&) { return nullptr; }
}  // namespace tandem::bench

#endif
