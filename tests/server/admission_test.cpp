#include "server/admission.h"

#include <gtest/gtest.h>

namespace tandem::server {
namespace {

TEST(Admission, ReturnsWhatWasSigned) {
  const SigningKey key = makeSigningKey();
  const Ticket ticket{true, sync::Role::instructor, 513, makeNonce(), 1234567890123};
  const auto read = verify(sign(ticket, key), key, 1234567890122);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->resume, ticket.resume);
  EXPECT_EQ(read->role, ticket.role);
  EXPECT_EQ(read->site, ticket.site);
  EXPECT_EQ(read->nonce, ticket.nonce);
  EXPECT_EQ(read->expires, ticket.expires);
  EXPECT_FALSE(verify(sign(ticket, key), key, ticket.expires).ok());
  EXPECT_FALSE(verify(sign(ticket, key), makeSigningKey(), 0).ok());
}

TEST(Admission, ACredentialsKnockIsKnownByItsKeyAlone) {
  const SigningKey key = makeSigningKey();
  for (const bool resume : {false, true}) {
    const std::string text = sign({resume, sync::Role::observer, 3, makeNonce(key), 99}, key);
    const auto knock = sync::knockOf(text);
    ASSERT_TRUE(knock);
    EXPECT_TRUE(knows(key, *knock));
    EXPECT_FALSE(knows(makeSigningKey(), *knock));
    for (std::size_t i = 0; i < knock->size(); ++i) {
      sync::Knock forged = *knock;
      forged[i] ^= 1;
      EXPECT_FALSE(knows(key, forged)) << i;
    }
  }
  EXPECT_FALSE(knows(key, *sync::knockOf(sign({false, sync::Role::observer, 0, makeNonce(), 99}, key))));
}

TEST(Admission, RefusesAChangeOfAnyCharacter) {
  const SigningKey key = makeSigningKey();
  const std::string good = sign({false, sync::Role::participant, 0, makeNonce(), 99}, key);
  ASSERT_TRUE(verify(good, key, 0).ok());
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_=+/ \n";
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (std::size_t k = i % 7; k < alphabet.size(); k += 7) {
      std::string bad = good;
      bad[i] = alphabet[k];
      if (bad == good) continue;
      EXPECT_FALSE(verify(bad, key, 0).ok()) << i;
    }
    EXPECT_FALSE(verify(good.substr(0, i), key, 0).ok());
  }
  EXPECT_FALSE(verify(good + "A", key, 0).ok());
}

}  // namespace
}  // namespace tandem::server
