#include "client/commands/join_report.h"

#include <cstdio>

#include "assets/base/json.h"
#include "assets/base/utc_time.h"
#include "client/base/tick_flags.h"
#include "client/base/traffic_json.h"
#include "client/session/document_words.h"
#include "client/session/doubt_words.h"
#include "client/session/holding_words.h"

namespace tandem::client {

namespace {

Json flagNames(std::uint32_t flags) {
  Json names = Json::array();
  for (const auto& [flag, name] : tickFlagNames())
    if ((flags & flag) != 0) names.push(name);
  return names;
}

Json partNames(const ViewModel& model, const auto& isOne) {
  Json names = Json::array();
  for (std::size_t part = 0; part < model.scene->parts.size(); ++part)
    if (isOne(static_cast<PartId>(part))) names.push(model.scene->parts[part].name);
  return names;
}

std::string nameOfSite(const ViewModel& model, SiteId site) {
  for (const SiteView& view : model.sites)
    if (view.info.site == site) return view.info.name;
  return {};
}

/// Of which sites others do not believe the motion.
Json doubtsJson(const ViewModel& model) {
  Json json = Json::array();
  for (const SiteView& site : model.sites) {
    if (site.doubtedBy.empty()) continue;
    Json by = Json::array();
    for (const SiteId doubter : site.doubtedBy) by.push(nameOfSite(model, doubter));
    json.push({{"about", site.info.name}, {"by", by}, {"in_words", doubtsInWords(model, site)}});
  }
  return json;
}

/// The clash that the sharing site looks at; null if none.
Json clashJson(const ViewModel& model, const sync::Inspection& looks) {
  if (looks.a == kNoPart) return {};
  return {{"a", partName(model, looks.a)},
          {"b", partName(model, looks.b)},
          {"mark", sync::kClashMarkNames[static_cast<std::size_t>(looks.mark)]},
          {"amount_m", looks.amount},
          {"moved", looks.moved},
          {"on_a", {looks.onA.x, looks.onA.y, looks.onA.z}},
          {"on_b", {looks.onB.x, looks.onB.y, looks.onB.z}}};
}

/// What others share and point at, and what was said; of a site without a window also what it shares and
/// follows, and the section planes in effect.
Json presentingJson(const ViewModel& model, const HeadlessView* view) {
  const PresentingView& presenting = model.presenting;
  Json json;
  json["shared_by"] = nameOfSite(model, presenting.shared.site);
  json["shared"] = sync::kSharesNames[static_cast<std::size_t>(presenting.shared.shares)];
  json["selected"] = partName(model, presenting.shared.selected);
  json["explode"] = presenting.shared.style.explode;
  json["colours"] = document::kColouringNames[static_cast<std::size_t>(presenting.shared.style.colouring)];
  json["hidden"] = partNames(model, [&](PartId part) { return presenting.hides(part); });
  json["clash"] = clashJson(model, presenting.shared.inspection);
  json["measuring"] = presenting.shared.inspection.measuring;
  json["marks"] = Json::array();
  for (const document::Anchor& mark : presenting.shared.inspection.marks)
    json["marks"].push(
        {{"part", partName(model, mark.part)}, {"place", {mark.point.x, mark.point.y, mark.point.z}}});
  json["points"] = Json::array();
  for (const sync::Presentation& shown : presenting.points)
    json["points"].push({{"by", nameOfSite(model, shown.site)},
                         {"part", partName(model, shown.pointedAt)},
                         {"place", {shown.place.x, shown.place.y, shown.place.z}}});
  json["said"] = Json::array();
  for (const ChatLine& chat : model.chat)
    json["said"].push({{"by", chat.line.name},
                       {"text", chat.line.said.text},
                       {"at", utcText(chat.line.at)},
                       {"earlier", chat.earlier}});
  if (view == nullptr) return json;
  json["shares"] = sync::kSharesNames[static_cast<std::size_t>(view->shares())];
  json["follows"] = view->following().followsView()       ? "view"
                    : view->following().followsSections() ? "sections"
                                                          : "nothing";
  json["sections"] = Json::array();
  for (const document::SectionPlane& plane : view->sections(model))
    json["sections"].push({{"point", {plane.point.x, plane.point.y, plane.point.z}},
                           {"normal", {plane.normal.x, plane.normal.y, plane.normal.z}}});
  return json;
}

}  // namespace

std::string reportJson(JoinedSite& site, const ViewModel& model, const JoinReport& report,
                       const HeadlessView* view, const std::string& end) {
  Json json;
  json["site"] = site.id();
  json["role"] = sync::toString(site.role());
  json["end"] = end;
  const haptics::ServoStatistics servo = site.servoStatistics();
  json["ticks"] = servo.ticks;
  json["late"] = servo.late;
  json["stalls"] = model.hand.stalls;
  json["compute_us"] = {
      {"p50", servo.compute_us_p50}, {"p99", servo.compute_us_p99}, {"max", servo.compute_us_max}};
  const ConnectionStatistics connection = site.connectionStatistics();
  json["round_trip_ms"] = connection.roundTrip_ms;
  json["loss_up"] = connection.lossUp;
  json["loss_down"] = connection.lossDown;
  json["play_out_ms"] = connection.playOut_ms;
  json["reconnects"] = connection.reconnects;
  json["sent"] = trafficJson(connection.sent);
  json["received"] = trafficJson(connection.received);
  json["voice_url"] = model.connection.voiceUrl;
  json["dropped_states"] = connection.droppedStates;
  json["state_over_udp"] = model.connection.stateOverUdp;
  json["flags_seen"] = flagNames(model.hand.flagsSeen);
  json["fault"] = nullptr;
  if (!model.hand.fault.empty()) json["fault"] = model.hand.fault;
  json["fault_clears"] = report.faultClears;
  json["tool_radius_m"] = model.hand.toolRadius;
  json["stiffest_contact_n_per_m"] = model.hand.stiffest;
  json["models"] = {{"coarse_s", report.modelSeconds}, {"refined", model.loop.refined}};
  if (const SecondHandView& second = model.hand.second; !second.deviceName.empty()) {
    json["second_hand"] = {{"device", second.deviceName},
                           {"held", nullptr},
                           {"largest_force_n", second.mostForce},
                           {"flags_seen", flagNames(second.flagsSeen)}};
    if (second.held != kNoPart) json["second_hand"]["held"] = site.scene().parts[second.held].name;
  }
  if (model.document != nullptr)
    json["document"] = {{"entries", model.document->size()}, {"in_words", inWords(*model.document)}};
  json["doubts"] = doubtsJson(model);
  json["presenting"] = presentingJson(model, view);
  json["grabs"] = Json::array();
  for (const GrabNote& grab : report.grabs)
    json["grabs"].push({{"t", grab.time},
                        {"wait_ms", grab.wait_ms},
                        {"part", site.scene().parts[grab.part].name},
                        {"answer", sync::toString(grab.denial)},
                        {"owner", grab.owner}});
  json["ownership"] = Json::array();
  for (const OwnershipNote& note : report.ownership)
    json["ownership"].push({{"t", note.time},
                            {"part", site.scene().parts[note.record.part].name},
                            {"owner", note.record.owner},
                            {"epoch", note.record.epoch}});
  for (std::size_t i = 0; i < site.scene().parts.size(); ++i) {
    if (!site.scene().parts[i].movable) continue;
    const Pose& pose = model.worldFromPart[i];
    json["poses"][site.scene().parts[i].name] = {pose.position.x,    pose.position.y,    pose.position.z,
                                                 pose.orientation.w, pose.orientation.x, pose.orientation.y,
                                                 pose.orientation.z};
  }
  return json.rounded().dump(2);
}

PoseTrace::PoseTrace(const std::string& path) : file_(path) {
  file_ << "session_us,part,owned,x,y,z,qw,qx,qy,qz\n";
}

void PoseTrace::add(const ShownPose& shown, const assets::Scene& scene) {
  if (shown.time == 0) return;
  const glm::dvec3& p = shown.worldFromPart.position;
  const glm::dquat& q = shown.worldFromPart.orientation;
  char line[320];
  std::snprintf(line, sizeof line, "%lld,%s,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",
                static_cast<long long>(shown.time), scene.parts[shown.part].name.substr(0, 100).c_str(),
                shown.owned ? 1 : 0, p.x, p.y, p.z, q.w, q.x, q.y, q.z);
  file_ << line;
}

}  // namespace tandem::client
