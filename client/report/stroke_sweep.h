#pragma once

// Random strokes of a point through models that a user names: how many go where a ball of 2^-20 of a part's
// coordinates could not follow, and what a tick costs.

#include <memory>
#include <string>
#include <vector>

#include "assets/scene/scene.h"
#include "client/report/measurement.h"

namespace tandem::client::report {

/// A model by the name that the page shows.
struct StrokedModel {
  std::string name;
  std::shared_ptr<const assets::Scene> scene;
};

/// One setting of the point.
struct StrokeMeasurement {
  std::string setting;  // "tandem", or "bare": the control, a point without a least radius
  std::string name;     // for people
  int fallen = 0;       // strokes that went where the ball does not
  int inside = 0;       // strokes of which a leg ended inside a part, by its winding number
  Cost cost;            // of a tick
};

/// One model with all settings.
struct StrokeResult {
  std::string model;
  std::size_t triangles = 0, parts = 0;
  int strokes = 0;
  std::size_t ticks = 0;
  std::vector<StrokeMeasurement> settings;
};

/// The same strokes for every setting and on every machine. They begin outside, end anywhere within, and
/// come back out. Time grows with the triangles that they come near.
StrokeResult sweepStrokes(const StrokedModel& model, int strokes, int runs);

}  // namespace tandem::client::report
