// A part in the hand does not meet what sections cut away of its neighbours, and sections that move never
// kick the hand through it.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/tick.h"
#include "tests/support/shapes.h"

namespace tandem::haptics {
namespace {

constexpr double kKick = 0.3;  // N in 20 ms
constexpr std::size_t kWindow = 20;
constexpr PartId kPart = 1;

/// A hand with a cube of 2 cm, or a ball, over a table whose top is z = 0.
class HeldOverTable {
 public:
  explicit HeldOverTable(bool ball)
      : contact_(ball ? contactOf<true>() : contactOf<false>()), state_(contact_) {
    using Kind = PartCommand::Kind;
    tick({0.0, 0.0, 0.03});
    commands_ = {{Kind::own, kPart, state_.worldFromPart(kPart)}, {Kind::grasp, kPart, {}}};
    tick({0.0, 0.0, 0.03});
    EXPECT_EQ(out.hands[0].held, kPart);
  }

  void tick(const glm::dvec3& device) {
    reading_.time += 1e-3;
    reading_.valid = true;
    reading_.worldFromDevice.position = device;
    out = haptics::tick({.hands = {{{reading_}}}, .moved = {}, .commands = commands_, .sections = sections},
                        contact_, TickParameters{}, state_);
    commands_.clear();
    forces_.push_back(out.hands[0].toHand.force);
    most = 0.0;
    for (const glm::dvec3& before : forces_) most = std::max(most, glm::length(before - forces_.back()));
    largest = std::max(largest, most);
    if (forces_.size() > kWindow) forces_.erase(forces_.begin());
  }
  void hold(int ticks) {
    for (int i = 0; i < ticks; ++i) tick(reading_.worldFromDevice.position);
  }
  void moveTo(double z) {
    const double from = reading_.worldFromDevice.position.z;
    for (int i = 1; i <= 200; ++i) tick({0.0, 0.0, from + (z - from) * i / 200});
  }
  /// N, that the part gets from the table.
  double contacts() const {
    double sum = 0.0;
    for (int i = 0; i < out.contactCount; ++i) sum += out.contacts[static_cast<std::size_t>(i)].force;
    return sum;
  }
  double force() const { return glm::length(out.hands[0].toHand.force); }
  double height() const { return state_.worldFromPart(kPart).position.z; }

  std::vector<Section> sections;
  TickOutput out;
  double most = 0.0, largest = 0.0;  // N, change of force in the last 20 ms, and since it was set to 0

 private:
  static assets::Scene makeScene(bool ball) {
    test::SceneBuilder b;
    b.addPart(test::boxMesh({0.2, 0.2, 0.04}), {{0.0, 0.0, -0.02}, {1.0, 0.0, 0.0, 0.0}});
    b.addPart(ball ? test::sphereMesh(0.01, 16) : test::boxMesh({0.02, 0.02, 0.02}),
              {{0.0, 0.0, 0.03}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
    return b.scene;
  }
  /// Its models are made once.
  template <bool ball>
  static const ContactScene& contactOf() {
    static const assets::Scene scene = makeScene(ball);
    static ContactScene contact(scene);
    static const bool modelled = contact.modelParts();
    EXPECT_TRUE(modelled);
    return contact;
  }

  const ContactScene& contact_;
  TickState state_;
  DeviceSample reading_;
  std::vector<PartCommand> commands_;
  std::vector<glm::dvec3> forces_;
};

class CutNeighbours : public testing::TestWithParam<bool> {};

TEST_P(CutNeighbours, AreNotMetByAPartInTheHand) {
  HeldOverTable hand(GetParam());
  hand.sections = {{{1.0, 0.0, 0.0}, -0.05}};  // leaves what is far to the left
  hand.moveTo(-0.01);
  hand.hold(500);
  EXPECT_LT(hand.force(), 0.05);
  EXPECT_NEAR(hand.height(), -0.01, 1e-4);
}

TEST_P(CutNeighbours, AreMetWhereTheyAreLeft) {
  HeldOverTable hand(GetParam());
  hand.sections = {{{-1.0, 0.0, 0.0}, 0.05}};  // cuts what is far to the left
  hand.moveTo(0.007);
  hand.hold(300);
  EXPECT_NEAR(hand.force(), 2.4, 0.05);
  EXPECT_NEAR(hand.height(), 0.01, 1e-4);
}

TEST_P(CutNeighbours, ThatSectionsTakeAwayAndBringBackDoNotKick) {
  for (const double speed : {0.01, 0.1, 10.0, 1000.0}) {
    HeldOverTable hand(GetParam());
    hand.moveTo(0.007);
    hand.hold(300);
    ASSERT_NEAR(hand.force(), 2.4, 0.1);
    const double pressed = hand.contacts();
    hand.largest = 0.0;
    const auto sweep = [&](double from, double to) {
      const int ticks = std::max(1, static_cast<int>(std::abs(to - from) / (speed * 1e-3)));
      for (int i = 1; i <= ticks; ++i) {
        hand.sections = {{{1.0, 0.0, 0.0}, from + (to - from) * i / ticks}};
        hand.hold(1);
      }
      if (ticks == 1 && to < from) {
        hand.hold(2);
        EXPECT_GT(pressed - hand.contacts(), 1.0) << "the contact alone is gone at once";
      }
      hand.hold(700);
    };
    sweep(0.02, -0.02);
    EXPECT_LE(hand.largest, kKick) << speed;
    EXPECT_LT(hand.force(), 0.05) << "what held the part is cut away";
    hand.moveTo(0.003);
    hand.hold(100);
    EXPECT_LT(hand.height(), 0.009) << "it goes in there";
    hand.hold(500);
    hand.largest = 0.0;
    sweep(-0.02, 0.02);
    EXPECT_LE(hand.largest, kKick) << speed;
    hand.moveTo(0.03);
    hand.hold(500);
    hand.moveTo(0.0);
    hand.hold(300);
    EXPECT_GT(hand.force(), 0.8) << "what has come back is met once the part has come out";
  }
}

INSTANTIATE_TEST_SUITE_P(, CutNeighbours, testing::Bool(),
                         [](const auto& part) { return part.param ? "Ball" : "Cube"; });

}  // namespace
}  // namespace tandem::haptics
