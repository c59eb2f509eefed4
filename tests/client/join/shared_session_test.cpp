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

document::Entry group(document::EntryId id, document::Revision revision) {
  document::Entry entry;
  entry.id = id;
  entry.revision = revision;
  entry.body = document::Group{"group " + std::to_string(id), {}};
  return entry;
}

TEST(SharedSession, TheMainThreadHasTheDocumentWhetherItReadsOftenOrSeldom) {
  ServerConnection connection = connectionWithoutServer();
  SessionDocument& document = connection.document();
  SharedSession shared;
  ViewModel model;
  EXPECT_TRUE(document.handle(sync::DocumentChunk{true, true, 2, {group(1, 1), group(2, 2)}}));
  shared.exchange(connection, 0);
  EXPECT_TRUE(document.handle(sync::DocumentChanged{group(1, 3)}));
  shared.exchange(connection, 0);
  shared.read(model, 0);
  EXPECT_TRUE(model.documentStanding.complete);
  EXPECT_EQ(model.document->size(), 2u);
  EXPECT_EQ(model.document->find(1)->revision, 3u);
  // A whole that comes anew replaces what was there, read or not.
  EXPECT_TRUE(document.handle(sync::DocumentChanged{group(3, 4)}));
  shared.exchange(connection, 0);
  EXPECT_TRUE(document.handle(sync::DocumentChunk{true, true, 9, {group(9, 9)}}));
  shared.exchange(connection, 0);
  shared.read(model, 0);
  EXPECT_EQ(model.document->size(), 1u);
  EXPECT_NE(model.document->find(9), nullptr);
}

TEST(SharedSession, AWishForTheDocumentIsTakenOnOnce) {
  ServerConnection connection = connectionWithoutServer();
  SharedSession shared;
  shared.want({DocumentWish::Kind::change, {0, 0, document::Group{"g", {}}}});
  ViewActions actions;
  actions.documentWishes.push_back({DocumentWish::Kind::undo, {}});
  shared.act(actions);
  shared.exchange(connection, 0);
  shared.exchange(connection, 0);
  EXPECT_EQ(connection.document().standing().unsent, 2u);
}

}  // namespace
}  // namespace tandem::client
