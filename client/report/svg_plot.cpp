#include "client/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace tandem::client::report {
namespace {

constexpr double kWidth = 900.0;
constexpr double kAsExact = 0.01;  // what is more exact by less does not lie on the front
constexpr const char* kInk = "#33404d";
constexpr const char* kQuiet = "#6b7785";
constexpr const char* kGrid = "#e3e8ed";

__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...) {
  char text[640];
  va_list arguments;
  va_start(arguments, pattern);
  const int length = std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return std::string(text,
                     static_cast<std::size_t>(std::clamp(length, 0, static_cast<int>(sizeof text) - 1)));
}

std::string textAt(double x, double y, const char* anchor, const char* colour, double size,
                   const std::string& text) {
  return format(R"(<text x="%.1f" y="%.1f" text-anchor="%s" fill="%s" font-size="%.0f">)", x, y, anchor,
                colour, size) +
         escaped(text) + "</text>\n";
}

std::string lineFrom(double x0, double y0, double x1, double y1, const std::string& colour, double width) {
  return format(R"(<line x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f" stroke="%s" stroke-width="%.1f"/>)", x0, y0,
                x1, y1, colour.c_str(), width) +
         "\n";
}

std::string markerAt(double x, double y, const Look& look, const std::string& tooltip, double scale = 1.0) {
  scale *= look.size;
  const double r = 5.0 * scale, side = 9.0 * scale, tip = 6.0 * scale;
  const std::string style = format(R"(fill="%s" stroke="%s" stroke-width="1.8")",
                                   look.hollow ? "#ffffff" : look.colour.c_str(), look.colour.c_str());
  std::string shape;
  if (look.marker == Marker::circle)
    shape = format(R"(<circle cx="%.1f" cy="%.1f" r="%.1f" %s>)", x, y, r, style.c_str());
  if (look.marker == Marker::square)
    shape = format(R"(<rect x="%.1f" y="%.1f" width="%.1f" height="%.1f" %s>)", x - 0.5 * side,
                   y - 0.5 * side, side, side, style.c_str());
  if (look.marker == Marker::diamond)
    shape = format(R"(<path d="M%.1f %.1fl%.1f %.1fl%.1f %.1fl%.1f %.1fz" %s>)", x, y - tip, tip, tip, -tip,
                   tip, -tip, -tip, style.c_str());
  if (look.marker == Marker::triangle)
    shape = format(R"(<path d="M%.1f %.1fl%.1f %.1fh%.1fz" %s>)", x, y - tip, tip, 1.7 * tip, -2.0 * tip,
                   style.c_str());
  const char* end = look.marker == Marker::circle   ? "</circle>"
                    : look.marker == Marker::square ? "</rect>"
                                                    : "</path>";
  return shape + "<title>" + escaped(tooltip) + "</title>" + end + "\n";
}

/// A logarithmic axis around some positive values, with lines at 1, 2, 5 or at powers of ten.
class LogAxis {
 public:
  /// Nothing is drawn below `floor`.
  LogAxis(const std::vector<double>& values, double from, double to, double floor = 0.0)
      : from_(from), to_(to) {
    double low = 1e300, high = 0.0;
    for (const double v : values) {
      if (!(v > 0.0) || !std::isfinite(v)) continue;
      low = std::min(low, v);
      high = std::max(high, v);
    }
    if (!(high > 0.0)) low = high = 1.0;
    const bool wide = high / low > 300.0;
    for (double e = std::floor(std::log10(low)) - 1.0; e <= std::ceil(std::log10(high)) + 1.0; ++e)
      for (const double digit : {1.0, 2.0, 5.0})
        if (!wide || digit == 1.0) lines_.push_back(digit * std::pow(10.0, e));
    while (lines_.size() > 2 && lines_[1] < 0.9 * low) lines_.erase(lines_.begin());
    while (lines_.size() > 2 && lines_[0] < 0.9 * floor) lines_.erase(lines_.begin());
    while (lines_.size() > 2 && lines_[lines_.size() - 2] > 1.1 * high) lines_.pop_back();
    low_ = std::log10(lines_.front());
    high_ = std::log10(lines_.back());
  }

