#pragma once

// What a site without a window shows: a table in the terminal, drawn anew, or a line now and then where there
// is none.

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
  /// A summary at the end.
  static void summary(const ViewModel& model, const std::string& end, std::size_t grabs);

 private:
  void tellNews(const ViewModel& model, double elapsed);
  bool quiet_, terminal_;
  double next_ = 0.0;       // s since the start
  std::uint64_t told_ = 0;  // notices
  std::string toldFault_;
  int lines_ = 0;
};

}  // namespace tandem::client
