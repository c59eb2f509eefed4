#pragma once

// One site of a simulated session: a scripted person with a modelled arm and device, and the hand loop and
// connection of a real client. Arm and device stay in the world when the client dies or stands still.

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "client/hand/hand_loop.h"
#include "client/hand/scripted_device.h"
#include "client/simulation/fingerprint.h"
#include "client/simulation/measures.h"
#include "client/simulation/simulated_client.h"
#include "client/simulation/simulated_server.h"
#include "client/simulation/simulation.h"
#include "sync/transport/virtual_network.h"

namespace tandem::client {

inline constexpr sync::Micros kSimulationTick = sync::kMillisecond;

/// What the sites of one simulation share, and the records that they add to.
struct SimulationContext {
  /// `script`, `parts` and the scene that they are of must outlive this object.
  SimulationContext(const Scenario& script, const haptics::ContactScene& parts,
                    const SimulationOptions& options)
      : scenario(script),
        scene(parts.scene()),
        contact(parts),
        network(options.seed, script.network),
        invariants(script.sites.size(), sync::LeaseRules{}),
        server(scene, network, options.seed, options.mistake),
        mistake(options.mistake),
        lie(options.lie),
        everOwned(scene.parts.size(), false) {}

  const Scenario& scenario;
  const assets::Scene& scene;
  const haptics::ContactScene& contact;
  sync::VirtualNetwork network;
  Invariants invariants;
  SimulatedServer server;
  const Mistake mistake;
  const LinkLie lie;
  Fingerprint fingerprint;
  std::ofstream trace;          // open where a trace was asked for
  std::vector<bool> everOwned;  // a part each
  double linkWork = 0.0;        // J, done by all coordination links on all replicas
};

class SimulatedSite final : public SimulatedClient {
 public:
  /// `context` and `description` must outlive this object. `clockOffset` is the site's clock less virtual
  /// time.
  SimulatedSite(SimulationContext& context, std::size_t index, const ScenarioSite& description,
                HandScript script, const Pose& worldFromStart, sync::Micros clockOffset);

  /// Starts the client: from now on it connects.
  void start() override;
  /// Starts the client once, at the time at which the scenario lets it join.
  void startWhenDue(sync::Micros now);
  /// Ends the client at once. What it knew is lost.
  void crash() override;
  /// One tick of the hand, then one step of the connection.
  void step(sync::Micros now);

  const haptics::TickOutput& tick() const { return hand_->output().tick; }
  const Pose& worldFromPart(PartId part) const { return hand_->worldFromPart(part); }
  /// The display pose of a part: where a window at this site would draw it.
  const Pose& worldFromDrawn(PartId part) const { return worldFromDrawn_[part]; }
  const HandMeasures& measures() const { return measures_; }
  std::uint64_t denials() const { return denials_; }
  std::uint64_t droppedStates() const;
  /// The figures of this site over a run of `duration` s; `undisturbed` as for HandMeasures::calm().
  SimulatedSiteResult result(double duration, const std::vector<bool>& undisturbed) const;

  void onOwnership(const sync::PartRecord& record) override;
  void onGrabReply(const sync::GrabReply& reply) override;

 private:
  bool paused(sync::Micros now) const { return now < pausedUntil_; }
  sync::Micros local(sync::Micros now) const { return clock_.at(now); }
  HandSettingsInput settings() const;
  void tickHand(sync::Micros now);
  void pushAlong(Wrench& toHand) const;
  void lieInLinks();
  HandSample measure(const Wrench& toHand);
  void noteContact(PartId part, HandSample& sample) const;
  void addSources(const haptics::TickOutput& tick);
  void addWeight(const haptics::TickOutput& tick);
  void addLinkWork(const haptics::TickOutput& tick);
  void addPushedContacts(const haptics::TickOutput& tick);
  void writeTrace(const HandSample& sample, sync::Micros now);
  void countTransport();

  SimulationContext& context_;
  sync::Micros joinsAt_;
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<HandLoop> hand_;
  ScriptedDevice device_;
  HandMeasures measures_;
  glm::dvec3 lastTarget_;
  double sourceEnergy_ = 0.0;         // J, that the scene itself has given to this hand
  double turned_ = 0.0;               // J, that torques have given to it
  std::vector<Pose> lastPoses_;       // of every part, as of the last tick here
  std::vector<Pose> worldFromDrawn_;  // of every part
  std::uint64_t denials_ = 0;
  glm::dvec3 liedWave_{0.0};  // sqrt(W) s, what lying link packets have added to the sum of waves
  double liedEnergy_ = 0.0;   // J
  // By clients and connections of this site that are gone.
  std::uint64_t packetsBefore_ = 0, bytesBefore_ = 0, droppedBefore_ = 0;
  sync::Traffic sentBefore_;
};

}  // namespace tandem::client
