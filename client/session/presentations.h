#pragma once

// What the people of a session show and say to each other: what the server has told of the others, and what
// this person shows and says, on its way to the server.
//
// 1. What this person shows is sent when it has changed, at most once in kPeriod, and anew on every
//    connection.
// 2. What the server ends of it is not sent again until the person has stopped showing it.
// 3. Of the lines that the server tells on a connection, those that this site has are left out. Only a line
//    that is said now is a notice.
// 4. What names a part that the scene has not is shown without it.
//
// Network thread; a step without news costs a comparison.

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "client/session/message_sender.h"
#include "client/session/participants.h"
#include "client/session/presenting_view.h"

namespace tandem::client {

class Presentations {
 public:
  static constexpr sync::Micros kPeriod = 66 * sync::kMillisecond;
  static constexpr sync::Micros kSayPeriod = sync::kSecond;
  static constexpr std::size_t kMaxUnsaid = 5;  // messages that wait for their turn

  /// Both must outlive this.
  Presentations(Participants& people, MessageSender& sender) : people_(people), sender_(sender) {}

  void handle(const sync::Presentation& message);
  /// False, and nothing is taken, if it is none that a server tells.
  bool handle(const sync::Said& message);
  void forget(SiteId site);

  /// The site is in the session, on a new connection.
  void enter();
  void connectionLost();

  /// What this person shows from now on.
  void show(const sync::Presentation& shown);
  void say(const sync::Say& said);
  /// Sends what is due at local time `now`; in the session.
  void step(sync::Micros now);

  /// For a scene of so many parts.
  PresentingView view(std::size_t partCount) const;
  /// What was said, or told of earlier lines, since the last call, oldest first.
  std::vector<ChatLine> drainChat();

 private:
  bool known(SiteId site) const;
  bool differs() const;
  void tellOfChange(const sync::Presentation& before, const sync::Presentation& now);

  Participants& people_;
  MessageSender& sender_;
  std::map<SiteId, sync::Presentation> others_;
  SiteId sharer_ = kNoSite;
  sync::Presentation interrupted_;  // what was shared when the connection was lost
  std::uint32_t begun_ = 0, ended_ = 0;
  sync::Presentation own_;
  std::optional<sync::Presentation> sent_;   // on this connection
  sync::Micros nextAt_ = 0, nextSayAt_ = 0;  // local time
  std::deque<sync::Say> unsaid_;
  std::vector<ChatLine> chat_;
  std::uint64_t lines_ = 0;   // of this site
  std::uint64_t newest_ = 0;  // the server's number of the line that came last
  bool stopping_ = false;     // the server has ended what this person shares, who has not stopped yet
};

}  // namespace tandem::client
