#include "client/plot/svg_shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::client::report {

std::string format(const char* pattern, ...) {
  char text[640];
  va_list arguments;
  va_start(arguments, pattern);
  const int length = std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  ASSERT(length >= 0 && length < static_cast<int>(sizeof text));  // a shape that is cut off is no shape
  return std::string(text, static_cast<std::size_t>(length));
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

std::string markerAt(double x, double y, const SeriesStyle& style, const std::string& tooltip, double scale) {
  scale *= style.size;
  const double r = 5.0 * scale, side = 9.0 * scale, tip = 6.0 * scale;
  const std::string attributes =
      format(R"(fill="%s" stroke="%s" stroke-width="1.8")", style.hollow ? "#ffffff" : style.colour.c_str(),
             style.colour.c_str());
  std::string shape;
  if (style.marker == Marker::circle)
    shape = format(R"(<circle cx="%.1f" cy="%.1f" r="%.1f" %s>)", x, y, r, attributes.c_str());
  if (style.marker == Marker::square)
    shape = format(R"(<rect x="%.1f" y="%.1f" width="%.1f" height="%.1f" %s>)", x - 0.5 * side,
                   y - 0.5 * side, side, side, attributes.c_str());
  if (style.marker == Marker::diamond)
    shape = format(R"(<path d="M%.1f %.1fl%.1f %.1fl%.1f %.1fl%.1f %.1fz" %s>)", x, y - tip, tip, tip, -tip,
                   tip, -tip, -tip, attributes.c_str());
  if (style.marker == Marker::triangle)
    shape = format(R"(<path d="M%.1f %.1fl%.1f %.1fh%.1fz" %s>)", x, y - tip, tip, 1.7 * tip, -2.0 * tip,
                   attributes.c_str());
  const char* end = style.marker == Marker::circle   ? "</circle>"
                    : style.marker == Marker::square ? "</rect>"
                                                     : "</path>";
  return shape + "<title>" + escaped(tooltip) + "</title>" + end + "\n";
}

LogAxis::LogAxis(const std::vector<double>& values, double from, double to, double floor)
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
  span();
}

LogAxis::LogAxis(double from, double to, std::vector<double> lines)
    : from_(from), to_(to), lines_(std::move(lines)) {
  ASSERT(!lines_.empty() && std::is_sorted(lines_.begin(), lines_.end()) && lines_.front() > 0.0);
  span();
}

void LogAxis::span() {
  ASSERT(from_ != to_ && !lines_.empty());
  low_ = std::log10(lines_.front());
  high_ = std::log10(lines_.back());
  if (lines_.size() == 1) low_ -= 0.5, high_ += 0.5;  // a single line lies in the middle
}

double LogAxis::at(double value) const {
  const double share = (std::log10(std::max(value, 1e-300)) - low_) / (high_ - low_);
  return from_ + (to_ - from_) * std::clamp(share, 0.0, 1.0);
}

std::string axisNumber(double value, bool powers) {
  ASSERT(value > 0.0);
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

std::string legend(const std::vector<SeriesStyle>& styles, double x, double y) {
  std::string svg;
  for (std::size_t i = 0; i < styles.size(); ++i) {
    const double row = y + 21.0 * static_cast<double>(i);
    svg += markerAt(x, row, styles[i], styles[i].name) +
           textAt(x + 13.0, row + 4.0, "start", kInk, 12.0, styles[i].name);
  }
  return svg;
}

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
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

}  // namespace tandem::client::report
