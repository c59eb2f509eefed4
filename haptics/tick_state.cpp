#include "haptics/tick_data.h"

// The state of ticks: made for a scene, updated when its meshes change and when parts are linked to other
// sites.

namespace tandem::haptics {

TickState::Data::Data(const ContactScene& contactScene)
    : scene(&contactScene.data()),
      world(contactScene),
      layers(contactScene.scene()),
      moved(contactScene.scene().parts.size()),
      tool(world, fault),
      fields(contactScene.scene()),
      fieldsOnPart{ForceFields(contactScene.scene()), ForceFields(contactScene.scene())} {
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
  data_->modelsChanged();
  data_->tool.afterMeshesChange();
}

void TickState::adopt(const ContactScene& next) {
  data_->tool.beforeMeshesChange();
  data_->scene = &next.data();
  data_->world.adopt(next);
  data_->modelsChanged();
  data_->tool.afterMeshesChange();
}

void TickState::refine(const ContactScene& next) {
  data_->scene = &next.data();
  data_->world.refine(next);
  data_->modelsChanged();
}

void TickState::share(TickHelpers* helpers) {
  if (data_->partContact != nullptr) data_->partContact->share(helpers);
}

bool TickState::beginLink(const LinkTerms& terms) {
  for (const SimulatedPart& entry : data_->held.parts()) {
    const bool moves = entry.held() || data_->held.links().has(entry.part);
    if (entry.part != terms.id.part || moves || data_->partContact == nullptr) continue;
    data_->partContact->own(entry.part, entry.body.centreOfMass);  // it moves here from now on
  }
  return data_->held.beginLink(terms);
}

void TickState::orderLink(const LinkTerms& terms) { data_->held.links().order(terms); }

void TickState::beginOrderedLinks() {
  data_->held.links().beginOrders([this](const LinkTerms& terms) {
    if (!data_->held.owns(terms.id.part)) return false;
    beginLink(terms);  // without room the peer is alone with its replica
    return true;
  });
}

void TickState::cancelLinkOrders(PartId part) { data_->held.links().cancelOrders(part); }

void TickState::endLink(LinkId link) { data_->held.links().end(link); }

void TickState::setSimulators(PartId part, int simulators) {
  data_->held.links().setSimulators(part, simulators);
}

bool TickState::receive(const AddressedPacket& packet) { return data_->held.links().receive(packet); }

std::size_t TickState::drainPackets(std::span<AddressedPacket> packets) {
  return data_->held.links().drainPackets(packets);
}

std::size_t TickState::drainDoubts(std::span<LinkId> doubts) {
  return data_->held.links().drainDoubts(doubts);
}

void TickState::noteStall() { data_->hands[0].noteStall(); }

void TickState::resetFault() { data_->fault = FaultLatch{}; }

}  // namespace tandem::haptics
