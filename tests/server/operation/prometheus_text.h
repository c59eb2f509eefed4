#pragma once

// A strict reader of the text format 0.0.4 of Prometheus
// (https://prometheus.io/docs/instrumenting/exposition_formats/): it refuses what a scraper would read and a
// careful writer does not write.
//
// 1. Lines end with a line feed. A family is its HELP, its TYPE and its samples together, and comes once.
// 2. Labels differ by name, samples by labels; values hold the escapes \\, \" and \n only; no time stamps.
// 3. A counter's name ends with _total, and it is finite and not negative.
// 4. A histogram has rising bounds, counts that do not fall, +Inf that equals _count, and a _sum.

#include <map>
#include <string>
#include <vector>

#include "assets/base/result.h"

namespace tandem::test {

struct PrometheusSample {
  std::string name;
  std::map<std::string, std::string> labels;
  double value = 0.0;
};

struct PrometheusFamily {
  std::string help, type;
  std::vector<PrometheusSample> samples;
};

class PrometheusText {
 public:
  static Result<PrometheusText> parse(const std::string& text);

  const std::map<std::string, PrometheusFamily>& families() const { return families_; }
  /// NaN if there is no such sample.
  double value(const std::string& name, const std::map<std::string, std::string>& labels = {}) const;

 private:
  std::map<std::string, PrometheusFamily> families_;
};

}  // namespace tandem::test
