#include "client/report/link_page.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "client/plot/panel_plot.h"
#include "client/plot/words.h"
#include "client/report/targets.h"

namespace tandem::client::report {
namespace {

using Measure = std::function<double(const LinkMeasurement&)>;
using Chosen = std::function<bool(const LinkMeasurement&)>;

const Measure kApart = [](const LinkMeasurement& m) { return 1e3 * m.apart; };
const Measure kHandToHand = [](const LinkMeasurement& m) { return m.handToHand; };
const Measure kOffGrip = [](const LinkMeasurement& m) { return 1e3 * m.offGrip; };
const Measure kWall = [](const LinkMeasurement& m) { return m.wall; };
const Measure kLoad = [](const LinkMeasurement& m) { return m.load; };
const Measure kChange = [](const LinkMeasurement& m) { return m.change; };
const Measure kPlayOut = [](const LinkMeasurement& m) { return 1e3 * m.playOut; };
const Measure kKilobytes = [](const LinkMeasurement& m) { return 1e-3 * m.bytes; };
const Measure kPackets = [](const LinkMeasurement& m) { return m.setting.packetHz; };
const Measure kCost = [](const LinkMeasurement& m) { return m.cost; };

constexpr const char* kApartLabel = "sites apart, rms, mm";
constexpr const char* kHandToHandLabel = "hand to hand, N/m";
constexpr const char* kLoadLabel = "leader's force, × no network";
constexpr const char* kChangeLabel = "largest change in 20 ms, N";
// The floors of the axes: mm, N/m, -, N.
constexpr double kLeastApart = 0.1, kLeastStiffness = 2.0, kLeastLoad = 0.2, kLeastChange = 0.01;

bool isLink(const LinkMeasurement& m) { return m.setting.architecture == Architecture::link; }
bool isOff(const LinkMeasurement& m) { return isLink(m) && m.off > 0.5; }

/// The style of an architecture other than the link.
SeriesStyle styleOfRival(const LinkMeasurement& m) {
  const std::string& name = m.setting.name;
  switch (m.setting.architecture) {
    case Architecture::plain:
      return {name, "#b3261e", m.setting.id == "plain-400" ? Marker::triangle : Marker::diamond,
              m.setting.id == "plain-400"};
    case Architecture::tank:
      return {name, "#c9730b", Marker::square};
    case Architecture::server:
      return {name, "#6a4c93", Marker::square};
    case Architecture::oneRoom:
      return {name, "#6b7785", Marker::circle, true, 0.7};
    case Architecture::link:
      break;
  }
  return {name, "#0b6e99"};
}

std::string signedMilliseconds(double seconds) {
  const std::string text = number(1e3 * seconds);
  return (seconds > 0.0 ? "+" : "") + text;
}

/// b of a link; K and B of a spring.
std::string gainsOf(const LinkSetting& s) {
  if (s.architecture == Architecture::link) return number(s.impedance);
  if (s.architecture == Architecture::oneRoom) return "";
  return number(s.gains.stiffness, 4) + "; " + number(s.gains.damping);
}

std::string knobsOf(const LinkSetting& s) {
  if (s.architecture == Architecture::oneRoom) return "";
  if (s.architecture != Architecture::link)
    return "K " + number(s.gains.stiffness, 4) + ", B " + number(s.gains.damping);
  return number(s.packetHz) + " Hz, margin " + signedMilliseconds(s.margin) + " ms, b " + gainsOf(s);
}

std::string whyUnstable(const LinkMeasurement& m) {
  if (m.diverged) return "diverges";
  if (m.created > bench::kEnergyBound) return "makes " + number(1e3 * m.created) + " mJ";
  return "does not come to rest";
}

std::string linkTooltip(const LinkExperimentResult& e, const LinkMeasurement& m) {
  const std::string knobs = knobsOf(m.setting);
  std::string text = (isLink(m) ? std::string("coordination link") : m.setting.name) +
                     (knobs.empty() ? "" : " (" + knobs + ")") + ", " + number(1e3 * e.delay) +
                     " ms one way: ";
  if (!m.stable()) return text + "unstable, " + whyUnstable(m);
  return text + number(1e3 * m.apart) + " mm apart, " + number(m.handToHand) +
         " N/m from hand to hand, wall " + number(m.wall) + " N/m, leader's force × " + number(m.load) +
         ", " + number(1e-3 * m.bytes) + " kB/s";
}

/// Adds a point to the series with this style's name, which is made if it is new.
void put(Panel& panel, const SeriesStyle& style, bool joined, const PlotPoint& point, bool stable) {
  auto series = std::find_if(panel.series.begin(), panel.series.end(),
                             [&](const PanelSeries& s) { return s.style.name == style.name; });
  if (series == panel.series.end()) series = panel.series.insert(series, PanelSeries{style, {}, {}, joined});
  if (stable && !std::isfinite(point.y)) return;
  (stable ? series->points : series->unstable).push_back(point);
}

PlotPoint pointOf(const LinkExperimentResult& e, const LinkMeasurement& m, double x, double y) {
  return {x, y, "", linkTooltip(e, m), false};
}

/// A measure of every architecture over the delay.
Panel overDelay(const SweepResult& result, const char* title, const char* yLabel, double floor,
                const Measure& measure) {
  Panel panel{title, "one way, ms", yLabel, floor, {}, {}};
  for (const LinkExperimentResult& e : result.links) {
    panel.xLines.push_back(1e3 * e.delay);
    for (const LinkMeasurement& m : e.settings) {
      if (isLink(m) && !m.setting.inUse) continue;
      PlotPoint point = pointOf(e, m, 1e3 * e.delay, measure(m));
      if (isOff(m)) point.label = "off";
      put(panel, styleOfRival(m), true, point, m.stable());
    }
  }
  return panel;
}

/// From light to dark as the impedance grows.
const char* colourOf(double impedance) {
  return impedance < 10.0   ? "#8fc7e0"
         : impedance < 20.0 ? "#4f9fbf"
         : impedance < 30.0 ? "#0b6e99"
                            : "#06384f";
}

void putRivals(const LinkExperimentResult& e, const Measure& x, const Measure& y, Panel& panel) {
  for (const LinkMeasurement& m : e.settings) {
    if (isLink(m) || m.setting.architecture == Architecture::oneRoom) continue;
    put(panel, styleOfRival(m), false, pointOf(e, m, x(m), y(m)), m.stable());
  }
}

/// The settings that are drawn. Settings whose styles have one name form one line, in the order of the sweep.
struct Lines {
  Chosen drawn;
  std::function<SeriesStyle(const LinkMeasurement&)> style;
  std::function<std::string(const LinkMeasurement&)> label;
};

void putLines(const LinkExperimentResult& e, const Lines& lines, const Measure& x, const Measure& y,
              Panel& panel) {
  std::vector<const LinkMeasurement*> ordered;
  for (const LinkMeasurement& m : e.settings)
    if (isLink(m) && lines.drawn(m)) ordered.push_back(&m);
  std::stable_sort(ordered.begin(), ordered.end(), [](const LinkMeasurement* a, const LinkMeasurement* b) {
    const LinkSetting &p = a->setting, &q = b->setting;
    if (p.impedance != q.impedance) return p.impedance < q.impedance;
    return p.margin != q.margin ? p.margin < q.margin : p.packetHz < q.packetHz;
  });
  for (const LinkMeasurement* m : ordered) {
    PlotPoint point = pointOf(e, *m, x(*m), y(*m));
    point.ringed = m->setting.inUse;
    point.label = lines.label(*m);
    put(panel, lines.style(*m), true, point, m->stable());
  }
}

/// The delays with more settings of the link than the one in use.
std::vector<const LinkExperimentResult*> turnedLinks(const SweepResult& result) {
  std::vector<const LinkExperimentResult*> found;
  for (const LinkExperimentResult& e : result.links)
    if (std::count_if(e.settings.begin(), e.settings.end(), isLink) > 1) found.push_back(&e);
  return found;
}

double impedanceInUse(const LinkExperimentResult& e) {
  for (const LinkMeasurement& m : e.settings)
    if (m.setting.inUse) return m.setting.impedance;
  return 0.0;
}

/// Bytes against the distance of the sites: a line an impedance, along it the packet rate.
std::string rateFigure(const SweepResult& result) {
  std::vector<Panel> panels;
  for (const LinkExperimentResult* e : turnedLinks(result)) {
    Panel panel{delayInWords(*e), "kB/s each way", kApartLabel, kLeastApart, {}, {}};
    const double used = impedanceInUse(*e);
    putLines(*e,
             {[](const LinkMeasurement& m) { return m.setting.margin == 0.0; },
              [](const LinkMeasurement& m) {
                return SeriesStyle{"link, b = " + number(m.setting.impedance) + " N·s/m",
                                   colourOf(m.setting.impedance)};
              },
              [&](const LinkMeasurement& m) {
                return m.setting.impedance == used ? number(m.setting.packetHz) + " Hz" : "";
              }},
             kKilobytes, kApart, panel);
    putRivals(*e, kKilobytes, kApart, panel);
    panels.push_back(std::move(panel));
  }
  return "<figure>" + panelsSvg(panels) + "</figure>\n";
}

/// Stiffness against the leader's force: a line a margin, along it the impedance.
std::string impedanceFigure(const SweepResult& result) {
  const auto colour = [](double margin) {
    return margin < -0.007 ? "#8a2f6b" : margin < 0.0 ? "#c9590b" : margin < 0.005 ? "#0b6e99" : "#4f7d3a";
  };
  std::vector<Panel> panels;
  for (const LinkExperimentResult* e : turnedLinks(result)) {
    Panel panel{delayInWords(*e), kLoadLabel, kHandToHandLabel, kLeastStiffness, {}, {}};
    const auto style = [&](const LinkMeasurement& m) {
      return SeriesStyle{"link, margin " + signedMilliseconds(m.setting.margin) + " ms",
                         colour(m.setting.margin)};
    };
    putLines(*e,
             {[](const LinkMeasurement& m) { return m.setting.packetHz == 250.0; }, style,
              [](const LinkMeasurement& m) {
                return m.setting.margin == 0.0 ? "b " + number(m.setting.impedance) : "";
              }},
             kLoad, kHandToHand, panel);
    putRivals(*e, kLoad, kHandToHand, panel);
    panels.push_back(std::move(panel));
  }
  return "<figure>" + panelsSvg(panels) + "</figure>\n";
}

SeriesStyle styleOfDelay(double delay) {
  const char* colour = delay < 0.02   ? "#4f9fbf"
                       : delay < 0.04 ? "#0b6e99"
                       : delay < 0.08 ? "#4f7d3a"
                                      : "#c9730b";
  return {number(1e3 * delay) + " ms one way", colour, Marker::circle};
}

/// Benefit and cost of the margin, and the cost of a tick: a line a delay.
std::string marginFigure(const SweepResult& result) {
  Panel change{"Roughness", "played out late by, ms", kChangeLabel, kLeastChange, {}, {}};
  Panel apart{"Distance", "played out late by, ms", kApartLabel, kLeastApart, {}, {}};
  Panel stiffness{"Stiffness", "played out late by, ms", kHandToHandLabel, kLeastStiffness, {}, {}};
  Panel cost{"Load", "packets a second", "tick of an end, × held step", 0.01, {}, {}};
  for (const LinkExperimentResult* e : turnedLinks(result)) {
    const double used = impedanceInUse(*e);
    const auto style = [&](const LinkMeasurement&) { return styleOfDelay(e->delay); };
    const Lines alongMargin{
        [&](const LinkMeasurement& m) { return m.setting.packetHz == 250.0 && m.setting.impedance == used; },
        style, [](const LinkMeasurement& m) { return signedMilliseconds(m.setting.margin); }};
    putLines(*e, alongMargin, kPlayOut, kChange, change);
    putLines(*e, alongMargin, kPlayOut, kApart, apart);
    putLines(*e, alongMargin, kPlayOut, kHandToHand, stiffness);
    const Lines timed{[](const LinkMeasurement& m) { return std::isfinite(m.cost); }, style,
                      [](const LinkMeasurement&) { return std::string(); }};
    putLines(*e, timed, kPackets, kCost, cost);
  }
  if (!turnedLinks(result).empty()) putRivals(*turnedLinks(result).front(), kPackets, kCost, cost);
  return "<figure>" + panelsSvg({change, apart, stiffness, cost}) + "</figure>\n";
}

std::string delayFigure(const SweepResult& result) {
  const auto panel = [&](const char* title, const char* yLabel, double floor, const Measure& measure) {
    return overDelay(result, title, yLabel, floor, measure);
  };
  return "<figure>" +
         panelsSvg({panel("Sites apart in the shared drag", kApartLabel, kLeastApart, kApart),
                    panel("Leader's hand off the part that it sees", "rms, mm", kLeastApart, kOffGrip),
                    panel("Stiffness from hand to hand", kHandToHandLabel, kLeastStiffness, kHandToHand),
                    panel("Wall felt by the co-holder", "N/m", kLeastStiffness, kWall),
                    panel("What the leader has to push", kLoadLabel, kLeastLoad, kLoad),
                    panel("Roughness", kChangeLabel, kLeastChange, kChange)}) +
         "</figure>\n";
}

std::string cellUnless(bool hidden, const std::string& text) { return hidden ? "–" : text; }

std::string rowOf(const LinkMeasurement& m) {
  const bool none = m.diverged, alone = m.setting.architecture == Architecture::oneRoom;
  std::string html = std::string("<tr class=\"") + (m.setting.inUse ? "tandem" : "other") + "\"><td>" +
                     escaped(m.setting.inUse ? "Coordination link, as used"
                             : isLink(m)     ? "Coordination link"
                                             : m.setting.name) +
                     "</td>";
  for (const std::string& cell :
       {cellUnless(alone, number(m.setting.packetHz)),
        cellUnless(!isLink(m), signedMilliseconds(m.setting.margin)), gainsOf(m.setting),
        cellUnless(none, number(1e3 * m.apart)), cellUnless(none, number(1e3 * m.maxApart)),
        cellUnless(none, number(1e3 * m.offGrip)), cellUnless(none, isOff(m) ? "off" : number(m.handToHand)),
        cellUnless(none || !std::isfinite(m.wall), number(m.wall)), cellUnless(none, number(m.load)),
        cellUnless(none, number(m.change, 2)), cellUnless(!isLink(m), number(1e3 * m.playOut)),
        cellUnless(alone, number(1e-3 * m.bytes)), cellUnless(!std::isfinite(m.cost), number(m.cost, 2)),
        number(1e3 * m.created, 2)})
    html += "<td>" + cell + "</td>";
  return html + "<td class=\"" + (m.stable() ? "met\">stable" : "missed\">" + escaped(whyUnstable(m))) +
         "</td></tr>\n";
}

std::string linkTable(const LinkExperimentResult& e, const Chosen& shown) {
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th>tied by</th><th>Hz</th><th>margin,<br>ms</th><th>b, or K; "
      "B</th><th>apart<br>rms, mm</th>"
      "<th>largest,<br>mm</th><th>hand off<br>part, mm</th><th>hand to<br>hand, N/m</th><th>wall,<br>N/m</th>"
      "<th>leader's<br>force ×</th><th>change in<br>20 ms, N</th><th>played<br>out, ms</th><th>kB/s</th>"
      "<th>tick ×</th><th>made,<br>mJ</th><th></th></tr></thead><tbody>\n";
  for (const LinkMeasurement& m : e.settings)
    if (shown(m)) html += rowOf(m);
  return html + "</tbody></table></div>\n";
}

std::string tablesOf(const SweepResult& result) {
  std::string html;
  for (const LinkExperimentResult& e : result.links) {
    html += "<h3>" + escaped(e.info.title) + "</h3>\n" +
            linkTable(e, [](const LinkMeasurement& m) { return !isLink(m) || m.setting.inUse; });
    if (std::count_if(e.settings.begin(), e.settings.end(), isLink) > 1)
      html += "<details><summary>Every packet rate, margin and impedance</summary>\n" + linkTable(e, isLink) +
              "</details>\n";
  }
  return html;
}

/// Each measure in one sentence.
const char* const kMeasures =
    "<ul>\n"
    "<li><b>Sites apart</b> is the distance, root mean square from 3 to 8 s, between the centres of "
    "the part at the two sites at one instant, while a firm arm leads it to and fro by 5 cm at 0.5 "
    "Hz and the other hand lightly holds on.</li>\n"
    "<li><b>Leader's force</b> is the leader's root mean square force in that drag, over what it is "
    "where both hands hold the part itself.</li>\n"
    "<li><b>Hand off part</b> is the distance, root mean square, of the leader's device from where "
    "the part that it sees is held.</li>\n"
    "<li><b>Change in 20 ms</b> is the largest by which the force on either hand differs from that "
    "20 ms before, in the steady middle of that drag.</li>\n"
    "<li><b>Hand to hand</b> is the force on a firm hand that holds still, over the distance between the "
    "two devices, while the other firm hand pulls 15 mm away.</li>\n"
    "<li><b>Wall</b> is the least-squares slope of force against travel that the co-holder feels who "
    "presses the part with 2 N against a wall of 5 N/mm (in series with the grasp of 1 N/mm: 833 "
    "N/m).</li>\n"
    "<li><b>kB/s</b> counts the sealed messages of one direction, without UDP and IP: those of the "
    "link as its wire encodes them; others are given the same header, pose and twist, the tank 4 "
    "bytes more and the server's forces 12.</li>\n"
    "<li><b>Tick</b> is the processor time of one end in one tick, replayed from the drag, over that "
    "of the implicit step of a held part in the same run; of the server its own step with both "
    "springs.</li>\n"
    "<li><b>Made</b> is the most by which the energy given at both devices ever exceeded what came "
    "in, in any run.</li>\n"
    "<li><b>Stable</b> is what never diverges, makes at most 1 mJ, and, where hands let go in "
    "tension, rests within 1 mm; what makes a joule, or goes 0.6 m astray, <b>diverges</b> and has "
    "no figures.</li>\n"
    "</ul>\n";

const char* const kArchitectures =
    R"(. The <b>coordination link</b> is the code that sessions run: replicas at both sites, tied by wave
variables. It stands beside what it replaces: the part simulated <b>on the server</b>, midway; a <b>plain
delayed spring</b> between replicas; the same spring behind a <b>tank</b> of energy (Franken et al. 2011);
and <b>no network</b>, both hands on the part itself. <i>Its best</i> are, of 75 pairs of gains tried at
each delay, those that feel stiffest from hand to hand, are stable, stay so with half as much stiffness
more, and take of the leader at most twice the force without a network. Where none will do, the softest
tried are shown. What is unstable stands as a cross above its plot.</p>
)";

std::string linkIntroduction(const SweepResult& result) {
  const int seeds = result.links.front().seeds;
  return R"(<h2>Across the network</h2>
<p>Two people hold one part of 1 kg, each at their own site, with 20 % jitter and 2 % loss between them;
arms and devices are modelled, time is virtual, and each figure is )" +
         (seeds == 1 ? std::string("that of seed 1") : "the worst of " + std::to_string(seeds) + " seeds") +
         kArchitectures + kMeasures;
}

