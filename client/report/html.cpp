#include "client/report/html.h"

#include <algorithm>
#include <map>

#include "assets/base/assert.h"
#include "client/plot/svg_plot.h"
#include "client/plot/words.h"
#include "client/report/link_page.h"
#include "client/report/part_page.h"
#include "client/report/press_page.h"
#include "client/report/stroke_page.h"
#include "client/report/targets.h"

namespace tandem::client::report {
namespace {

constexpr double kRounding_n = 1e-6;  // N

const char* const kStyle = R"(<style>
:root{color-scheme:light}
body{margin:0;background:#fafbfc;color:#26313c;font:16px/1.55 system-ui,"DejaVu Sans",sans-serif}
main{max-width:960px;margin:0 auto;padding:40px 24px 80px}
h1{font-size:30px;line-height:1.2;margin:0 0 6px;font-weight:650}
h2{font-size:21px;margin:52px 0 8px;font-weight:650}
h3{font-size:15px;margin:26px 0 6px;font-weight:600}
p{margin:8px 0;max-width:74ch}
.quiet{color:#6b7785;font-size:14px}
figure{margin:16px 0 6px;padding:16px;background:#fff;border:1px solid #e3e8ed;border-radius:8px}
svg{display:block;width:100%;height:auto}
.wide{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:13.5px;font-variant-numeric:tabular-nums;background:#fff}
th,td{padding:5px 9px;border-bottom:1px solid #e8ecf0;text-align:right;white-space:nowrap}
th{font-weight:600;color:#55616e;vertical-align:bottom}
th:first-child,td:first-child{text-align:left;white-space:normal}
tr.tandem td:first-child{font-weight:600}
.met{color:#1f7a4d}.missed{color:#b3261e;font-weight:600}
details{margin:8px 0}summary{cursor:pointer;color:#2b5f8a}
</style>
)";

SeriesStyle styleOf(const Measurement& m) {
  static const std::map<std::string, SeriesStyle> kKnown = {
      {"tandem", {"", "#0b6e99", Marker::circle, false}},
      {"shading", {"", "#3d5a99", Marker::circle, false}},
      {"no-memory", {"", "#69b3d3", Marker::circle, false}},
      {"float-data", {"", "#0b6e99", Marker::circle, true}},
      {"three-planes-double", {"", "#c9730b", Marker::square, false}},
      {"three-planes-float", {"", "#c9730b", Marker::square, true}},
      {"one-plane-double", {"", "#ab3545", Marker::square, false}},
      {"one-plane-float", {"", "#ab3545", Marker::square, true}},
      {"embree", {"", "#6a4c93", Marker::diamond, false}},
      {"fcl", {"", "#4f7d3a", Marker::diamond, false}}};
  const auto known = kKnown.find(m.setting);
  SeriesStyle style =
      known != kKnown.end() ? known->second : SeriesStyle{"", "#6b7785", Marker::diamond, true};
  style.name = m.name;
  return style;
}

/// The part of the title that differs within a family: "10k", "all moving", "3 mm ball".
std::string sizeOf(const ExperimentInfo& info) {
  const std::size_t comma = info.title.find(", ");
  const std::string rest = comma == std::string::npos ? info.title : info.title.substr(comma + 2);
  return rest.substr(0, rest.find(" triangles"));
}

std::string tooltip(const ExperimentResult& e, const Measurement& m) {
  return m.name + " on " + e.info.title + ": " + microseconds(m.cost.p50) + " p50, " +
         microseconds(m.cost.p99) + " p99; error " + newtons(m.error.p99) + " p99";
}

/// Cost against a figure of a family: a series a setting, a point an experiment.
template <typename FigureOf>
std::string scatterOf(const std::vector<const ExperimentResult*>& family, const std::string& yLabel,
                      double floor, FigureOf figureOf) {
  ScatterPlot plot;
  plot.xLabel = "cost of a tick, 99th percentile, µs";
  plot.yLabel = yLabel;
  plot.floorY = floor;
  for (const ExperimentResult* e : family) {
    for (const Measurement& m : e->settings) {
      auto series = std::find_if(plot.series.begin(), plot.series.end(),
                                 [&](const PlotSeries& s) { return s.style.name == m.name; });
      if (series == plot.series.end()) series = plot.series.insert(series, PlotSeries{styleOf(m), {}});
      const bool labelled = family.size() > 1 && m.setting == "tandem";
      series->points.push_back({m.cost.p99, figureOf(m), labelled ? sizeOf(e->info) : "", tooltip(*e, m)});
    }
  }
  return "<figure>" + scatterSvg(plot) + "</figure>\n";
}

bool hovers(const ExperimentResult& e) { return e.info.family.starts_with("hover"); }

/// The plots of a family: error, and what else its scenes are hard on.
std::string plotsOf(const std::vector<const ExperimentResult*>& family) {
  std::string html = scatterOf(family,
                               family.front()->info.exact ? "error of the force, 99th percentile, N"
                                                          : "off the force of the body, 99th percentile, N",
                               1e-9, [](const Measurement& m) { return m.error.p99; });
  if (!family.front()->info.exact)
    html += scatterOf(family, "change of force a tick beyond 1 N/mm x travel, largest, N", 1e-3,
                      [](const Measurement& m) { return m.step.beyondTravel; });
  return html;
}

/// The cost of hovering beside that of the whole path.
std::string hoveringRanges(const std::vector<const ExperimentResult*>& family) {
  RangePlot plot;
  plot.xLabel = "cost of a tick from the median (dot) to the 99th percentile, µs";
  for (const ExperimentResult* e : family) {
    RangeRow alone{sizeOf(e->info) + ", hovering", {}}, whole{sizeOf(e->info) + ", whole path", {}};
    for (const Measurement& m : e->settings) {
      if (m.setting == "no-memory" || m.setting.ends_with("float") || m.setting == "float-data") continue;
      alone.marks.push_back({styleOf(m), m.hovering.p50, m.hovering.p99, tooltip(*e, m)});
      whole.marks.push_back({styleOf(m), m.cost.p50, m.cost.p99, tooltip(*e, m)});
    }
    plot.rows.push_back(std::move(alone));
    plot.rows.push_back(std::move(whole));
  }
  return "<figure>" + rangeSvg(plot) + "</figure>\n";
}

/// Headings of the columns that some families alone have.
std::string extraHeadings(const ExperimentResult& e) {
  if (hovers(e)) return "<th>hovering p50</th><th>p99</th>";
  if (e.info.exact) return "";
  return "<th>change beyond<br>K x travel</th><th>ticks over<br>50 mN</th><th>force beyond<br>K x depth</th>";
}

std::vector<std::string> extraCells(const ExperimentResult& e, const Measurement& m) {
  if (hovers(e)) return {microseconds(m.hovering.p50), microseconds(m.hovering.p99)};
  if (e.info.exact) return {};
  return {newtons(m.step.beyondTravel), std::to_string(m.step.jumps),
          m.kind == Kind::tandem ? newtons(m.beyondDepth) : std::string("–")};
}

std::string tableOf(const ExperimentResult& e) {
  std::string html =
      "<h3>" + escaped(e.info.title) +
      "</h3>\n<div class=\"wide\"><table><thead><tr><th>method</th>"
      "<th>cost p50</th><th>p99</th><th>error rms</th><th>p99</th><th>largest</th><th>p99, of the force</th>"
      "<th>largest step<br>(ideal " +
      newtons(e.settings.empty() ? 0.0 : e.settings[0].step.ideal) + ")</th>" + extraHeadings(e) +
      "<th>heap use</th><th>build, ms</th></tr></thead><tbody>\n";
  for (const Measurement& m : e.settings) {
    html += std::string("<tr class=\"") + (m.kind == Kind::tandem ? "tandem" : "other") + "\"><td>" +
            escaped(m.name) + "</td>";
    std::vector<std::string> cells{
        microseconds(m.cost.p50), microseconds(m.cost.p99),     newtons(m.error.rms),    newtons(m.error.p99),
        newtons(m.error.max),     percent(m.error.relativeP99), newtons(m.step.measured)};
    for (std::string& cell : extraCells(e, m)) cells.push_back(std::move(cell));
    cells.push_back(m.allocationsCounted ? std::to_string(m.allocations) : std::string("–"));
    cells.push_back(number(m.build_ms));
    for (const std::string& cell : cells) html += "<td>" + cell + "</td>";
    html += "</tr>\n";
  }
  html += "</tbody></table></div>\n";
  if (e.facetError > 0.0)
    html += "<p class=\"quiet\">Facets alone may cost up to " + newtons(e.facetError) +
            " here: the mesh is not the sphere that it stands for.</p>\n";
  return html;
}

std::string rangesOf(const SweepResult& result) {
  RangePlot plot;
  plot.xLabel = "cost of a tick from the median (dot) to the 99th percentile, µs";
  for (const ExperimentResult& e : result.experiments) {
    RangeRow row{e.info.title, {}};
    for (const Measurement& m : e.settings)
      row.marks.push_back({styleOf(m), m.cost.p50, m.cost.p99, tooltip(e, m)});
    plot.rows.push_back(std::move(row));
  }
  return "<figure>" + rangeSvg(plot) + "</figure>\n";
}

std::string buildBars(const SweepResult& result) {
  std::vector<Bar> bars;
  std::size_t largest = 0;
  for (const ExperimentResult& e : result.experiments) largest = std::max(largest, e.triangles);
  for (const ExperimentResult& e : result.experiments) {
    if (e.triangles * 10 < largest || e.parts > 1) continue;
    for (const Measurement& m : e.settings) {
      if (m.setting != "tandem" && m.setting != "three-planes-double" && m.kind != Kind::peer) continue;
      const std::string who = m.kind == Kind::tandem ? "Tandem"
                              : m.kind == Kind::peer ? m.setting
                                                     : "baseline";
      bars.push_back({e.info.id + ", " + who, number(m.build_ms) + " ms", m.build_ms, styleOf(m).colour});
    }
  }
  return bars.empty() ? "" : "<figure>" + barsSvg(bars) + "</figure>\n";
}

std::string boundsTable(const SweepResult& result) {
  const std::vector<Bound> bounds = boundsOf(result);
  if (bounds.empty()) return "";
  std::string html =
      "<h2>Bounds</h2>\n<p>What the project has set itself, against this run.</p>\n<div "
      "class=\"wide\"><table>"
      "<thead><tr><th>figure</th><th>measured</th><th>asked</th><th></th></tr></thead><tbody>\n";
  for (const Bound& b : bounds)
    html += "<tr><td>" + escaped(b.name) + "</td><td>" + number(b.measured) + " " + b.unit + "</td><td>" +
            (b.atLeast ? "≥ " : "≤ ") + number(b.target) + " " + b.unit + "</td><td class=\"" +
            (b.met() ? "met\">met" : "missed\">not met") + "</td></tr>\n";
  html += "</tbody></table></div>\n";
  for (const Figure& f : result.figures)
    if (!(f.target > 0.0))
      html += "<p class=\"quiet\">Beside these: " + escaped(f.name) + ": " + number(f.value) + " " + f.unit +
              ".</p>\n";
  return html;
}

/// What a family's plot shows, for a reader who has not seen the code.
std::string explanation(const std::string& family) {
  static const std::map<std::string, std::string> kTexts = {
      {"sphere",
       "A mesh is not a sphere: its facets lie under it and are tilted. Every method that follows the facets "
       "pays for them, "
       "and more triangles make the error smaller along the line. What a method adds of its own shows as "
       "distance from "
       "Tandem's line. Force shading bends the facets back to the surface that they stand for."},
      {"sphere-far",
       "The same part ten metres from the origin of the scene. Single precision resolves 1 µm there; what is "
       "computed or "
       "stored in it can be no better."},
      {"gear",
       "The walls are flat, so the mesh is exact at every number of triangles, and the answer of an ideal "
       "god object is known "
       "in closed form. An error here is the method's own. At the sharp corners of a tooth an ideal proxy "
       "snaps from one face "
       "to the next; a proxy that comes a tick late or goes another way is wrong by newtons for that long."},
      {"plane",
       "The simplest scene there is. A proxy that takes one plane a tick stands still every second tick "
       "while the hand moves "
       "on: a buzz of 500 Hz whose strength grows with speed."},
      {"gear-ball",
       "Each edge and corner of the mesh under a ball is an arc of its own. The exact answer is that of a "
       "point outside the outline grown by the ball's radius."},
      {"friction",
       "The exact proxy lags by the coefficient times the depth, straight behind the hand. An error here is "
       "that of the ratio of tangential to normal force, or of its direction."},
      {"groove", "Two walls hold the tool at once. The exact answer is the nearest point of a wedge."},
      {"parts",
       "Ten thousand parts, and joints between them that must not be felt. Where all parts move, each tick "
       "gets 10,000 "
       "new poses. The baselines know still parts only."},
      {"fine",
       "A million triangles on a small sphere: edges of 40 µm under a ball of up to 3 mm, which touches "
       "thousands of them."},
      {"hover-gear",
       "A hand is most often near a surface, not in it: there the question is what is nearest, and nothing "
       "that is known from the last tick answers it alone. The exact answer is known as for the gear."},
      {"hover-sphere", "Here every facet at the same height is as near as the next one."},
      {"scan",
       "Of a rough mesh no exact force is known: what is shown is how far the force is from that of the "
       "body without noise, which every method that follows the facets pays. The second plot shows what "
       "the hand would feel as kicks: by how much the force changes in a tick beyond 1 N/mm times the "
       "travel of the hand. At this depth a facet that is tilted by a few degrees moves the place of the "
       "proxy by tenths of a millimetre, and the proxy snaps from hollow to hollow. An error of ten times "
       "the force is that of a tool that has fallen through. A nearest point (peers) is free to be "
       "anywhere at once, and so is nearer to the body. A force must never be larger than 1 N/mm times its "
       "own depth, however it is shaded."},
      {"scan-ball", "A ball lies over the roughness that a point falls into."}};
  const auto found = kTexts.find(family);
  return found != kTexts.end() ? found->second : "";
}

/// The fastest method whose error is within a share of the force; null if there is none.
const Measurement* fastestWithin(const ExperimentResult& e, double share) {
  const Measurement* fast = nullptr;
  for (const Measurement& m : e.settings)
    if (m.error.relativeP99 < share && (fast == nullptr || m.cost.p99 < fast->cost.p99)) fast = &m;
  return fast;
}

/// The best corner of a plot in words: the smallest error, and the fastest that are near enough for a hand.
std::string cornerOf(const ExperimentResult& e) {
  if (e.settings.empty()) return "";
  const Measurement& least =
      *std::min_element(e.settings.begin(), e.settings.end(),
                        [](const Measurement& a, const Measurement& b) { return a.error.p99 < b.error.p99; });
  const auto inWords = [](const Measurement& m) {
    return "<b>" + escaped(m.name) + "</b> (" + microseconds(m.cost.p99) + ", " + newtons(m.error.p99) +
           ", " + percent(m.error.relativeP99) + " of the force)";
  };
  std::string text = "<p>" + escaped(e.info.title) +
                     ", the best corner, by 99th percentiles. Smallest error: " + inWords(least) + ".";
  const Measurement* before = &least;
  for (const auto& [share, words] : {std::pair{1e-6, "a millionth"}, {0.01, "1 %"}}) {
    const Measurement* fast = fastestWithin(e, share);
    text += std::string(" Fastest within ") + words + " of the force: " +
            (fast == nullptr  ? std::string("none is")
             : fast == before ? "the same"
                              : inWords(*fast)) +
            ".";
    if (fast != nullptr) before = fast;
  }
  return text + "</p>\n";
}

std::string familySection(const SweepResult& result, const std::string& family) {
  std::vector<const ExperimentResult*> members;
  for (const ExperimentResult& e : result.experiments)
    if (e.info.family == family) members.push_back(&e);
  ASSERT(!members.empty());
  const ExperimentInfo& first = members.front()->info;
  const std::string heading =
      members.size() > 1 ? first.title.substr(0, first.title.find(", ")) : first.title;
  std::string html = "<h2>" + escaped(heading) + "</h2>\n<p>" + escaped(first.about) + " " +
                     escaped(explanation(family)) + "</p>\n";
  html += plotsOf(members) + cornerOf(*members.back());
  if (hovers(*members.back())) html += hoveringRanges(members);
  html += "<details><summary>All figures</summary>\n";
  for (const ExperimentResult* e : members) html += tableOf(*e);
  return html + "</details>\n";
}

std::string introduction(const SweepResult& result) {
  std::string html =
      "<h1>Speed against error</h1>\n<p class=\"quiet\">" + escaped(result.machine) +
      (result.quick ? "; quick run" : "") +
      "</p>\n<p>A haptic tick turns the position of a hand into a force, a thousand times a second. Here "
      "every method follows "
      "the same scripted hand over the same scenes, and each force is compared with the exact one: 1000 N/m "
      "times the distance "
      "from the hand to where an ideal god object would be. <b>Left is faster, down is more exact.</b> Both "
      "axes are "
      "logarithmic; an error of at most 1 nN is drawn at 1 nN, with an arrow down.</p>\n<p>A tick gives the "
      "same bits each time, so its cost is taken as the least of "
      "several runs of the "
      "whole path; that leaves out what other programs on the machine took. The baselines are a textbook "
      "proxy written for "
      "this comparison: segments against triangles under a plain tree, planes one after another. ";
  if (result.peers.empty()) {
    html += "Peers were not measured in this run: the program that measures them was not there.</p>\n";
  } else {
    html += "Peers, measured in the same run: ";
    for (std::size_t i = 0; i < result.peers.size(); ++i)
      html += (i > 0 ? ", " : "") + escaped(result.peers[i]);
    html +=
        ". They answer which surface point is nearest; the force is then a spring to that point, with no "
        "memory of the "
        "side that the hand came from.</p>\n";
  }
  return html;
}

/// JSON with no "<" in it, which could end the script element that holds it. It stands in strings only, and
/// may be written as a code there.
std::string scriptData(const std::string& json) {
  std::string out;
  for (const char c : json) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

/// Targets of single experiments for Tandem as it is used.
void costBounds(const ExperimentResult& e, const Measurement& m, std::vector<Bound>& bounds) {
  static const std::pair<const char*, TargetCost> kTargets[] = {{"gear-1m", kGearTarget},
                                                                {"gear-ball1-1m", kGearBallTarget},
                                                                {"fine-ball3-1m", kFineSphereTarget},
                                                                {"parts-still", kStillPartsTarget},
                                                                {"parts-moving", kMovingPartsTarget},
                                                                {"hover-gear-1m", kGearTarget},
                                                                {"scan-1m", kScanTarget},
                                                                {"scan-ball1-1m", kScanBallTarget}};
  for (const auto& [id, target] : kTargets) {
    if (e.info.id != id) continue;
    if (target.p50 > 0.0) bounds.push_back({e.info.title + ": tick p50", "µs", m.cost.p50, target.p50});
    bounds.push_back({e.info.title + ": tick p99", "µs", m.cost.p99, target.p99});
  }
  if (e.info.id == "friction")
    bounds.push_back({"friction on a plane: error of the force, p99", "%", 100.0 * m.error.relativeP99, 0.5});
  if (e.info.id == "gear-1m") bounds.push_back({"build of 1 M triangles", "ms", m.build_ms, kBuildTarget_ms});
}

/// What a force must keep where no exact one is known.
void roughBounds(const ExperimentResult& e, std::vector<Bound>& bounds) {
  if (e.info.exact) return;
  for (const Measurement& m : e.settings) {
    if (m.setting != "shading") continue;
    bounds.push_back(
        {e.info.title + ", force shading: change of force a tick beyond 1 N/mm x travel, largest", "N",
         m.step.beyondTravel, kFeltJump});
    bounds.push_back({e.info.title + ", force shading: force beyond 1 N/mm x depth, largest", "N",
                      m.beyondDepth, kRounding_n});
  }
}

}  // namespace

std::vector<Bound> boundsOf(const SweepResult& result) {
  std::vector<Bound> bounds;
  double steps = 0.0, allocations = 0.0, gear = 0.0;
  bool counted = false, gears = false, exactSteps = false;
  for (const ExperimentResult& e : result.experiments) {
    for (const Measurement& m : e.settings) {
      if (m.kind == Kind::tandem && m.allocationsCounted) {
        counted = true;
        allocations += static_cast<double>(m.allocations);
      }
      if (m.setting == "shading" && e.info.id == "sphere-100k")
        bounds.push_back({e.info.title + ", force shading: error of the force, p99", "%",
                          100.0 * m.error.relativeP99, 0.1});
      if (m.setting != "tandem") continue;
      if (!(e.facetError > 0.0) && e.info.exact && m.step.ideal > 0.0) {
        exactSteps = true;
        steps = std::max(steps, m.step.measured / m.step.ideal);
      }
      if (e.info.family == "gear") {
        gears = true;
        gear = std::max(gear, m.error.relativeP99);
      }
      costBounds(e, m, bounds);
    }
    roughBounds(e, bounds);
  }
  for (const PartExperimentResult& e : result.held) partBounds(e, bounds, counted, allocations);
  for (const PressResult& e : result.presses) pressBounds(e, bounds, counted, allocations);
  for (const StrokeResult& e : result.strokes) strokeBounds(e, bounds);
  for (const LinkExperimentResult& e : result.links) linkBounds(e, bounds);
  if (gears) bounds.push_back({"gears: error of the force, p99, share of it", "", gear, 1e-4});
  if (exactSteps)
    bounds.push_back({"flat surfaces: change of force a tick against the ideal", "x", steps, 1.05});
  for (const Figure& f : result.figures)
    if (f.target > 0.0) bounds.push_back({f.name, f.unit, f.value, f.target, f.atLeast});
  if (counted) bounds.push_back({"heap allocations in Tandem's ticks", "", allocations, 0.0});
  return bounds;
}

std::string htmlPage(const SweepResult& result, const std::string& json) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>Tandem: speed against error</title>\n";
  html += kStyle + std::string("</head>\n<body>\n<main>\n") + introduction(result) + boundsTable(result);
  if (!result.experiments.empty())
    html +=
        "<h2>Cost of a tick</h2>\n<p>Every experiment and every method. A millisecond is all there "
        "is.</p>\n" +
        rangesOf(result);
  std::vector<std::string> done;
  for (const ExperimentResult& e : result.experiments) {
    if (std::find(done.begin(), done.end(), e.info.family) != done.end()) continue;
    done.push_back(e.info.family);
    html += familySection(result, e.info.family);
  }
  html += strokeSection(result.strokes);
  html += partSection(result) + pressSection(result) + manifoldSection(result) + linkSection(result);
  const std::string bars = buildBars(result);
  if (!bars.empty())
    html +=
        "<h2>Preparing a mesh</h2>\n<p>Time to build what each method searches, once, when a scene is "
        "loaded. Tandem builds "
        "on all cores.</p>\n" +
        bars;
  html +=
      "<h2>Data</h2>\n<p class=\"quiet\">The figures behind the plots stand in this page as JSON, in the "
      "element with the id "
      "<code>data</code>.</p>\n</main>\n<script type=\"application/json\" id=\"data\">\n" +
      scriptData(json) + "</script>\n</body>\n</html>\n";
  return html;
}

}  // namespace tandem::client::report
