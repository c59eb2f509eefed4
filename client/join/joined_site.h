#pragma once

// A site that runs: servo thread (HandLoop on a device), network thread (ServerConnection on sockets), and
// what the main thread needs to show and steer both. Main thread only, but for what its two threads do
// inside.

#include <atomic>
#include <functional>
#include <memory>
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
#include "haptics/servo/servo_loop.h"

namespace tandem::client {

class JoinedSite {
 public:
  /// Enters the session and fetches the scene. Blocks until the scene stands. What was fetched when it is
  /// stopped, or killed, is kept: the next visit goes on from there.
  static Result<std::unique_ptr<JoinedSite>> enter(const JoinOptions& options, const Progress& progress);
  ~JoinedSite();  // stops both threads, says goodbye

  const assets::Scene& scene() const { return scene_; }
  const haptics::ContactScene& contact() const { return *contact_; }
  sync::Role role() const { return connection_->welcome().role; }
  SiteId id() const { return connection_->welcome().site; }
  /// Servo thread, once started.
  Pose worldFromPart(PartId part) const { return hand_->worldFromPart(part); }

  /// Makes what a part in the hand needs to collide, where JoinOptions::partContact asks for it: seconds, for
  /// large scenes minutes, from the cache a share of that. The site stays in the session meanwhile. Before
  /// start(); an error if `progress` stopped it or the session ended.
  Status modelParts(const Progress& progress);

  /// Starts both threads with this device, which must be open. `prepare`, if given, is called before each
  /// tick in the servo thread. `second`: the device of the same person's other hand, or null.
  void start(std::unique_ptr<haptics::Device> device, std::function<void(HandLoop&)> prepare = {},
             std::unique_ptr<haptics::Device> second = nullptr);

  /// Brings the model up to date with both threads.
  void update(ViewModel& model);
  /// Puts the tip of the stylus back onto the device: it is caught behind something.
  void reseat();
  /// Lets force come back after a fault, for a site without a window; a ViewActions does the same.
  void clearFault();
  /// Hands the person's actions on.
  void act(const ViewActions& actions);

  /// The site is out of the session for good, and why.
  bool ended(std::string& reason) { return shared_.ended(reason); }
  ConnectionStatistics connectionStatistics() { return shared_.statistics(); }
  haptics::ServoStatistics servoStatistics() const;
  std::vector<OwnershipNote> takeOwnershipNotes() { return notes_.drainOwnership(); }
  std::vector<GrabNote> takeGrabNotes() { return notes_.drainGrabs(); }
  /// Called in update() for every pose that a part had here, in the order of time.
  std::function<void(const ShownPose&)> onShown;

 private:
  explicit JoinedSite(const JoinOptions& options);
  Status enterSession(const Progress& progress);
  Status prepareScene(const Progress& progress);
  void runNetwork();
  void waitForNetwork();
  void updateHand(ViewModel& model);

  JoinOptions options_;
  SceneStore store_;
  SessionNotes notes_;
  SharedSession shared_;
  std::unique_ptr<ServerConnection> connection_;  // network thread, once started
  std::unique_ptr<sync::RecordingWriter> recording_;
  assets::Scene scene_;
  std::unique_ptr<haptics::ContactScene> contact_;
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<HandLoop> hand_;                          // servo thread, once started
  std::unique_ptr<haptics::Device> device_, secondDevice_;  // the second may be null
  std::unique_ptr<haptics::ServoLoop> servo_;
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
