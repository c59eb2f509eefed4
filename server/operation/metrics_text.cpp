#include "server/operation/metrics_text.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "assets/base/assert.h"
#include "sync/wire/participant_messages.h"

namespace tandem::server {
namespace {

std::string inSeconds(sync::Micros time) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.15g", sync::toSeconds(time));
  return text.data();
}

/// Writes families one after another: HELP, TYPE, samples.
class Text {
 public:
  void family(const std::string& name, const char* type, const char* help) {
    name_ = "tandem_" + name;
    out_ += "# HELP " + name_ + ' ' + help + "\n# TYPE " + name_ + ' ' + type + '\n';
  }
  void sample(const std::string& labels, const std::string& value, const char* suffix = "") {
    ASSERT(!name_.empty());
    out_ += name_ + suffix + (labels.empty() ? "" : '{' + labels + '}') + ' ' + value + '\n';
  }
  void sample(const std::string& labels, std::uint64_t value) { sample(labels, std::to_string(value)); }
  std::string take() { return std::move(out_); }

 private:
  std::string out_, name_;
};

/// Names of sites are people's text.
std::string escaped(const std::string& value) {
  std::string out;
  for (const char c : value) {
    if (c == '\\' || c == '"') out += '\\';
    out += c == '\n' ? std::string("\\n") : std::string(1, c);
  }
  return out;
}

std::string label(const std::string& key, const std::string& value) {
  return key + "=\"" + escaped(value) + '"';
}

std::string labelsOf(const ConnectedSite& site) {
  return label("site", std::to_string(site.site)) + ',' + label("role", sync::toString(site.role));
}

void writeHistogram(Text& text, const char* name, const char* help, const DurationHistogram& histogram) {
  text.family(name, "histogram", help);
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    total += histogram.counts[i];
    const bool last = i == DurationHistogram::kBounds.size();
    text.sample(label("le", last ? "+Inf" : inSeconds(DurationHistogram::kBounds[i])), std::to_string(total),
                "_bucket");
  }
  text.sample("", inSeconds(histogram.sum), "_sum");
  text.sample("", std::to_string(total), "_count");
}

void writeSites(Text& text, const SessionFigures& figures) {
  text.family("sites", "gauge", "Sites that are connected.");
  for (const sync::Role role : {sync::Role::observer, sync::Role::participant, sync::Role::instructor})
    text.sample(label("role", sync::toString(role)),
                static_cast<std::uint64_t>(
                    std::count_if(figures.sites.begin(), figures.sites.end(),
                                  [role](const ConnectedSite& site) { return site.role == role; })));
  text.family("strangers", "gauge", "Connections that have sent no hello.");
  text.sample("", figures.strangers);
  text.family("site_info", "gauge", "1 for each connected site, with its name.");
  for (const ConnectedSite& site : figures.sites)
    text.sample(labelsOf(site) + ',' + label("name", site.name), 1);
}

void writeTraffic(Text& text, const SessionCounters& counts) {
  const auto each = [&](const char* unit, const sync::Traffic& traffic, const char* way) {
    for (const auto& cause : sync::kTrafficCauses) {
      const sync::Flow& flow = traffic.*cause.flow;
      text.sample(label("direction", way) + ',' + label("cause", cause.name),
                  unit[0] == 'm' ? flow.packets : flow.bytes);
    }
  };
  for (const char* unit : {"messages", "bytes"}) {
    text.family(std::string("traffic_") + unit + "_total", "counter",
                "Messages of the protocol, without what transport adds.");
    each(unit, counts.received, "in");
    each(unit, counts.sent, "out");
  }
}

void writeTransport(Text& text, const sync::TransportCounters& transport) {
  text.family("transport_bytes_total", "counter",
              "Bytes of messages and datagrams, without what encryption adds.");
  const auto bytes = [&](const char* channel, std::uint64_t in, std::uint64_t out) {
    text.sample(label("direction", "in") + ',' + label("channel", channel), in);
    text.sample(label("direction", "out") + ',' + label("channel", channel), out);
  };
  bytes("control", transport.controlBytesIn, transport.controlBytesOut);
  bytes("state", transport.stateBytesIn, transport.stateBytesOut);
  text.family("transport_datagrams_total", "counter", "Datagrams of state.");
  text.sample(label("direction", "in"), transport.statePacketsIn);
  text.sample(label("direction", "out"), transport.statePacketsOut);
}

void writeRelayed(Text& text, const SessionCounters& counts) {
  text.family("relayed_total", "counter", "What sites sent for others and the server passed on.");
  text.sample(label("kind", "update"), counts.relayedUpdates);
  text.sample(label("kind", "part"), counts.relayedParts);
  text.sample(label("kind", "link"), counts.relayedLinks);
  text.sample(label("kind", "presentation"), counts.relayedPresentations);
}

