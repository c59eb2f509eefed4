// Pins and bores of equal radii, whose file states the cylinders: the pin turns and slides, and stays in the
// bore's exact cylinder.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "assets/gltf/load_gltf.h"
#include "tests/haptics/contact/moving_rig.h"
#include "tests/support/exact_fit_file.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

/// What a hand may feel of a part that is free: N, N·m, and m of penetration.
struct FreeBounds {
  double force = 0.25, torque = 0.05, deepest = 5e-6;
};
constexpr double kADegree = std::numbers::pi / 180.0;

/// A part that turns and slides about an axis.
struct Turning {
  PartId part = 0;
  Pose axis;                    // in the part; its z is the way out
  double from = 0.0, to = 0.0;  // m along it, what is within the fit
};

/// What a hand feels of a part that it leads, and where the part goes.
struct Felt {
  double force = 0.0, torque = 0.0;  // N, N·m, the largest on the hand
  double deepest = 0.0;              // m, of the part's exact cylinder in the exact bore
  double behind = 0.0;               // m and rad that the part lacks at the end
};

class TurningHand {
 public:
  TurningHand(MovingRig& rig, const Turning& turning)
      : rig_(rig),
        turning_(turning),
        worldFromAxis_(rig.scene().parts[turning.part].worldFromPart * turning.axis) {
    rig_.restart();
    rig_.each = [this] { note(); };
    rig_.takeHold(turning.part, at(0.0, 0.0));  // a part that is being taken does not follow the hand
    rig_.tick(20);
  }
  TurningHand(const TurningHand&) = delete;
  ~TurningHand() { rig_.each = nullptr; }

  /// Turns to an angle at 120 degrees a second, on average.
  Felt turnTo(double degrees) {
    const double from = angle_, by = degrees * kADegree - from;
    angle_ = from + by;
    return led([=, this](double share) { return at(from + by * share, out_); },
               std::max(0.1, std::abs(by) / (120.0 * kADegree)));
  }
  /// Slides to a height at 20 mm/s.
  Felt slideTo(double height) {
    const double from = out_, by = height - from;
    out_ = height;
    return led([=, this](double share) { return at(angle_, from + by * share); },
               std::max(0.1, std::abs(by) / 0.02));
  }

 private:
  Pose at(double angle, double out) const {
    return worldFromAxis_ * Pose{{0.0, 0.0, out}, fromRotationVector({0.0, 0.0, angle})} *
           inverse(turning_.axis);
  }
  template <typename Path>
  Felt led(const Path& path, double duration) {
    felt_ = {};
    const auto eased = [](double t) { return t < 1.0 ? 0.5 - 0.5 * std::cos(std::numbers::pi * t) : 1.0; };
    rig_.lead([&](double t) { return path(eased(t / duration)); }, duration + 0.03);
    const Pose off = inverse(path(1.0)) * rig_.pose(turning_.part);
    felt_.behind = glm::length(off.position) + glm::length(rotationVector(off.orientation));
    return felt_;
  }
  void note() {
    const auto& wrench = rig_.out.hands[0].toHand;
    felt_.force = std::max(felt_.force, glm::length(wrench.force));
    felt_.torque = std::max(felt_.torque, glm::length(wrench.torque));
    const Pose now = inverse(worldFromAxis_) * rig_.pose(turning_.part) * turning_.axis;
    // Where the fit ends, as far as the part still reaches.
    for (const double end : {turning_.from, turning_.to}) {
      const double height = std::clamp(end - now.position.z, turning_.from, turning_.to);
      const glm::dvec3 p = transformPoint(now, {0.0, 0.0, height});
      if (p.z > turning_.to + 1e-9) continue;
      felt_.deepest = std::max(felt_.deepest, std::hypot(p.x, p.y));
    }
  }

  MovingRig& rig_;
  Turning turning_;
  Pose worldFromAxis_;
  double angle_ = 0.0, out_ = 0.0;
  Felt felt_;
};

void expectFree(const Felt& felt, const FreeBounds& bounds = {}) {
  EXPECT_LT(felt.force, bounds.force);
  EXPECT_LT(felt.torque, bounds.torque);
  EXPECT_LT(felt.deepest, bounds.deepest);
  EXPECT_LT(felt.behind, 1e-3);
}

