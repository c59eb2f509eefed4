#pragma once

// The options with which a site joins a session.

#include <optional>
#include <string>

#include "client/session/connection_options.h"
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
  std::string recordPath;            // empty: no recording
  std::optional<double> toolRadius;  // m; 0: a point; none: the tip that suits the scene
  bool partContact = true;           // a part in the hand collides with others, where the role may take one
  bool facets = false;               // the file's normals are not felt
  std::uint64_t maxSceneBytes = ConnectionOptions{}.maxSceneBytes;
  double enterTimeout_s = 10.0;  // to enter the session, the scene transfer not counted
};

}  // namespace tandem::client
