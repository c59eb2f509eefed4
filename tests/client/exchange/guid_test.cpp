// Identifiers are the same in every run, and well formed.

#include "client/exchange/guid.h"

#include <gtest/gtest.h>

#include <regex>
#include <set>

namespace tandem::client {
namespace {

document::Entry entry(document::EntryId id, std::int64_t made) {
  document::Entry e;
  e.id = id;
  e.author = 3;
  e.creation = 7;
  e.authorName = "Ada";
  e.made = made;
  e.body = document::Note{};
  return e;
}

TEST(Guid, OfANameIsTheSameForEver) {
  // Exported files contain these GUIDs. If they change, an import no longer recognises its own topics.
  EXPECT_EQ(uuidOf(std::string("name")), "09d1bdfb-8728-86d4-ac81-d2c24648f3da");
  EXPECT_EQ(ifcGuidOf("Impeller"), "1PhPOvyZ8XrEZjjrhqZqeJ");
}

TEST(Guid, HasTheFormThatOtherProgramsCheck) {
  const std::regex uuid("[a-f0-9]{8}-[a-f0-9]{4}-8[a-f0-9]{3}-[89ab][a-f0-9]{3}-[a-f0-9]{12}");
  std::set<std::string> uuids, guids;
  for (int i = 0; i < 1000; ++i) {
    const std::string name = "part " + std::to_string(i);
    EXPECT_TRUE(std::regex_match(uuidOf(name), uuid)) << uuidOf(name);
    EXPECT_TRUE(isIfcGuid(ifcGuidOf(name))) << ifcGuidOf(name);
    uuids.insert(uuidOf(name));
    guids.insert(ifcGuidOf(name));
  }
  EXPECT_EQ(uuids.size(), 1000u);
  EXPECT_EQ(guids.size(), 1000u);
  EXPECT_FALSE(isIfcGuid("4" + std::string(21, 'A')));  // more than 128 bits
  EXPECT_FALSE(isIfcGuid(std::string(21, '0')));
  EXPECT_FALSE(isIfcGuid(std::string(21, '0') + "-"));
}

TEST(Guid, OfAnEntryStaysThroughItsChangesAndDiffersBetweenSessions) {
  const std::string guid = uuidOf(entry(5, 1000), "abc");
  document::Entry changed = entry(5, 1000);
  changed.revision = 9;
  changed.changed = 2000;
  changed.editor = 4;
  changed.body = document::Note{"other text", 1, {}, "Ben", document::NoteStatus::closed};
  EXPECT_EQ(uuidOf(changed, "abc"), guid);
  EXPECT_NE(uuidOf(entry(6, 1000), "abc"), guid);
  EXPECT_NE(uuidOf(entry(5, 1001), "abc"), guid);  // another session on the same scene
  EXPECT_NE(uuidOf(entry(5, 1000), "abd"), guid);
}

TEST(PartGuids, AreFoundAgainAndAnIfcNameIsOneAlready) {
  assets::Scene scene;
  scene.parts.resize(2);
  scene.parts[0].name = "Bolt";
  scene.parts[1].name = "1bbI761TbBCOoIa5Kt6PXt";
  const PartGuids guids(scene);
  EXPECT_EQ(guids.guid(1), scene.parts[1].name);
  EXPECT_EQ(guids.part(guids.guid(0)), 0);
  EXPECT_EQ(guids.part(guids.guid(1)), 1);
  EXPECT_EQ(guids.part(ifcGuidOf("Nut")), kNoPart);
  // A part keeps its GUID in a scene in which it stands elsewhere.
  std::swap(scene.parts[0], scene.parts[1]);
  EXPECT_EQ(PartGuids(scene).guid(1), guids.guid(0));
}

}  // namespace
}  // namespace tandem::client
