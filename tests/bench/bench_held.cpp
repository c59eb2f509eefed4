// bench_held [--repeats N] [--helpers N] [--only NAME] [--record FILE] [--json OUT] [FILE UNIT]
//
// The tick with a part in the hand, for every part of a scene that a hand can take: it is held by its middle
// where it stands and drawn 1 % of its size to and fro along each axis, 180 ticks, at full effort. The ticks
// that take it, in which it stands still, are told apart. Without a file: the two-cylinder engine in
// $TANDEM_DATA, then the M16 nut beside it, with seven turns engaged, turned once by a hand that presses 2 N.
//
// Every run does the same work tick by tick, so that each tick counts with its best time of --repeats runs:
// that leaves out what other programs on the machine cost. `--record` writes the pose and the force of every
// tick, so that two programs can be compared.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "assets/base/command_line.h"
#include "assets/gltf/load_gltf.h"
#include "assets/scene/control.h"
#include "client/base/thread_clock.h"
#include "haptics/base/tick_helpers.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/tick_data.h"
#include "tests/bench/bench_report.h"

namespace {

namespace haptics = tandem::haptics;
namespace bench = tandem::bench;
using tandem::PartId;
using tandem::Pose;

constexpr double kMostP99 = 500.0, kLongest = 1000.0;       // us, asked of every part
constexpr double kMostNutP50 = 250.0, kMostNutP99 = 500.0;  // us, asked of the nut
constexpr double kTurn = 2.0 * std::numbers::pi;            // rad

struct Options {
  int repeats = 3, helpers = 0, queries = haptics::ContactEffort{}.sampleQueries;
  std::string only, record, json, file, unit = "m";
};

/// One tick: its cost, what contact did in it, and what came out.
struct HeldTick {
  double time_us = 0.0;
  haptics::ContactWork work;
  Pose part;
  tandem::Wrench toHand;
};

struct HeldRun {
  std::vector<HeldTick> taking, ticks;  // while the part is taken; the last one of these moves it already

  double longestTaking_us() const {
    double longest = 0.0;
    for (const HeldTick& tick : taking) longest = std::max(longest, tick.time_us);
    return longest;
  }
};

/// A hand that takes a part where it stands and leads it along a path.
template <typename Path>
HeldRun hold(const haptics::ContactScene& contact, PartId part, int ticks,
             const haptics::TickParameters& parameters, haptics::TickHelpers& helpers, const Path& path) {
  haptics::TickState state(contact);
  state.share(&helpers);
  const std::array<haptics::PartCommand, 2> take{
      {{haptics::PartCommand::Kind::own, part, state.worldFromPart(part)},
       {haptics::PartCommand::Kind::grasp, part, {}}}};
  haptics::TickInput input;
  input.hands[0].device.valid = true;
  input.hands[0].device.worldFromDevice = path(0);
  input.commands = take;
  HeldRun run;
  const auto tick = [&] {
    const double start = tandem::client::threadMicroseconds();
    const haptics::TickOutput out = haptics::tick(input, contact, parameters, state);
    const double time_us = tandem::client::threadMicroseconds() - start;
    input.commands = {};
    return HeldTick{time_us, state.data().partContact->work(), state.worldFromPart(part),
                    out.hands[0].toHand};
  };
  do {
    run.taking.push_back(tick());
  } while (state.data().partContact->isTaking(part));
  for (int i = 0; i < ticks; ++i) {
    input.hands[0].device.worldFromDevice = path(i + 1);
    run.ticks.push_back(tick());
  }
  return run;
}

void keepBest(std::vector<HeldTick>& least, const std::vector<HeldTick>& run) {
  for (std::size_t i = 0; i < run.size(); ++i) least[i].time_us = std::min(least[i].time_us, run[i].time_us);
}

/// The same `repeats` times, each tick with its best time.
template <typename Hold>
HeldRun best(int repeats, const Hold& holdOnce) {
  HeldRun least = holdOnce();
  for (int k = 1; k < repeats; ++k) {
    const HeldRun run = holdOnce();
    keepBest(least.taking, run.taking);
    keepBest(least.ticks, run.ticks);
  }
  return least;
}

HeldRun draw(const haptics::ContactScene& contact, PartId part, const haptics::TickParameters& parameters,
             haptics::TickHelpers& helpers) {
  constexpr int kTicksAnAxis = 60;
  constexpr double kDraw = 0.01;  // of the part's size
  const haptics::ContactWorld world(contact);
  const haptics::Collider& collider = world.collider(part);
  const glm::dvec3 middle = transformPoint(world.pose(part), collider.centre);
  return hold(contact, part, 3 * kTicksAnAxis, parameters, helpers, [&](int i) {
    Pose device{middle, glm::dquat(1.0, 0.0, 0.0, 0.0)};
    if (i > 0) {
      device.position[(i - 1) / kTicksAnAxis] +=
          2.0 * kDraw * collider.radius * std::sin(kTurn * ((i - 1) % kTicksAnAxis) / kTicksAnAxis);
    }
    return device;
  });
}

/// Once round, at a turn a second.
HeldRun turnNut(const haptics::ContactScene& contact, PartId nut, haptics::TickParameters parameters,
                haptics::TickHelpers& helpers) {
  constexpr int kSettle = 200, kTicks = 1200;
  constexpr double kPitch = 0.002, kPush = 2.0;  // m, N
  parameters.graspStiffness = 1000.0;
  parameters.forceLimit = parameters.torqueLimit = 1e6;
  const Pose start = contact.scene().parts[nut].worldFromPart;
  return hold(contact, nut, kTicks, parameters, helpers, [&](int i) {
    const double turned = 1e-3 * std::max(0, i - kSettle);
    Pose device = start;
    device.orientation = tandem::fromRotationVector({0.0, 0.0, -kTurn * turned}) * start.orientation;
    device.position.z -= kPitch * turned + kPush / parameters.graspStiffness * std::min(1.0, i / 100.0);
    return device;
  });
}

class Bench {
 public:
  explicit Bench(const Options& options)
      : options_(options), helpers_(options.helpers), report_("bench_held") {
    parameters_.effort.sampleQueries = options.queries;
    if (!options.record.empty()) record_ = std::fopen(options.record.c_str(), "w");
  }
  ~Bench() {
    if (record_ != nullptr) std::fclose(record_);
  }

