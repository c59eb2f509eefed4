#pragma once

// A server's figures in the text format 0.0.4 of Prometheus
// (https://prometheus.io/docs/instrumenting/exposition_formats/).

#include <string>

#include "server/duration_histogram.h"
#include "server/session_figures.h"

namespace tandem::server {

struct ServerFigures {
  SessionFigures session;
  DurationHistogram rounds;  // of the loop, its wait left out
};

std::string metricsText(const ServerFigures& figures);

}  // namespace tandem::server
