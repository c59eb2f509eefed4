#pragma once

// Whose motion this site does not believe, from what the owners say of their parts, and when it tells the
// server. A single oddity names nobody: some of them within kWindow do.
//
// Network thread; a state costs a look-up.

#include <array>
#include <map>
#include <unordered_map>

#include "assets/scene/scene.h"
#include "client/session/connection_observer.h"
#include "client/session/message_sender.h"
#include "sync/replica/motion_check.h"

namespace tandem::client {

/// When a site begins to doubt another.
struct DoubtLimits {
  sync::MotionLimits motion;
  int enough = 3;  // oddities within Doubts::kWindow, at most Doubts::kMostOddities
};

class Doubts {
 public:
  static constexpr sync::Micros kWindow = 10 * sync::kSecond;
  static constexpr sync::Micros kSayPeriod = 20 * sync::kSecond;  // while it goes on
  static constexpr std::size_t kMostOddities = 8;

  /// Both must outlive this.
  Doubts(const DoubtLimits& limits, MessageSender& sender, const Watchers& watchers)
      : limits_(limits), sender_(sender), watchers_(watchers) {}

  /// The scene must outlive this.
  void sceneReady(const assets::Scene& scene) { scene_ = &scene; }
  /// The site is in the session, on a new connection.
  void enter();
  void forget(SiteId site) { doubted_.erase(site); }

  /// A state that ownership has accepted from its owner, held at session time `time`; `now` is local time.
  void observe(SiteId owner, const sync::PartState& state, sync::Micros time, sync::Micros now);
  /// The hand does not believe the link packets of a site, which needs no more oddities.
  void accuse(SiteId site, sync::Micros now);

 private:
  void note(SiteId site, sync::Micros now);

  struct Doubted {
    std::array<sync::Micros, kMostOddities> oddities{};  // local times, a ring
    std::size_t count = 0;
    sync::Micros nextAt = 0;  // local time
  };

  const DoubtLimits limits_;
  MessageSender& sender_;
  const Watchers& watchers_;
  const assets::Scene* scene_ = nullptr;
  std::unordered_map<PartId, sync::MotionCheck> checks_;
  std::map<SiteId, Doubted> doubted_;
};

}  // namespace tandem::client