  double at(double value) const {
    const double share = (std::log10(std::max(value, 1e-300)) - low_) / (high_ - low_);
    return from_ + (to_ - from_) * std::clamp(share, 0.0, 1.0);
  }
  const std::vector<double>& lines() const { return lines_; }

 private:
  double from_, to_, low_ = 0.0, high_ = 1.0;
  std::vector<double> lines_;
};

/// Finds places for labels beside their points: clear of every marker and of each other, where there is room.
class LabelPlaces {
 public:
  void avoid(double x, double y, double half = 6.0) {
    taken_.push_back({x - half, y - half, x + half, y + half});
  }
  /// Keeps off a line, less strictly than off a marker: small boxes along it.
  void avoidLine(double x0, double y0, double x1, double y1) {
    const int pieces = 1 + static_cast<int>(std::hypot(x1 - x0, y1 - y0) / 4.0);
    for (int i = 1; i < pieces; ++i) {
      const double s = static_cast<double>(i) / pieces;
      avoid(x0 + s * (x1 - x0), y0 + s * (y1 - y0), 1.5);
    }
  }

  /// The label's text element.
  std::string place(double x, double y, const std::string& text) {
    const double width = 6.4 * static_cast<double>(text.size()), height = 12.0;
    Box best{};
    double least = 1e300;
    for (const double away : {9.0, 20.0, 31.0}) {
      for (const auto& [right, down] : {std::pair{0.0, -1.0},
                                        {0.0, 1.0},
                                        {1.0, 0.0},
                                        {-1.0, 0.0},
                                        {0.8, -0.8},
                                        {-0.8, -0.8},
                                        {0.8, 0.8},
                                        {-0.8, 0.8}}) {
        const double cx = x + right * (away + 0.5 * width), cy = y + down * (away + 0.4 * height);
        const Box box{cx - 0.5 * width, cy - 0.5 * height, cx + 0.5 * width, cy + 0.5 * height};
        double covered = 0.1 * away;
        for (const Box& other : taken_) covered += overlap(box, other);
        if (covered < least) best = box, least = covered;
      }
    }
    taken_.push_back(best);
    return textAt(0.5 * (best.left + best.right), best.bottom - 2.0, "middle", kInk, 11.0, text);
  }

 private:
  struct Box {
    double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;
  };
  static double overlap(const Box& a, const Box& b) {
    const double w = std::min(a.right, b.right) - std::max(a.left, b.left);
    const double h = std::min(a.bottom, b.bottom) - std::max(a.top, b.top);
    return w > 0.0 && h > 0.0 ? w * h : 0.0;
  }
  std::vector<Box> taken_;
};

/// A number of an axis: plain where it is short, else as a power of ten; `powers`: an axis that needs those.
std::string axisNumber(double value, bool powers = false) {
  if (powers ? value > 0.9 && value < 11.0 : value > 0.9e-3 && value < 1.1e5)
    return format(value < 999.0 ? "%.3g" : "%.0f", value);
  const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  const double exponent = std::floor(std::log10(value) + 1e-9), lead = value / std::pow(10.0, exponent);
  std::string text = lead > 1.5 ? format("%.0f·10", lead) : "10";
  if (exponent < 0.0) text += "⁻";
  for (const char c : format("%.0f", std::abs(exponent))) text += digits[c - '0'];
  return text;
}

std::string begin(double height, const std::string& label) {
  return format(R"(<svg viewBox="0 0 %.0f %.0f" role="img" xmlns="http://www.w3.org/2000/svg" )", kWidth,
                height) +
         R"(font-family="system-ui, 'DejaVu Sans', sans-serif" aria-label=")" + escaped(label) + "\">\n";
}

std::string legend(const std::vector<Look>& looks, double x, double y) {
  std::string svg;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const double row = y + 21.0 * static_cast<double>(i);
    svg += markerAt(x, row, looks[i], looks[i].name) +
           textAt(x + 13.0, row + 4.0, "start", kInk, 12.0, looks[i].name);
  }
  return svg;
}

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

