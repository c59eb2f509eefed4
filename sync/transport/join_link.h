#pragma once

// A join link: everything that a site needs to enter a session, to be sent by mail or chat.
//   tandem://HOST:PORT/ROLE?token=TOKEN&pin=PIN
// TOKEN is signed by the server and used once. PIN is the SHA-256 of the server's public key (RFC 7469's form
// of a pin, in hexadecimal): the site trusts that key and no other, so no certificate authority is needed.

#include <cstdint>
#include <string>

#include "assets/base/result.h"
#include "sync/wire/participant_messages.h"

namespace tandem::sync {

struct JoinLink {
  std::string host;
  std::uint16_t port = 0;
  Role role = Role::participant;
  std::string token;
  std::string pin;  // 64 hexadecimal digits
};

std::string toString(const JoinLink& link);
/// An error says which part of the link is wrong.
Result<JoinLink> parseJoinLink(const std::string& text);

}  // namespace tandem::sync
