#pragma once

// The display of a site without a window: a table in the terminal that is redrawn, or without a terminal a
// line every two seconds.

#include <cstddef>
#include <cstdint>
#include <string>

#include "client/session/view_model.h"

namespace tandem::client {

class LiveTable {
 public:
  explicit LiveTable(bool quiet);
  /// `elapsed` in s since the start; draws a few times a second at most.
  void show(const ViewModel& model, double elapsed);
  /// A summary at the end: `grabs` were answered, and `shared` parts of others were held or pushed with them.
  static void summary(const ViewModel& model, const std::string& end, std::size_t grabs, std::size_t shared);

 private:
  void printDocument(const ViewModel& model, double elapsed);
  void printEarlier(const ViewModel& model);
  void printNews(const ViewModel& model, double elapsed);
  bool quiet_, terminal_;
  double next_ = 0.0;              // s since the start
  std::uint64_t printed_ = 0;      // the number of the last notice that was printed
  std::uint64_t printedChat_ = 0;  // the number of the last line of what was said before
  std::string printedFault_;
  std::uint64_t printedRevision_ = 0;  // of the document
  int lines_ = 0;
};

}  // namespace tandem::client
