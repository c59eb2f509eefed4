#pragma once

// The participants of the session, as the server publishes them, and the notices for the person at this site.
//
// Network thread.

#include <string>
#include <vector>

#include "client/session/view_model.h"
#include "sync/wire/doubt_messages.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/state_update.h"

namespace tandem::client {

class Participants {
 public:
  /// Everybody, by a Welcome; `self` is this site.
  void reset(SiteId self, const std::vector<sync::SiteInfo>& sites);
  void handle(const sync::SiteChanged& message);
  void handle(const sync::SiteLeft& message);
  void handle(const sync::Doubt& message);
  /// Without a server, no other site is known to be connected.
  void connectionLost();
  /// A newer presence of a site. An unknown site is ignored.
  void show(SiteId site, const sync::Presence& presence);

  /// This site; kNoSite before the first Welcome.
  SiteId self() const { return self_; }
  const std::vector<SiteView>& sites() const { return sites_; }
  /// For a person, whether or not the site is known.
  std::string nameOf(SiteId site) const;

  void notice(Notice::Level level, std::string text);
  /// The notices since the last call, oldest first.
  std::vector<Notice> drainNotices();

 private:
  SiteView* find(SiteId site);

  SiteId self_ = kNoSite;
  std::vector<SiteView> sites_;
  std::vector<Notice> notices_;
};

}  // namespace tandem::client
