#include "client/simulation/light_site.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;
using Stage = ServerConnection::Stage;

namespace {

constexpr Micros kAsksAgain = kSecond;       // from a refusal to the next link
constexpr Micros kStep = 25 * kMillisecond;  // of a program that does other things too
constexpr double kDriftBound = 500.0;        // ppm, that two clocks may disagree by (sync/README.md)

}  // namespace

std::unique_ptr<Exchange> ExchangePool::take() {
  if (free_.empty()) return std::make_unique<Exchange>();
  std::unique_ptr<Exchange> exchange = std::move(free_.back());
  free_.pop_back();
  return exchange;
}

void ExchangePool::giveBack(std::unique_ptr<Exchange> exchange) {
  NetworkEvent event;
  while (exchange->events.pop(event)) continue;
  HandIntent intent;
  while (exchange->intents.pop(intent)) continue;
  SiteId site;
  while (exchange->doubts.pop(site)) continue;
  haptics::AddressedPacket packet;
  while (exchange->linksIn.pop(packet) || exchange->linksOut.pop(packet)) continue;
  exchange->timeBase.write({});
  exchange->output.write({});
  free_.push_back(std::move(exchange));
}

LightSite::LightSite(const LightWorld& world, ExchangePool& pool, std::size_t index,
                     const ScenarioSite& description, HandScript script, Micros clockOffset)
    : SimulatedClient(world.invariants, world.scene, index, description, clockOffset),
      world_(world),
      pool_(pool),
      script_(std::move(script)),
      joinsAt_(static_cast<Micros>(std::llround(description.joins * 1e6))),
      nextDue_(joinsAt_),
      fetches_(index % 2 == 1) {}

LightSite::~LightSite() { end(); }

/// The client and all that it knew are gone.
void LightSite::end() {
  granted_ = granted();
  connection_.reset();
  hand_.reset();
  if (exchange_) pool_.giveBack(std::exchange(exchange_, nullptr));
  id_ = kNoSite;
}

std::uint64_t LightSite::drainGranted() { return granted() - std::exchange(drained_, granted()); }

void LightSite::start() {
  ASSERT(!started());
  ConnectionOptions options;
  options.name = description_.name;
  options.rates.max = world_.scenario.packetHz;
  options.rates.min = std::min(options.rates.min, options.rates.max);
  options.rates.deadband = description_.deadband;
  options.token = world_.server.makeToken(description_.role);
  exchange_ = pool_.take();
  hand_ = std::make_unique<LightHand>(world_.scene, script_.steps, *exchange_);
  connection_ = std::make_unique<ServerConnection>(
      options, [this]() -> Result<std::unique_ptr<Transport>> { return world_.network.connect(name()); });
  connection_->setObserver(this);
  nextDue_ = now_;
}

void LightSite::crash() {
  if (connection_) world_.invariants.onDead(index_, id_);
  end();
  asksAgainAt_ = -1;
}

void LightSite::leave() {
  left_ = left_ || inSession();
  SimulatedClient::leave();
}

bool LightSite::hasEvents(Micros now) const {
  return connection_ && now >= pausedUntil_ && connection_->transport() != nullptr &&
         VirtualNetwork::hasEvents(*connection_->transport());
}

void LightSite::step(Micros now) {
  now_ = now;
  nextDue_ = now + kStep;
  if (!started() && world_.server.running() && joinsAt_ >= 0 && now >= joinsAt_) {
    joinsAt_ = -1;
    start();
  }
  if (asksAgainAt_ >= 0 && now >= asksAgainAt_ && world_.server.running()) {
    asksAgainAt_ = -1;
    if (!started()) start();
  }
  if (!started()) {
    nextDue_ = joinsAt_ > now ? joinsAt_ : now + 10 * kStep;
    return;
  }
  if (now < pausedUntil_) {
    nextDue_ = pausedUntil_;
    return;
  }
  const double t = toSeconds(now);
  hand_->step(t, clock_.at(now));
  connection_->step(clock_.at(now));
  enter();
  if (!started()) return;
  const double handDue = hand_->nextDue();
  if (handDue > t) nextDue_ = std::min(nextDue_, static_cast<Micros>(std::llround(handDue * 1e6)));
}

void LightSite::enter() {
  if (connection_->stage() == Stage::needScene) {
    if (fetches_)
      connection_->startTransfer({});
    else
      connection_->skipTransfer();
  }
  if (connection_->stage() == Stage::haveScene) connection_->sceneReady(world_.scene, *exchange_);
  if (connection_->welcome().site != kNoSite) id_ = connection_->welcome().site;
  if (beyondBound() && id_ != kNoSite) world_.invariants.onClockBeyondBound(id_);
  if (connection_->stage() != Stage::ended || left_) return;
  // Refused. The parts that it held are free when the lease is over.
  world_.invariants.onDead(index_, id_);
  end();
  asksAgainAt_ = now_ + kAsksAgain;
}

bool LightSite::beyondBound() const { return std::abs(clock_.drift() - world_.server.drift()) > kDriftBound; }

}  // namespace tandem::client
