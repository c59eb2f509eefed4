#include "client/simulation/simulated_client.h"

namespace tandem::client {

using namespace sync;

void SimulatedClient::leave() {
  if (!inSession()) return;
  invariants_.onLeft(index_, id_);
  connection_->leave();
}

void SimulatedClient::revoke(PartId part) {
  if (!connection_) return;
  if (commands()) invariants_.onCommand(part);
  connection_->revoke(part);
}

void SimulatedClient::resetParts() {
  if (!connection_) return;
  for (std::size_t part = 0; commands() && part < scene_.parts.size(); ++part)
    invariants_.onCommand(static_cast<PartId>(part));
  connection_->resetParts();
}

void SimulatedClient::onOwnership(const PartRecord& record) { invariants_.onOwnership(index_, record); }
void SimulatedClient::onGrab(const Grab& grab) { invariants_.onGrab(index_, grab); }
void SimulatedClient::onRelease(const Release& release) { invariants_.onRelease(release); }
void SimulatedClient::onGrabReply(const GrabReply& reply) {
  invariants_.onGrabReply(index_, reply);
  if (!observes()) return;
  invariants_.checked(Rule::R1);
  if (reply.denial == Denial::none)
    invariants_.reportBroken(Rule::R1, name() + " observes and was granted a part");
}
void SimulatedClient::onAccepted(SiteId, const PartState& state) {
  invariants_.onAccepted(index_, state);
  invariants_.checked(Rule::R5);
}
void SimulatedClient::onDoubt(SiteId about) {
  invariants_.reportBroken(Rule::R5, name() + " doubts the motion of site " + std::to_string(about));
}
void SimulatedClient::onPublished(const PartState& state) {
  invariants_.onPublished(connection_->welcome().site, state);
}
void SimulatedClient::onConnection(bool up) { invariants_.onConnection(index_, up); }

}  // namespace tandem::client
