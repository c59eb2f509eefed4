// A clock of relative motion says when samples must be read again: none that is near is left out.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "haptics/contact/due_samples.h"
#include "haptics/contact/side_clocks.h"
#include "haptics/touch/sample_memory.h"
#include "tests/support/irregular_shapes.h"
#include "tests/support/part_cases.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::AllowedDepth;
using haptics::ContactSamples;
using haptics::DistanceField;
using haptics::DueTimes;
using haptics::SampledModels;

constexpr float kReach = 0.2e-3f;  // m

/// An irregular part that is led to and fro before a plate, and what its samples read there.
class Led {
 public:
  explicit Led(double clockShare = 1.0)
      : clockShare_(clockShare),
        scene_(sceneOfParts({{"part", part(), {}, true}, {"plate", boxMesh({0.08, 0.08, 0.01}), {}, true}})),
        contact_(scene_, 1),
        world_((contact_.modelParts(), contact_)),
        clocks_(world_) {}

  /// Leads it through `steps` poses, of which each is within `speed` m of the last one.
  void lead(int steps, double speed) {
    const auto& nodes = world_.model(0)->samples.nodes();
    const double radius = static_cast<double>(nodes.front().radius);
    for (int i = 0; i < steps; ++i) {
      time_ += speed / radius;
      Pose pose;
      pose.orientation =
          fromRotationVector({0.5 * std::sin(time_), 0.4 * std::sin(1.3 * time_), 0.3 * time_});
      pose.position = {0.01 * std::sin(0.7 * time_), 0.01 * std::cos(0.9 * time_),
                       0.005 + radius * (0.85 + 0.1 * std::sin(0.6 * time_))};
      look(pose);
    }
  }

  AllowedDepth allowed;
  int missed = 0;             // samples within the reach, in all steps
  int read = 0, without = 0;  // samples that were judged; that would be without clocks

 private:
  static assets::Mesh part() {
    Random random(7);
    return meshOf(blobSoup(random, 6));
  }

  void look(const Pose& pose) {
    const haptics::PartModel &from = *world_.model(0), &to = *world_.model(1);
    SampledModels models;
    models.from = &from;
    models.to = &to;
    models.toFromSamples = pose;
    const haptics::FloatMotion motion(pose, to.field.origin());
    std::vector<bool> seen(from.samples.samples().size());
    DueTimes due = clocks_.at(0, 1, models, allowed);
    due.now *= static_cast<float>(clockShare_);
    const auto visit = [&](std::uint32_t i, const glm::vec3& p, const DistanceField::Reading& reading) {
      seen[i] = true;
      ++read;
      const glm::vec4& sample = from.samples.points()[i];
      return reading.distance - reading.error - ContactSamples::touchAbout(sample) +
             allowed.least(glm::vec3(sample), p, 0.0f);
    };
    haptics::DueSamples(from.samples, to.field, motion, allowed, kReach, due, visit).read(0);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const glm::vec4& sample = from.samples.points()[i];
      const glm::vec3 p = motion(glm::vec3(sample));
      const DistanceField::Reading reading = to.field.read(p);
      // The distance of the mesh itself is at most this.
      const float most =
          reading.distance + reading.error - ContactSamples::touchAbout(sample) + allowed.depth;
      missed += !seen[i] && most <= kReach ? 1 : 0;
      without += reading.distance - reading.error - ContactSamples::touchAbout(sample) <= kReach ? 1 : 0;
    }
  }

  double clockShare_, time_ = 0.0;
  assets::Scene scene_;
  haptics::ContactScene contact_;
  haptics::ContactWorld world_;
  haptics::SideClocks clocks_;
};

TEST(SideClocks, AMotionIsAtLeastThatOfAnyPointOfTheBall) {
  Random random(3);
  const auto any = [&] { return anyVector(random); };
  double tightest = 1e300;
  for (int i = 0; i < 2000; ++i) {
    const double size = std::pow(10.0, between(random, -6.0, 0.3));
    const Pose from{any(), fromRotationVector(3.0 * any())};
    Pose to{from.position + size * any(), fromRotationVector(size * any()) * from.orientation};
    if (i % 2 == 0) to.orientation = -to.orientation;
    const glm::dvec3 centre = any();
    const double radius = 0.5, bound = haptics::farthestMotion(from, to, centre, radius);
    double farthest = 0.0;
    for (int k = 0; k < 50; ++k) {
      const glm::dvec3 p = centre + radius * glm::normalize(any());
      farthest = std::max(farthest, glm::length(transformPoint(to, p) - transformPoint(from, p)));
    }
    ASSERT_LE(farthest, bound * (1.0 + 1e-9));
    tightest = std::min(tightest, bound / farthest);
  }
  EXPECT_LT(tightest, 1.2);
}

/// Random answers of samples that then move: how many of 50 places within `extent` m of each have moved
/// further than the answer says.
int placesBeyond(float extentSaid, float extent) {
  Random random(11);
  const auto any = [&] { return anyVector(random); };
  int beyond = 0;
  for (int i = 0; i < 500; ++i) {
    const double size = std::pow(10.0, between(random, -4.0, 0.3));
    const Pose then{0.05 * any(), fromRotationVector(3.0 * any())};
    const Pose now{then.position + 0.01 * size * any(), fromRotationVector(size * any()) * then.orientation};
    const glm::dvec3 sample = 0.02 * any();
    haptics::SampleAnswer answer;
    answer.place = glm::vec3(transformPoint(then, sample));
    answer.orientation = glm::quat(then.orientation);
    const double said = static_cast<double>(
        answer.movedSince(glm::vec3(transformPoint(now, sample)), glm::quat(now.orientation), extentSaid));
    for (int k = 0; k < 50; ++k) {
      const glm::dvec3 p = sample + static_cast<double>(extent) * glm::normalize(any());
      beyond += glm::length(transformPoint(now, p) - transformPoint(then, p)) > said + 1e-8 ? 1 : 0;
    }
  }
  return beyond;
}

TEST(SideClocks, AnAnswerHoldsForAllThatItsSampleStandsFor) {
  EXPECT_EQ(placesBeyond(1e-3f, 1e-3f), 0);
  // The control: an answer that counts the way of the sample alone.
  EXPECT_GT(placesBeyond(0.0f, 1e-3f), 0);
}

TEST(SideClocks, NoSampleThatIsNearIsLeftOut) {
  Led led;
  for (const double speed : {1e-6, 10e-6, 50e-6, 0.2e-3, 1e-3}) led.lead(400, speed);
  EXPECT_EQ(led.missed, 0);
  EXPECT_GT(led.read, 1000) << "it was near";
}

TEST(SideClocks, AClockThatRunsTooSlowlyLeavesSamplesOut) {
  // The control: the bound of the motion lies.
  Led led(0.3);
  for (const double speed : {1e-6, 10e-6, 50e-6, 0.2e-3, 1e-3}) led.lead(400, speed);
  EXPECT_GT(led.missed, 0);
}

TEST(SideClocks, WhatPartsMayBeInEachOtherShrinksWithoutLeavingAnyOut) {
  Led led;
  led.allowed.depth = 1e-3f;
  led.allowed.margin = 0.01f;
  led.allowed.sampledHalf = glm::vec3(0.01f);
  led.allowed.targetHalf = glm::vec3(0.03f);
  for (int i = 0; i < 40; ++i) {
    led.lead(20, 20e-6);
    led.allowed.depth *= 0.9f;
  }
  EXPECT_EQ(led.missed, 0);
  EXPECT_LT(led.read, led.without);
}

}  // namespace
}  // namespace tandem::test
