#include "sync/transport/join_link.h"

#include <gtest/gtest.h>

namespace tandem::sync {
namespace {

const std::string kPin(64, 'a');

TEST(JoinLink, ComesBackFromItsText) {
  for (const std::string host : {"example.org", "192.0.2.7", "2001:db8::1"}) {
    for (const Role role : {Role::observer, Role::participant, Role::instructor}) {
      const JoinLink link{host, 47800, role, "v1.ab-_+/=&%?", kPin};
      const auto back = parseJoinLink(toString(link));
      ASSERT_TRUE(back.ok()) << toString(link) << ": " << back.error().message;
      EXPECT_EQ(back->host, link.host);
      EXPECT_EQ(back->port, link.port);
      EXPECT_EQ(back->role, link.role);
      EXPECT_EQ(back->token, link.token);
      EXPECT_EQ(back->pin, link.pin);
    }
  }
}

TEST(JoinLink, NamesTheWrongPart) {
  const auto problem = [](const std::string& text) {
    const auto link = parseJoinLink(text);
    return link.ok() ? std::string("none") : link.error().message;
  };
  const std::string good = "?token=t&pin=" + kPin;
  EXPECT_EQ(problem("tandem://h:1/observer" + good), "none");
  EXPECT_NE(problem("http://h:1/observer" + good).find("tandem://"), std::string::npos);
  EXPECT_NE(problem("tandem://h/observer" + good).find("port"), std::string::npos);
  EXPECT_NE(problem("tandem://h:0/observer" + good).find("port"), std::string::npos);
  EXPECT_NE(problem("tandem://h:65536/observer" + good).find("port"), std::string::npos);
  EXPECT_NE(problem("tandem://h:1x/observer" + good).find("port"), std::string::npos);
  EXPECT_NE(problem("tandem://:1/observer" + good).find("host"), std::string::npos);
  EXPECT_NE(problem("tandem://a b:1/observer" + good).find("host"), std::string::npos);
  EXPECT_NE(problem("tandem://h:1/king" + good).find("role"), std::string::npos);
  EXPECT_NE(problem("tandem://h:1/observer?pin=" + kPin).find("token"), std::string::npos);
  EXPECT_NE(problem("tandem://h:1/observer?token=t&token=u&pin=" + kPin).find("twice"), std::string::npos);
  EXPECT_NE(problem("tandem://h:1/observer?token=%0a&pin=" + kPin).find("token"), std::string::npos);
  EXPECT_NE(problem("tandem://h:1/observer?token=t&pin=abc").find("pin"), std::string::npos);
  EXPECT_NE(problem("tandem://h:1/observer?token=t&pin=" + std::string(64, 'g')).find("pin"),
            std::string::npos);
}

TEST(JoinLink, SurvivesEveryTruncation) {
  const std::string text = toString({"h", 1, Role::observer, "t%", kPin});
  for (std::size_t length = 0; length < text.size(); ++length) {
    EXPECT_FALSE(parseJoinLink(text.substr(0, length)).ok());
  }
}

}  // namespace
}  // namespace tandem::sync
