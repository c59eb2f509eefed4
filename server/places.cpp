#include "server/places.h"

#include <algorithm>

namespace tandem::server {

std::optional<std::string> Places::refusal(sync::Role role, const RoleCounts& there) const {
  const auto count = [&](sync::Role of) { return there[static_cast<std::size_t>(of)]; };
  const std::string full = "the session is full: all ";
  const std::size_t instructors = count(sync::Role::instructor);
  const std::size_t holders = count(sync::Role::participant) + instructors;
  const std::size_t onKept = std::min(instructors, kForInstructor);
  switch (role) {
    case sync::Role::observer:
      if (count(role) < observers) return std::nullopt;
      return full + std::to_string(observers) + " places for observers are taken";
    case sync::Role::participant:
      if (holders - onKept < participants) return std::nullopt;
      return full + std::to_string(participants) + " places for participants are taken";
    case sync::Role::instructor:
      if (holders < participants + kForInstructor) return std::nullopt;
      return full + std::to_string(participants) +
             " places for participants and the one kept for an instructor are taken";
  }
  return "there is no such role";
}

}  // namespace tandem::server
