#include "assets/base/fnv1a.h"

#include <gtest/gtest.h>

#include <string_view>

#include <glm/vec3.hpp>

namespace tandem {
namespace {

std::uint64_t hashOf(std::string_view text) {
  Fnv1a hash;
  hash.addBytes(text.data(), text.size());
  return hash.value();
}

// The vectors are those that the authors of the hash publish.
TEST(Fnv1a, GivesThePublishedValues) {
  EXPECT_EQ(hashOf(""), 0xcbf29ce484222325ull);
  EXPECT_EQ(hashOf("a"), 0xaf63dc4c8601ec8cull);
  EXPECT_EQ(hashOf("foobar"), 0x85944171f73967e8ull);
}

TEST(Fnv1a, HashesTheBitsOfAValue) {
  Fnv1a positive, negative, bytes;
  positive.add(0.0);
  negative.add(-0.0);
  bytes.addBytes("\0\0\0\0\0\0\0\0", 8);
  EXPECT_NE(positive.value(), negative.value());
  EXPECT_EQ(positive.value(), bytes.value());
}

TEST(Fnv1a, HashesAVectorComponentByComponent) {
  Fnv1a vector, components;
  vector.addComponents(glm::dvec3(1.0, 2.0, 3.0));
  for (const double x : {1.0, 2.0, 3.0}) components.add(x);
  EXPECT_EQ(vector.value(), components.value());
}

}  // namespace
}  // namespace tandem
