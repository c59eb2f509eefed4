#include "haptics/measure/held_depth.h"

#include <map>
#include <optional>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/tick.h"

namespace tandem::haptics {

struct HeldPartDepthMeter::Data {
  Data(const ContactScene& contact, PartId part)
      : scene(contact), held(part), meters(contact.scene().parts.size()) {}

  const Collider& collider(PartId part) const { return scene.data().colliders[part]; }

  /// Instances of one mesh share a model.
  std::shared_ptr<const DepthModel> modelOf(PartId part) {
    std::shared_ptr<const DepthModel>& model = models[collider(part).tree];
    if (!model) model = std::make_shared<const DepthModel>(collider(part).tree->mesh());
    return model;
  }

  bool mayTouch(PartId part) const {
    const std::vector<assets::Part>& parts = scene.scene().parts;
    return part != held && collider(part).tree != nullptr &&
           assets::mayCollide(parts[held].filter, parts[part].filter);
  }

  template <typename PoseOf>
  HeldPartDepth measure(PoseOf&& poseOf) {
    HeldPartDepth deepest;
    if (held >= meters.size() || collider(held).tree == nullptr) return deepest;
    const Pose mine = poseOf(held);
    const glm::dvec3 centre = transformPoint(mine, collider(held).centre);
    for (PartId part = 0; part < meters.size(); ++part) {
      if (!mayTouch(part)) continue;
      const Pose pose = poseOf(part);
      const double distance = glm::length(transformPoint(pose, collider(part).centre) - centre);
      if (distance > collider(held).radius + collider(part).radius) continue;
      if (!meters[part]) meters[part].emplace(modelOf(held), modelOf(part));
      const PenetrationDepth found = meters[part]->measure(mine, pose);
      if (found.depth > deepest.depth) deepest = {found, part};
    }
    return deepest;
  }

  const ContactScene& scene;
  PartId held;
  std::vector<std::optional<PenetrationMeter>> meters;
  std::map<const TriangleBvh*, std::shared_ptr<const DepthModel>> models;
};

HeldPartDepthMeter::HeldPartDepthMeter(const ContactScene& scene, PartId held)
    : data_(std::make_unique<Data>(scene, held)) {}
HeldPartDepthMeter::~HeldPartDepthMeter() = default;
HeldPartDepthMeter::HeldPartDepthMeter(HeldPartDepthMeter&&) noexcept = default;

HeldPartDepth HeldPartDepthMeter::measure(const TickState& state) {
  return data_->measure([&](PartId part) { return state.worldFromPart(part); });
}

HeldPartDepth HeldPartDepthMeter::measure(const std::vector<Pose>& worldFromPart) {
  ASSERT(worldFromPart.size() >= data_->meters.size());
  return data_->measure([&](PartId part) { return worldFromPart[part]; });
}

}  // namespace tandem::haptics
