#pragma once

// Who takes part in a session: the roles, and what the server publishes of each site.

#include <array>
#include <cstdint>
#include <string>

#include "assets/base/ids.h"

namespace tandem::sync {

enum class Role : std::uint8_t { observer = 0, participant = 1, instructor = 2 };
const char* toString(Role role);

/// A site as the others see it.
struct SiteInfo {
  SiteId site = kNoSite;
  Role role = Role::observer;
  std::string name;
  std::array<std::uint8_t, 3> colour{200, 200, 200};  // sRGB
  bool connected = true;
  friend bool operator==(const SiteInfo&, const SiteInfo&) = default;
};

/// A site joined, or its record changed (connected, name, role).
struct SiteChanged {
  SiteInfo site;
};
struct SiteLeft {
  SiteId site = kNoSite;
};

}  // namespace tandem::sync
