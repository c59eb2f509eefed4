// Taking a part takes as many ticks as its neighbours need, each of bounded work. Until then it stands still
// and is not felt.

#include <functional>

#include "haptics/fit/counted_work.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/model_bake.h"
#include "tests/haptics/contact/moving_rig.h"

namespace tandem::test {
namespace {

constexpr int kSeats = 3;
constexpr PartId kBoard = 0, kFirstPeg = 1;
constexpr double kSeatToSeat = 0.05;  // m, between seats
constexpr double kMostStep = 0.05;    // N, by which a force may change in a tick
constexpr int kMostTicks = 130;       // of taking the board, which needs 123

/// A board with seats of 10 mm for as many pegs, which are 0.1 mm too large, each a part of its own.
assets::Scene boardOfSeats() {
  assets::TriangleSoup board;
  std::vector<CasePart> parts{{.name = "board", .mesh = {}, .movable = true, .mass = 0.1}};
  for (int i = 0; i < kSeats; ++i) {
    const glm::dvec3 at(kSeatToSeat * i, 0.0, 0.0);
    const BoredBlock seat{
        .depth = 0.02, .width = 0.04, .height = 0.02, .fit = Fit::within, .facets = {48, 4}};
    const Peg peg{.radius = 0.0101, .length = 0.03, .facets = {48, 4}};
    board = joined(board, moved(boredBlockSoup(seat), at));
    parts.push_back({.name = "peg",
                     .mesh = meshOf(moved(pegSoup(peg), at + glm::dvec3(0.0, 0.0, -0.02))),
                     .movable = true,
                     .mass = 0.05});
  }
  parts[0].mesh = meshOf(board);
  return sceneOfParts(parts);
}

/// The models of the board and its pegs take long to make: once for all tests.
MovingRig& boardRig() {
  static MovingRig rig(boardOfSeats());
  return rig;
}

/// The board of seats with all pegs where they were modelled, and a hand that takes the board.
class TakenBoard {
 public:
  explicit TakenBoard(int portion = haptics::ContactEffort{}.taking, const glm::dvec3& gravity = {})
      : rig(boardRig()) {
    rig.restart();
    rig.at({});
    rig.flags = 0;
    rig.parameters.gravity = gravity;
    rig.parameters.effort.taking = portion;
    rig.each = [this] { note(); };
  }
  ~TakenBoard() {
    rig.moved.clear();
    rig.sections.clear();
    rig.each = nullptr;
  }
  TakenBoard(const TakenBoard&) = delete;

  bool isTaking(PartId part = kBoard) { return rig.contact().isTaking(part); }
  /// The hand takes the board by its first seat; the first tick of that.
  void take() {
    rig.ownAndGrasp(kBoard, rig.pose(kBoard));
    rig.tick();
  }
  /// Ticks until the board is taken; the first one has been.
  int untilTaken() {
    int ticks = 1;
    for (; isTaking() && ticks < 1000; ++ticks) rig.tick();
    return ticks;
  }
  /// The board is drawn off all its pegs, which it comes off only along fits.
  void expectComesOut() {
    largestStep = 0.0;
    rig.lead(
        [](double time) {
          return Pose{{0.0, 0.0, -0.015 * (1.0 - std::cos(std::min(time / 0.5, 1.0) * 3.14159265358979))},
                      {1.0, 0.0, 0.0, 0.0}};
        },
        0.6);
    EXPECT_NEAR(rig.pose(kBoard).position.z, -0.03, 1e-4);
    EXPECT_LT(glm::length(glm::dvec2(rig.pose(kBoard).position)), 1e-4);
    EXPECT_LT(largestStep, 0.25 * kSeats);  // 0.25 N of one seat, as in fits_test.cpp
    EXPECT_EQ(rig.flags & haptics::kFlagFault, 0u);
  }

  MovingRig& rig;
  int mostWork = 0;
  double largestStep = 0.0;  // N, from tick to tick

 private:
  void note() {
    mostWork = std::max(mostWork, rig.contact().takingWork());
    const glm::dvec3 force = rig.out.hands[0].toHand.force;
    largestStep = std::max(largestStep, glm::length(force - lastForce_));
    lastForce_ = force;
  }

