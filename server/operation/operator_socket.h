#pragma once

// How an operator's command reaches a running server: a Unix socket in the data directory (0600), one
// command and one answer a connection, each one line of JSON.
//
// 1. A thread of its own talks to the socket, one connection at a time, with a limit of time and of bytes.
//    The commands are carried out by the thread that calls serve(), which never waits.
// 2. Only the server's own user and root are heard.

#include <functional>
#include <memory>
#include <string>

#include "assets/base/result.h"
#include "sync/wire/participant_messages.h"

namespace tandem::server {

struct OperatorRequest {
  enum class Kind : std::uint8_t { kick, ban, revokeLinks, revokeTicket, rotateKeys, inviteNow };
  Kind kind = Kind::kick;
  std::string who;                            // kick, ban, revokeTicket: a site's number or name
  sync::Role role = sync::Role::participant;  // inviteNow
};

class OperatorSocket {
 public:
  /// Listens in the directory. `wake` is called from the socket's thread when a command waits for serve(); it
  /// must stay callable until the socket is destroyed.
  static Result<std::unique_ptr<OperatorSocket>> open(const std::string& directory,
                                                      std::function<void()> wake);
  ~OperatorSocket();

  /// Carries out the command that waits, if one does.
  void serve(const std::function<Result<std::string>(const OperatorRequest&)>& obey);

 private:
  struct State;
  explicit OperatorSocket(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

struct OperatorAnswer {
  enum class Outcome : std::uint8_t { done, refused, unreachable };
  Outcome outcome = Outcome::unreachable;
  std::string text;  // one line
};
/// Gives a command to the server that runs on this data directory.
OperatorAnswer askServer(const std::string& directory, const OperatorRequest& request);

/// The line on the socket, and back; for tests.
std::string encodeRequest(const OperatorRequest& request);
Result<OperatorRequest> decodeRequest(const std::string& line);

}  // namespace tandem::server
