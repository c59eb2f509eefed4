// A site whose part moves as no body in a hand can is named to all by those who see it, and an honest one
// never: whatever the network does, and however it moves.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "client/session/server_connection.h"
#include "haptics/base/minimum_jerk.h"
#include "tests/server/session_rig.h"

namespace tandem::client {
namespace {

using namespace sync;

enum class Says { shake, slide, jumps, velocities, turns, strokes, comes, creeps, spins };
constexpr std::array kLies{Says::shake, Says::slide, Says::jumps, Says::velocities, Says::turns};
constexpr std::array kMotions{Says::strokes, Says::comes, Says::creeps, Says::spins};

/// What an owner says of its part.
class Owner {
 public:
  Owner(Says says, unsigned seed) : says_(says), random_(seed) {}

  PartState at(double t) {
    PartState state;
    glm::dvec3 &x = state.worldFromPart.position, &v = state.twist.linear;
    switch (says_) {
      case Says::shake:
        x.x = in(0.0, 1.0) < 0.5 ? 0.02 : -0.02;  // 250 Hz, seen now and then
        break;
      case Says::slide:
        x.x = 0.02 * std::sin(100.0 * t);
        v.x = 2.0 * std::cos(100.0 * t);
        break;
      case Says::jumps:
        if (t > next_) next_ = t + 0.3, place_ = {in(-0.2, 0.2), in(-0.2, 0.2), in(-0.2, 0.2)};
        x = place_;
        break;
      case Says::velocities:
        v.x = in(-5.0, 5.0);
        break;
      case Says::turns:
        state.worldFromPart.orientation = fromRotationVector({0.0, 0.0, in(-3.0, 3.0)});
        break;
      case Says::strokes:
        stroke(t, x, v);
        break;
      case Says::comes:
        x.x = std::min(0.3, 0.3 * t), v.x = x.x < 0.3 ? 0.3 : 0.0;
        break;
      case Says::creeps:
        x.x = v.x = 0.01, x.x *= t;
        break;
      case Says::spins:
        state.twist.angular.z = 15.0;
        state.worldFromPart.orientation = fromRotationVector({0.0, 0.0, std::remainder(15.0 * t, 6.2831853)});
        break;
    }
    return state;
  }

 private:
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  /// One after the other, up to 30 cm in 0.3 s, some of which end in a wall.
  void stroke(double t, glm::dvec3& x, glm::dvec3& v) {
    if (t >= begun_ + over_) {
      place_ += share_ * way_;
      begun_ = t, over_ = in(0.3, 1.0), share_ = in(0.0, 1.0) < 0.3 ? in(0.1, 0.9) : 1.0;
      way_ = glm::dvec3(in(-0.15, 0.15), in(-0.15, 0.15), in(-0.15, 0.15)) - place_;
    }
    const auto along = [&](double at) {
      return std::min(share_, haptics::minimumJerk((at - begun_) / over_));
    };
    x = place_ + along(t) * way_;
    v = (along(t + 5e-4) - along(t - 5e-4)) / 1e-3 * way_;
  }

  Says says_;
  std::mt19937 random_;
  double next_ = 0.0, begun_ = 0.0, over_ = 0.0, share_ = 0.0;
  glm::dvec3 place_{0.0}, way_{0.0};
};

/// Three real connections and an owner, in a real session.
struct Watched : server::SessionRig, ConnectionObserver {
  std::vector<std::unique_ptr<Exchange>> exchanges;
  std::vector<std::unique_ptr<ServerConnection>> watchers;
  test::FakeSite* owner = nullptr;
  Epoch epoch = 0;
  int doubts = 0;
  double namedAfter = -1.0;  // s
  double hz = 60.0;

