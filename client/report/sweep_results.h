#pragma once

// What a sweep found: each experiment with the measurements of its settings.

#include <string>
#include <vector>

#include "client/report/experiment.h"
#include "client/report/figures.h"
#include "client/report/link_measurement.h"
#include "client/report/measurement.h"
#include "client/report/part_measurement.h"
#include "client/report/stroke_sweep.h"

namespace tandem::client::report {

/// An experiment with the tool, and its measurements with each setting.
struct ExperimentResult {
  ExperimentInfo info;
  std::size_t triangles = 0, parts = 0, ticks = 0;
  double peakForce = 0.0;   // N, exact
  double facetError = 0.0;  // N: error from the depth and tilt of the facets alone; 0 = exact facets
  std::vector<Measurement> settings;
};

/// An experiment with a part in the hand, and its measurements with each setting.
struct PartExperimentResult {
  ExperimentInfo info;
  std::size_t triangles = 0, ticks = 0;
  double peakForce = 0.0;    // N, exact, of the judged ticks
  double targetDepth = 0.0;  // m, the project's target
  std::vector<PartMeasurement> settings;
};

/// The measurements of one setting over all pairs of a family that are pressed onto each other.
struct PressMeasurement {
  PartMeasurement figures;
  int beyond = 0;  // presses that went deeper than is asked
};

/// Pairs of irregular parts of one family, pressed onto each other, and the measurements with each setting.
struct PressResult {
  ExperimentInfo info;
  int presses = 0;
  std::size_t leastTriangles = 0, mostTriangles = 0;  // of a pair
  std::size_t ticks = 0;                              // of all presses
  double targetDepth = 0.0;                           // m, the project's target
  std::vector<PressMeasurement> settings;
};

/// Two sites that hold one part across a delay, and the measurements with each setting.
struct LinkExperimentResult {
  ExperimentInfo info;
  double delay = 0.0;  // s, one way
  int seeds = 1;
  std::vector<LinkMeasurement> settings;
};

struct SweepResult {
  bool quick = false;
  std::string machine;
  std::vector<ExperimentResult> experiments;
  std::vector<PartExperimentResult> held;
  std::vector<PressResult> presses;
  std::vector<StrokeResult> strokes;
  std::vector<LinkExperimentResult> links;
  std::vector<Figure> figures;     // empty where single experiments were asked for
  std::vector<std::string> peers;  // the libraries that were measured, with versions
};

}  // namespace tandem::client::report
