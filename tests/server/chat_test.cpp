// What sites say, through the server: who hears it, who may, how much of it, and what who joins later gets.

#include "server/chat.h"

#include <algorithm>

#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

struct ChatTest : testing::Test, SessionRig {
  void settle() { run(150 * kMillisecond); }
  static SiteId siteOf(const FakeSite& site) { return site.last<Welcome>()->site; }
  /// The lines that a site was told, earlier or as they were said.
  static std::vector<SaidLine> lines(const FakeSite& site, bool earlier) {
    std::vector<SaidLine> all;
    for (const ControlMessage& message : site.received)
      if (const auto* said = std::get_if<Said>(&message); said != nullptr && said->earlier == earlier)
        all.insert(all.end(), said->lines.begin(), said->lines.end());
    return all;
  }
  void say(FakeSite& site, const std::string& text, const std::vector<PartId>& parts = {}) {
    site.send(Say{text, parts});
    run(1100 * kMillisecond);
  }
};

TEST_F(ChatTest, ReachesAllInOneOrderAndNobodySaysTooMuch) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben", Role::observer);
  for (int i = 0; i < 9; ++i) ada.send(Say{"line " + std::to_string(i) + " on [part1]", {PartId{1}}});
  settle();
  EXPECT_EQ(session->counters().droppedSays, 4u);
  for (const FakeSite* site : {&ada, &ben}) {
    const std::vector<SaidLine> told = lines(*site, false);
    ASSERT_EQ(told.size(), 5u);
    for (std::size_t i = 0; i < told.size(); ++i) {
      EXPECT_EQ(told[i].number, i + 1);
      EXPECT_EQ(told[i].said.text, "line " + std::to_string(i) + " on [part1]");
    }
    EXPECT_EQ(told[0].site, siteOf(ada));
    EXPECT_EQ(told[0].name, "ada");
    EXPECT_EQ(told[0].at, kUnix);
    EXPECT_EQ(told[0].said.parts, std::vector<PartId>{1});
  }
  run(kSecond);
  say(ada, "again");
  EXPECT_EQ(lines(ben, false).back().said.text, "again");
  EXPECT_TRUE(lines(ben, true).empty());
}

TEST_F(ChatTest, OfObserversAndOfUnknownPartsIsDroppedAndCountedAndNotKept) {
  FakeSite& watcher = join("watcher", Role::observer);
  FakeSite& ada = join("ada");
  watcher.send(Say{"hello", {}});
  ada.send(Say{"", {}});
  ada.send(Say{"that part", {PartId{3}}});
  settle();
  EXPECT_EQ(session->counters().droppedSays, 3u);
  FakeSite& eve = join("eve");
  settle();
  for (const FakeSite* site : {&watcher, &ada, &eve}) {
    EXPECT_EQ(site->count<Said>(), 0u);
    EXPECT_FALSE(site->closed);
  }
}

TEST_F(ChatTest, WhoJoinsHasWhatWasSaidBeforeAnythingElse) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben");
  say(ada, "see [part1]", {PartId{1}});
  say(ben, "yes");
  ben.send(Goodbye{});
  settle();
  FakeSite& eve = join("eve", Role::observer);
  say(ada, "hello eve");
  ASSERT_EQ(eve.count<Said>(), 2u);
  const std::vector<SaidLine> told = lines(eve, true);
  ASSERT_EQ(told.size(), 2u);
  const std::vector<SaidLine> heard = lines(ada, false);
  ASSERT_EQ(heard.size(), 3u);
  for (std::size_t i = 0; i < told.size(); ++i) EXPECT_EQ(told[i], heard[i]);
  EXPECT_EQ(told[1].name, "ben") << "though he has left";
  EXPECT_LT(told[0].at, told[1].at);
  ASSERT_EQ(lines(eve, false).size(), 1u);
  EXPECT_EQ(lines(eve, false)[0].number, 3u);
}

TEST_F(ChatTest, KeepsTheNewestLinesAndAfterACrashToo) {
  std::vector<FakeSite*> all;
  for (int i = 0; i < 10; ++i) all.push_back(&join("s" + std::to_string(i)));
  for (std::size_t i = 0; i < kMaxSaidLines + 20; ++i) {
    all[i % all.size()]->send(Say{"line " + std::to_string(i + 1), {}});
    if (i % all.size() == all.size() - 1) run(1100 * kMillisecond);
  }
  EXPECT_EQ(session->counters().droppedSays, 0u);
  for (int start = 0; start < 2; ++start) {
    FakeSite& eve = join("eve" + std::to_string(start));
    settle();
    const std::vector<SaidLine> told = lines(eve, true);
    ASSERT_EQ(told.size(), kMaxSaidLines);
    for (std::size_t i = 0; i < told.size(); ++i) {
      EXPECT_EQ(told[i].number, i + 21);
      EXPECT_EQ(told[i].said.text, "line " + std::to_string(i + 21));
    }
    for (auto& site : sites) site->transport.reset();
    crash();
    this->start();
  }
  FakeSite& ada = join("ada");
  say(ada, "after it");
  EXPECT_EQ(lines(ada, false).back().number, kMaxSaidLines + 21) << "numbers go on";
}

TEST_F(ChatTest, IsToldWhileTheJournalFailsAndKeptInMemoryAlone) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben");
  say(ada, "before");
  journal.fail("disk full");
  run(50 * kMillisecond);
  say(ada, "meanwhile");
  EXPECT_EQ(lines(ben, false).size(), 2u);
  journal.heal();
  run(50 * kMillisecond);
  FakeSite& eve = join("eve");
  settle();
  EXPECT_EQ(lines(eve, true).size(), 2u);
  EXPECT_EQ(journal.contents().said.size(), 1u);
}

TEST_F(ChatTest, WhoComesBackIsToldAllThatIsKeptOnce) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben");
  say(ada, "one");
  const std::string ticket = ben.last<Welcome>()->resumeTicket;
  ben.transport->close(0);
  settle();
  say(ada, "two");
  FakeSite& back = resume("ben", ticket);
  settle();
  back.send(Ready{});  // said twice, it brings nothing more
  settle();
  EXPECT_EQ(lines(back, true).size(), 2u);
}

TEST_F(ChatTest, FromASiteIsNoLineThatAServerTells) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben");
  ada.send(Said{true, {{7, 0, siteOf(ben), "ben", Say{"I said that", {}}}}});
  settle();
  EXPECT_TRUE(ada.closed);
  EXPECT_EQ(ben.count<Said>(), 0u);
}

}  // namespace
}  // namespace tandem::server
