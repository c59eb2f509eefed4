#pragma once

// What was sent or received, by cause, as the reports write it.

#include <nlohmann/json.hpp>

#include "sync/wire/traffic.h"

namespace tandem::client {

inline nlohmann::ordered_json trafficJson(const sync::Traffic& traffic) {
  nlohmann::ordered_json json;
  for (const auto& cause : sync::kTrafficCauses) {
    const sync::Flow& flow = traffic.*cause.flow;
    json[cause.name] = {{"packets", flow.packets}, {"bytes", flow.bytes}};
  }
  return json;
}

}  // namespace tandem::client