const char* const kAboutDelay = R"(<h3>What it replaces, by delay</h3>
<p>A server shows both sites the same part, one delay late: they are close to each other, and far from the
hands. A link that is <i>off</i> leaves each with the whole part.</p>
)";

const char* const kAboutRate = R"(<h3>Packet rate: bytes against distance</h3>
<p>A line is an impedance b, along it the packet rate; the ring is the link as sessions have it. <b>Left is
cheaper, down is closer.</b> The sites of a server are close to each other, not to the hands.</p>
)";

const char* const kAboutImpedance = R"(<h3>Impedance: stiffness against the leader's force</h3>
<p>A line is a margin of the play-out, along it the impedance, at 250 packets a second. A line weighs b
times its delay, which the leader carries. <b>Left is lighter, up is stiffer.</b></p>
)";

const char* const kAboutMargin = R"(<h3>Margin and load</h3>
<p>How much later than what a link finds enough the peer is played out: -10, -5, 0, +10 ms, at 250 packets a
second. Sooner, the wave starves more often, and what the reserve cannot lend is lost; later costs distance
and stiffness. Last: what a tick of one end costs.</p>
)";

}  // namespace

std::string delayInWords(const LinkExperimentResult& e) { return number(1e3 * e.delay) + " ms one way"; }

