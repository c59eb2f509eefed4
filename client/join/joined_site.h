#pragma once

// A running site: the servo thread (HandLoop on a device), the network thread (ServerConnection on sockets),
// and the interface by which the main thread displays and controls both. All public functions are for the
// main thread.

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/hand/hand_loop.h"
#include "client/hand/scripted_device.h"
#include "client/join/join_options.h"
#include "client/join/scene_download.h"
#include "client/join/scene_store.h"
#include "client/join/session_notes.h"
#include "client/join/shared_session.h"
#include "client/session/exchange.h"
#include "client/session/server_connection.h"
#include "client/session/view_model.h"
#include "haptics/base/tick_helpers.h"
#include "haptics/scene/model_refiner.h"
#include "haptics/servo/servo_loop.h"
#include "sync/wire/recording.h"

namespace tandem::client {

class JoinedSite {
 public:
  /// Enters the session and fetches the scene. Blocks until the scene is ready. A transfer that is stopped or
  /// killed is kept, and the next visit continues it.
  static Result<std::unique_ptr<JoinedSite>> enter(const JoinOptions& options, const Progress& progress);
  ~JoinedSite();  // stops both threads and leaves the session

  const assets::Scene& scene() const { return scene_; }
  const haptics::ContactScene& contact() const { return *contact_; }
  /// Share of the contact models that are refined, 0..1; what is still coarse costs the ticks more.
  double refined() const { return refiner_ ? refiner_->done() : 1.0; }
  sync::Role role() const { return connection_->welcome().role; }
  SiteId id() const { return connection_->welcome().site; }
  /// Radius of the ball that the hands touch with, m; 0: a point.
  double toolRadius() const;
  /// Servo thread, once started.
  Pose worldFromPart(PartId part) const { return hand_->worldFromPart(part); }

  /// Makes coarse contact models, by which a part in the hand collides, where JoinOptions::partContact asks
  /// for it; start() has them refined while they are felt. This takes a second or two; the site stays in the
  /// session meanwhile. Called before start(). An error if `progress` stopped it or the session ended.
  Status modelParts(const Progress& progress);

  /// Starts both threads with this device, which must be open. `prepare`, if given, is called before each
  /// tick in the servo thread. `second`: the device of the same person's other hand, or null.
  void start(std::unique_ptr<haptics::Device> device, std::function<void(HandLoop&)> prepare = {},
             std::unique_ptr<haptics::Device> second = nullptr);

  /// Updates the model from both threads.
  void update(ViewModel& model);
  /// Moves the proxy back onto the device where it is caught behind a surface.
  void reseat();
  /// Clears a fault of the tick, so that force returns, for a site without a window; ViewActions::resetFault
  /// does the same. A fault of the servo loop (ServoStatistics::fault) lasts until the site is started again.
  void clearFault();
  /// Passes the person's actions to both threads.
  void act(const ViewActions& actions);
  /// A wish for the document, for a site without a window.
  void want(const DocumentWish& wish) { shared_.want(wish); }

  /// Whether the site has left the session for good, and why.
  bool ended(std::string& reason) { return shared_.ended(reason); }
  ConnectionStatistics connectionStatistics() { return shared_.statistics(); }
  haptics::ServoStatistics servoStatistics() const;
  std::vector<OwnershipNote> drainOwnershipNotes() { return notes_.drainOwnership(); }
  std::vector<GrabNote> drainGrabNotes() { return notes_.drainGrabs(); }
  std::size_t sharedParts() { return notes_.sharedParts(); }
  /// Called in update() for every pose that a part had at this site, in the order of time.
  std::function<void(const ShownPose&)> onShown;

 private:
  explicit JoinedSite(const JoinOptions& options);
  Status enterSession(const Progress& progress);
  Status prepareScene(const Progress& progress);
  void runNetwork();
  LoopTotals loopTotals() const;
  void waitForNetwork();
  void updateHand(ViewModel& model);
  void updateTool(const HandOutput& output, std::size_t hand, ToolView& tool) const;
  void updateSecondHand(const HandOutput& output, SecondHandView& hand) const;

  JoinOptions options_;
  SceneStore store_;
  SessionNotes notes_;
  SharedSession shared_;
  std::unique_ptr<ServerConnection> connection_;  // network thread, once started
  std::unique_ptr<sync::RecordingWriter> recording_;
  assets::Scene scene_;
  std::unique_ptr<haptics::ContactScene> contact_;
  std::optional<haptics::ContactScene> felt_;  // with models, from modelParts() to start()
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<haptics::ModelRefiner> refiner_;          // null before start()
  std::unique_ptr<haptics::TickHelpers> helpers_;           // null: no core is idle
  std::unique_ptr<HandLoop> hand_;                          // servo thread, once started
  std::unique_ptr<haptics::Device> device_, secondDevice_;  // the second may be null
  std::unique_ptr<haptics::ServoLoop> servo_;
  std::atomic<std::uint64_t> forceLimited_{0};  // ticks
  std::array<std::atomic<double>, 3> tip_{};    // m, world: where the first hand is
  std::thread network_;
  std::atomic<bool> stop_{false};

  // main thread
  HandSettingsInput settings_;
  double stiffest_ = 0.0;  // N/m, of a contact on this device; 0 = any
  std::vector<Notice> notices_;
  std::uint64_t noticeCount_ = 0;
  std::vector<float> recentForces_;
  double lastUpdate_ = 0.0;
};

}  // namespace tandem::client
