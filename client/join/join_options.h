#pragma once

// The options with which a site joins a session.

#include <string>

#include "client/session/state_publisher.h"
#include "sync/transport/join_link.h"
#include "sync/wire/site_colours.h"

namespace tandem::client {

struct JoinOptions {
  sync::JoinLink link;
  std::string name = "site";
  sync::SiteColour colour = sync::kAnyColour;
  bool udp = true;
  double deadband = PublishRates{}.deadband;  // Weber fraction of what it publishes
  std::string cacheDirectory;
  std::string recordPath;        // empty: no recording
  bool partContact = true;       // a part in the hand collides with others, where the role may take one
  double enterTimeout_s = 10.0;  // to enter the session, the scene transfer not counted
};

}  // namespace tandem::client
