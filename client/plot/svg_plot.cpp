#include "client/plot/svg_plot.h"

#include <algorithm>
#include <cmath>

#include "assets/base/assert.h"
#include "client/plot/label_places.h"
#include "client/plot/svg_shapes.h"

namespace tandem::client::report {
namespace {

constexpr double kAsExact = 0.01;  // a point that is more exact by a smaller share does not lie on the front

/// Where a plot's axes are, px.
struct PlotBox {
  double left, top, right, bottom;
};

/// Axes with their lines, numbers and names.
std::string frameOf(const ScatterPlot& plot, const LogAxis& x, const LogAxis& y,
                    const std::vector<double>& ys, const PlotBox& box) {
  const bool floored = std::any_of(ys.begin(), ys.end(), [&](double v) { return v <= plot.floorY; });
  const auto [left, top, right, bottom] = box;
  std::string svg;
  for (const double v : x.lines()) {
    const double at = x.at(v);
    svg += lineFrom(at, top, at, bottom, kGrid, 1.0) +
           textAt(at, bottom + 25.0, "middle", kQuiet, 12.0, axisNumber(v));
  }
  for (const double v : y.lines()) {
    const double at = y.at(v);
    svg += lineFrom(left, at, right, at, kGrid, 1.0) +
           textAt(left - 9.0, at + 4.0, "end", kQuiet, 12.0,
                  (floored && v < 1.1 * plot.floorY ? "≤ " : "") + axisNumber(v, y.lines().front() < 0.9e-3));
  }
  svg += lineFrom(left, bottom, right, bottom, kQuiet, 1.0) + lineFrom(left, top, left, bottom, kQuiet, 1.0);
  svg += textAt(0.5 * (left + right), bottom + 46.0, "middle", kInk, 13.0, plot.xLabel);
  svg += format(R"svg(<g transform="translate(20 %.1f) rotate(-90)">)svg", 0.5 * (top + bottom)) +
         textAt(0.0, 0.0, "middle", kInk, 13.0, plot.yLabel) + "</g>\n";
  return svg;
}

/// The stair of the front: from each point on, the least error at that cost or less.
std::string frontOf(const ScatterPlot& plot, const LogAxis& x, const LogAxis& y, double right) {
  std::string path;
  double before = 0.0;
  ASSERT(std::is_sorted(plot.front.begin(), plot.front.end(),
                        [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; }));
  for (const PlotPoint& p : plot.front) {
    const double px = x.at(p.x), py = y.at(std::max(p.y, plot.floorY));
    path += path.empty() ? format("M%.1f %.1f", px, py) : format("L%.1f %.1fL%.1f %.1f", px, before, px, py);
    before = py;
  }
  if (path.empty()) return "";
  return "<path class=\"front\" fill=\"none\" stroke-width=\"1.4\" stroke-dasharray=\"5 4\" stroke=\"" +
         std::string(kInk) + "\" d=\"" + path + format("L%.1f %.1f", right, before) + "\"/>\n";
}

}  // namespace

std::vector<PlotPoint> paretoFront(std::vector<PlotPoint> points) {
  std::sort(points.begin(), points.end(),
            [](const PlotPoint& a, const PlotPoint& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<PlotPoint> front;
  for (const PlotPoint& p : points)
    if (front.empty() || p.y < (1.0 - kAsExact) * front.back().y) front.push_back(p);
  return front;
}

std::string scatterSvg(const ScatterPlot& plot) {
  const double left = 84.0, right = 560.0, top = 16.0, bottom = 372.0, height = 430.0;
  std::vector<double> xs, ys;
  for (const PlotSeries& series : plot.series)
    for (const PlotPoint& p : series.points) {
      xs.push_back(p.x);
      ys.push_back(std::max(p.y, plot.floorY));
    }
  const LogAxis x(xs, left, right), y(ys, bottom, top, plot.floorY);
  std::string svg = begin(height, plot.yLabel + " against " + plot.xLabel) +
                    frameOf(plot, x, y, ys, {left, top, right, bottom});
  std::string marks, labels;
  std::vector<SeriesStyle> styles;
  LabelPlaces places;
  for (const PlotSeries& series : plot.series)
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const PlotPoint& p = series.points[i];
      const double px = x.at(p.x), py = y.at(std::max(p.y, plot.floorY));
      places.avoid(px, py, p.ringed ? 11.0 : 6.0);
      if (i == 0 || !series.joined) continue;
      const PlotPoint& last = series.points[i - 1];
      places.avoidLine(x.at(last.x), y.at(std::max(last.y, plot.floorY)), px, py);
    }
  for (std::size_t i = 1; i < plot.front.size(); ++i) {
    const double px = x.at(plot.front[i].x), before = y.at(std::max(plot.front[i - 1].y, plot.floorY));
    places.avoidLine(x.at(plot.front[i - 1].x), before, px, before);
    places.avoidLine(px, before, px, y.at(std::max(plot.front[i].y, plot.floorY)));
  }
  for (const PlotSeries& series : plot.series) {
    styles.push_back(series.style);
    std::string path, own;
    for (const PlotPoint& p : series.points) {
      const double px = x.at(p.x), py = y.at(std::max(p.y, plot.floorY));
      path += format("%s%.1f %.1f", path.empty() ? "M" : "L", px, py);
      if (p.y <= plot.floorY)  // below the floor
        own +=
            format(R"(<path class="below" d="M%.1f %.1fv12m-3.5 -4l3.5 4l3.5 -4" fill="none" stroke="%s" )",
                   px, py, series.style.colour.c_str()) +
            "stroke-width=\"1.6\"/>\n";
      if (p.ringed)
        own += format(R"(<circle cx="%.1f" cy="%.1f" r="10" fill="none" stroke="%s" stroke-width="1.6"/>)",
                      px, py, kInk) +
               "\n";
      own += markerAt(px, py, series.style, p.tooltip);
      if (!p.label.empty()) labels += places.place(px, py, p.label);
    }
    marks = own + marks;  // the first series lies on top
    if (series.joined && series.points.size() > 1)
      svg += R"(<path fill="none" stroke-width="1.2" stroke-opacity="0.35" stroke=")" + series.style.colour +
             "\" d=\"" + path + "\"/>\n";
  }
  svg += frontOf(plot, x, y, right);
  const double rows = 21.0 * static_cast<double>(styles.size());
  labels += legend(styles, right + 32.0, top + 14.0);
  if (!plot.front.empty())
    labels += format(R"(<path d="M%.1f %.1fh20" stroke="%s" stroke-width="1.6" stroke-dasharray="5 4"/>)",
                     right + 22.0, top + 14.0 + rows, kInk) +
              "\n" + textAt(right + 45.0, top + 18.0 + rows, "start", kInk, 12.0, plot.frontName);
  return svg + marks + labels + "</svg>\n";
}

std::string rangeSvg(const RangePlot& plot) {
  const double left = 280.0, right = 620.0, top = 14.0, perMark = 9.0, between = 13.0;
  double height = top;
  std::vector<double> values;
  for (const RangeRow& row : plot.rows) {
    height += between + perMark * static_cast<double>(row.marks.size());
    for (const RangeMark& mark : row.marks) {
      values.push_back(mark.low);
      values.push_back(mark.high);
    }
  }
  const LogAxis x(values, left, right);
  std::string svg = begin(height + 56.0, plot.xLabel), marks;
  std::vector<SeriesStyle> styles;
  for (const double v : x.lines()) {
    const double at = x.at(v);
    svg += lineFrom(at, top, at, height, kGrid, 1.0) +
           textAt(at, height + 20.0, "middle", kQuiet, 12.0, axisNumber(v));
  }
  double y = top;
  for (const RangeRow& row : plot.rows) {
    const double middle = y + 0.5 * (between + perMark * static_cast<double>(row.marks.size()));
    marks += textAt(left - 14.0, middle + 4.0, "end", kInk, 12.0, row.name);
    y += 0.5 * between;
    for (const RangeMark& mark : row.marks) {
      y += 0.5 * perMark;
      const SeriesStyle& style = mark.style;
      marks += format(R"(<line x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f" stroke="%s" stroke-width="3" )"
                      R"(stroke-linecap="round" stroke-opacity="0.5"/>)",
                      x.at(mark.low), y, x.at(mark.high), y, style.colour.c_str());
      marks += markerAt(x.at(mark.low), y, style, mark.tooltip, 0.75);
      y += 0.5 * perMark;
      if (std::none_of(styles.begin(), styles.end(),
                       [&](const SeriesStyle& l) { return l.name == style.name; }))
        styles.push_back(style);
    }
    y += 0.5 * between;
    svg += lineFrom(left, y, right, y, kGrid, 1.0);
  }
  svg += textAt(0.5 * (left + right), height + 44.0, "middle", kInk, 13.0, plot.xLabel);
  return svg + marks + legend(styles, right + 32.0, top + 14.0) + "</svg>\n";
}

std::string barsSvg(const std::vector<Bar>& bars) {
  const double left = 280.0, right = 790.0, row = 24.0;
  double longest = 0.0;
  for (const Bar& bar : bars) longest = std::max(longest, bar.length);
  std::string svg = begin(row * static_cast<double>(bars.size()) + 12.0, "bars");
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const double y = 6.0 + row * static_cast<double>(i);
    const double length = longest > 0.0 ? (right - left) * bars[i].length / longest : 0.0;
    svg += textAt(left - 14.0, y + 16.0, "end", kInk, 12.0, bars[i].name);
    svg += format(R"(<rect x="%.1f" y="%.1f" width="%.1f" height="15" fill="%s"/>)", left, y + 4.0,
                  std::max(length, 1.0), bars[i].colour.c_str()) +
           "\n" + textAt(left + length + 8.0, y + 16.0, "start", kQuiet, 12.0, bars[i].value);
  }
  return svg + "</svg>\n";
}

}  // namespace tandem::client::report
