#pragma once

// Haply's device service, as far as one client sees it: sends states, takes the answers. The caller decides
// when, so time is the test's own.
//
// Threads: all calls from one thread at a time.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <glm/vec3.hpp>

namespace tandem::haptics::testing {

class FakeHaply {
 public:
  FakeHaply();  // listens on a free port of the loopback
  ~FakeHaply();

  std::uint16_t port() const;
  /// Waits for a client and shakes hands; false when that failed.
  bool accept();
  /// Sends a message and waits for the answer; nothing when the client has gone.
  std::optional<std::string> exchange(const std::string& message);
  /// Cuts the line without a word.
  void drop();

  /// A state in the service's axes, m and m/s.
  static std::string state(const glm::dvec3& position, const glm::dvec3& velocity, bool grasp = false);
  /// The force in N that an answer commands; nothing when it commands none.
  static std::optional<glm::dvec3> forceIn(const std::string& answer);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::haptics::testing
