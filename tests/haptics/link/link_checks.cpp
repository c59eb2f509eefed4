#include "tests/haptics/link/link_checks.h"
#include "tests/support/full_size.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tandem::test {
namespace {

constexpr std::uint32_t kSequenceStep = 1000;  // room for forged packets between two real ones

class HoldLastEnd : public CoordinationLinkEnd {
 public:
  HoldLastEnd(const haptics::LinkParameters& parameters, double delay, const Network& network)
      : CoordinationLinkEnd(parameters, delay), network_(network) {}

  void receive(const haptics::LinkPacket& packet) override {
    if (!heard_ || packet.time > newest_.time) {
      previous_ = newest_;
      newest_ = packet;
      heard_ = true;
    }
    CoordinationLinkEnd::receive(packet);
  }
  haptics::LinkPull pull(double now, const Pose& worldFromCentre, const Twist& twist) override {
    forge(now);
    return CoordinationLinkEnd::pull(now, worldFromCentre, twist);
  }
  haptics::LinkPacket packet(double now) override {
    haptics::LinkPacket packet = CoordinationLinkEnd::packet(now);
    packet.sequence *= kSequenceStep;
    return packet;
  }

 private:
  void forge(double now) {
    if (previous_.sequence == 0 || now - newest_.time < network_.delay) return;
    const double span = newest_.time - previous_.time;
    haptics::LinkPacket next = newest_;
    next.time += network_.packetPeriod;
    next.sequence += 1;
    const double share = network_.packetPeriod / span;
    next.wave += share * (newest_.wave - previous_.wave);
    next.energy += share * std::max(0.0, newest_.energy - previous_.energy);
    receive(next);
  }

  Network network_;
  haptics::LinkPacket newest_, previous_;
  bool heard_ = false;
};

}  // namespace

void expectPassive(const Tally& tally, const char* what) {
  EXPECT_FALSE(tally.astray) << what;
  EXPECT_LE(tally.created, kEnergyBound) << what;
  EXPECT_LE(tally.inLinks, kEnergyBound) << what;
}

int seeds(int few) { return atFullSize() ? 20 : few; }

LinkEndMaker holdingTheLastWave(const Network& network) {
  return [network](const haptics::LinkParameters& parameters, double delay) {
    return std::make_unique<HoldLastEnd>(parameters, delay, network);
  };
}

}  // namespace tandem::test
