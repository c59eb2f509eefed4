#include "client/join/shared_session.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

ServerConnection connectionWithoutServer() {
  return ServerConnection({},
                          []() -> Result<std::unique_ptr<sync::Transport>> { return Error{"no server"}; });
}

TEST(SharedSession, TheMainThreadReadsHowTheConnectionStands) {
  ServerConnection connection = connectionWithoutServer();
  connection.step(sync::kSecond);
  SharedSession shared;
  shared.exchange(connection, 2);
  ViewModel model;
  EXPECT_TRUE(shared.read(model, 2).empty());
  EXPECT_EQ(model.owner, std::vector<SiteId>(2, kNoSite));
  EXPECT_FALSE(model.connection.connected);
  EXPECT_EQ(model.connection.status, "reconnecting: no server");
  std::string reason;
  EXPECT_FALSE(shared.ended(reason));
  connection.leave();
  shared.exchange(connection, 2);
  EXPECT_TRUE(shared.ended(reason));
  EXPECT_EQ(reason, "left");
}

TEST(SharedSession, ANoticeIsReadOnce) {
  SharedSession shared;
  shared.notice({Notice::Level::error, 0.0, "disk full"});
  ViewModel model;
  const std::vector<Notice> notices = shared.read(model, 0);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_EQ(notices[0].text, "disk full");
  EXPECT_TRUE(shared.read(model, 0).empty());
}

}  // namespace
}  // namespace tandem::client
