#pragma once

// How a site enters a session and leaves it.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sync/wire/limits.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/participant_messages.h"

namespace tandem::sync {

/// First message of a connection. `credential` is the token of a join link, or the resume ticket of an
/// earlier Welcome.
struct Hello {
  std::uint16_t protocolVersion = kProtocolVersion;
  bool resume = false;
  std::string credential;
  std::string name;
  std::array<std::uint8_t, 3> colour{200, 200, 200};
};

/// The scene is loaded: the site wants state from now on.
struct Ready {};

/// The site leaves for good; its parts are free at once.
struct Goodbye {};

/// The answer to a good Hello.
struct Welcome {
  SiteId site = kNoSite;
  Role role = Role::observer;
  std::string resumeTicket;                  // credential for a later Hello with resume = true
  std::array<std::uint8_t, 32> sceneHash{};  // assets::ContentHash of the scene package
  std::uint64_t sceneBytes = 0;
  Micros sessionTime = 0;         // when this was sent
  Micros lease = 0;               // length of a lease
  std::string voiceUrl;           // where people talk, see voice_url.h; empty: the server names none
  std::vector<SiteInfo> sites;    // everybody, this site included
  std::vector<PartRecord> parts;  // those that were ever granted or moved
};
/// The server's keys have changed: this ticket takes the place of that of the Welcome.
struct NewTicket {
  std::string resumeTicket;
};
enum class Refusal : std::uint8_t {
  protocolVersion,
  badCredential,
  expired,
  alreadyUsed,
  sessionFull,
  unexpectedMessage,
  malformed,
  removed  // an operator parted from the site
};
const char* toString(Refusal refusal);
/// The last message before the server closes a connection.
struct Refused {
  Refusal refusal = Refusal::malformed;
  std::string reason;  // one line for a person
};

}  // namespace tandem::sync
