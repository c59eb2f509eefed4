#include "sync/wire/voice_url.h"

#include <gtest/gtest.h>

#include "sync/wire/wire.h"

namespace tandem::sync {
namespace {

TEST(VoiceUrl, IsOfAFewSchemesWhateverTheirCase) {
  for (const char* url : {"https://meet.example.org/review?room=1#a", "HTTP://10.0.0.1:8080",
                          "mumble://ada@voice.example.org:64738/Room", "sip:review@example.org",
                          "sips:review@example.org;transport=tcp", "xmpp:review@rooms.example.org?join",
                          "ts3server://voice.example.org?port=9987", "teamspeak://voice.example.org"})
    EXPECT_TRUE(isVoiceUrl(url)) << url;
}

TEST(VoiceUrl, IsNothingThatRunsOrReadsSomethingOrConfusesATerminal) {
  for (const char* url : {"",
                          "https:",
                          "https://",
                          "https:///etc",
                          "sip:",
                          "sip://x",
                          "file:///etc/passwd",
                          "javascript:alert(1)",
                          "data:text/html,x",
                          "meet.example.org",
                          " https://a.org",
                          "https://a.org b",
                          "https://a.org\n",
                          "https://a.org\x1b[2J",
                          "https://a.org\"x",
                          "https://a.org'x",
                          "https://a.org<x>",
                          "https://a.org`x`",
                          "https://a.org/\xc3\xa9",
                          "https://a.org\x7f",
                          "https://-x"})
    EXPECT_FALSE(isVoiceUrl(url)) << url;
  EXPECT_FALSE(isVoiceUrl(std::string("https://a.org\0b", 15)));
  const std::string host = "https://a.org/";
  EXPECT_TRUE(isVoiceUrl(host + std::string(kMaxVoiceUrl - host.size(), 'x')));
  EXPECT_FALSE(isVoiceUrl(host + std::string(kMaxVoiceUrl + 1 - host.size(), 'x')));
}

TEST(VoiceUrl, OfALyingServerMakesItsWelcomeMalformed) {
  Welcome welcome;
  welcome.voiceUrl = "https://a.org/room";
  std::vector<std::byte> bytes = encodeControl(welcome);
  const Result<ControlMessage> good = decodeControl(bytes);
  ASSERT_TRUE(good);
  EXPECT_EQ(std::get<Welcome>(*good).voiceUrl, welcome.voiceUrl);
  for (const char bad : {'\x1b', '\n', ' '}) {
    std::vector<std::byte> lies = bytes;
    // The text stands before the two empty lists.
    lies[lies.size() - 4 - 1] = std::byte(bad);
    EXPECT_FALSE(decodeControl(lies)) << int(bad);
  }
}

}  // namespace
}  // namespace tandem::sync
