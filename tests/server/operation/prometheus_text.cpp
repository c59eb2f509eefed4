#include "tests/server/operation/prometheus_text.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

namespace tandem::test {
namespace {

using Labels = std::map<std::string, std::string>;

/// A double as it is written in the format, or NaN.
double number(const std::string& text) {
  static const std::regex form(R"([+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?)");
  if (text == "+Inf") return std::numeric_limits<double>::infinity();
  return std::regex_match(text, form) ? std::strtod(text.c_str(), nullptr)
                                      : std::numeric_limits<double>::quiet_NaN();
}

/// Reads `key="value",...}` from `at` on, which then lies behind the brace.
Status readLabels(const std::string& line, std::size_t& at, Labels& labels) {
  static const std::regex key(R"([a-zA-Z_][a-zA-Z0-9_]*)");
  for (;;) {
    const auto equals = line.find("=\"", at);
    if (equals == std::string::npos) return Error{"a label without a value"};
    const std::string name = line.substr(at, equals - at);
    if (!std::regex_match(name, key)) return Error{"no name of a label: " + name};
    std::string value;
    for (at = equals + 2; at < line.size() && line[at] != '"'; ++at) {
      if (line[at] != '\\') {
        value += line[at];
        continue;
      }
      const char escaped = ++at < line.size() ? line[at] : ' ';
      if (escaped != '\\' && escaped != '"' && escaped != 'n') return Error{"an unknown escape"};
      value += escaped == 'n' ? '\n' : escaped;
    }
    if (at + 1 >= line.size()) return Error{"labels without an end"};
    if (!labels.emplace(name, value).second) return Error{"a label twice: " + name};
    const char after = line[at + 1];
    at += 2;
    if (after == '}') return {};
    if (after != ',') return Error{"no comma between labels"};
  }
}

Result<PrometheusSample> readSample(const std::string& line) {
  static const std::regex name(R"([a-zA-Z_:][a-zA-Z0-9_:]*)");
  PrometheusSample sample;
  std::size_t at = line.find_first_of("{ ");
  if (at == std::string::npos) return Error{"a sample without a value"};
  sample.name = line.substr(0, at);
  if (!std::regex_match(sample.name, name)) return Error{"no name of a metric: " + sample.name};
  if (line[at] == '{')
    if (Status status = readLabels(line, ++at, sample.labels); !status) return status.error();
  if (at >= line.size() || line[at] != ' ') return Error{"no space before the value"};
  sample.value = number(line.substr(at + 1));
  if (std::isnan(sample.value)) return Error{"no value: " + line.substr(at + 1)};
  return sample;
}

Status checkHistogram(const std::string& name, const PrometheusFamily& family) {
  struct Series {
    double bound = -std::numeric_limits<double>::infinity(), below = 0.0;
    double sum = std::numeric_limits<double>::quiet_NaN(), count = sum;
  };
  std::map<Labels, Series> all;
  for (const PrometheusSample& sample : family.samples) {
    Labels labels = sample.labels;
    const bool bucket = sample.name == name + "_bucket";
    if (labels.contains("le") != bucket) return Error{"le belongs to the buckets: " + sample.name};
    const double bound = bucket ? number(labels["le"]) : 0.0;
    labels.erase("le");
    Series& series = all[labels];
    if (sample.name == name + "_sum") series.sum = sample.value;
    if (sample.name == name + "_count") series.count = sample.value;
    if (!bucket) continue;
    if (!(bound > series.bound)) return Error{"the bounds of " + name + " do not rise"};
    if (sample.value < series.below) return Error{"the counts of " + name + " fall"};
    series.bound = bound;
    series.below = sample.value;
  }
  for (const auto& [labels, series] : all) {
    if (!std::isinf(series.bound)) return Error{name + " has no bucket +Inf"};
    if (series.count != series.below) return Error{name + " has a _count that is not that of +Inf"};
    if (std::isnan(series.sum)) return Error{name + " has no _sum"};
  }
  return {};
}

Status check(const std::string& name, const PrometheusFamily& family) {
  std::set<std::pair<std::string, Labels>> seen;
  for (const PrometheusSample& sample : family.samples) {
    if (!seen.emplace(sample.name, sample.labels).second) return Error{"twice the same sample of " + name};
    if (family.type == "gauge") continue;
    if (!std::isfinite(sample.value) || sample.value < 0.0) return Error{name + " is no count"};
  }
  const bool total = name.ends_with("_total");
  if (total != (family.type == "counter")) return Error{name + ": counters end with _total, others do not"};
  return family.type == "histogram" ? checkHistogram(name, family) : Status{};
}

bool belongs(const std::string& sample, const std::string& name, const std::string& type) {
  if (type != "histogram") return sample == name;
  return sample == name + "_bucket" || sample == name + "_sum" || sample == name + "_count";
}

}  // namespace

Result<PrometheusText> PrometheusText::parse(const std::string& text) {
  if (text.empty() || text.back() != '\n') return Error{"the last line has no end"};
  static const std::regex comment(R"(# (HELP|TYPE) ([a-zA-Z_:][a-zA-Z0-9_:]*) (.+))");
  PrometheusText out;
  std::string name, line;
  for (std::istringstream lines(text); std::getline(lines, line);) {
    std::smatch words;
    if (line.starts_with('#')) {
      if (!std::regex_match(line, words, comment)) return Error{"neither HELP nor TYPE: " + line};
      if (words[1] == "HELP") {
        if (!name.empty() && out.families_[name].type.empty()) return Error{name + " has no TYPE"};
        name = words[2];
        if (!out.families_.emplace(name, PrometheusFamily{words[3], {}, {}}).second)
          return Error{name + " comes twice"};
        continue;
      }
      if (words[2] != name || !out.families_[name].type.empty()) return Error{"a TYPE out of place: " + line};
      if (words[3] != "counter" && words[3] != "gauge" && words[3] != "histogram")
        return Error{"no type: " + line};
      out.families_[name].type = words[3];
      continue;
    }
    const Result<PrometheusSample> sample = readSample(line);
    if (!sample) return Error{sample.error().message + ": " + line};
    if (name.empty() || !belongs(sample->name, name, out.families_[name].type))
      return Error{"a sample of no family: " + line};
    out.families_[name].samples.push_back(*sample);
  }
  for (const auto& [family, content] : out.families_)
    if (Status status = check(family, content); !status) return status.error();
  return out;
}

double PrometheusText::value(const std::string& name, const Labels& labels) const {
  for (const auto& [family, content] : families_)
    for (const PrometheusSample& sample : content.samples)
      if (sample.name == name && sample.labels == labels) return sample.value;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace tandem::test
