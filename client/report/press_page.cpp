#include "client/report/press_page.h"

#include <algorithm>
#include <iterator>

#include "client/plot/panel_plot.h"
#include "client/plot/svg_plot.h"
#include "client/plot/words.h"
#include "client/report/targets.h"

namespace tandem::client::report {
namespace {

constexpr double kShownDepth = 1e-2, kShownForce = 1e-4;  // um, N: the floors of the axes

SeriesStyle familyStyle(const PressResult& e, const PressResult& first, bool samplesAlone) {
  static const char* const kColours[] = {"#0b6e99", "#c9730b", "#8a2f6b"};
  const auto index = static_cast<std::size_t>(&e - &first) % std::size(kColours);
  return {e.info.title + (samplesAlone ? ", at the samples alone" : ""), kColours[index],
          samplesAlone ? Marker::square : Marker::circle, samplesAlone, 1.0};
}

std::string pressTooltip(const PressResult& e, const PartMeasurement& m) {
  return e.info.title + ", " + m.name + ": " + microseconds(m.cost.p50) + " p50, " +
         microseconds(m.cost.p99) + " p99; penetration " + metres(m.depth.max) + "; change of force " +
         newtons(m.forceChange.p99) + " p99, " + newtons(m.forceChange.max) + " at most";
}

/// The settings that differ in the density of samples alone, from dense to sparse.
std::vector<const PartMeasurement*> byDensity(const std::vector<const PartMeasurement*>& settings) {
  std::vector<const PartMeasurement*> chosen;
  for (const PartMeasurement* m : settings)
    if (m->kind == Kind::tandem && m->fieldScale == 1.0 && usualIterations(m->effort) && m->effort.exact &&
        m->effort.descend)
      chosen.push_back(m);
  std::sort(chosen.begin(), chosen.end(),
            [](const auto* a, const auto* b) { return a->sampleScale < b->sampleScale; });
  return chosen;
}

std::vector<const PartMeasurement*> measurementsOf(const PressResult& e) {
  std::vector<const PartMeasurement*> all;
  for (const PressMeasurement& m : e.settings) all.push_back(&m.figures);
  return all;
}

std::vector<const PartMeasurement*> measurementsOf(const PartExperimentResult& e) {
  std::vector<const PartMeasurement*> all;
  for (const PartMeasurement& m : e.settings) all.push_back(&m);
  return all;
}

/// Cost against a figure: a line a family from dense to sparse samples, and what the samples alone give.
template <typename FigureOf>
std::string pressPlot(const std::vector<PressResult>& presses, const std::string& yLabel, double floor,
                      FigureOf figureOf) {
  ScatterPlot plot;
  plot.xLabel = "cost of a tick, 99th percentile, µs";
  plot.yLabel = yLabel;
  plot.floorY = floor;
  for (const PressResult& e : presses) {
    PlotSeries line{familyStyle(e, presses.front(), false), {}, true};
    for (const PartMeasurement* m : byDensity(measurementsOf(e)))
      line.points.push_back({m->cost.p99, figureOf(*m),
                             m->sampleScale == 1.0 ? "as used" : "s" + number(m->sampleScale),
                             pressTooltip(e, *m), m->sampleScale == 1.0});
    plot.series.push_back(std::move(line));
    PlotSeries alone{familyStyle(e, presses.front(), true), {}, false};
    for (const PartMeasurement* m : measurementsOf(e))
      if (!m->effort.descend)
        alone.points.push_back({m->cost.p99, figureOf(*m), "", pressTooltip(e, *m), false});
    plot.series.push_back(std::move(alone));
  }
  return "<figure>" + scatterSvg(plot) + "</figure>\n";
}

std::string pressTable(const PressResult& e) {
  std::string html = "<h3>" + escaped(e.info.title) + "</h3>\n<p class=\"quiet\">" + escaped(e.info.about) +
                     " " + std::to_string(e.presses) + " presses of pairs of " +
                     std::to_string(e.leastTriangles) + " to " + std::to_string(e.mostTriangles) +
                     " triangles, " + std::to_string(e.ticks) +
                     " ticks.</p>\n<div class=\"wide\"><table><thead><tr><th>setting</th><th>samples</th>"
                     "<th>cost p50</th><th>p99</th><th>max</th><th>penetration<br>p50</th><th>p99</th>"
                     "<th>max</th><th>presses<br>beyond " +
                     metres(e.targetDepth) +
                     "</th><th>change of<br>force p99</th><th>max</th><th>heap use</th></tr></thead>"
                     "<tbody>\n";
  for (const PressMeasurement& press : e.settings) {
    const PartMeasurement& m = press.figures;
    html += std::string("<tr class=\"") + (m.setting == "tandem" ? "tandem" : "other") + "\"><td>" +
            escaped(m.setting == "tandem" ? "Tandem, as used" : m.name) + "</td>";
    for (const std::string& cell :
         {"x " + number(m.sampleScale), microseconds(m.cost.p50), microseconds(m.cost.p99),
          microseconds(m.cost.max), metres(m.depth.p50), metres(m.depth.p99), metres(m.depth.max),
          std::to_string(press.beyond), newtons(m.forceChange.p99), newtons(m.forceChange.max),
          m.allocationsCounted ? std::to_string(m.allocations) : std::string("–")})
      html += "<td>" + cell + "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

/// A scene with a part in the hand, for the plots of all of them.
struct HeldScene {
  SeriesStyle style;
  std::vector<const PartMeasurement*> settings;  // byDensity()
  const PartMeasurement* used = nullptr;
};

template <typename Result>
void addScene(const Result& e, Marker marker, std::vector<HeldScene>& scenes) {
  static const char* const kColours[] = {"#06384f", "#0b6e99", "#69b3d3", "#4f7d3a",
                                         "#c9730b", "#ab3545", "#8a2f6b"};
  HeldScene& scene = scenes.emplace_back();
  scene.style = {e.info.title, kColours[(scenes.size() - 1) % std::size(kColours)], marker, false, 0.8};
  scene.settings = byDensity(measurementsOf(e));
  for (const PartMeasurement* m : scene.settings)
    if (m->sampleScale == 1.0) scene.used = m;
}

std::vector<HeldScene> scenesOf(const SweepResult& result) {
  std::vector<HeldScene> scenes;
  for (const PartExperimentResult& e : result.held) addScene(e, Marker::circle, scenes);
  for (const PressResult& e : result.presses) addScene(e, Marker::triangle, scenes);
  return scenes;
}

template <typename FigureOf>
Panel densityPanel(const std::vector<HeldScene>& scenes, const char* title, const char* yLabel, double floor,
                   FigureOf figureOf) {
  Panel panel{title, "spacing of the samples, of that in use", yLabel, floor, {0.5, 1.0, 2.0, 4.0}, {},
              false};
  for (const HeldScene& scene : scenes) {
    PanelSeries line{scene.style, {}, {}, true};
    for (const PartMeasurement* m : scene.settings)
      line.points.push_back({m->sampleScale, figureOf(*m), "",
                             scene.style.name + ", " + m->name + ": " + microseconds(m->cost.p50) + " p50, " +
                                 microseconds(m->cost.p99) + " p99; penetration " + metres(m->depth.max)});
    panel.series.push_back(std::move(line));
  }
  return panel;
}

Panel rowsPanel(const std::vector<HeldScene>& scenes, const char* title, const char* xLabel,
                std::vector<ManifoldBin> PartMeasurement::*bins) {
  Panel panel{title, xLabel, "cost of a tick, median, µs", 1e-1, {}, {}, false};
  for (const HeldScene& scene : scenes) {
    if (scene.used == nullptr) continue;
    PanelSeries line{scene.style, {}, {}, true};
    for (const ManifoldBin& bin : scene.used->*bins)
      line.points.push_back({bin.rows, bin.p50, "",
                             scene.style.name + ", " + number(bin.rows) + " rows: " + microseconds(bin.p50) +
                                 " p50, " + microseconds(bin.p99) + " p99, " + std::to_string(bin.ticks) +
                                 " ticks"});
    panel.series.push_back(std::move(line));
  }
  return panel;
}

}  // namespace

std::string pressSection(const SweepResult& result) {
  if (result.presses.empty()) return "";
  std::string html =
      "<h2>Irregular parts, pressed</h2>\n<p>Solids with facets of many sizes, made from seeds, as no test "
      "fixture is: one is led 2 mm into another in a random pose, and 10 mm aside while it turns, below 40 "
      "mm/s. No exact force is known. What can be said is how deep the parts are in each other, measured "
      "apart from fields and samples, and by how much the force changes in a tick. Along a line the samples "
      "become sparser (s4: four times as far apart as they are used); squares are the control, at the "
      "samples "
      "alone: no sample goes to the deepest place near it.</p>\n" +
      pressPlot(result.presses, "penetration, largest, µm", kShownDepth,
                [](const PartMeasurement& m) { return 1e6 * m.depth.max; }) +
      pressPlot(result.presses, "change of force a tick, 99th percentile, N", kShownForce,
                [](const PartMeasurement& m) { return m.forceChange.p99; }) +
      "<details><summary>All figures</summary>\n";
  for (const PressResult& e : result.presses) html += pressTable(e);
  return html + "</details>\n";
}

std::string manifoldSection(const SweepResult& result) {
  const std::vector<HeldScene> scenes = scenesOf(result);
  if (scenes.empty()) return "";
  return "<h2>What a held part's tick costs</h2>\n<p>Against the density of contact samples, with fields as "
         "they are used; and, as it is used, against the rows that push at the end of a tick and those that "
         "it measured or made active on the way, in all its steps. Each mark is the median of the ticks with "
         "about as many rows; ticks without any are left out.</p>\n<figure>" +
         panelsSvg({densityPanel(scenes, "cost", "cost of a tick, 99th percentile, µs", 1e-1,
                                 [](const PartMeasurement& m) { return m.cost.p99; }),
                    densityPanel(scenes, "penetration", "penetration, largest, µm", kShownDepth,
                                 [](const PartMeasurement& m) { return 1e6 * m.depth.max; }),
                    rowsPanel(scenes, "rows that push", "rows that push at the end of the tick",
                              &PartMeasurement::active),
                    rowsPanel(scenes, "rows solved", "rows measured or made active in the tick",
                              &PartMeasurement::solved)}) +
         "</figure>\n";
}

void pressBounds(const PressResult& e, std::vector<Bound>& bounds, bool& counted, double& allocations) {
  for (const PressMeasurement& press : e.settings) {
    const PartMeasurement& m = press.figures;
    if (m.allocationsCounted) {
      counted = true;
      allocations += static_cast<double>(m.allocations);
    }
    if (m.setting != "tandem") continue;
    const std::string name = e.info.title + ", pressed";
    bounds.push_back({name + ": tick p99", "µs", m.cost.p99, kHeldPartTarget.p99});
    bounds.push_back({name + ": longest tick", "ms", 1e-3 * m.cost.max, kHeldPartLongest_ms});
    bounds.push_back({name + ": penetration, largest", "µm", 1e6 * m.depth.max, 1e6 * e.targetDepth});
    bounds.push_back({name + ": change of force a tick, p99", "N", m.forceChange.p99, kForceStepTarget});
    bounds.push_back({name + ": change of force a tick, largest", "N", m.forceChange.max, kForceStepLargest});
  }
}

}  // namespace tandem::client::report