void writeDrops(Text& text, const SessionCounters& counts, const sync::TransportCounters& transport) {
  const std::pair<const char*, std::uint64_t> all[] = {
      {"stale_or_not_owner", counts.droppedStates},
      {"malformed", counts.droppedMalformed},
      {"missing_baseline", counts.droppedBaselines},
      {"not_ready", counts.droppedEarly},
      {"link_without_part", counts.droppedLinks},
      {"over_rate", counts.droppedFlood},
      {"over_rate_unopened", transport.droppedFlood},
      {"unknown_connection", transport.droppedUnknown},
      {"forged", transport.droppedForged},
      {"replayed", transport.droppedReplayed},
      {"oversized", transport.droppedOversized},
      {"queue_full", transport.droppedFull},
  };
  text.family("dropped_total", "counter", "State messages and datagrams that had no effect, by reason.");
  for (const auto& [reason, count] : all) text.sample(label("reason", reason), count);
}

void writeDecisions(Text& text, const SessionCounters& counts, const sync::TransportCounters& transport) {
  text.family("decisions_total", "counter", "What became of parts.");
  text.sample(label("kind", "grant"), counts.grants);
  text.sample(label("kind", "denial"), counts.denials);
  text.sample(label("kind", "release"), counts.releases);
  text.sample(label("kind", "expiry"), counts.expiries);
  text.family("refused_total", "counter",
              "Hellos, messages, poses, reports, doubts, and what was shown or said, that was refused.");
  text.sample(label("what", "hello"), counts.refusedHellos);
  text.sample(label("what", "message"), counts.refusedMessages);
  text.sample(label("what", "pose"), counts.refusedPoses);
  text.sample(label("what", "report"), counts.refusedReports);
  text.sample(label("what", "presentation"), counts.droppedPresentations);
  text.sample(label("what", "say"), counts.droppedSays);
  text.sample(label("what", "doubt"), counts.droppedDoubts);
  text.family("failed_handshakes_total", "counter", "Connections that ended before their greeting.");
  text.sample("", transport.failedHandshakes);
  text.family("budget_holds_total", "counter", "Times that a site had spent its budget of requests.");
  text.sample("", counts.holds);
}

void writeJournal(Text& text, const SessionFigures& figures) {
  text.family("journal_sound", "gauge", "1 while the journal can be written.");
  text.sample("", figures.journalFailure.empty() ? 1 : 0);
  writeHistogram(text, "journal_durable_seconds", "From a record's append until it is durable.",
                 figures.counters.journal);
}

void writeReports(Text& text, const SessionFigures& figures) {
  const auto each = [&](const char* name, const char* type, const char* help, const auto& value) {
    text.family(name, type, help);
    for (const ConnectedSite& site : figures.sites)
      if (site.figures.reports > 0) text.sample(labelsOf(site), value(site.figures));
  };
  each("site_ticks_total", "counter", "Ticks of the haptic loop, as reported.",
       [](const SiteFigures& s) { return std::to_string(s.ticks); });
  each("site_ticks_missed_total", "counter", "Ticks that began late or were left out, as reported.",
       [](const SiteFigures& s) { return std::to_string(s.missed); });
  each("site_ticks_force_limited_total", "counter", "Ticks at the device's force limit, as reported.",
       [](const SiteFigures& s) { return std::to_string(s.forceLimited); });
  each("site_round_trip_seconds", "gauge", "Round trip of the newest ping, as reported.",
       [](const SiteFigures& s) { return inSeconds(s.latest.roundTrip); });
  text.family("site_tick_seconds", "gauge",
              "Time of computation of a tick in the last period of 5 s, as reported.");
  for (const ConnectedSite& site : figures.sites) {
    if (site.figures.reports == 0) continue;
    const sync::SiteReport& latest = site.figures.latest;
    text.sample(labelsOf(site) + ',' + label("quantile", "0.5"), inSeconds(latest.tick50));
    text.sample(labelsOf(site) + ',' + label("quantile", "0.99"), inSeconds(latest.tick99));
    text.sample(labelsOf(site) + ',' + label("quantile", "1"), inSeconds(latest.tickMax));
  }
}

void writeRefusedReports(Text& text, const SessionFigures& figures) {
  text.family("site_reports_refused_total", "counter", "Reports of a site that cannot be true.");
  for (const ConnectedSite& site : figures.sites) text.sample(labelsOf(site), site.figures.refused);
}

void writeDoubts(Text& text, const SessionFigures& figures) {
  text.family("doubts_total", "counter", "Times that a site began to say that it does not believe another.");
  text.sample("", figures.counters.doubts);
  text.family("site_doubted_by", "gauge", "Sites that do not believe the motion of this one.");
  for (const ConnectedSite& site : figures.sites) text.sample(labelsOf(site), site.doubtedBy);
}

}  // namespace

std::string metricsText(const ServerFigures& figures) {
  const SessionFigures& session = figures.session;
  Text text;
  writeSites(text, session);
  writeTraffic(text, session.counters);
  writeTransport(text, session.transport);
  writeRelayed(text, session.counters);
  writeDrops(text, session.counters, session.transport);
  writeDecisions(text, session.counters, session.transport);
  writeJournal(text, session);
  writeHistogram(text, "loop_round_seconds", "A round of the server's loop, its wait left out.",
                 figures.rounds);
  writeReports(text, session);
  writeRefusedReports(text, session);
  writeDoubts(text, session);
  return text.take();
}

}  // namespace tandem::server
