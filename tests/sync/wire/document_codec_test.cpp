// Bytes of entries: what came later than an entry was written may be missing.

#include "sync/wire/document_codec.h"

#include <gtest/gtest.h>

#include "assets/document/entry_check.h"

namespace tandem::sync {
namespace {

using document::NamedView;
using document::PartColouring;
using document::PartStyle;

TEST(DocumentCodec, AViewAsMadeHasTheBytesThatItHadBeforeThereWereStyles) {
  NamedView view{"v", {}, 1.0, {}, false, {}, {}};
  const std::vector<std::uint8_t> old = encodeBody(view);
  EXPECT_EQ(old.size(), 1u + 3u + 56u + 8u + 2u + 1u + 2u);
  const auto read = decodeBody(old);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(std::get<NamedView>(*read).style, PartStyle{});

  view.style = {0.5, {3, 1}, PartColouring::byMaterial, true};
  std::vector<std::uint8_t> bytes = encodeBody(view);
  EXPECT_EQ(bytes.size(), old.size() + 8 + 2 + 4 + 1 + 1);
  const auto again = decodeBody(bytes);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(std::get<NamedView>(*again).style, view.style);
  for (std::size_t cut = old.size() + 1; cut < bytes.size(); ++cut)
    EXPECT_FALSE(decodeBody(std::span(bytes).first(cut))) << cut;
  bytes.push_back(0);
  EXPECT_FALSE(decodeBody(bytes)) << "nothing follows";
  std::vector<std::uint8_t> empty = old;
  empty.resize(old.size() + 8 + 2 + 1 + 1);
  EXPECT_FALSE(decodeBody(empty)) << "a style that says nothing is not written";
}

TEST(DocumentCodec, WhatIsSeenThroughFollowsAStyleThatMaySayNothing) {
  NamedView view{"v", {}, 1.0, {}, false, {}, {}};
  const std::size_t plain = encodeBody(view).size();
  view.style.ghosts = true;
  const std::vector<std::uint8_t> styled = encodeBody(view);
  for (const bool ghosts : {true, false}) {
    view.style.ghosts = ghosts;
    view.seenThrough = {true, {4, 2}};
    std::vector<std::uint8_t> bytes = encodeBody(view);
    EXPECT_EQ(bytes.size(), styled.size() + 1 + 2 + 4);
    const auto again = decodeBody(bytes);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(std::get<NamedView>(*again).style, view.style);
    EXPECT_EQ(std::get<NamedView>(*again).seenThrough, view.seenThrough);
    for (std::size_t cut = plain + 1; cut < bytes.size(); ++cut)
      EXPECT_EQ(decodeBody(std::span(bytes).first(cut)).ok(), ghosts && cut == styled.size()) << cut;
    bytes.push_back(0);
    EXPECT_FALSE(decodeBody(bytes)) << "nothing follows";
    std::vector<std::uint8_t> empty(bytes.begin(),
                                    bytes.begin() + static_cast<std::ptrdiff_t>(styled.size()));
    empty.resize(styled.size() + 1 + 2);
    EXPECT_FALSE(decodeBody(empty)) << "what says nothing is not written";
  }
}

/// The largest view still fits into a request.
TEST(DocumentCodec, AViewAtAllItsLimitsKeepsTheLargestBody) {
  NamedView view{std::string(document::kMaxName, 'n'), {}, 1.0, {}, false, {}, {}};
  view.sections.resize(document::kMaxSections);
  view.parts.resize(document::kMaxListed);
  view.style.apart.resize(document::kMaxApart);
  view.seenThrough.parts.resize(document::kMaxSeenThrough);
  const std::vector<std::uint8_t> bytes = encodeBody(view);
  EXPECT_LE(bytes.size(), document::kMaxBodyBytes);
  EXPECT_TRUE(decodeBody(bytes));
  view.seenThrough.parts.push_back(0);
  EXPECT_FALSE(decodeBody(encodeBody(view)));
}

}  // namespace
}  // namespace tandem::sync
