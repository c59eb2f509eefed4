#pragma once

// The shapes of the report's plots. Lengths in px of a page that is kWidth wide.

#include <string>
#include <vector>

#include "client/plot/svg_plot.h"

namespace tandem::client::report {

inline constexpr double kWidth = 900.0;
inline constexpr const char* kInk = "#33404d";
inline constexpr const char* kQuiet = "#6b7785";
inline constexpr const char* kGrid = "#e3e8ed";

__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...);

std::string textAt(double x, double y, const char* anchor, const char* colour, double size,
                   const std::string& text);
std::string lineFrom(double x0, double y0, double x1, double y1, const std::string& colour, double width);
std::string markerAt(double x, double y, const SeriesStyle& style, const std::string& tooltip,
                     double scale = 1.0);
/// The opening tag of a picture; `label` describes it for screen readers.
std::string begin(double height, const std::string& label);
std::string legend(const std::vector<SeriesStyle>& styles, double x, double y);
/// A number of an axis: plain where it is short, else as a power of ten. `powers`: the axis has powers of
/// ten.
std::string axisNumber(double value, bool powers = false);

/// A logarithmic axis around some positive values, with lines at 1, 2, 5 or at powers of ten.
class LogAxis {
 public:
  /// Nothing is drawn below `floor`.
  LogAxis(const std::vector<double>& values, double from, double to, double floor = 0.0);
  /// From the first line to the last.
  LogAxis(double from, double to, std::vector<double> lines);

  double at(double value) const;
  const std::vector<double>& lines() const { return lines_; }

 private:
  void span();
  double from_, to_, low_ = 0.0, high_ = 1.0;
  std::vector<double> lines_;
};

}  // namespace tandem::client::report
