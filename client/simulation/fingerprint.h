#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include <glm/vec3.hpp>

#include "assets/base/fnv1a.h"

namespace tandem::client {

/// The hash of a run: two runs have the same one if every tick gave the same bits.
class Fingerprint {
 public:
  void add(const glm::dvec3& v) { hash_.addComponents(v); }
  /// 16 hexadecimal digits.
  std::string hex() const {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash_.value()));
    return text;
  }

 private:
  Fnv1a hash_;
};

}  // namespace tandem::client