  glm::dvec3 lastForce_{0.0};
};

TEST(PartTaking, IsSpreadOverTicksOfBoundedWork) {
  TakenBoard board;
  board.take();
  EXPECT_TRUE(board.isTaking());
  const int ticks = board.untilTaken();
  EXPECT_GE(ticks, 5);
  EXPECT_LE(ticks, kMostTicks);
  EXPECT_LE(board.mostWork, board.rig.parameters.effort.taking);
  EXPECT_GT(board.mostWork, board.rig.parameters.effort.taking / 2);
  board.expectComesOut();
}

/// The negative control: the same work in one tick is far more than a tick may do.
TEST(PartTaking, AtOnceExceedsThePortionOfATick) {
  TakenBoard board(1'000'000'000);
  board.take();
  EXPECT_FALSE(board.isTaking());
  EXPECT_GT(board.mostWork, 4 * haptics::ContactEffort{}.taking);
  board.expectComesOut();
}

TEST(PartTaking, IsNotFeltByAHandAtRest) {
  TakenBoard board;
  board.take();
  board.untilTaken();
  board.rig.tick(200);
  EXPECT_LT(board.largestStep, 1e-3);
  EXPECT_LT(glm::length(board.rig.pose(kBoard).position), 1e-6);
}

/// The hand goes on moving while the part is taken: the part stays, and follows from where the hand is then.
TEST(PartTaking, IsNotFeltByAHandThatMoves) {
  constexpr double kSpeed = 0.02;  // m/s
  TakenBoard board;
  board.take();
  const glm::dvec3 start = board.rig.pose(kBoard).position;
  double whenTaken = 0.0;
  board.rig.each = [&, before = board.rig.each] {
    before();
    if (!board.isTaking()) return;
    EXPECT_EQ(board.rig.pose(kBoard).position, start);
    EXPECT_EQ(glm::length(board.rig.out.hands[0].toHand.force), 0.0);
    whenTaken += kSpeed * board.rig.parameters.dt;
  };
  board.rig.lead([](double time) { return Pose{{0.0, 0.0, -kSpeed * time}, {1.0, 0.0, 0.0, 0.0}}; }, 0.4);
  EXPECT_GT(whenTaken, 5 * kSpeed * board.rig.parameters.dt);
  EXPECT_LT(board.largestStep, kMostStep);
  EXPECT_NEAR(board.rig.pose(kBoard).position.z, whenTaken - 0.4 * kSpeed, 1e-4);
}

/// A part that is near to nothing moves in the tick in which it is taken.
TEST(PartTaking, TakesNoTimeWhereThereIsLittleToMeasure) {
  MovingRig rig(sceneOfParts({{.name = "box", .mesh = meshOf(boxSoup({0.02, 0.02, 0.02})), .movable = true},
                              {.name = "other",
                               .mesh = meshOf(boxSoup({0.02, 0.02, 0.02})),
                               .worldFromPart = {{0.0, 0.0, 0.0250}, {1.0, 0.0, 0.0, 0.0}}}}));
  rig.ownAndGrasp(0, rig.pose(0));
  rig.tick();
  EXPECT_EQ(rig.out.hands[0].held, 0u);
  EXPECT_FALSE(rig.contact().isTaking(0));
}

/// What moves cannot stand still: it is taken in the very tick.
TEST(PartTaking, OfAPartThatMovesIsHurried) {
  TakenBoard board(haptics::CountedWork::kLargest, {0.0, 0.0, -9.81});
  board.rig.tick();
  board.rig.own(kFirstPeg);
  board.rig.tick();
  EXPECT_TRUE(board.isTaking(kFirstPeg));
  board.rig.disown(kFirstPeg);
  board.rig.tick();
  board.rig.throwPart(kFirstPeg, {{0.0, 0.0, 0.01}, {}});
  board.rig.tick();
  EXPECT_FALSE(board.isTaking(kFirstPeg));
  EXPECT_GT(board.rig.pose(kFirstPeg).position.z, 0.0);
}

/// Another site draws a peg out meanwhile: the board is taken in a hurry, as its neighbours now are.
TEST(PartTaking, IsHurriedWhereANeighbourMoves) {
  TakenBoard board(haptics::CountedWork::kLargest);
  board.take();
  board.rig.tick(3);
  ASSERT_TRUE(board.isTaking());
  Pose higher = board.rig.pose(kFirstPeg);
  higher.position.z += 1e-3;
  board.rig.moved = {{kFirstPeg, higher, {{0.0, 0.0, 1.0}, {}}}};
  board.rig.tick();
  board.rig.moved.clear();
  EXPECT_FALSE(board.isTaking());
  board.rig.tick(100);
  EXPECT_LT(board.largestStep, kMostStep);
  EXPECT_LT(glm::length(board.rig.pose(kBoard).position), 1e-4);
}

/// Sections do not move parts: nothing begins anew.
TEST(PartTaking, GoesOnWhereSectionsMove) {
  TakenBoard undisturbed;
  undisturbed.take();
  const int ticks = undisturbed.untilTaken();
  TakenBoard board;
  board.take();
  board.rig.each = [&, before = board.rig.each] {
    before();
    board.rig.sections = {
        {{0.0, 1.0, 0.0}, board.rig.sections.empty() ? 0.1 : board.rig.sections[0].offset - 1e-4}};
  };
  EXPECT_EQ(board.untilTaken(), ticks);
  board.rig.each = nullptr;
  board.rig.sections.clear();
  board.rig.tick();
  board.expectComesOut();
}

TEST(PartTaking, GoesOnAfterTheHandHasLetGo) {
  TakenBoard board;
  board.take();
  board.rig.tick(2);
  board.rig.letGo(kBoard);
  board.rig.tick(2);
  board.rig.grasp(kBoard);
  board.rig.tick();
  ASSERT_TRUE(board.isTaking());
  board.untilTaken();
  EXPECT_LT(board.largestStep, 1e-3);
  board.expectComesOut();
}

TEST(PartTaking, BeginsAnewAfterThePartWasGivenBack) {
  TakenBoard board;
  board.take();
  const int ticks = board.untilTaken();
  board.rig.restart();
  board.take();
  board.rig.tick(2);
  board.rig.letGo(kBoard);
  board.rig.disown(kBoard);
  board.rig.tick();
  EXPECT_FALSE(board.isTaking());
  board.take();
  EXPECT_EQ(board.untilTaken(), ticks);
  board.expectComesOut();
}

/// A refined model has the same samples and a finer field: measured anew, by that.
TEST(PartTaking, BeginsAnewWithRefinedModels) {
  TakenBoard board;
  board.take();
  board.rig.tick(4);
  ASSERT_TRUE(board.isTaking());
  const haptics::ContactScene& coarse = board.rig.contactScene();
  const haptics::ContactScene::Data& data = coarse.data();
  const std::size_t tree = 1;
  haptics::DistanceField::Options finer;
  finer.tolerance = 0.5 * data.models[tree]->field.tolerance();
  const haptics::ContactScene next = coarse.withModel(
      tree, std::make_shared<haptics::PartModel>(*data.trees[tree], data.models[tree]->features,
                                                 haptics::DistanceField(*data.trees[tree], finer)));
  board.rig.refine(next);
  EXPECT_GT(board.untilTaken(), 4);
  EXPECT_LE(board.mostWork, board.rig.parameters.effort.taking);
  board.expectComesOut();
  board.rig.refine(coarse);
}

/// Two parts at once: one after the other, of which neither moves before it is taken.
TEST(PartTaking, OfTwoPartsGoesOnOneAfterTheOther) {
  TakenBoard board(haptics::CountedWork::kLargest, {0.0, 0.0, -9.81});
  board.rig.tick();
  board.rig.own(kFirstPeg);
  board.rig.own(kFirstPeg + 1);
  board.rig.tick();
  EXPECT_TRUE(board.isTaking(kFirstPeg) && board.isTaking(kFirstPeg + 1));
  for (int i = 0; i < 200 && board.isTaking(kFirstPeg); ++i) {
    EXPECT_TRUE(board.isTaking(kFirstPeg + 1));
    EXPECT_EQ(board.rig.pose(kFirstPeg).position.z, 0.0);
    board.rig.tick();
  }
  for (int i = 0; i < 200 && board.isTaking(kFirstPeg + 1); ++i) board.rig.tick();
  EXPECT_FALSE(board.isTaking(kFirstPeg) || board.isTaking(kFirstPeg + 1));
  EXPECT_LE(board.mostWork, haptics::CountedWork::kLargest);
}

/// A part that another site drags too cannot stand still.
TEST(PartTaking, OfALinkedPartIsHurried) {
  TakenBoard board(haptics::CountedWork::kLargest);
  board.take();
  board.rig.tick(2);
  ASSERT_TRUE(board.isTaking());
  EXPECT_TRUE(board.rig.state().beginLink({{kBoard, 7}, {}, 0.025, 1}));
  board.rig.tick();
  EXPECT_FALSE(board.isTaking());
  board.rig.tick(100);
  EXPECT_LT(board.largestStep, kMostStep);
}

}  // namespace
}  // namespace tandem::test