/// A pin in its bore, tilted and away from the origin of the file's meshes.
ExactFit equalFit(double radius, int pinSegments, int boreSegments) {
  ExactFit fit;
  fit.radius = radius;
  fit.play = 0.0;
  fit.height = 0.6 * radius;
  fit.segments = pinSegments;
  fit.boreSegments = boreSegments;
  fit.place = {radius * glm::dvec3(0.3, -0.2, 0.1), fromRotationVector({0.4, -0.7, 0.3})};
  return fit;
}

assets::Scene equalFitScene(const ExactFit& fit) {
  assets::LoadOptions options;
  options.movable = {"pin"};
  options.density = 2000.0 * std::pow(0.01 / fit.radius, 3);  // the same mass for all
  Result<assets::Scene> scene = assets::loadGltfFromMemory("fit.glb", exactFitFile(fit).glb(), options);
  EXPECT_TRUE(scene.ok());
  return std::move(scene).value();
}

Turning pinOf(const ExactFit& fit) { return {0, fit.place, -fit.height, 0.0}; }

void expectPinIsFree(const ExactFit& fit, const FreeBounds& bounds = {}) {
  SCOPED_TRACE(testing::Message() << 1e3 * fit.radius << " mm, " << fit.segments << " facets");
  MovingRig rig(equalFitScene(fit), glm::dvec3(0.0), 2.0);
  TurningHand hand(rig, pinOf(fit));
  for (const double degrees : {0.5 * 360.0 / fit.segments, 45.0, 200.0}) {
    SCOPED_TRACE(degrees);
    expectFree(hand.turnTo(degrees), bounds);
  }
  expectFree(hand.slideTo(0.5 * fit.height), bounds);
  expectFree(hand.turnTo(170.0), bounds);
  expectFree(hand.slideTo(2.0 * fit.height), bounds);
}

TEST(EqualFits, APinTurnsAndSlides) {
  expectPinIsFree(equalFit(0.0005, 16, 24));
  expectPinIsFree(equalFit(0.010, 48, 48));
}

TEST(EqualFits, ByFacetsItJams) {
  // The control: the same files without their cylinders.
  for (const double radius : {0.0005, 0.010}) {
    ExactFit fit = equalFit(radius, 48, 48);
    fit.exact = false;
    MovingRig rig(equalFitScene(fit), glm::dvec3(0.0), 2.0);
    TurningHand hand(rig, pinOf(fit));
    const Felt felt = hand.turnTo(45.0);
    EXPECT_GT(felt.torque, 1.0);
    EXPECT_GT(felt.behind, 0.1);
  }
}

TEST(EqualFits, PinsOfAllSizesTurnAndSlide) {
  if (!atFullSize()) GTEST_SKIP() << "set TANDEM_FULL_SIZE";
  // A large pin sometimes waits for a tick in which the queries run out, as it does in a bore 5 um wider.
  const FreeBounds large{6.0, 0.2, 5e-6};
  for (const double radius : {0.0005, 0.002, 0.005, 0.020, 0.050})
    for (const int segments : {16, 32, 96}) {
      expectPinIsFree(equalFit(radius, segments, segments), radius > 0.01 ? large : FreeBounds());
      expectPinIsFree(equalFit(radius, segments, 112 - segments), radius > 0.01 ? large : FreeBounds());
    }
}

