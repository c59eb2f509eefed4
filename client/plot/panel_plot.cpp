#include "client/plot/panel_plot.h"

#include <algorithm>
#include <cmath>

#include "client/plot/label_places.h"
#include "client/plot/svg_shapes.h"

namespace tandem::client::report {
namespace {

constexpr double kPanelWidth = 450.0, kPanelHeight = 330.0;
constexpr double kLeft = 66.0, kRight = 436.0, kLane = 36.0, kTop = 56.0, kBottom = 276.0, kInset = 14.0;
constexpr double kLegendRow = 21.0, kLegendColumn = 290.0;
constexpr int kLegendColumns = 3;

std::string crossAt(double x, double y, const SeriesStyle& style, const std::string& tooltip) {
  return format(R"(<path class="unstable" d="M%.1f %.1fl9 9m0 -9l-9 9" fill="none" stroke="%s" )"
                R"(stroke-width="2.2">)",
                x - 4.5, y - 4.5, style.colour.c_str()) +
         "<title>" + escaped(tooltip) + "</title></path>\n";
}

/// One panel, drawn with its own corner as the origin.
class PanelDrawing {
 public:
  explicit PanelDrawing(const Panel& panel)
      : panel_(panel),
        x_(panel.xLines.empty() ? LogAxis(allX(), kLeft + kInset, kRight - kInset)
                                : LogAxis(kLeft + kInset, kRight - kInset, panel.xLines)),
        y_(allY(), kBottom, kTop, panel.floorY) {}

  std::string draw() {
    std::string svg = textAt(kLeft, 20.0, "start", kInk, 13.0, panel_.title) + frame();
    for (const double v : x_.lines()) places_.avoid(x_.at(v), kBottom + 16.0, 12.0);
    places_.avoidLine(kRight + 6.0, kTop, kRight + 6.0, kBottom);
    for (const PanelSeries& series : panel_.series) avoid(series);
    for (const PanelSeries& series : panel_.series) svg += lineThrough(series);
    std::string marks;
    for (const PanelSeries& series : panel_.series)
      marks = marksOf(series) + marks;  // the first series lies on top
    return svg + marks + labels_;
  }

 private:
  std::vector<double> allX() const {
    std::vector<double> all;
    for (const PanelSeries& series : panel_.series) {
      for (const PlotPoint& p : series.points) all.push_back(p.x);
      for (const PlotPoint& p : series.unstable) all.push_back(p.x);
    }
    return all;
  }
  std::vector<double> allY() const {
    std::vector<double> all;
    for (const PanelSeries& series : panel_.series)
      for (const PlotPoint& p : series.points) all.push_back(std::max(p.y, panel_.floorY));
    return all;
  }
  double atX(const PlotPoint& p) const { return x_.at(p.x); }
  double atY(const PlotPoint& p) const { return y_.at(std::max(p.y, panel_.floorY)); }

  std::string frame() const {
    std::string svg;
    if (panel_.unstableLane)
      svg += format(R"(<rect x="%.1f" y="%.1f" width="%.1f" height="%.1f" fill="#f6ece9"/>)", kLeft,
                    kLane - 8.0, kRight - kLeft, 16.0) +
             "\n" + textAt(kLeft - 8.0, kLane + 4.0, "end", "#b3261e", 11.0, "unstable");
    for (const double v : x_.lines())
      svg += lineFrom(x_.at(v), kTop, x_.at(v), kBottom, kGrid, 1.0) +
             textAt(x_.at(v), kBottom + 22.0, "middle", kQuiet, 11.0, axisNumber(v));
    for (const double v : y_.lines())
      svg += lineFrom(kLeft, y_.at(v), kRight, y_.at(v), kGrid, 1.0) +
             textAt(kLeft - 7.0, y_.at(v) + 4.0, "end", kQuiet, 11.0, axisNumber(v));
    svg += lineFrom(kLeft, kBottom, kRight, kBottom, kQuiet, 1.0) +
           lineFrom(kLeft, kTop, kLeft, kBottom, kQuiet, 1.0) +
           textAt(0.5 * (kLeft + kRight), kBottom + 42.0, "middle", kInk, 12.0, panel_.xLabel);
    return svg + format(R"svg(<g transform="translate(16 %.1f) rotate(-90)">)svg", 0.5 * (kTop + kBottom)) +
           textAt(0.0, 0.0, "middle", kInk, 12.0, panel_.yLabel) + "</g>\n";
  }