  explicit Watched(const DoubtLimits& limits = {}) {
    owner = &join("Owner");
    epoch = grab(*owner, 0, 1).part.epoch;
    for (const Role role : {Role::participant, Role::participant, Role::instructor}) enter(role, limits);
  }
  void enter(Role role, const DoubtLimits& limits) {
    ConnectionOptions options;
    options.token = token(role);
    options.name = "watcher" + std::to_string(watchers.size());
    options.doubts = limits;
    watchers.push_back(std::make_unique<ServerConnection>(
        options, [this, name = options.name]() -> Result<std::unique_ptr<Transport>> {
          return network.connect(name);
        }));
    watchers.back()->setObserver(this);
    exchanges.push_back(std::make_unique<Exchange>());
    for (int i = 0; i < 500 && watchers.back()->stage() != ServerConnection::Stage::needScene; ++i)
      run(kMillisecond);
    watchers.back()->skipTransfer();
    watchers.back()->sceneReady(scene, *exchanges.back());
    run(300 * kMillisecond);
    ASSERT_EQ(watchers.back()->stage(), ServerConnection::Stage::ready) << watchers.back()->reason();
  }
  void afterStep() override {
    for (auto& site : watchers) site->step(now);
  }
  void onDoubt(SiteId about) override {
    EXPECT_EQ(about, owner->last<Welcome>()->site);
    ++doubts;
  }
  /// How many of the watchers' lists say that the owner is doubted, and by all of them.
  std::size_t told() const {
    return static_cast<std::size_t>(
        std::count_if(watchers.begin(), watchers.end(), [&](const std::unique_ptr<ServerConnection>& site) {
          const auto& seen = site->sites();
          return std::any_of(seen.begin(), seen.end(), [&](const SiteView& view) {
            return view.info.site == owner->last<Welcome>()->site && view.doubtedBy.size() == watchers.size();
          });
        }));
  }
  void say(Says says, unsigned seed, double seconds) {
    Owner saying(says, seed);
    std::mt19937 random(seed);
    const Micros begun = now;
    Micros next = now;
    while (now < begun + static_cast<Micros>(seconds * 1e6)) {
      run(kMillisecond);
      if (namedAfter < 0.0 && told() == watchers.size()) namedAfter = toSeconds(now - begun);
      if (now < next) continue;
      // Now and then the owner stands still for a while.
      const bool stalls = says == Says::strokes && random() % 200 == 0;
      next += stalls ? static_cast<Micros>(random() % 800000) : static_cast<Micros>(1e6 / hz);
      StateUpdate out = update(*owner, 0, epoch, 0.0);
      const PartState said = saying.at(toSeconds(now - begun));
      out.parts[0].worldFromPart = said.worldFromPart;
      out.parts[0].twist = said.twist;
      owner->send(out);
    }
  }
};

TEST(LyingSite, IsNamedToAllByAllWhoSeeIt) {
  for (const Says lie : kLies) {
    Watched rig;
    rig.say(lie, 1, 5.0);
    EXPECT_EQ(rig.told(), rig.watchers.size()) << "lie " << static_cast<int>(lie);
    EXPECT_LT(rig.namedAfter, 3.0) << "lie " << static_cast<int>(lie);
    EXPECT_EQ(rig.doubts, 3) << "said once in a while";
    EXPECT_EQ(rig.session->ownership().part(0).owner, rig.owner->last<Welcome>()->site);
    std::printf("lie %d: all are told after %.2f s\n", static_cast<int>(lie), rig.namedAfter);
  }
}

TEST(LyingSite, IsNamedWhereItsStatesComeSeldomAndLate) {
  Watched rig;
  rig.network.setConditions({80 * kMillisecond, 0.5, 0.2, 0.1, 0.1});
  rig.hz = 15.0;
  rig.say(Says::jumps, 1, 6.0);
  EXPECT_EQ(rig.told(), rig.watchers.size());
}

TEST(LyingSite, WhoseLinkPacketsTheHandDoesNotBelieveIsNamedToAll) {
  Watched rig;
  for (auto& exchange : rig.exchanges) ASSERT_TRUE(exchange->doubts.push(rig.owner->last<Welcome>()->site));
  rig.run(300 * kMillisecond);
  EXPECT_EQ(rig.told(), rig.watchers.size());
  EXPECT_EQ(rig.doubts, 3);
}

NetworkConditions drawnNetwork(std::mt19937& random) {
  const auto in = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  return {static_cast<Micros>(1000.0 * in(1.0, 200.0)), in(0.0, 1.0), in(0.0, 0.5), in(0.0, 0.3),
          in(0.0, 0.3)};
}

/// The number of seeds in which an honest owner is doubted.
int doubtedSeeds(const DoubtLimits& limits, unsigned seeds) {
  int doubted = 0;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    std::mt19937 random(seed);
    Watched rig(limits);
    rig.network.setConditions(drawnNetwork(random));
    rig.hz = std::uniform_real_distribution<double>(5.0, 250.0)(random);
    rig.say(kMotions[seed % 4 == 3 ? seed / 4 % kMotions.size() : 0], seed, 6.0);
    doubted += rig.doubts > 0 ? 1 : 0;
  }
  return doubted;
}

TEST(HonestOwner, IsNeverDoubtedHoweverItMovesAndWhateverTheNetworkDoes) {
  EXPECT_EQ(doubtedSeeds({}, std::getenv("TANDEM_FULL_SIZE") != nullptr ? 2000 : 24), 0);
}

TEST(HonestOwner, IsDoubtedByWhoDoubtsFarTooSoon) {
  DoubtLimits eager;
  eager.motion.way = {0.01, 0.0};
  eager.motion.change = {1.0, 0.0};
  eager.enough = 1;
  EXPECT_GT(doubtedSeeds(eager, 8), 4);
}

}  // namespace
}  // namespace tandem::client
