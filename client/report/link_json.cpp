#include "client/report/link_json.h"

#include <limits>

#include "assets/base/json.h"
#include "client/report/measurement_json.h"

namespace tandem::client::report {
namespace {

const char* architectureKey(Architecture architecture) {
  switch (architecture) {
    case Architecture::link:
      return "link";
    case Architecture::plain:
      return "plain";
    case Architecture::tank:
      return "tank";
    case Architecture::server:
      return "server";
    case Architecture::oneRoom:
      return "no-network";
  }
  return "";
}

/// A figure as JSON; null if the run diverged, because its values are meaningless.
Json figure(const LinkMeasurement& m, double value) {
  return numberJson(m.diverged ? std::numeric_limits<double>::quiet_NaN() : value);
}

Json linkSettingJson(const LinkMeasurement& m) {
  const LinkSetting& s = m.setting;
  Json json = {
      {"id", s.id}, {"name", s.name}, {"architecture", architectureKey(s.architecture)}, {"in_use", s.inUse}};
  json["packet_hz"] = s.packetHz;
  if (s.architecture == Architecture::link) {
    json["margin_s"] = s.margin;
    json["impedance_ns_m"] = s.impedance;
    json["off_share"] = m.off;
  } else {
    json["stiffness_n_m"] = s.gains.stiffness;
    json["damping_ns_m"] = s.gains.damping;
  }
  json["stable"] = m.stable();
  json["diverged"] = m.diverged;
  json["created_j"] = numberJson(m.created);
  json["rest_m"] = figure(m, m.rest);
  json["apart_m"] = {{"rms", figure(m, m.apart)}, {"max", figure(m, m.maxApart)}};
  json["off_grip_m"] = figure(m, m.offGrip);
  json["hand_to_hand_n_m"] = figure(m, m.handToHand);
  json["wall_n_m"] = figure(m, m.wall);
  json["leader_force_ratio"] = figure(m, m.load);
  json["change_n"] = figure(m, m.change);
  json["play_out_s"] = figure(m, m.playOut);
  json["bytes_per_s"] = numberJson(m.bytes);
  json["tick_cost"] = numberJson(m.cost);
  return json;
}

}  // namespace

Json linkExperimentJson(const LinkExperimentResult& e) {
  Json json = {{"id", e.info.id},
               {"title", e.info.title},
               {"about", e.info.about},
               {"one_way_s", e.delay},
               {"seeds", e.seeds}};
  json["settings"] = Json::array();
  for (const LinkMeasurement& m : e.settings) json["settings"].push(linkSettingJson(m));
  return json;
}

}  // namespace tandem::client::report
