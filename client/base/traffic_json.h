#pragma once

// Datagrams sent or received, by cause, as reports write them.

#include "assets/base/json.h"
#include "sync/wire/traffic.h"

namespace tandem::client {

inline Json trafficJson(const sync::Traffic& traffic) {
  Json json;
  for (const auto& cause : sync::kTrafficCauses) {
    const sync::Flow& flow = traffic.*cause.flow;
    json[cause.name] = {{"packets", flow.packets}, {"bytes", flow.bytes}};
  }
  return json;
}

}  // namespace tandem::client
