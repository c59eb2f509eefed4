#include "tests/bench/part_peers/part_peer.h"

#ifdef TANDEM_PEER_BULLET

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include <vector>

#include <glm/gtc/quaternion.hpp>

namespace tandem::bench {
namespace {

constexpr double kScale = 1e3;  // in mm: its tolerances are made for lengths about 1

btVector3 vectorOf(const glm::dvec3& v) {
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}

/// A mesh as the one shape of Bullet's that moves and need not be convex.
class BulletMesh {
 public:
  explicit BulletMesh(const assets::Mesh& mesh) {
    for (const glm::dvec3& p : mesh.positions)
      for (int i = 0; i < 3; ++i) corners_.push_back(static_cast<btScalar>(kScale * p[i]));
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t v : t) indices_.push_back(static_cast<int>(v));
    triangles_ = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(indices_.size() / 3), indices_.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(corners_.size() / 3), corners_.data(), static_cast<int>(3 * sizeof(btScalar)));
    shape_ = std::make_unique<btGImpactMeshShape>(triangles_.get());
    shape_->setMargin(0);
    shape_->updateBound();
    object_.setCollisionShape(shape_.get());
  }
  BulletMesh(const BulletMesh&) = delete;

  btCollisionObjectWrapper wrapper(const btTransform& at) const {
    return {nullptr, shape_.get(), &object_, at, -1, -1};
  }
  void place(const btTransform& at) { object_.setWorldTransform(at); }

 private:
  std::vector<btScalar> corners_;
  std::vector<int> indices_;
  std::unique_ptr<btTriangleIndexVertexArray> triangles_;
  std::unique_ptr<btGImpactMeshShape> shape_;
  btCollisionObject object_;
};

/// Takes every contact as it is found, before Bullet keeps four of them.
struct Collect final : btManifoldResult {
  using btManifoldResult::btManifoldResult;

  PeerContacts all;

  void addContactPoint(const btVector3& normalOnSecond, const btVector3&, btScalar distance) override {
    const double depth = -static_cast<double>(distance) / kScale;
    if (depth < 0.0) return;
    ++all.count;
    all.depth = std::max(all.depth, depth);
    // It looks from the second object to the first.
    all.normal += depth * glm::dvec3(normalOnSecond.x(), normalOnSecond.y(), normalOnSecond.z());
  }
};

class BulletPartPeer final : public PartPeer {
 public:
  BulletPartPeer(const assets::Mesh& held, const assets::Mesh& other)
      : dispatcher_(&configuration_), held_(held), other_(other) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    const btTransform still = btTransform::getIdentity();
    const btCollisionObjectWrapper first = held_.wrapper(still), second = other_.wrapper(still);
    algorithm_ = dispatcher_.findAlgorithm(&first, &second, nullptr, BT_CONTACT_POINT_ALGORITHMS);
  }
  ~BulletPartPeer() override {
    algorithm_->~btCollisionAlgorithm();
    dispatcher_.freeCollisionAlgorithm(algorithm_);
  }

  std::string id() const override { return "bullet"; }
  std::string name() const override { return "Bullet GImpact"; }
  std::string version() const override { return "Bullet " TANDEM_PEER_BULLET; }

  PeerContacts contacts(const Pose& worldFromHeld) override {
    const glm::dquat& q = worldFromHeld.orientation;
    const btQuaternion turn(static_cast<btScalar>(q.x), static_cast<btScalar>(q.y),
                            static_cast<btScalar>(q.z), static_cast<btScalar>(q.w));
    const btTransform at(turn, vectorOf(kScale * worldFromHeld.position));
    held_.place(at);
    const btCollisionObjectWrapper first = held_.wrapper(at),
                                   second = other_.wrapper(btTransform::getIdentity());
    Collect collected(&first, &second);
    algorithm_->processCollision(&first, &second, dispatch_, &collected);
    return collected.all;
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDispatcherInfo dispatch_;
  BulletMesh held_, other_;
  btCollisionAlgorithm* algorithm_ = nullptr;
};

}  // namespace

std::unique_ptr<PartPeer> bulletPartPeer(const assets::Mesh& held, const assets::Mesh& other) {
  return std::make_unique<BulletPartPeer>(held, other);
}

}  // namespace tandem::bench

#else

namespace tandem::bench {
std::unique_ptr<PartPeer> bulletPartPeer(const assets::Mesh&, const assets::Mesh&) { return nullptr; }
}  // namespace tandem::bench

#endif
