#include "client/session/doubt_words.h"

#include <gtest/gtest.h>

#include "client/session/participants.h"

namespace tandem::client {
namespace {

using sync::Doubt;
using sync::Role;

/// Five people, of whom the first is at this site and the last observes.
struct People {
  Participants participants;
  ViewModel model;

  People() {
    std::vector<sync::SiteInfo> sites;
    for (const char* name : {"Me", "Ada", "Ben", "Cid", "Eve"})
      sites.push_back({static_cast<SiteId>(sites.size() + 1),
                       sites.size() == 4 ? Role::observer : Role::participant,
                       name,
                       {1, 2, 3},
                       true});
    participants.reset(1, sites);
  }
  std::string wordsAbout(SiteId site) {
    model.sites = participants.sites();
    return doubtsInWords(model, model.sites[site - 1u]);
  }
};

TEST(DoubtWords, SayWhoSaysItAndHowManyCould) {
  People people;
  EXPECT_EQ(people.wordsAbout(3), "");
  people.participants.handle(Doubt{2, 3, true});
  EXPECT_EQ(people.wordsAbout(3), "does not move or push as a hand does, says Ada (1 of 3 other sites)");
  people.participants.handle(Doubt{1, 3, true});
  people.participants.handle(Doubt{1, 3, true});
  EXPECT_EQ(people.wordsAbout(3),
            "does not move or push as a hand does, say Ada and you (2 of 3 other sites)");
  EXPECT_EQ(people.wordsAbout(2), "");
  people.participants.handle(Doubt{2, 3, false});
  EXPECT_EQ(people.wordsAbout(3), "does not move or push as a hand does, say you (1 of 3 other sites)");
}

TEST(DoubtWords, OneNoticeIsGivenForTheFirstWhoSaysIt) {
  People people;
  people.participants.handle(Doubt{2, 3, true});
  people.participants.handle(Doubt{4, 3, true});
  const std::vector<Notice> notices = people.participants.drainNotices();
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_EQ(notices[0].text, "Ben does not move or push as a hand does, says Ada");
}

TEST(DoubtWords, WhoIsUnknownOrHasLeftSaysNothing) {
  People people;
  people.participants.handle(Doubt{9, 3, true});
  people.participants.handle(Doubt{2, 9, true});
  people.participants.handle(Doubt{2, 3, true});
  people.participants.handle(sync::SiteLeft{2});
  EXPECT_EQ(people.participants.sites().size(), 4u);
  for (const SiteView& site : people.participants.sites()) EXPECT_TRUE(site.doubtedBy.empty());
}

}  // namespace
}  // namespace tandem::client
