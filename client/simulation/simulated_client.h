#pragma once

// The client of a simulated site: the connection of a real one, watched by the invariants. Both simulations
// derive their sites from it.

#include <memory>
#include <string>

#include "client/session/server_connection.h"
#include "client/simulation/drifting_clock.h"
#include "client/simulation/fault_schedule.h"

namespace tandem::client {

class SimulatedClient : public FaultySite, public ConnectionObserver {
 public:
  /// All that is referred to outlives this. `clockOffset` is the site's clock less virtual time.
  SimulatedClient(Invariants& invariants, const assets::Scene& scene, std::size_t index,
                  const ScenarioSite& description, sync::Micros clockOffset)
      : invariants_(invariants),
        scene_(scene),
        index_(index),
        description_(description),
        clock_(clockOffset) {}

  std::size_t index() const { return index_; }
  SiteId id() const { return id_; }
  const std::string& name() const override { return description_.name; }
  bool started() const override { return connection_ != nullptr; }
  bool inSession() const { return connection_ && connection_->stage() == ServerConnection::Stage::ready; }
  /// Who owns a part, as far as this site knows. Only while it is started.
  SiteId ownerOf(PartId part) const { return connection_->owner(part); }

  /// The client stands still until then.
  void pauseUntil(sync::Micros until) override { pausedUntil_ = until; }
  void setDrift(double ppm, sync::Micros now) override { clock_.setDrift(ppm, now); }
  void leave() override;
  void revoke(PartId part) override;
  void resetParts() override;

  void onOwnership(const sync::PartRecord& record) override;
  void onGrab(const sync::Grab& grab) override;
  void onGrabReply(const sync::GrabReply& reply) override;
  void onRelease(const sync::Release& release) override;
  void onAccepted(SiteId from, const sync::PartState& state) override;
  void onPublished(const sync::PartState& state) override;
  void onDoubt(SiteId about) override;
  void onConnection(bool up) override;

 protected:
  bool observes() const { return description_.role == "observer"; }
  bool commands() const { return description_.role == "instructor"; }

  Invariants& invariants_;
  const assets::Scene& scene_;
  const std::size_t index_;
  const ScenarioSite& description_;
  DriftingClock clock_;
  sync::Micros pausedUntil_ = 0;
  SiteId id_ = kNoSite;
  std::unique_ptr<ServerConnection> connection_;  // null: the client does not run
};

}  // namespace tandem::client
