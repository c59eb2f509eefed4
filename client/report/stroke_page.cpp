#include "client/report/stroke_page.h"

#include "client/plot/svg_plot.h"
#include "client/plot/words.h"
#include "client/report/measurement_json.h"

namespace tandem::client::report {
namespace {

SeriesStyle strokeStyle(const StrokeMeasurement& m) {
  const bool used = m.setting == "tandem";
  return {m.name, used ? "#0b6e99" : "#c9730b", used ? Marker::circle : Marker::square, !used, 1.0};
}

std::string fallenOf(const StrokeResult& e, const StrokeMeasurement& m) {
  return std::to_string(m.fallen) + " of " + std::to_string(e.strokes);
}

/// A name that has room beside a plot; the table has all of it.
std::string shortened(const std::string& name) {
  constexpr std::size_t kRoom = 34;
  if (name.size() <= kRoom) return name;
  std::size_t end = kRoom - 3;  // no letter of UTF-8 is cut
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0u) == 0x80u) --end;
  return name.substr(0, end) + "...";
}

std::string strokeTable(const std::vector<StrokeResult>& strokes) {
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th>model</th><th>point</th><th>triangles</th><th>parts</th>"
      "<th>ticks</th><th>go where<br>no ball does</th><th>end a leg<br>in a part</th><th>cost "
      "p50</th><th>p99</th><th>max</th></tr></thead>"
      "<tbody>\n";
  for (const StrokeResult& e : strokes)
    for (const StrokeMeasurement& m : e.settings) {
      html += std::string("<tr class=\"") + (m.setting == "tandem" ? "tandem" : "other") + "\"><td>" +
              escaped(e.model) + "</td>";
      for (const std::string& cell :
           {m.name, std::to_string(e.triangles), std::to_string(e.parts), std::to_string(e.ticks),
            fallenOf(e, m), std::to_string(m.inside), microseconds(m.cost.p50), microseconds(m.cost.p99),
            microseconds(m.cost.max)})
        html += "<td>" + cell + "</td>";
      html += "</tr>\n";
    }
  return html + "</tbody></table></div>\n";
}

}  // namespace

std::string strokeSection(const std::vector<StrokeResult>& strokes) {
  if (strokes.empty()) return "";
  std::vector<Bar> bars;
  RangePlot costs;
  costs.xLabel = "cost of a tick from the median (dot) to the 99th percentile, µs";
  for (const StrokeResult& e : strokes) {
    RangeRow row{shortened(e.model), {}};
    for (const StrokeMeasurement& m : e.settings) {
      bars.push_back({m.setting == "tandem" ? shortened(e.model) : m.name, fallenOf(e, m),
                      static_cast<double>(m.fallen), strokeStyle(m).colour});
      row.marks.push_back({strokeStyle(m), m.cost.p50, m.cost.p99,
                           e.model + ", " + m.name + ": " + microseconds(m.cost.p99)});
    }
    costs.rows.push_back(std::move(row));
  }
  return "<h2>Strokes through models</h2>\n<p>A point is drawn from outside through each model at random, at "
         "speeds up to its size in a tick. Files state coordinates in single precision, which leaves cracks "
         "between triangles. Counted are strokes in which the point goes where a ball of 2⁻²⁰ of a part's "
         "coordinates could not follow in one motion, asked of every triangle apart from the contact; an "
         "opening that such a ball fits through is none. The control is a point without the least radius: it "
         "falls "
         "through cracks, and it rests on surfaces where the ball has no room, so that most strokes that "
         "touch "
         "count. How many strokes end a leg inside a part, by its winding number, tells the two apart: what "
         "the "
         "point has beyond Tandem came in through cracks; Tandem comes in through openings.</p>\n<figure>" +
         barsSvg(bars) + "</figure>\n<figure>" + rangeSvg(costs) + "</figure>\n" + strokeTable(strokes);
}

void strokeBounds(const StrokeResult& e, std::vector<Bound>& bounds) {
  for (const StrokeMeasurement& m : e.settings)
    if (m.setting == "tandem")
      bounds.push_back({e.model + ": strokes of a point that go where no ball does", "",
                        static_cast<double>(m.fallen), 0.0});
}

Json strokeJson(const StrokeResult& e) {
  Json json = {{"model", e.model},
               {"triangles", e.triangles},
               {"parts", e.parts},
               {"strokes", e.strokes},
               {"ticks", e.ticks}};
  json["settings"] = Json::array();
  for (const StrokeMeasurement& m : e.settings) {
    Json setting = {{"id", m.setting}, {"name", m.name}, {"fallen", m.fallen}, {"inside", m.inside}};
    putCost(setting, m.cost);
    json["settings"].push(std::move(setting));
  }
  return json;
}

}  // namespace tandem::client::report