std::string linkSection(const SweepResult& result) {
  if (result.links.empty()) return "";
  std::string html = linkIntroduction(result) + kAboutDelay + delayFigure(result);
  if (!turnedLinks(result).empty())
    html += kAboutRate + rateFigure(result) + kAboutImpedance + impedanceFigure(result) + kAboutMargin +
            marginFigure(result);
  return html + tablesOf(result);
}

void linkBounds(const LinkExperimentResult& e, std::vector<Bound>& bounds) {
  for (const LinkMeasurement& m : e.settings) {
    if (!m.setting.inUse) continue;
    const std::string where = delayInWords(e) + ": ";
    for (const LinkTarget& target : kLinkTargets) {
      if (std::abs(target.delay_ms - 1e3 * e.delay) > 0.5) continue;
      bounds.push_back({where + "wall felt by the co-holder", "N/m", m.wall, target.wall, true});
      if (target.handToHand > 0.0)
        bounds.push_back({where + "hand to hand", "N/m", m.handToHand, target.handToHand, true});
      if (target.apart_mm > 0.0)
        bounds.push_back({where + "sites apart, rms", "mm", 1e3 * m.apart, target.apart_mm});
      bounds.push_back({where + "leader's force", "×", m.load, target.load});
    }
    bounds.push_back(
        {where + "bytes each way at 250 packets a second", "kB/s", 1e-3 * m.bytes, kLinkBytesTarget_k});
    bounds.push_back({where + "energy made", "mJ", 1e3 * m.created, 1e3 * bench::kEnergyBound});
  }
}

}  // namespace tandem::client::report
