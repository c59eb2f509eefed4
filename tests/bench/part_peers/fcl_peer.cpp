#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>

#include "tests/bench/part_peers/part_peer.h"

namespace tandem::bench {
namespace {

using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Model> modelOf(const assets::Mesh& mesh) {
  std::vector<fcl::Vector3d> corners;
  std::vector<fcl::Triangle> indices;
  for (const glm::dvec3& p : mesh.positions) corners.emplace_back(p.x, p.y, p.z);
  for (const auto& t : mesh.triangles) indices.emplace_back(t[0], t[1], t[2]);
  auto model = std::make_shared<Model>();
  model->beginModel(static_cast<int>(indices.size()), static_cast<int>(corners.size()));
  model->addSubModel(corners, indices);
  model->endModel();
  return model;
}

class FclPartPeer final : public PartPeer {
 public:
  FclPartPeer(const assets::Mesh& held, const assets::Mesh& other)
      : held_(modelOf(held)), other_(modelOf(other)) {}

  std::string id() const override { return "fcl"; }
  std::string name() const override { return "FCL collide"; }
  std::string version() const override { return "FCL " FCL_VERSION; }

  PeerContacts contacts(const Pose& worldFromHeld) override {
    fcl::Transform3d at = fcl::Transform3d::Identity();
    const glm::dquat& q = worldFromHeld.orientation;
    at.linear() = fcl::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
    at.translation() =
        fcl::Vector3d(worldFromHeld.position.x, worldFromHeld.position.y, worldFromHeld.position.z);
    const fcl::CollisionRequestd request(100'000, true);
    fcl::CollisionResultd result;
    fcl::collide(held_.get(), at, other_.get(), fcl::Transform3d::Identity(), request, result);
    PeerContacts all;
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      const fcl::Contactd& c = result.getContact(i);
      ++all.count;
      all.depth = std::max(all.depth, c.penetration_depth);
      // Its normals look from the first object to the second.
      all.normal -= c.penetration_depth * glm::dvec3(c.normal.x(), c.normal.y(), c.normal.z());
    }
    return all;
  }

 private:
  std::shared_ptr<Model> held_, other_;
};

}  // namespace

std::unique_ptr<PartPeer> fclPartPeer(const assets::Mesh& held, const assets::Mesh& other) {
  return std::make_unique<FclPartPeer>(held, other);
}

}  // namespace tandem::bench
