#pragma once

// The report's pictures as inline SVG: nothing outside is needed to show them. Sizes in px; the width is that
// of the page's column and scales down with it.

#include <string>
#include <vector>

namespace tandem::client::report {

enum class Marker { circle, square, diamond, triangle };

/// How the series of one setting is drawn in every plot.
struct SeriesStyle {
  std::string name;
  std::string colour;  // #rrggbb
  Marker marker = Marker::circle;
  bool hollow = false;
  double size = 1.0;
};

struct PlotPoint {
  double x = 0.0, y = 0.0;
  std::string label;    // beside the point; may be empty
  std::string tooltip;  // shown while the pointer rests on it
  bool ringed = false;  // stands out
};

struct PlotSeries {
  SeriesStyle style;
  std::vector<PlotPoint> points;
  bool joined = true;  // by a line, in this order
};

/// A scatter on two logarithmic axes. Values of at most `floorY` are drawn on it with an arrow down, and the
/// axis says so.
struct ScatterPlot {
  std::string xLabel, yLabel;
  std::vector<PlotSeries> series;
  double floorY = 1e-9;
  std::vector<PlotPoint> front;  // drawn as a dashed stair from point to point
  std::string frontName;         // in the legend
};
/// The Pareto front: the points to which no other one is both at most as dear (x) and as exact (y, within 1
/// %). In order of rising x and falling y.
std::vector<PlotPoint> paretoFront(std::vector<PlotPoint> points);

std::string scatterSvg(const ScatterPlot& plot);

/// Rows of ranges on one logarithmic axis: from the median to the 99th percentile.
struct RangeMark {
  SeriesStyle style;
  double low = 0.0, high = 0.0;
  std::string tooltip;
};
struct RangeRow {
  std::string name;
  std::vector<RangeMark> marks;
};
struct RangePlot {
  std::string xLabel;
  std::vector<RangeRow> rows;
};
std::string rangeSvg(const RangePlot& plot);

/// Horizontal bars from zero.
struct Bar {
  std::string name, value;  // the value as it is written at its end
  double length = 0.0;
  std::string colour;
};
std::string barsSvg(const std::vector<Bar>& bars);

/// Text with what HTML and SVG would read as markup replaced.
std::string escaped(const std::string& text);

}  // namespace tandem::client::report
