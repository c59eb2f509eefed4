#include "client/session/document_undo.h"

#include <gtest/gtest.h>

#include <random>

namespace tandem::client {
namespace {

using document::Body;
using document::Document;
using document::EntryId;
using document::Group;
using document::Refusal;
using document::Removed;
using Direction = DocumentUndo::Direction;

/// A person who changes a document that no network parts from her.
struct Writer {
  Document& document;
  SiteId site;
  DocumentUndo undo{};

  static std::string nameOf(const Body& body) {
    return std::holds_alternative<Group>(body) ? std::get<Group>(body).name : "removed";
  }
  EntryId write(EntryId id, const Body& body) {
    const document::Entry* old = document.find(id);
    const Body before = old == nullptr ? Body{} : old->body;
    const document::Revision base = old == nullptr ? 0 : old->revision;
    const auto outcome = document.apply({id, base, body}, {site, "", 0, 0});
    if (outcome.refusal != Refusal::none) return 0;
    undo.changed({outcome.entry.id, base, outcome.entry.revision, before});
    return outcome.entry.id;
  }
  /// False if there is nothing to take back, or it may not be.
  bool take(Direction direction) {
    const DocumentUndo::Step* step = undo.next(direction);
    if (step == nullptr) return false;
    const Body left = document.find(step->id)->body;
    const auto outcome = document.apply(DocumentUndo::changeFor(*step), {site, "", 0, 0});
    if (outcome.refusal == Refusal::none)
      undo.taken(direction, left, outcome.entry.revision);
    else
      undo.drop(direction);
    return outcome.refusal == Refusal::none;
  }
};

std::vector<std::string> names(const Document& document) {
  std::vector<std::string> all;
  for (const auto& [id, entry] : document.entries()) all.push_back(Writer::nameOf(entry.body));
  return all;
}

TEST(DocumentUndo, GoesThroughEveryStateBackAndForthHoweverOften) {
  Document document;
  Writer ada{document, 1};
  std::mt19937 random(7);
  std::vector<std::vector<std::string>> states{names(document)};
  std::vector<EntryId> ids;
  for (int i = 0; i < 40; ++i) {
    const std::string name = std::to_string(i);
    const bool makes = ids.size() < 3 || random() % 4 == 0;
    const EntryId id = makes ? 0 : ids[random() % ids.size()];
    const bool removes = !makes && random() % 4 == 0 && !document.find(id)->removed();
    const EntryId changed = ada.write(id, removes ? Body{} : Body{Group{name, {}}});
    ASSERT_NE(changed, 0u);
    if (makes) ids.push_back(changed);
    states.push_back(names(document));
  }
  std::size_t at = states.size() - 1;
  const auto lasts = [&](const std::vector<std::string>& state) {
    // An entry that is not made yet is a removed one.
    std::vector<std::string> padded = state;
    padded.resize(names(document).size(), "removed");
    return padded;
  };
  for (int i = 0; i < 400; ++i) {
    const bool back = random() % 2 == 0;
    const bool possible = back ? at > 0 : at + 1 < states.size();
    ASSERT_EQ(ada.take(back ? Direction::undo : Direction::redo), possible) << i;
    if (possible) at = back ? at - 1 : at + 1;
    ASSERT_EQ(names(document), lasts(states[at])) << i;
  }
}

TEST(DocumentUndo, NeverChangesWhatAnotherWroteLast) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    Document document;
    Writer people[] = {{document, 1}, {document, 2}};
    std::mt19937 random(seed);
    const EntryId ids[] = {people[0].write(0, Group{"a", {}}), people[1].write(0, Group{"b", {}})};
    for (int i = 0; i < 200; ++i) {
      Writer& person = people[random() % 2];
      const std::map before = document.entries();
      if (random() % 2 == 0) {
        person.write(ids[random() % 2], Group{std::to_string(i), {}});
      } else {
        const Direction direction = random() % 3 == 0 ? Direction::redo : Direction::undo;
        person.take(direction);
        for (const auto& [id, entry] : document.entries())
          if (entry.revision != before.at(id).revision) {
            ASSERT_EQ(before.at(id).editor, person.site) << "seed " << seed << " step " << i;
          }
      }
    }
  }
}

TEST(DocumentUndo, KeepsTheNewestSteps) {
  Document document;
  Writer ada{document, 1};
  const EntryId id = ada.write(0, Group{"first", {}});
  for (std::size_t i = 0; i < DocumentUndo::kMaxSteps + 10; ++i) ada.write(id, Group{std::to_string(i), {}});
  std::size_t taken = 0;
  while (ada.take(Direction::undo)) ++taken;
  EXPECT_EQ(taken, DocumentUndo::kMaxSteps);
  EXPECT_EQ(Writer::nameOf(document.find(id)->body), "9");
}

}  // namespace
}  // namespace tandem::client
