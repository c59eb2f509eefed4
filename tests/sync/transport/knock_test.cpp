#include "sync/transport/knock.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/sync/transport/flood.h"

namespace tandem::sync {
namespace {

using Guess = FirstBytes::Kind;

class Knocks : public testing::Test {
 protected:
  Knocks() { std::iota(knock.begin(), knock.end(), std::uint8_t{1}); }
  ~Knocks() override { SSL_CTX_free(context); }
  std::string helloWith(const std::string& name) {
    return clientHello(context, std::string(1, static_cast<char>(name.size())) + name);
  }
  static FirstBytes read(const std::string& bytes) {
    return readFirstBytes({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  }
  SSL_CTX* context = SSL_CTX_new(TLS_client_method());
  Knock knock{};
};

TEST_F(Knocks, AreFoundInAClientHelloOfOpenSslAndOnlyOnceItIsWhole) {
  const std::string hello = helloWith(protocolName(knock));
  EXPECT_EQ(read(hello).kind, Guess::clientHello);
  EXPECT_EQ(read(hello).knock, knock);
  for (std::size_t size = 0; size < hello.size(); ++size)
    EXPECT_EQ(read(hello.substr(0, size)).kind, Guess::incomplete) << size;
}

TEST_F(Knocks, AreNotFoundWhereThereIsNone) {
  EXPECT_FALSE(read(clientHello(context)).knock);
  EXPECT_FALSE(read(helloWith("h2")).knock);
  EXPECT_FALSE(read(helloWith(protocolName(knock) + "0")).knock);
  EXPECT_FALSE(read(helloWith("tandem-knock-" + std::string(32, 'x'))).knock);
  EXPECT_EQ(read("GET / HTTP/1.1\r\n").kind, Guess::foreign);
  std::string other = helloWith("h2");
  other[5] = 2;  // a ServerHello
  EXPECT_EQ(read(other).kind, Guess::foreign);
}

TEST_F(Knocks, ATooLongClientHelloIsAHandshakeWithoutOne) {
  std::string hello = helloWith(protocolName(knock));
  hello[3] = 0x20;
  EXPECT_EQ(read(hello).kind, Guess::clientHello);
  EXPECT_FALSE(read(hello).knock);
}

TEST_F(Knocks, DamagedBytesEnd) {
  const std::string hello = helloWith(protocolName(knock));
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = hello;
    for (unsigned n = 1 + random() % 4; n > 0; --n)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    bytes.resize(random() % (bytes.size() + 1));
    const FirstBytes first = read(std::string(bytes.begin(), bytes.end()));
    EXPECT_TRUE(!first.knock || first.kind == Guess::clientHello);
  }
}

TEST_F(Knocks, NoTextButACredentialHasOne) {
  for (const char* text : {"", "A", "not base64!", "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA", "===="})
    EXPECT_FALSE(knockOf(text)) << text;
  EXPECT_FALSE(knockOf(std::string(1000, 'A')));
  EXPECT_TRUE(knockOf(std::string(124, 'A')));
}

}  // namespace
}  // namespace tandem::sync
