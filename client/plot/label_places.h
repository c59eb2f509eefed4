#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "client/plot/svg_shapes.h"

namespace tandem::client::report {

/// Finds places for labels beside their points: clear of every marker and of each other, where there is room.
class LabelPlaces {
 public:
  void avoid(double x, double y, double half = 6.0) {
    taken_.push_back({x - half, y - half, x + half, y + half});
  }
  /// Keeps labels off a line, less strictly than off a marker, by small boxes along it.
  void avoidLine(double x0, double y0, double x1, double y1) {
    const int pieces = 1 + static_cast<int>(std::hypot(x1 - x0, y1 - y0) / 4.0);
    for (int i = 1; i < pieces; ++i) {
      const double s = static_cast<double>(i) / pieces;
      avoid(x0 + s * (x1 - x0), y0 + s * (y1 - y0), 1.5);
    }
  }

  /// Places a label beside the point and returns its text element.
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

}  // namespace tandem::client::report