  bool drawAll(const std::string& file, const std::string& unit) {
    tandem::assets::LoadOptions load;
    const auto scale = tandem::assets::parseUnits(unit);
    if (!scale) return fail(unit + " is no unit");
    load.unitScale = *scale;
    load.allMovable = true;
    const auto scene = tandem::assets::loadGltf(file, load);
    if (!scene) return fail(scene.error().message);
    const haptics::ContactScene contact = modelled(*scene);
    int beyond = 0, longer = 0, parts = 0;
    std::size_t mostTaking = 0;
    double longestTaking_us = 0.0;
    for (std::size_t i = 0; i < scene->parts.size(); ++i) {
      const auto part = static_cast<PartId>(i);
      const std::string& name = scene->parts[i].name;
      if (!scene->parts[i].movable || tandem::assets::controlOf(*scene, part) != nullptr ||
          name.find(options_.only) == std::string::npos)
        continue;
      const HeldRun run =
          best(options_.repeats, [&] { return draw(contact, part, parameters_, helpers_); });
      const tandem::Percentiles times = note(name, run);
      ++parts;
      mostTaking = std::max(mostTaking, run.taking.size());
      longestTaking_us = std::max(longestTaking_us, run.longestTaking_us());
      beyond += times.p99 > kMostP99 ? 1 : 0;
      longer += times.max >= kLongest ? 1 : 0;
    }
    std::printf("of %d parts, taken in %zu ticks at most\n", parts, mostTaking);
    bool met = report_.bound("longest tick that takes one, us", longestTaking_us, kLongest);
    met = report_.bound("parts with p99 over 500 us", beyond, 0) && met;
    return report_.bound("parts with a tick of 1 ms", longer, 0) && met;
  }

  bool turn(const std::string& file) {
    const auto scene = [&] {
      tandem::assets::LoadOptions load;
      load.allMovable = true;
      return tandem::assets::loadGltf(file, load);
    }();
    if (!scene) return fail(scene.error().message);
    tandem::assets::Scene engaged = *scene;
    PartId nut = 0;
    while (engaged.parts[nut].name != "nut") ++nut;
    engaged.parts[nut].worldFromPart = {{0.0, 0.0, 0.010}, glm::dquat(1.0, 0.0, 0.0, 0.0)};
    const haptics::ContactScene contact = modelled(engaged);
    const HeldRun run =
        best(options_.repeats, [&] { return turnNut(contact, nut, parameters_, helpers_); });
    const tandem::Percentiles times = note("M16 nut, seven turns", run);
    const bool met = report_.bound("nut p50, us", times.p50, kMostNutP50);
    return report_.bound("nut p99, us", times.p99, kMostNutP99) && met;
  }