/// From each point on: the least error at that cost or less.
std::string frontOf(const ScatterPlot& plot, const LogAxis& x, const LogAxis& y, double right) {
  std::string way;
  double before = 0.0;
  for (const PlotPoint& p : plot.front) {
    const double px = x.at(p.x), py = y.at(std::max(p.y, plot.floorY));
    way += way.empty() ? format("M%.1f %.1f", px, py) : format("L%.1f %.1fL%.1f %.1f", px, before, px, py);
    before = py;
  }
  if (way.empty()) return "";
  return "<path class=\"front\" fill=\"none\" stroke-width=\"1.4\" stroke-dasharray=\"5 4\" stroke=\"" +
         std::string(kInk) + "\" d=\"" + way + format("L%.1f %.1f", right, before) + "\"/>\n";
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

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
  std::vector<Look> looks;
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
    looks.push_back(series.look);
    std::string way, own;
    for (const PlotPoint& p : series.points) {
      const double px = x.at(p.x), py = y.at(std::max(p.y, plot.floorY));
      way += format("%s%.1f %.1f", way.empty() ? "M" : "L", px, py);
      if (p.y <= plot.floorY)  // less than can be shown: an arrow down from where it is drawn
        own +=
            format(R"(<path class="below" d="M%.1f %.1fv12m-3.5 -4l3.5 4l3.5 -4" fill="none" stroke="%s" )",
                   px, py, series.look.colour.c_str()) +
            "stroke-width=\"1.6\"/>\n";
      if (p.ringed)
        own += format(R"(<circle cx="%.1f" cy="%.1f" r="10" fill="none" stroke="%s" stroke-width="1.6"/>)",
                      px, py, kInk) +
               "\n";
      own += markerAt(px, py, series.look, p.tooltip);
      if (!p.label.empty()) labels += places.place(px, py, p.label);
    }
    marks = own + marks;  // the first series lies on top
    if (series.joined && series.points.size() > 1)
      svg += R"(<path fill="none" stroke-width="1.2" stroke-opacity="0.35" stroke=")" + series.look.colour +
             "\" d=\"" + way + "\"/>\n";
  }
  svg += frontOf(plot, x, y, right);
  const double rows = 21.0 * static_cast<double>(looks.size());
  labels += legend(looks, right + 32.0, top + 14.0);
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
  std::vector<Look> looks;
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
      const Look& look = mark.look;
      marks += format(
          R"(<line x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f" stroke="%s" stroke-width="3" stroke-linecap="round" stroke-opacity="0.5"/>)",
          x.at(mark.low), y, x.at(mark.high), y, look.colour.c_str());
      marks += markerAt(x.at(mark.low), y, look, mark.tooltip, 0.75);
      y += 0.5 * perMark;
      if (std::none_of(looks.begin(), looks.end(), [&](const Look& l) { return l.name == look.name; }))
        looks.push_back(look);
    }
    y += 0.5 * between;
    svg += lineFrom(left, y, right, y, kGrid, 1.0);
  }
  svg += textAt(0.5 * (left + right), height + 44.0, "middle", kInk, 13.0, plot.xLabel);
  return svg + marks + legend(looks, right + 32.0, top + 14.0) + "</svg>\n";
}

std::string barsSvg(const std::vector<Bar>& bars) {
  const double left = 280.0, right = 790.0, row = 24.0;
  double most = 0.0;
  for (const Bar& bar : bars) most = std::max(most, bar.length);
  std::string svg = begin(row * static_cast<double>(bars.size()) + 12.0, "bars");
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const double y = 6.0 + row * static_cast<double>(i);
    const double length = most > 0.0 ? (right - left) * bars[i].length / most : 0.0;
    svg += textAt(left - 14.0, y + 16.0, "end", kInk, 12.0, bars[i].name);
    svg += format(R"(<rect x="%.1f" y="%.1f" width="%.1f" height="15" fill="%s"/>)", left, y + 4.0,
                  std::max(length, 1.0), bars[i].colour.c_str()) +
           "\n" + textAt(left + length + 8.0, y + 16.0, "start", kQuiet, 12.0, bars[i].value);
  }
  return svg + "</svg>\n";
}

}  // namespace tandem::client::report