TEST(EqualFits, AreMadeReadyAsFastAsFitsWithPlay) {
  if (!atFullSize()) GTEST_SKIP() << "set TANDEM_FULL_SIZE";
  const auto seconds = [](double play, bool exact) {
    ExactFit fit;
    fit.play = play;
    fit.exact = exact;
    const assets::Scene scene = equalFitScene(fit);
    const std::clock_t start = std::clock();
    const MovingRig rig(scene);
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  const double equal = seconds(0.0, true), play = seconds(5e-6, true), facets = seconds(0.0, false);
  EXPECT_LT(equal, play);
  std::printf("equal radii %.2f s, with play %.2f s, facets %.2f s\n", equal, play, facets);
}

/// as1-oc-214.stp by the import beside this program; nothing where one of both is missing.
std::string importedAssembly() {
  const char* const data = std::getenv("TANDEM_DATA");
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "tandem-import";
  if (data == nullptr || !std::filesystem::exists(program)) return {};
  const std::string out = testing::TempDir() + "as1-oc-214.glb";
  const std::string command =
      "'" + program.string() + "' '" + data + "/as1-oc-214.stp' -o '" + out + "' > /dev/null";
  return std::system(command.c_str()) == 0 ? out : std::string();
}

assets::Scene assembly(const std::string& path, bool exact) {
  assets::LoadOptions options;
  options.allMovable = true;
  options.normals = exact;
  Result<assets::Scene> scene = assets::loadGltf(path, options);
  EXPECT_TRUE(scene.ok());
  return std::move(scene).value();
}

std::vector<Turning> boltsAndNuts(const assets::Scene& scene) {
  const glm::dquat over = glm::angleAxis(std::numbers::pi, glm::dvec3(1.0, 0.0, 0.0));
  std::vector<Turning> found;
  for (PartId part = 0; part < scene.parts.size(); ++part) {
    const std::string& name = scene.parts[part].name;
    if (name.starts_with("bolt")) found.push_back({part, {glm::dvec3(0.0), over}, -0.036, -0.003});
    if (name == "nut_2") found.push_back({part, {{0.010, 0.0075, 0.0}, over}, -0.003, 0.0});
    if (name.starts_with("nut") && name != "nut_2")
      found.push_back({part, {{0.010, 0.0075, 0.0}, glm::dquat(1.0, 0.0, 0.0, 0.0)}, 0.0, 0.003});
  }
  return found;
}

TEST(EqualFits, BoltsAndNutsOfAnAssemblyTurnAndComeOut) {
  if (!atFullSize()) GTEST_SKIP() << "set TANDEM_FULL_SIZE";
  const std::string path = importedAssembly();
  if (path.empty()) GTEST_SKIP() << "set TANDEM_DATA, and build tandem-import";
  MovingRig rig(assembly(path, true));
  const std::vector<Turning> all = boltsAndNuts(rig.scene());
  EXPECT_EQ(all.size(), 14u);
  Felt most;
  for (const Turning& turning : all) {
    SCOPED_TRACE(rig.scene().parts[turning.part].name);
    TurningHand hand(rig, turning);
    const auto expect = [&](const Felt& felt) {
      expectFree(felt);
      most.force = std::max(most.force, felt.force);
      most.torque = std::max(most.torque, felt.torque);
      most.deepest = std::max(most.deepest, felt.deepest);
    };
    for (const double degrees : {5.0, 10.0, 45.0, 180.0}) expect(hand.turnTo(degrees));
    expect(hand.slideTo(0.002));
    expect(hand.turnTo(90.0));
    expect(hand.slideTo(0.0));
    expect(hand.slideTo(0.012));
  }
  std::printf("at most %.3f N, %.4f N m, %.2f um\n", most.force, most.torque, 1e6 * most.deepest);
}

TEST(EqualFits, BoltsAndNutsOfAnAssemblyJamByFacets) {
  // The control: the facets of the import, which stand corner in corner.
  if (!atFullSize()) GTEST_SKIP() << "set TANDEM_FULL_SIZE";
  const std::string path = importedAssembly();
  if (path.empty()) GTEST_SKIP() << "set TANDEM_DATA, and build tandem-import";
  MovingRig rig(assembly(path, false));
  for (const Turning& turning : boltsAndNuts(rig.scene())) {
    TurningHand hand(rig, turning);
    const Felt five = hand.turnTo(5.0), more = hand.turnTo(45.0);
    EXPECT_GT(five.torque, 0.3);
    EXPECT_GT(more.torque, 3.0);
    std::printf("%s: %.2f N m at 5 degrees, %.2f at 45\n", rig.scene().parts[turning.part].name.c_str(),
                five.torque, more.torque);
  }
}

}  // namespace
}  // namespace tandem::test
