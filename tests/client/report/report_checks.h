#pragma once

// Checks of a page that the program writes.

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tandem::test {

/// Whether all elements are closed again in the right order. Suffices for a page that the program writes
/// itself.
inline void expectBalanced(const std::string& html) {
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const bool closes = html[at + 1] == '/';
    const std::size_t from = at + (closes ? 2 : 1);
    const std::string name = html.substr(from, html.find_first_of(" >/\n", from) - from);
    if (name == "!DOCTYPE" || name == "meta" || name == "br" || html[end - 1] == '/') continue;
    if (closes) {
      ASSERT_FALSE(open.empty()) << name;
      ASSERT_EQ(open.back(), name);
      open.pop_back();
    } else {
      open.push_back(name);
      if (name == "script" || name == "style") at = html.find("</" + name, at) - 1;
    }
  }
  EXPECT_TRUE(open.empty());
}

/// How often `part` occurs in a text.
inline std::size_t countOf(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

}  // namespace tandem::test