  bool finish() { return options_.json.empty() || report_.writeJson(options_.json); }

 private:
  static haptics::ContactScene modelled(const tandem::assets::Scene& scene) {
    haptics::ContactScene contact(scene);
    haptics::ModelOptions how;
    how.cacheDirectory = tandem::assets::defaultCacheDirectory();
    static_cast<void>(contact.modelParts(how));
    return contact;
  }

  static bool fail(const std::string& why) {
    std::fprintf(stderr, "%s\n", why.c_str());
    return false;
  }

  tandem::Percentiles note(const std::string& name, const HeldRun& held) {
    const std::vector<HeldTick>& run = held.ticks;
    std::vector<double> times;
    double steps = 0.0, planes = 0.0, balls = 0.0, exact = 0.0, iterations = 0.0;
    for (std::size_t i = 0; i < run.size(); ++i) {
      const HeldTick& tick = run[i];
      times.push_back(tick.time_us);
      steps += tick.work.steps;
      planes += tick.work.planes;
      balls += tick.work.balls;
      exact += tick.work.exact;
      iterations += tick.work.iterations;
      if (record_ == nullptr) continue;
      const glm::dvec3 &p = tick.part.position, &f = tick.toHand.force;
      const glm::dquat& q = tick.part.orientation;
      std::fprintf(
          record_,
          "%s\t%zu\t%.17g %.17g %.17g %.17g %.17g %.17g %.17g\t%.9g %.9g %.9g\t%.1f\t%d %d %d %d %d\n",
          name.c_str(), i, p.x, p.y, p.z, q.w, q.x, q.y, q.z, f.x, f.y, f.z, tick.time_us, tick.work.steps,
          tick.work.planes, tick.work.balls, tick.work.exact, tick.work.iterations);
    }
    const tandem::Percentiles p = tandem::percentiles(times);
    report_.row(name, "us", p);
    const double n = static_cast<double>(run.size());
    std::printf(
        "  %-34s steps %.2f planes %.0f balls %.1f exact %.1f iterations %.1f, "
        "taking it %zu ticks, longest %.0f us\n",
        "", steps / n, planes / n, balls / n, exact / n, iterations / n, held.taking.size(),
        held.longestTaking_us());
    return p;
  }

  const Options& options_;
  haptics::TickParameters parameters_;
  haptics::TickHelpers helpers_;
  bench::Report report_;
  std::FILE* record_ = nullptr;
};

/// The exit code, where the program is to end now.
std::optional<int> parse(int argc, char** argv, Options& options) {
  tandem::assets::CommandLine line("Ticks of each part of an engine in the hand, and of a nut on its bolt.",
                                   "bench_held");
  line.option("file", options.file, "scene (.gltf or .glb) [engine and nut in TANDEM_DATA]");
  line.option("unit", options.unit, "unit of length of the file").showDefault();
  line.option("--repeats", options.repeats, "runs, of which the fastest counts a tick")
      .showDefault()
      .integerFrom(1, 1000);
  line.option("--helpers", options.helpers, "threads that help in heavy ticks, each on a core of its own")
      .showDefault()
      .integerFrom(0, haptics::TickHelpers::kMost);
  line.option("--queries", options.queries, "rows measured or made active a tick, at most")
      .showDefault()
      .integerFrom(1, 100'000);
  line.option("--only", options.only, "the one part that is drawn, or nut").typeName("NAME");
  line.option("--record", options.record, "writes every tick").typeName("FILE");
  line.option("--json", options.json, "writes the figures").typeName("FILE");
  if (const std::optional<int> code = line.parse("bench_held", argc, argv)) return code;
  if (!options.file.empty() || std::getenv("TANDEM_DATA") != nullptr) return std::nullopt;
  std::fprintf(stderr, "bench_held: name a scene, or set TANDEM_DATA\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const std::optional<int> code = parse(argc, argv, options)) return *code;
  Bench held(options);
  bool met = true;
  if (!options.file.empty()) {
    met = held.drawAll(options.file, options.unit);
  } else {
    const std::string data = std::getenv("TANDEM_DATA");
    if (options.only != "nut") met = held.drawAll(data + "/2CylinderEngine.glb", "mm");
    if (options.only.empty() || options.only == "nut")
      met = held.turn(data + "/m16_nut_bolt_loose.glb") && met;
  }
  return held.finish() && met ? 0 : 1;
}
