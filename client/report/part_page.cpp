#include "client/report/part_page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "client/plot/svg_plot.h"
#include "client/plot/words.h"
#include "client/report/targets.h"

namespace tandem::client::report {
namespace {

constexpr double kLeastDepth = 1e-3, kLeastForce = 1e-6;  // um, N: the floors of the axes

std::string degrees(double radians) {
  const double value = radians * 180.0 / std::numbers::pi;
  return value < 1e-4 ? "0" : number(value) + "°";
}

/// Settings with the same fields form one line, from dense to sparse samples. Settings with fewer steps or
/// queries form a line of their own.
SeriesStyle partStyle(const PartMeasurement& m) {
  static const std::map<std::string, std::string> kPeers = {
      {"fcl", "#4f7d3a"}, {"bullet", "#6a4c93"}, {"ode", "#ab3545"}};
  if (m.kind == Kind::peer) {
    const auto known = kPeers.find(m.setting);
    return {m.name, known != kPeers.end() ? known->second : "#6b7785", Marker::diamond, false, 1.0};
  }
  if (!usualIterations(m.effort))
    return {m.effort.exact ? "fewer steps or queries" : "the same, not refined", "#8a2f6b", Marker::triangle,
            !m.effort.exact, 0.75};
  const char* const colour = m.fieldScale < 1.0   ? "#06384f"
                             : m.fieldScale < 1.5 ? "#0b6e99"
                             : m.fieldScale < 3.0 ? "#4f9fbf"
                             : m.fieldScale < 6.0 ? "#d1972f"
                                                  : "#c9590b";
  const std::string fields =
      m.fieldScale == 1.0 ? "fields as they are used" : "fields x " + number(m.fieldScale);
  if (!m.effort.exact) return {fields + ", not refined", colour, Marker::square, true, 0.8};
  return {fields, colour, Marker::circle, false, 1.0};
}

std::string partTooltip(const PartMeasurement& m) {
  return m.name + ": " + microseconds(m.cost.p50) + " p50, " + microseconds(m.cost.p99) + " p99; " +
         (m.kind == Kind::peer ? "error of depth " : "penetration ") + metres(m.depth.max) +
         "; error of force " + newtons(m.error.p99) + " p99";
}

/// A setting as a label of a few letters: f2 s4 is fields x 2, samples x 4.
std::string shortName(const PartMeasurement& m) {
  std::string text;
  const auto add = [&](const std::string& words) { text += (text.empty() ? "" : " ") + words; };
  const haptics::ContactEffort used;
  if (m.fieldScale != 1.0) add("f" + number(m.fieldScale));
  if (m.sampleScale != 1.0) add("s" + number(m.sampleScale));
  if (m.effort.steps != used.steps) add(number(m.effort.steps) + " st");
  if (m.effort.sampleQueries != used.sampleQueries) add(number(m.effort.sampleQueries) + " q");
  if (!m.effort.exact) add("nr");
  return text;
}

/// The label of a peer that reports no contact is "no contact".
std::string labelOf(const PartMeasurement& m) {
  if (m.setting == "tandem") return "as used";
  return m.found < 0.5 && m.kind == Kind::peer ? "no contact" : "";
}

/// The settings in drawing order. Tandem as it is used comes first and lies on top.
std::vector<const PartMeasurement*> inDrawingOrder(const PartExperimentResult& e) {
  std::vector<const PartMeasurement*> ordered;
  for (const PartMeasurement& m : e.settings) ordered.push_back(&m);
  const auto rank = [](const PartMeasurement& m) {
    if (m.kind == Kind::peer) return 4;
    if (!usualIterations(m.effort)) return 3;
    if (!m.effort.exact) return 2;
    return m.fieldScale == 1.0 ? 0 : 1;
  };
  std::stable_sort(ordered.begin(), ordered.end(), [&](const auto* a, const auto* b) {
    if (rank(*a) != rank(*b)) return rank(*a) < rank(*b);
    if (a->fieldScale != b->fieldScale) return a->fieldScale < b->fieldScale;
    return a->sampleScale < b->sampleScale;
  });
  return ordered;
}

/// A plot of `costOf` against `errorOf` of every setting.
template <typename CostOf, typename ErrorOf>
std::string partPlot(const PartExperimentResult& e, const char* whichCost, const std::string& yLabel,
                     double floor, CostOf costOf, ErrorOf errorOf) {
  ScatterPlot plot;
  plot.xLabel = std::string("cost of a tick (peers: of the query alone), ") + whichCost + ", µs";
  plot.yLabel = yLabel;
  plot.floorY = floor;
  plot.frontName = "Tandem: none faster is as exact";
  std::vector<PlotPoint> ours;
  for (const PartMeasurement* m : inDrawingOrder(e))
    if (m->kind == Kind::tandem)
      ours.push_back({costOf(*m), std::max(errorOf(*m), floor), shortName(*m), "", false});
  plot.front = paretoFront(std::move(ours));
  const auto onFront = [&](double x, double y) {
    return std::any_of(plot.front.begin(), plot.front.end(),
                       [&](const PlotPoint& p) { return p.x == x && p.y == std::max(y, floor); });
  };
  for (const PartMeasurement* m : inDrawingOrder(e)) {
    const SeriesStyle style = partStyle(*m);
    auto series = std::find_if(plot.series.begin(), plot.series.end(),
                               [&](const PlotSeries& s) { return s.style.name == style.name; });
    if (series == plot.series.end()) {
      series = plot.series.insert(series, PlotSeries{style, {}, true});
      series->joined = m->kind == Kind::tandem && m->effort.exact && usualIterations(m->effort);
    }
    const double cost = costOf(*m), error = errorOf(*m);
    std::string label = labelOf(*m);
    if (label.empty() && m->kind == Kind::tandem && onFront(cost, error)) label = shortName(*m);
    series->points.push_back({cost, error, label, partTooltip(*m), m->setting == "tandem"});
  }
  return "<figure>" + scatterSvg(plot) + "</figure>\n";
}

/// Both errors against one cost.
template <typename CostOf>
std::string partPlots(const PartExperimentResult& e, const char* whichCost, CostOf costOf) {
  return partPlot(e, whichCost, "penetration (peers: error of the depth), largest, µm", kLeastDepth, costOf,
                  [](const PartMeasurement& m) { return 1e6 * m.depth.max; }) +
         partPlot(e, whichCost, "error of the force, 99th percentile, N", kLeastForce, costOf,
                  [](const PartMeasurement& m) { return m.error.p99; });
}

/// "x 2"; a dash for peers.
std::string scaleOf(const PartMeasurement& m, double scale) {
  return m.kind == Kind::peer ? "–" : "x " + number(scale);
}

std::string unlessPeer(const PartMeasurement& m, const std::string& text) {
  return m.kind == Kind::peer ? "–" : text;
}

std::string partTable(const PartExperimentResult& e) {
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th>method</th><th>fields</th><th>samples</th><th>steps</th>"
      "<th>queries</th><th>refined</th>"
      "<th>cost p50</th><th>p99</th><th>max</th><th>pene-<br>tration</th><th>force<br>error p99</th>"
      "<th>of the<br>force</th><th>force<br>step p99</th><th>contact<br>turns "
      "p99</th><th>contact<br>found</th>"
      "<th>build,<br>ms</th></tr></thead><tbody>\n";
  for (const PartMeasurement& m : e.settings) {
    const bool used = m.setting == "tandem";
    html += std::string("<tr class=\"") + (used ? "tandem" : "other") + "\"><td>" +
            (m.kind == Kind::peer ? escaped(m.name)
             : used               ? "Tandem, as used"
                                  : "Tandem") +
            "</td>";
    for (const std::string& cell :
         {scaleOf(m, m.fieldScale), scaleOf(m, m.sampleScale), unlessPeer(m, number(m.effort.steps)),
          unlessPeer(m, number(m.effort.sampleQueries)), unlessPeer(m, m.effort.exact ? "yes" : "no"),
          microseconds(m.cost.p50), microseconds(m.cost.p99), microseconds(m.cost.max), metres(m.depth.max),
          newtons(m.error.p99), percent(m.error.relativeP99), newtons(m.forceStep.p99),
          degrees(m.normalStep.p99), percent(m.found), number(m.build_ms)})
      html += "<td>" + cell + "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

/// Lengths behind the scales.
std::string lengthsInWords(const PartExperimentResult& e) {
  for (const PartMeasurement& m : e.settings)
    if (m.setting == "tandem")
      return " As they are used, the held part's field has cells of " + metres(m.cell) +
             " at least, and its samples stand " + metres(m.spacing) + " apart.";
  return "";
}

/// In words, what a plot cannot show: whether a method finds the contact at all, and how steadily.
std::string contactsInWords(const PartExperimentResult& e) {
  std::string text;
  for (const PartMeasurement& m : e.settings) {
    if (m.setting != "tandem" && m.kind != Kind::peer) continue;
    text += (text.empty() ? "" : "; ") + escaped(m.name) + " in " + percent(m.found);
    if (const std::string turn = degrees(m.normalStep.max); turn != "0")
      text += ", turning by up to " + turn + " a tick";
  }
  return "<p>Of the ticks with a contact, one that pushes the right way was reported by " + text + ".</p>\n";
}

std::string sectionOf(const PartExperimentResult& e) {
  return "<h3>" + escaped(e.info.title) + "</h3>\n<p>" + escaped(e.info.about) + " " +
         std::to_string(e.triangles) + " triangles; the exact force is " + newtons(e.peakForce) +
         " at most." + lengthsInWords(e) + "</p>\n" + contactsInWords(e) +
         partPlots(e, "99th percentile", [](const PartMeasurement& m) { return m.cost.p99; }) +
         "<details><summary>The same against the median cost</summary>\n" +
         partPlots(e, "median", [](const PartMeasurement& m) { return m.cost.p50; }) + "</details>\n" +
         "<details><summary>All figures</summary>\n" + partTable(e) + "</details>\n";
}

bool measuredBy(const SweepResult& result, const std::string& setting) {
  const auto has = [&](const PartExperimentResult& e) {
    return std::any_of(e.settings.begin(), e.settings.end(),
                       [&](const PartMeasurement& m) { return m.setting == setting; });
  };
  return std::any_of(result.held.begin(), result.held.end(), has);
}

std::string aboutPeers(const SweepResult& result) {
  std::string there, missing;
  for (const auto& [id, name] : {std::pair{"fcl", "FCL"}, {"bullet", "Bullet"}, {"ode", "ODE"}}) {
    std::string& list = measuredBy(result, id) ? there : missing;
    list += (list.empty() ? "" : ", ") + std::string(name);
  }
  if (there.empty()) return "<p>Other libraries were not measured on these experiments in this run.</p>\n";
  std::string html =
      "<p>" + there +
      " get the same meshes at the poses to which the hand leads the part, as a penalty method would. They "
      "are timed on the query for contacts alone, the lesser of two in a row; Tandem on the whole tick, with "
      "solver, coupling and limits. What is shown as their penetration is the error of the deepest contact "
      "that they report against the exact depth at that pose. Their force is the coupling's stiffness times "
      "the deepest contact, in the direction of all contacts together, each weighed by its depth.";
  if (!missing.empty())
    html += " Left out, since it was not there when the program that measures was built: " + missing + ".";
  return html + "</p>\n";
}

}  // namespace

std::string partSection(const SweepResult& result) {
  if (result.held.empty()) return "";
  const haptics::ContactEffort used;
  std::string html =
      "<h2>A part in the hand</h2>\n<p>The hand holds a part by a spring of 1 N/mm and leads it along a path "
      "that goes through another part. Measured are the whole tick (time of its thread on the processor), "
      "how deep the part is left in the other one (exactly, apart from the solver), and the force on the "
      "hand against that of an ideal part that stays outside, in closed form. <b>Left is faster, down is "
      "more exact.</b></p>\n"
      "<p>Swept are the cells and tolerance of the distance fields together (a line each; x 2: twice as "
      "coarse "
      "as they are used), the spacing of the contact samples (along a line, from dense to sparse), whether a "
      "touch is refined on the triangles (squares: the field's reading is taken as it is; on every field, at "
      "two spacings), and the most steps and sample queries of a tick (triangles; as used " +
      number(used.steps) + " and " + number(used.sampleQueries) +
      "). Each mark is a measurement of this run, named where the pointer rests on it; the ring is Tandem as "
      "it is used. Beside points of the front, which no faster setting of Tandem equals within 1 %, stands "
      "how "
      "they differ from that: f2, fields x 2; s4, samples x 4; 1 st, one step; 30 q, 30 queries; nr, not "
      "refined.</p>\n"
      "<p>Penetration is measured in every tick, with more than 9,000 triangles in every 7th. <i>Contact "
      "found</i>: of the ticks with a contact, the share in which one is reported that pushes the right "
      "way.</p>\n" +
      aboutPeers(result);
  for (const PartExperimentResult& e : result.held) html += sectionOf(e);
  return html;
}

void partBounds(const PartExperimentResult& e, std::vector<Bound>& bounds, bool& counted,
                double& allocations) {
  for (const PartMeasurement& m : e.settings) {
    if (m.allocationsCounted) {
      counted = true;
      allocations += static_cast<double>(m.allocations);
    }
    if (m.setting != "tandem") continue;
    const std::string& name = e.info.title;
    bounds.push_back({name + ": tick p50", "µs", m.cost.p50, kHeldPartTarget.p50});
    bounds.push_back({name + ": tick p99", "µs", m.cost.p99, kHeldPartTarget.p99});
    bounds.push_back({name + ": longest tick", "ms", 1e-3 * m.cost.max, kHeldPartLongest_ms});
    bounds.push_back({name + ": penetration, largest", "µm", 1e6 * m.depth.max, 1e6 * e.targetDepth});
    bounds.push_back({name + ": change of force a tick beyond the exact one, p99", "N", m.forceStep.p99,
                      kForceStepTarget});
    bounds.push_back({name + ": ticks in contact that report it", "%", 100.0 * m.found, 100.0, true});
  }
}

}  // namespace tandem::client::report
