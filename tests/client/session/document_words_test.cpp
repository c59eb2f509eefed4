#include "client/session/document_words.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

TEST(DocumentWords, SayKindAndTextInOneLine) {
  document::Note note;
  note.text = "the bolt\nis loose";
  EXPECT_EQ(inWords(note), "note \"the bolt is loose\"");
  EXPECT_EQ(inWords(document::Comment{1, "why?"}), "reply \"why?\"");
  EXPECT_EQ(inWords(document::NamedView{"from below", {}, 1.0, {}, false, {}, {}}), "view \"from below\"");
  EXPECT_EQ(inWords(document::Removed{}), "removed");
}

TEST(DocumentWords, ALongTextIsCutBetweenCharacters) {
  const std::string umlauts = "äöüäöüäöü";  // two bytes each
  EXPECT_EQ(shortened(umlauts, 5), "äö...");
  EXPECT_EQ(shortened(umlauts, 6), "äöü...");
  EXPECT_EQ(shortened(umlauts, 18), umlauts);
}

TEST(DocumentWords, TheDocumentIsToldByItsLastEntryThatIsThere) {
  document::Document document;
  EXPECT_EQ(inWords(document), "empty");
  document.apply({0, 0, document::Group{"pump", {}}}, {1, "ada", 1, 0});
  document.apply({0, 0, document::Group{"lid", {}}}, {2, "ben", 1, 0});
  document.apply({2, 2, document::Removed{}}, {2, "ben", 2, 0});
  EXPECT_EQ(inWords(document), "1 entry, the last by ada: group \"pump\"");
}

}  // namespace
}  // namespace tandem::client
