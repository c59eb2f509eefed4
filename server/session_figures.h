#pragma once

// What a session is like at one moment, for metrics: a copy, so that another thread may read it.

#include <cstdint>
#include <string>
#include <vector>

#include "server/places.h"
#include "server/session_context.h"
#include "server/site_figures.h"
#include "sync/transport/transport.h"
#include "sync/wire/participant_messages.h"

namespace tandem::server {

struct ConnectedSite {
  SiteId site = kNoSite;
  sync::Role role = sync::Role::observer;
  std::string name;
  SiteFigures figures;
  std::size_t doubtedBy = 0;  // other sites that do not believe its motion
};

struct SessionFigures {
  SessionCounters counters;
  sync::TransportCounters transport;
  std::vector<ConnectedSite> sites;
  std::uint64_t strangers = 0;  // connections without a site
  std::string journalFailure;   // empty: sound
};

}  // namespace tandem::server
