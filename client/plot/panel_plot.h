#pragma once

// Several small plots side by side, two in a row, with one legend: inline SVG as svg_plot.h makes it.

#include <string>
#include <vector>

#include "client/plot/svg_plot.h"

namespace tandem::client::report {

struct PanelSeries {
  SeriesStyle style;
  std::vector<PlotPoint> points;    // labels beside the points, where there is room
  std::vector<PlotPoint> unstable;  // drawn as crosses in a lane above the plot; y is ignored
  bool joined = true;
};

/// Two logarithmic axes. Values below `floorY` are drawn on it with an arrow down.
struct Panel {
  std::string title, xLabel, yLabel;
  double floorY = 1e-9;
  std::vector<double> xLines;  // empty: chosen
  std::vector<PanelSeries> series;
  bool unstableLane = true;  // false where nothing can be unstable
};

/// A series of the same name looks the same in all panels.
std::string panelsSvg(const std::vector<Panel>& panels);

}  // namespace tandem::client::report
