#pragma once

// A site of a simulation of the protocol alone: the connection of a real client, with a hand that has no
// haptics. If its connection is refused, its person asks for a new link after a while.

#include <memory>
#include <string>

#include "client/simulation/light_hand.h"
#include "client/simulation/simulated_client.h"

namespace tandem::client {

/// What the sites of one simulation share.
struct LightWorld {
  const Scenario& scenario;
  const assets::Scene& scene;
  sync::VirtualNetwork& network;
  SimulatedServer& server;
  Invariants& invariants;
};

/// Exchanges are large, so that those of sites that are gone are used again.
class ExchangePool {
 public:
  std::unique_ptr<Exchange> take();
  void giveBack(std::unique_ptr<Exchange> exchange);

 private:
  std::vector<std::unique_ptr<Exchange>> free_;
};

class LightSite final : public SimulatedClient {
 public:
  /// All that is referred to outlives this. `clockOffset` is the site's clock less virtual time.
  LightSite(const LightWorld& world, ExchangePool& pool, std::size_t index, const ScenarioSite& description,
            HandScript script, sync::Micros clockOffset);
  ~LightSite() override;

  void crash() override;
  void start() override;
  void leave() override;

  /// Everything that is due at virtual time `now`.
  void step(sync::Micros now);
  /// When the site has something to do of itself.
  sync::Micros nextDue() const { return nextDue_; }
  /// Whether something has arrived for a site that does not stand still.
  bool hasEvents(sync::Micros now) const;

  /// Whether the person is still there: it was not killed for good and has not left.
  bool takesPart() const { return connection_ != nullptr && !left_; }
  const std::vector<ScriptStep>& script() const { return script_.steps; }
  const Pose& worldFromPart(PartId part) const { return hand_->worldFromPart(part); }
  std::uint64_t granted() const { return granted_ + (hand_ ? hand_->granted() : 0); }
  /// Grants since the last call.
  std::uint64_t drainGranted();
  ConnectionStatistics statistics() const { return connection_->statistics(); }

 private:
  void enter();
  void end();
  bool beyondBound() const;

  LightWorld world_;
  ExchangePool& pool_;
  const HandScript script_;
  sync::Micros now_ = 0, joinsAt_, nextDue_ = 0;
  sync::Micros asksAgainAt_ = -1;  // for a link, after a refusal; < 0: does not
  bool left_ = false, fetches_;
  std::uint64_t granted_ = 0, drained_ = 0;
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<LightHand> hand_;
};

}  // namespace tandem::client
