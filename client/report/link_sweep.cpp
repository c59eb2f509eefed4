#include "client/report/link_sweep.h"

#include <array>
#include <cmath>
#include <string>

#include "assets/base/assert.h"
#include "haptics/link/link_regime.h"

namespace tandem::client::report {
namespace {

constexpr std::array kDelays{10, 25, 50, 100, 250};  // ms
constexpr std::array kRates{60.0, 100.0, 150.0, 250.0, 500.0};
constexpr std::array kMargins{-10, -5, 0, 10};  // ms
constexpr std::array kImpedances{7, 14, 27, 40};
constexpr int kManySeeds = 3;
constexpr double kMaxLoad = 2.0;  // the largest load on a leader who can still lead, for gains that are found

constexpr SpringGains kPlainAsIs{400.0, 5.0};
constexpr SpringGains kSoftest{5.0, 2.0};  // of the gains that are tried

struct Known {
  int delay_ms;
  SpringGains plain, tank, server;
};
constexpr std::array<Known, 5> kKnown{{{10, {400.0, 5.0}, {400.0, 0.5}, {40.0, 2.0}},
                                       {25, {150.0, 5.0}, {100.0, 2.0}, {20.0, 2.0}},
                                       {50, {100.0, 5.0}, {60.0, 2.0}, {10.0, 0.5}},
                                       {100, {60.0, 5.0}, {40.0, 5.0}, {5.0, 2.0}},
                                       {250, {30.0, 10.0}, {40.0, 10.0}, {}}}};

int millisecondsOf(double delay) { return static_cast<int>(std::lround(1e3 * delay)); }

const char* nameOf(Architecture architecture) {
  switch (architecture) {
    case Architecture::link:
      return "coordination link";
    case Architecture::plain:
      return "plain delayed spring";
    case Architecture::tank:
      return "tank";
    case Architecture::server:
      return "on the server";
    case Architecture::oneRoom:
      return "no network";
  }
  return "";
}

LinkSetting rival(const char* id, Architecture architecture, const SpringGains& gains,
                  const char* which = "") {
  LinkSetting s;
  s.id = id;
  s.name = std::string(nameOf(architecture)) + which;
  s.architecture = architecture;
  s.gains = gains;
  s.letsGo = true;
  return s;
}

/// The impedance of sessions at this delay, N·s/m.
int usedImpedance(double delay) {
  haptics::RegimeByAge regime;
  regime.restart(delay);
  const haptics::LinkParameters p;
  return static_cast<int>(
      std::lround(regime.regime() == haptics::LinkRegime::stiff ? p.impedance : p.softImpedance));
}

LinkSetting inUse(double delay) {
  LinkSetting s;
  s.impedance = usedImpedance(delay);
  s.id = "link";
  s.name = nameOf(Architecture::link);
  s.inUse = s.letsGo = true;
  return s;
}

/// A link with other parameters than those in use.
LinkSetting turned(double rate, int margin_ms, int impedance) {
  LinkSetting s;
  s.id = "link-" + std::to_string(static_cast<int>(rate)) + "hz-margin" + std::to_string(margin_ms) + "ms-b" +
         std::to_string(impedance);
  s.name = "coordination link, " + std::to_string(static_cast<int>(rate)) + " Hz, " +
           (margin_ms > 0 ? "+" : "") + std::to_string(margin_ms) + " ms, b = " + std::to_string(impedance);
  s.packetHz = rate;
  s.margin = 1e-3 * margin_ms;
  s.impedance = impedance;
  return s;
}

/// Every combination of the parameters; with --quick one parameter at a time.
std::vector<LinkSetting> turnedSettings(double delay, bool quick) {
  std::vector<LinkSetting> all;
  if (delay > haptics::LinkParameters{}.longestDelay) return all;
  for (const int impedance : kImpedances)
    for (const int margin : kMargins)
      for (const double rate : kRates) {
        const int off = (rate != 250.0) + (margin != 0) + (impedance != usedImpedance(delay));
        if (off > 0 && (!quick || off == 1)) all.push_back(turned(rate, margin, impedance));
      }
  return all;
}

std::vector<LinkSetting> settingsAt(double delay, const SweepOptions& options) {
  const auto best = [&](Architecture architecture) {
    return options.thoroughLinks ? searchGains(architecture, delay, kManySeeds)
                                 : knownGains(architecture, delay);
  };
  std::vector<LinkSetting> all{inUse(delay), rival("no-network", Architecture::oneRoom, {}),
                               rival("plain-400", Architecture::plain, kPlainAsIs, ", 400 N/m")};
  for (const auto& [id, architecture] : {std::pair{"plain-best", Architecture::plain},
                                         {"tank-best", Architecture::tank},
                                         {"server-best", Architecture::server}}) {
    const SpringGains gains = best(architecture);
    const bool found = gains.stiffness > 0.0;
    all.push_back(rival(id, architecture, found ? gains : kSoftest, found ? ", its best" : ", its softest"));
  }
  for (LinkSetting& s : turnedSettings(delay, options.quick)) all.push_back(std::move(s));
  return all;
}

/// Whether a tick is timed. The cost depends on the architecture and on the packet rate alone.
bool isTimed(const LinkSetting& s, double delay) {
  if (s.architecture != Architecture::link) return true;
  return s.inUse || (s.margin == 0.0 && s.impedance == usedImpedance(delay));
}

/// The worst of all seeds, or the first alone where that is unstable.
LinkMeasurement worstOf(const LinkSetting& setting, double delay, int seeds, double alone) {
  const LinkMeasurement first = measureLink(setting, delay, 1, alone);
  return first.stable() ? measureLink(setting, delay, seeds, alone) : first;
}

}  // namespace

double delayOf(const ExperimentInfo& info) {
  ASSERT(info.id.starts_with("link-"));
  return 1e-3 * std::stod(info.id.substr(5));
}

std::vector<ExperimentInfo> allLinkExperiments() {
  std::vector<ExperimentInfo> all;
  for (const int delay : kDelays) {
    const std::string ms = std::to_string(delay);
    all.push_back({"link-" + ms + "ms", "link", "Two sites on one part, " + ms + " ms one way",
                   "Two people hold one part across " + ms + " ms each way, 20 % jitter, 2 % loss.",
                   delay == 25 || delay == 100});
  }
  return all;
}

std::vector<ExperimentInfo> chosenLinkExperiments(const SweepOptions& options) {
  return chosenOf(allLinkExperiments(), options);
}

SpringGains knownGains(Architecture architecture, double delay) {
  for (const Known& known : kKnown) {
    if (known.delay_ms != millisecondsOf(delay)) continue;
    if (architecture == Architecture::plain) return known.plain;
    if (architecture == Architecture::tank) return known.tank;
    if (architecture == Architecture::server) return known.server;
  }
  return {};
}

SpringGains searchGains(Architecture architecture, double delay, int seeds) {
  SpringGains best;
  double stiffest = 0.0;
  const double alone = loadWithoutNetwork();
  for (const double damping : {0.5, 2.0, 5.0, 10.0, 20.0}) {
    for (const double stiffness : {2000.0, 1000.0, 600.0, 400.0, 300.0, 200.0, 150.0, 100.0, 80.0, 60.0, 40.0,
                                   30.0, 20.0, 10.0, 5.0}) {
      const LinkSetting setting = rival("tried", architecture, {stiffness, damping});
      LinkSetting more = setting;
      more.gains.stiffness *= 1.5;
      const LinkMeasurement m = worstOf(setting, delay, seeds, alone);
      if (!m.stable() || m.load > kMaxLoad || !worstOf(more, delay, seeds, alone).stable()) continue;
      if (m.handToHand > stiffest) {
        stiffest = m.handToHand;
        best = setting.gains;
      }
      break;  // softer springs under the same damper feel softer
    }
  }
  return best;
}

LinkExperimentResult sweepLinks(const ExperimentInfo& info, const SweepOptions& options) {
  LinkExperimentResult out;
  out.info = info;
  out.delay = delayOf(info);
  out.seeds = options.thoroughLinks ? kManySeeds : 1;
  const double alone = loadWithoutNetwork();
  for (const LinkSetting& setting : settingsAt(out.delay, options)) {
    out.settings.push_back(measureLink(setting, out.delay, out.seeds, alone));
    if (isTimed(setting, out.delay)) out.settings.back().cost = tickCost(setting, out.delay);
  }
  return out;
}

}  // namespace tandem::client::report
