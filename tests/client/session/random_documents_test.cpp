// Sessions drawn at random in which people change the document: sites fall silent, the server dies.
//   D1  at the end every replica is the server's document
//   D2  every change that was told is kept, whatever dies
//   D3  the revisions that a site is told of an entry only grow

#include <gtest/gtest.h>

#include <iterator>
#include <map>
#include <random>

#include "tests/client/session/document_people.h"

namespace tandem::client {
namespace {

using namespace document;

struct RandomDocuments : SessionDocuments {
  std::mt19937 random;
  std::map<EntryId, Revision> told;  // the newest that any site was told
  std::string broken;                // the first rule
  bool forgets = false;              // a mistake: a server that dies loses its journal

  unsigned draw(unsigned below) { return static_cast<unsigned>(random() % below); }
  void breaks(const std::string& rule) {
    if (broken.empty()) broken = rule;
  }
  void onTold(const Person& person, const Entry& entry) override {
    const Entry* known = person.shown.find(entry.id);
    if (known != nullptr && known->revision > entry.revision) breaks("D3");
    Revision& newest = told[entry.id];
    newest = std::max(newest, entry.revision);
  }
  void act(Person& person) {
    const auto& entries = person.document().content().entries();
    const unsigned what = draw(10);
    if (what < 3 || entries.empty()) return person.write(0, note(std::to_string(draw(1000))));
    auto at = entries.begin();
    std::advance(at, draw(static_cast<unsigned>(entries.size())));
    const Entry& entry = at->second;
    const bool isNote = std::holds_alternative<Note>(entry.body);
    if (what < 5 && isNote)
      return person.write(entry.id, note(std::to_string(draw(1000)), NoteStatus::closed));
    if (what < 6 && isNote) return person.write(0, Comment{entry.id, "reply"});
    if (what < 7) return person.write(entry.id, Removed{});
    if (what < 9) return person.undo();
    person.redo();
  }
  void fault() {
    const unsigned what = draw(12);
    if (what == 0) {
      crash();
      if (forgets) journal = server::MemoryJournal{2 * kMillisecond};
      SessionRig::run(draw(100) * kMillisecond);
      start();
    } else if (what == 1) {
      network.blackout(draw(2) == 0 ? "ada" : "ben", now + draw(4000) * kMillisecond);
    }
  }
  void play(unsigned seed) {
    random.seed(seed);
    for (const char* name : {"ada", "ben"}) enter(name);
    enter("ines", sync::Role::instructor);
    for (int i = 0; i < 40; ++i) {
      act(*people[draw(3)]);
      SessionRig::run(draw(60) * kMillisecond);
      fault();
    }
    network.healAll();
    SessionRig::run(12 * kSecond);
    for (const auto& [id, revision] : told) {
      const Entry* entry = session->document().find(id);
      if (entry == nullptr || entry->revision < revision) breaks("D2");
    }
    const std::string truth = toJson(session->document(), "s");
    for (const auto& person : people)
      if (!person->document().standing().complete || person->document().standing().unsent != 0 ||
          toJson(person->document().content(), "s") != truth || toJson(person->shown, "s") != truth)
        breaks("D1");
  }
};

struct RandomDocumentsOf : RandomDocuments, testing::WithParamInterface<unsigned> {};

TEST_P(RandomDocumentsOf, KeepTheRules) {
  play(GetParam());
  EXPECT_EQ(broken, "");
  EXPECT_GT(told.size(), 5u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomDocumentsOf, testing::Range(1u, 26u));

// Mistakes that the rules must find.
TEST_F(RandomDocuments, D1FindsASiteThatMissesAChange) {
  missesEvery = 5;
  play(1);
  EXPECT_EQ(broken, "D1");
}

TEST_F(RandomDocuments, D2FindsAServerThatForgetsWhatItTold) {
  forgets = true;
  play(1);
  EXPECT_EQ(broken, "D2");
}

TEST_F(RandomDocuments, D3FindsASiteThatIsToldOfAnOlderRevision) {
  play(1);
  Entry older = session->document().entries().begin()->second;
  --older.revision;
  onTold(*people[0], older);
  EXPECT_EQ(broken, "D3");
}

}  // namespace
}  // namespace tandem::client
