#include "client/base/rounded_json.h"

#include <cstdio>
#include <cstdlib>
#include <utility>

#include <nlohmann/json.hpp>

namespace tandem::client {

nlohmann::ordered_json rounded(nlohmann::ordered_json json) {
  if (json.is_structured()) {
    for (nlohmann::ordered_json& entry : json) entry = rounded(std::move(entry));
  } else if (json.is_number_float()) {
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", json.get<double>());
    json = std::strtod(text, nullptr);
  }
  return json;
}

}  // namespace tandem::client
