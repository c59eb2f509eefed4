#pragma once

// How benches report: percentiles of many measurements, a yardstick measured in the same run, and the
// machine. Timings are never a test's pass or fail on their own; a ratio to the yardstick says more than
// microseconds on one machine.

#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "assets/base/percentiles.h"

namespace tandem::bench {

using tandem::Percentiles;
using tandem::percentiles;

/// Processor, cores and load, in one line: figures mean nothing without it.
inline std::string machineLine() {
  std::string model = "unknown processor", line;
  std::ifstream info("/proc/cpuinfo");
  while (std::getline(info, line)) {
    if (line.rfind("model name", 0) != 0) continue;
    model = line.substr(line.find(':') + 2);
    break;
  }
  std::string load;
  std::ifstream("/proc/loadavg") >> load;
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores, load " + load;
}

/// Seconds between construction and seconds().
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Collects lines for the terminal and fields for --json.
class Report {
 public:
  explicit Report(const std::string& name) {
    std::printf("%s on %s\n", name.c_str(), machineLine().c_str());
    field("bench", quoted(name));
    field("machine", quoted(machineLine()));
  }

  void row(const std::string& name, const std::string& unit, const Percentiles& p) {
    std::printf("  %-34s p50 %9.3f  p99 %9.3f  p99.9 %9.3f  max %9.3f %s\n", name.c_str(), p.p50, p.p99,
                p.p999, p.max, unit.c_str());
    char text[160];
    std::snprintf(text, sizeof text, R"({"p50":%.6g,"p99":%.6g,"p999":%.6g,"max":%.6g,"unit":"%s"})", p.p50,
                  p.p99, p.p999, p.max, unit.c_str());
    field(name, text);
  }

  void value(const std::string& name, const std::string& unit, double x) {
    std::printf("  %-34s %13.4g %s\n", name.c_str(), x, unit.c_str());
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", x);
    field(name, text);
  }

  /// A bound that the project has set itself, met or not.
  bool bound(const std::string& name, double x, double atMost) {
    std::printf("  %-34s %13.4g <= %g: %s\n", name.c_str(), x, atMost, x <= atMost ? "met" : "NOT MET");
    char text[80];
    std::snprintf(text, sizeof text, R"({"value":%.6g,"at_most":%.6g,"met":%s})", x, atMost,
                  x <= atMost ? "true" : "false");
    field(name, text);
    return x <= atMost;
  }

  /// Writes all fields as one JSON object; false if the file cannot be written.
  bool writeJson(const std::string& path) const {
    std::ofstream out(path);
    out << "{";
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      out << (i > 0 ? "," : "") << "\n  " << quoted(fields_[i].first) << ": " << fields_[i].second;
    }
    out << "\n}\n";
    return out.good();
  }

 private:
  static std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
    return out + "\"";
  }
  void field(const std::string& name, const std::string& json) { fields_.emplace_back(name, json); }

  std::vector<std::pair<std::string, std::string>> fields_;
};

}  // namespace tandem::bench
