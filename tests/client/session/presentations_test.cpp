// What a site takes of what the server tells it was said.

#include "client/session/presentations.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

using namespace sync;

struct ChatOfASite : testing::Test {
  Participants people;
  MessageSender sender;
  Presentations presentations{people, sender};
  std::vector<ChatLine> chat;

  ChatOfASite() { people.reset(1, {}); }
  static SaidLine line(std::uint64_t number, const std::string& text = "words") {
    return {number, 1000 + static_cast<std::int64_t>(number), 2, "ada", Say{text, {}}};
  }
  bool tell(bool earlier, std::vector<SaidLine> lines) {
    const bool taken = presentations.handle(Said{earlier, std::move(lines)});
    addChat(chat, presentations.drainChat());
    return taken;
  }
  std::size_t notices() { return people.drainNotices().size(); }
};

TEST_F(ChatOfASite, HasEarlierLinesInOrderAndOnlyWhatIsSaidNowIsANotice) {
  EXPECT_TRUE(tell(true, {line(3), line(4)}));
  EXPECT_EQ(notices(), 0u);
  EXPECT_TRUE(tell(false, {line(5)}));
  EXPECT_EQ(notices(), 1u);
  ASSERT_EQ(chat.size(), 3u);
  for (std::size_t i = 0; i < chat.size(); ++i) {
    EXPECT_EQ(chat[i].line.number, i + 3);
    EXPECT_EQ(chat[i].number, i + 1);
    EXPECT_EQ(chat[i].earlier, i < 2);
  }
}

TEST_F(ChatOfASite, OnANewConnectionLeavesOutWhatItHas) {
  EXPECT_TRUE(tell(true, {line(1)}));
  EXPECT_TRUE(tell(false, {line(2)}));
  presentations.connectionLost();
  EXPECT_TRUE(tell(true, {line(1), line(2), line(3)}));
  ASSERT_EQ(chat.size(), 3u);
  EXPECT_TRUE(chat[2].earlier);
  EXPECT_EQ(chat[2].line.number, 3u);
}

TEST_F(ChatOfASite, TakesNothingOfWhatNoServerTells) {
  SaidLine nobody = line(1);
  nobody.site = kNoSite;
  for (const std::vector<SaidLine>& lines : std::vector<std::vector<SaidLine>>{
           {}, {line(0)}, {line(2), line(2)}, {line(3), line(2)}, {line(1), line(2, "")}, {nobody}})
    EXPECT_FALSE(tell(true, lines));
  EXPECT_TRUE(chat.empty());
  EXPECT_EQ(notices(), 0u);
}

TEST_F(ChatOfASite, KeepsTheNewestWhateverAServerSends) {
  std::vector<SaidLine> lines;
  for (std::uint64_t i = 1; i <= kMaxSaidLines; ++i) lines.push_back(line(i));
  for (int i = 0; i < 50; ++i) presentations.handle(Said{false, lines});
  addChat(chat, presentations.drainChat());
  EXPECT_EQ(chat.size(), kMaxSaidLines);
  EXPECT_EQ(chat.back().number, 50 * kMaxSaidLines);
}

}  // namespace
}  // namespace tandem::client
