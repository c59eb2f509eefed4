#include "client/report/measurement_json.h"
#include "assets/base/json.h"

#include <cmath>
#include <string>

namespace tandem::client::report {

Json numberJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

const char* nameOf(Kind kind) {
  switch (kind) {
    case Kind::tandem:
      return "tandem";
    case Kind::baseline:
      return "baseline";
    case Kind::peer:
      return "peer";
  }
  return "tandem";
}

void putCost(Json& setting, const Cost& cost) {
  setting["cost_us"] = {{"p50", numberJson(cost.p50)},
                        {"p99", numberJson(cost.p99)},
                        {"max", numberJson(cost.max)},
                        {"p99_single_run", numberJson(cost.p99Single)}};
}

void putError(Json& setting, const ForceError& error) {
  setting["error_n"] = {
      {"rms", numberJson(error.rms)}, {"p99", numberJson(error.p99)}, {"max", numberJson(error.max)}};
  setting["error_share"] = {{"rms", numberJson(error.relativeRms)},
                            {"p99", numberJson(error.relativeP99)},
                            {"max", numberJson(error.relativeMax)}};
}

double measure(const Json& object, const char* key) {
  const double value = object.at(key).number();
  if (!std::isfinite(value) || value < 0.0) throw JsonError(std::string(key) + " is not a measure");
  return value;
}

Cost costFrom(const Json& setting) {
  const Json& cost = setting.at("cost_us");
  return {measure(cost, "p50"), measure(cost, "p99"), measure(cost, "max"), measure(cost, "p99_single_run")};
}

ForceError errorFrom(const Json& setting) {
  const Json &error = setting.at("error_n"), &share = setting.at("error_share");
  return {measure(error, "rms"), measure(error, "p99"), measure(error, "max"),
          measure(share, "rms"), measure(share, "p99"), measure(share, "max")};
}

}  // namespace tandem::client::report
