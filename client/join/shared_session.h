#pragma once

// What the network thread and the main thread of a joined site share, under one mutex: the session's state
// for display on its way to the main thread, and the person's commands on their way back. The servo thread
// never takes the mutex.

#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

#include "client/session/server_connection.h"
#include "client/session/view_model.h"

namespace tandem::client {

class SharedSession {
 public:
  /// Network thread: publishes the state of the connection, and gives it the camera and the commands. Once
  /// every kPeriod.
  void exchange(ServerConnection& connection, std::size_t partCount);
  /// Network thread: a notice that does not come from the connection.
  void notice(Notice notice);

  // Main thread.
  /// Copies the session's state into the model and returns the notices since the last call, oldest first.
  std::vector<Notice> read(ViewModel& model, std::size_t partCount);
  void act(const ViewActions& actions);
  void want(const DocumentWish& wish);
  /// Whether the site is out of the session for good, and why.
  bool ended(std::string& reason);
  ConnectionStatistics statistics();

  static constexpr sync::Micros kPeriod = 15 * sync::kMillisecond;

 private:
  struct ToMain {
    std::vector<SiteView> sites;
    std::vector<SiteId> owner;                   // by part
    std::vector<std::vector<SiteId>> coHolders;  // by part
    DocumentNews document;
    DocumentStanding documentStanding;
    PresentingView presenting;
    std::vector<ChatLine> chat;  // since the last read()
    std::vector<Notice> notices;
    ConnectionStatistics statistics;
    std::string reason, voiceUrl;
    ServerConnection::Stage stage = ServerConnection::Stage::connecting;
    bool udp = true;
    double sentKbit_s = 0.0, receivedKbit_s = 0.0;  // low-passed
  };
  struct ToNetwork {
    Pose worldFromCamera;
    std::vector<PartId> revokes;
    bool resetParts = false;
    std::vector<DocumentWish> documentWishes;
    sync::Presentation shown;
    std::vector<sync::Say> says;
  };

  void takeDocument(SessionDocument& document);
  void measureRates(const sync::TransportCounters& before, const sync::TransportCounters& after);

  std::mutex mutex_;  // guards what follows
  ToMain toMain_;
  ToNetwork toNetwork_;

  // main thread
  document::Document document_;
  std::vector<ChatLine> chat_;
};

}  // namespace tandem::client