  void avoid(const PanelSeries& series) {
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const PlotPoint& p = series.points[i];
      places_.avoid(atX(p), atY(p), p.ringed ? 10.0 : 5.0);
      if (i > 0 && series.joined)
        places_.avoidLine(atX(series.points[i - 1]), atY(series.points[i - 1]), atX(p), atY(p));
    }
  }

  std::string lineThrough(const PanelSeries& series) const {
    if (!series.joined || series.points.size() < 2) return "";
    std::string path;
    for (const PlotPoint& p : series.points)
      path += format("%s%.1f %.1f", path.empty() ? "M" : "L", atX(p), atY(p));
    return R"(<path fill="none" stroke-width="1.6" stroke-opacity="0.45" stroke=")" + series.style.colour +
           (series.style.hollow ? "\" stroke-dasharray=\"5 4" : "") + "\" d=\"" + path + "\"/>\n";
  }

  std::string marksOf(const PanelSeries& series) {
    std::string svg;
    for (const PlotPoint& p : series.points) {
      const double px = atX(p), py = atY(p);
      if (p.y < panel_.floorY)
        svg += format(R"(<path class="below" d="M%.1f %.1fv9m-3 -3l3 3l3 -3" fill="none" stroke="%s"/>)", px,
                      py, series.style.colour.c_str()) +
               "\n";
      if (p.ringed)
        svg += format(R"(<circle cx="%.1f" cy="%.1f" r="9" fill="none" stroke="%s" stroke-width="1.5"/>)", px,
                      py, kInk) +
               "\n";
      svg += markerAt(px, py, series.style, p.tooltip, 0.8);
      if (!p.label.empty()) labels_ += places_.place(px, py, p.label);
    }
    for (const PlotPoint& p : series.unstable) svg += crossAt(atX(p), kLane, series.style, p.tooltip);
    return svg;
  }

  const Panel& panel_;
  LogAxis x_, y_;
  LabelPlaces places_;
  std::string labels_;
};

std::vector<SeriesStyle> stylesOf(const std::vector<Panel>& panels) {
  std::vector<SeriesStyle> styles;
  for (const Panel& panel : panels)
    for (const PanelSeries& series : panel.series)
      if (std::none_of(styles.begin(), styles.end(),
                       [&](const SeriesStyle& l) { return l.name == series.style.name; }))
        styles.push_back(series.style);
  return styles;
}

}  // namespace

std::string panelsSvg(const std::vector<Panel>& panels) {
  const std::vector<SeriesStyle> styles = stylesOf(panels);
  const double rows = std::ceil(0.5 * static_cast<double>(panels.size()));
  const double legendRows = std::ceil(static_cast<double>(styles.size()) / kLegendColumns);
  std::string label;
  for (const Panel& panel : panels) label += (label.empty() ? "" : "; ") + panel.title;
  std::string svg = begin(kPanelHeight * rows + kLegendRow * legendRows + 8.0, label);
  for (std::size_t i = 0; i < panels.size(); ++i)
    svg += format(R"svg(<g transform="translate(%.0f %.0f)">)svg", i % 2 == 0 ? 0.0 : kPanelWidth,
                  kPanelHeight * static_cast<double>(i / 2)) +
           "\n" + PanelDrawing(panels[i]).draw() + "</g>\n";
  for (std::size_t i = 0; i < styles.size(); ++i)
    svg += legend({styles[i]}, kLeft + kLegendColumn * static_cast<double>(i % kLegendColumns),
                  kPanelHeight * rows + 10.0 + kLegendRow * static_cast<double>(i / kLegendColumns));
  return svg + "</svg>\n";
}

}  // namespace tandem::client::report
