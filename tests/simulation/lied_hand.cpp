#include "tests/simulation/lied_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "assets/gltf/load_gltf.h"

namespace tandem::test {

using namespace sync;

const haptics::ContactScene& lyingScene() {
  struct Made {
    assets::Scene scene;
    std::unique_ptr<haptics::ContactScene> contact;
    Made() {
      const std::string path =
          std::string(TANDEM_SOURCE_DIR) + "/tests/simulation/scenarios/shared_blocks.gltf";
      Result<assets::Scene> loaded = assets::loadGltf(path, {});
      EXPECT_TRUE(loaded.ok());
      scene = std::move(*loaded);
      contact = std::make_unique<haptics::ContactScene>(scene);
      EXPECT_TRUE(contact->modelParts());
    }
  };
  static const Made made;
  return *made.contact;
}

LiedHand::LiedHand(const Options& options)
    : network_(options.seed, NetworkConditions{20 * kMillisecond, options.jitter, options.loss, 0.0, 0.0}),
      server_(network_.listen()),
      frame_(wireFrame(lyingScene().scene().bounds)),
      exchange_(std::make_unique<client::Exchange>()),
      hand_(std::make_unique<client::HandLoop>(lyingScene(), *exchange_)),
      period_(static_cast<Micros>(1e6 / options.packetHz)) {
  const assets::Scene& scene = lyingScene().scene();
  client::ConnectionOptions connection;
  connection.name = "honest";
  site_ = std::make_unique<client::ServerConnection>(
      connection, [this]() -> Result<std::unique_ptr<Transport>> { return network_.connect("honest"); });
  Result<client::HandScript> script = client::parseHandScript(options.script, "script", scene);
  EXPECT_TRUE(script.ok()) << (script.ok() ? "" : script.error().message);
  device_ = std::make_unique<client::ScriptedDevice>(
      scene, std::move(*script), options.arm, haptics::SimulatedDeviceParameters{},
      Pose{options.start, {1.0, 0.0, 0.0, 0.0}}, [this](PartId part) { return hand_->worldFromPart(part); });
  client::HandSettingsInput settings;
  settings.parameters[0].gravity = scene.gravity;
  if (!options.guarded) settings.parameters[0].foreign.slew = 0.0;
  exchange_->settings.write(settings);
  block_.part = 0;
  block_.epoch = 1;
  block_.worldFromPart = scene.parts[0].worldFromPart;
  rest(0.2);
  EXPECT_EQ(site_->stage(), client::ServerConnection::Stage::ready);
  mark();
}

void LiedHand::answer(const ControlMessage& message) {
  heard_.push_back(message);
  if (std::holds_alternative<Hello>(message)) {
    Welcome welcome;
    welcome.site = kHonest;
    welcome.role = Role::participant;
    welcome.resumeTicket = "ticket";
    welcome.sessionTime = now_;
    welcome.lease = kSecond;
    for (const SiteId site : {kHonest, kLiar}) {
      SiteInfo info;
      info.site = site;
      info.name = site == kLiar ? "Eve" : "Ben";
      info.role = Role::participant;
      welcome.sites.push_back(info);
    }
    welcome.parts = {PartRecord{0, kLiar, 1, block_.worldFromPart}};
    say(welcome);
  }
  if (const auto* grab = std::get_if<Grab>(&message)) {
    PartRecord record{grab->part, kHonest, 1, lyingScene().scene().parts[grab->part].worldFromPart};
    if (grab->part == 0) record = {0, kLiar, block_.epoch, block_.worldFromPart};
    const Denial denial = grab->part == 0 ? Denial::ownedByOther : Denial::none;
    if (denial == Denial::none) say(OwnershipChanged{record});
    say(GrabReply{grab->request, denial, record});
  }
  if (const auto* engage = std::get_if<Engage>(&message)) {
    CoHolderRecord holders{engage->part, block_.epoch, grantsCoHolding ? 1u : 0u, {}};
    coHolds_ = grantsCoHolding;
    if (coHolds_) holders.sites = {kHonest};
    if (coHolds_) say(MembersChanged{holders});
    say(EngageReply{engage->request, coHolds_ ? Denial::none : Denial::notOwned, holders});
  }
}

void LiedHand::serve() {
  TransportEvent event;
  while (server_->poll(event)) {
    if (event.kind == TransportEvent::Kind::connected) peer_ = event.connection;
    if (event.kind == TransportEvent::Kind::control) {
      if (const auto message = decodeControl(event.bytes)) answer(*message);
    } else if (event.kind == TransportEvent::Kind::state) {
      std::span<const std::byte> datagram = event.bytes;
      while (!datagram.empty()) {
        StateMessage message;
        if (!decodeState(popMessage(datagram), frame_, message)) continue;
        if (const auto* ping = std::get_if<Ping>(&message))
          send(Pong{ping->sequence, ping->siteTime, now_, 0});
        if (const auto* link = std::get_if<LinkUpdate>(&message); link != nullptr && onLink) onLink(*link);
      }
    }
  }
}

void LiedHand::send(const StateMessage& message) {
  std::vector<std::byte> bytes;
  encodeState(message, frame_, bytes);
  server_->sendState(peer_, bytes);
}

void LiedHand::publish(const Claim& claim) {
  block_.worldFromPart = claim.worldFromPart;
  block_.twist = claim.twist;
  ++block_.sequence;
  StateUpdate update;
  update.site = update.presence.site = kLiar;
  update.sequence = ++sequence_;
  update.time = now_ - claim.late;
  update.newPresence = update.presenceKnown = false;
  update.parts = {block_};
  std::vector<std::byte> bytes;
  sender_.encode(update, frame_, bytes);
  server_->sendState(peer_, bytes);
}

void LiedHand::reown(const Pose& worldFromPart) {
  ++block_.epoch;
  block_.sequence = 0;
  block_.worldFromPart = worldFromPart;
  say(OwnershipChanged{PartRecord{0, kLiar, block_.epoch, worldFromPart}});
}

void LiedHand::tick() {
  now_ += kMillisecond;
  network_.advanceTo(now_);
  serve();
  const haptics::DeviceSample reading = device_->poll(toSeconds(now_));
  hand_->setWish(device_->wish());
  const Wrench toHand = hand_->tick(reading, now_);
  device_->apply(toHand);
  site_->step(now_);
  if (site_->stage() == client::ServerConnection::Stage::needScene) site_->skipTransfer();
  if (site_->stage() == client::ServerConnection::Stage::haveScene)
    site_->sceneReady(lyingScene().scene(), *exchange_);
  client::ShownPose shown;
  while (exchange_->shown.pop(shown)) continue;
  forces_.push_back(toHand.force);
  guardedTicks_ += (hand_->output().tick.flags & haptics::kFlagForeignLimited) != 0 ? 1 : 0;
  energy_ = std::max(energy_, device_->hand().energyGiven() - energyAt_);
}

void LiedHand::rest(double seconds) {
  for (const Micros end = now_ + static_cast<Micros>(seconds * 1e6); now_ < end; tick())
    if (now_ % period_ == 0 && peer_ != 0) publish({block_.worldFromPart, {}, 0});
}

void LiedHand::lie(double seconds, const Liar& liar) {
  const Micros begin = now_;
  for (const Micros end = now_ + static_cast<Micros>(seconds * 1e6); now_ < end; tick())
    if (now_ % period_ == 0) publish(liar(toSeconds(now_ - begin)));
}

void LiedHand::mark() {
  forces_.assign(forces_.empty() ? 0 : 1, forces_.empty() ? glm::dvec3(0.0) : forces_.back());
  energyAt_ = device_->hand().energyGiven();
  energy_ = 0.0;
  guardedTicks_ = 0;
}

double LiedHand::forceStep() const {
  double largest = 0.0;
  for (std::size_t i = 1; i < forces_.size(); ++i)
    for (std::size_t back = 1; back <= std::min<std::size_t>(20, i); ++back)
      largest = std::max(largest, glm::length(forces_[i] - forces_[i - back]));
  return largest;
}

double LiedHand::maxForce() const {
  double most = 0.0;
  for (const glm::dvec3& force : forces_) most = std::max(most, glm::length(force));
  return most;
}

}  // namespace tandem::test
