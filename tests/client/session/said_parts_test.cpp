// Links to parts in what people say, whatever brackets they write.

#include "client/session/said_parts.h"

#include <gtest/gtest.h>

#include <random>

#include "sync/wire/limits.h"
#include "tests/client/hand/box_row.h"

namespace tandem::client {
namespace {

using test::rowOfBoxes;

std::string joined(const std::vector<SaidPiece>& pieces) {
  std::string text;
  for (const SaidPiece& piece : pieces) text += piece.part == kNoPart ? piece.text : "<" + piece.text + ">";
  return text;
}

TEST(SaidParts, NamesInBracketsAreLinksIfAPartBearsThem) {
  const assets::Scene scene = rowOfBoxes();
  const auto shown = [&](const std::string& text) {
    return joined(piecesOf(saidWithLinks(text, scene), scene));
  };
  EXPECT_EQ(shown("see [box 1] and [box 2]"), "see <box 1> and <box 2>");
  EXPECT_EQ(shown("[lid] is loose, [box 0] not"), "[lid] is loose, <box 0> not");
  EXPECT_EQ(shown("a[[box 1]] ] ["), "a[<box 1>] ] [");
  EXPECT_EQ(shown("no names"), "no names");
  EXPECT_EQ(shown(""), "");
}

TEST(SaidParts, ALineOfTextHasNoBracketsAroundLinks) {
  const assets::Scene scene = rowOfBoxes();
  EXPECT_EQ(inWords(saidWithLinks("see [box 1] and [box 2]", scene)), "see box 1 and box 2");
  EXPECT_EQ(inWords(saidWithLinks("[lid] is loose, [box 0] not", scene)), "[lid] is loose, box 0 not");
  EXPECT_EQ(inWords(saidWithLinks("a[[box 1]] ] [", scene)), "a[box 1] ] [");
  EXPECT_EQ(inWords({"no brackets", {PartId{2}}}), "no brackets");
}

TEST(SaidParts, ALinkShowsThePartsOwnName) {
  const assets::Scene scene = rowOfBoxes();
  EXPECT_EQ(joined(piecesOf({"the [small lid]", {PartId{2}}}, scene)), "the <box 2>");
  EXPECT_EQ(joined(piecesOf({"the [small lid]", {PartId{200}}}, scene)), "the [small lid]");
  EXPECT_EQ(joined(piecesOf({"no brackets", {PartId{2}}}, scene)), "no brackets");
}

TEST(SaidParts, LoseNoTextWhateverItIs) {
  const assets::Scene scene = rowOfBoxes();
  std::mt19937 random(5);
  for (int round = 0; round < 5000; ++round) {
    std::string text;
    for (unsigned n = random() % 20; n > 0; --n) text += "[]ab"[random() % 4];
    const sync::Say said = saidWithLinks(text, scene);
    EXPECT_LE(said.parts.size(), sync::kMaxSaidParts);
    EXPECT_EQ(joined(piecesOf(said, scene)), text) << "no part has such a name";
  }
}

}  // namespace
}  // namespace tandem::client
