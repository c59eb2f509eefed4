#include "haptics/tick_data.h"

// The state of ticks: made for a scene, told when its meshes change and which parts are tied to other sites.

namespace tandem::haptics {

TickState::Data::Data(const ContactScene& contactScene)
    : scene(&contactScene.data()),
      world(contactScene),
      layers(contactScene.scene()),
      moved(contactScene.scene().parts.size()),
      tool(world, fault),
      fields(contactScene.scene()) {
  if (!scene->models.empty() || !contactScene.scene().joints.empty())
    partContact = std::make_unique<PartContact>(world, fault);
}

TickState::TickState(const ContactScene& scene) : data_(std::make_unique<Data>(scene)) {}
TickState::~TickState() = default;
TickState::TickState(TickState&&) noexcept = default;
TickState& TickState::operator=(TickState&&) noexcept = default;

const Pose& TickState::worldFromPart(PartId part) const { return data_->world.pose(part); }

const FaultLatch& TickState::fault() const { return data_->fault; }

void TickState::meshesChanged(std::uint32_t mesh) {
  data_->tool.beforeMeshesChange();
  data_->world.meshChanged(mesh);
  data_->tool.afterMeshesChange();
}

void TickState::adopt(const ContactScene& next) {
  data_->tool.beforeMeshesChange();
  data_->scene = &next.data();
  data_->world.adopt(next);
  data_->tool.afterMeshesChange();
}

bool TickState::tie(const PartTie& tie) {
  for (const SimulatedPart& entry : data_->held.parts()) {
    const bool moves = entry.held() || data_->held.ties().has(entry.part);
    if (entry.part != tie.part || moves || data_->partContact == nullptr) continue;
    data_->partContact->take(entry.part, entry.body.centreOfMass);  // it moves here from now on
  }
  return data_->held.tie(tie);
}

void TickState::untie(PartId part, SiteId peer) { data_->held.ties().untie(part, peer); }

void TickState::setSimulators(PartId part, int simulators) {
  data_->held.ties().setSimulators(part, simulators);
}

bool TickState::receive(PartId part, SiteId peer, const LinkPacket& packet) {
  return data_->held.ties().receive(part, peer, packet);
}

std::size_t TickState::takePackets(std::span<TiedPacket> packets) {
  return data_->held.ties().takePackets(packets);
}

void TickState::noteStall() { data_->stalled = true; }

void TickState::resetFault() { data_->fault = FaultLatch{}; }

}  // namespace tandem::haptics
