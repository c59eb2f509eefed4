#pragma once

// The session's document at a site that takes part: a replica of what the server has told, this person's
// changes on their way to the server, and what this person can take back.
//
// 1. One change is under way at a time, in the order in which they were wanted: each is made upon what the
//    one before has left.
// 2. A change that was not answered before the connection was lost is sent again with its number; the server
//    makes a request that comes twice have one effect. One that the server cannot write down now is repeated.
// 3. What is refused changes nothing here, and the person is told why.
// 4. A part that is moved back is asked of the server by the hand, as a control is, and is released at its
//    old place; where the grant is not the next after this person's own release, it stays where it is.
//
// Network thread; a step without news costs a few comparisons.

#include <deque>
#include <optional>
#include <string>

#include "assets/scene/scene.h"
#include "client/session/connection_observer.h"
#include "client/session/document_replica.h"
#include "client/session/document_undo.h"
#include "client/session/document_view.h"
#include "client/session/hand_events.h"
#include "client/session/message_sender.h"
#include "client/session/participants.h"
#include "client/session/pose_moves.h"

namespace tandem::client {

class SessionDocument final : public ConnectionObserver {
 public:
  /// Both must outlive this.
  SessionDocument(Participants& people, MessageSender& sender) : people_(people), sender_(sender) {}

  // False for what no sound server sends.
  [[nodiscard]] bool handle(const sync::DocumentChunk& message);
  [[nodiscard]] bool handle(const sync::DocumentChanged& message);
  [[nodiscard]] bool handle(const sync::PutReply& message);

  /// There is a hand, which can move parts back. Both must outlive this.
  void sceneReady(const assets::Scene& scene, HandEvents& events);
  void onOwnership(const sync::PartRecord& record) override;
  void onRelease(const sync::Release& release) override;

  /// The site is in the session, on a new connection.
  void enter();
  void connectionLost();

  /// Takes a wish on. One that cannot be taken on, because too many wait, is refused at once.
  void want(DocumentWish wish);
  /// Sends what is due at local time `now`; in the session.
  void step(sync::Micros now);

  const document::Document& content() const { return replica_.content(); }
  DocumentStanding standing() const;
  /// What was told since the last call.
  DocumentNews drainNews();

  static constexpr std::size_t kMaxWaiting = 1000;
  static constexpr sync::Micros kAgain = 500 * sync::kMillisecond;
  static constexpr sync::Micros kPlacing = 5 * sync::kSecond;  // until a part counts as not to be had

 private:
  /// The change that is under way.
  struct Open {
    DocumentWish::Kind kind = DocumentWish::Kind::change;
    sync::PutEntry request;
    document::Body before;          // of the entry; removed if it is new
    document::Revision answer = 0;  // of the change, once it is done
    bool sent = false;              // on this connection
    sync::Micros notBefore = 0;     // local time
  };
  /// The part that is moved back.
  struct Placing {
    DocumentWish::Kind kind = DocumentWish::Kind::undo;
    PartId part = kNoPart;
    Epoch epoch = 0;         // in which this site is to own it
    Pose stood;              // before
    sync::Micros until = 0;  // local time
  };

  bool withinLimits() const;
  bool busy() const { return open_ || placing_; }
  void place(DocumentWish::Kind kind, const DocumentUndo::Step& step);
  void placed(const sync::Release& release);
  void notPlaced(const std::string& why);
  void noteMoves();
  std::string words(const DocumentUndo::Step& step) const;
  void begin();
  void beginChange(document::Change change);
  void beginReversal(DocumentWish::Kind kind);
  void open(DocumentWish::Kind kind, document::Change change, document::Body before);
  void done(const sync::PutReply& reply);
  void refused(document::Refusal refusal, const std::string& reason);
  void refuse(DocumentWish::Kind kind, const document::Change& change, const document::Body& before,
              const std::string& why);
  std::string whoChanged(document::EntryId id) const;
  void tell(const document::Entry& entry) { news_.entries.push_back(entry); }

  Participants& people_;
  MessageSender& sender_;
  DocumentReplica replica_;
  DocumentUndo undo_;
  DocumentNews news_;
  std::deque<DocumentWish> waiting_;
  std::optional<Open> open_;
  std::optional<Placing> placing_;
  PoseMoves moves_;
  std::deque<DocumentUndo::Step> moved_;  // while something was under way
  const assets::Scene* scene_ = nullptr;  // null before sceneReady()
  HandEvents* events_ = nullptr;
  sync::Micros now_ = 0;
  sync::RequestId lastRequest_ = 0;
  bool inSession_ = false;
};

}  // namespace tandem::client
