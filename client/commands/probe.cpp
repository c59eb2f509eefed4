#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>

#include <glm/geometric.hpp>
#include "assets/base/allocation_counter.h"
#include "assets/base/assert.h"
#include "assets/base/json.h"
#include "assets/base/percentiles.h"
#include "assets/scene/near_names.h"
#include "client/base/felt_sections.h"
#include "client/base/tick_flags.h"
#include "client/commands/command.h"
#include "client/commands/tool_option.h"
#include "client/marks/section_set.h"
#include "client/review/contact_log.h"
#include "client/review/device_class.h"
#include "client/review/device_path.h"
#include "client/review/swept_path.h"
#include "haptics/measure/held_depth.h"
#include "haptics/safety/device_defaults.h"
#include "haptics/tick.h"

namespace tandem::client {

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kNoDevice = "none";

struct ProbeArguments {
  SceneArguments scene;
  std::string path, secondPath, tool = "point", ticks, json, contacts, swept, device = kNoDevice;
  std::vector<std::string> moves, sections;
  double sweptStep = 0.0;
  double stiffness = 0.0, damping = -1.0, forceLimit = 0.0, slewLimit = 0.0;
};

struct Tool {
  double radius = 0.0;
  PartId part = kNoPart;
};

struct MovedPart {
  PartId part = kNoPart;
  std::vector<PathRow> path;
};

/// One line of --ticks.
struct Row {
  double time = 0.0;
  Pose hand, proxy;
  haptics::TickOutput tick;
  std::vector<double> controls;  // values after the tick, m or rad, in the order of the scene's controls
  double depth = 0.0;            // m, with part:NAME: the exact deepest penetration
  double compute_ns = 0.0;
};

Result<Tool> parseTool(const std::string& text, const assets::Scene& scene) {
  Tool tool;
  if (text.rfind("part:", 0) == 0) {
    tool.part = assets::findPart(scene, text.substr(5));
    if (tool.part == kNoPart)
      return Error{"--tool " + text + ": no part has this name" + assets::nearParts(text.substr(5), scene)};
    if (!scene.parts[tool.part].movable)
      return Error{"--tool " + text + ": the part is not movable (see --movable)"};
    return tool;
  }
  const Result<std::optional<double>> radius = parseTip(text, "point, ball:RADIUS_M or part:NAME");
  if (!radius) return radius.error();
  tool.radius = radius->value_or(0.0);
  return tool;
}

Result<std::vector<MovedPart>> loadMoves(const std::vector<std::string>& moves, const assets::Scene& scene) {
  std::vector<MovedPart> moved;
  for (const std::string& move : moves) {
    const std::size_t equals = move.rfind('=');
    if (equals == std::string::npos) return Error{"--move " + move + ": must be NAME=PATH.csv"};
    MovedPart entry;
    entry.part = assets::findPart(scene, move.substr(0, equals));
    if (entry.part == kNoPart)
      return Error{"--move " + move + ": no part is named " + move.substr(0, equals) +
                   assets::nearParts(move.substr(0, equals), scene)};
    Result<std::vector<PathRow>> path = loadDevicePath(move.substr(equals + 1));
    if (!path) return path.error();
    for (std::size_t i = 0; i < path->size(); ++i)
      if (!(*path)[i].valid)
        return Error{move.substr(equals + 1) + ": row " + std::to_string(i + 1) + ": not finite"};
    entry.path = std::move(*path);
    moved.push_back(std::move(entry));
  }
  return moved;
}

/// Velocity between two rows of a path, world axes.
Twist twistBetween(const PathRow& from, const PathRow& to, double dt) {
  return {(to.pose.position - from.pose.position) / dt,
          rotationVector(to.pose.orientation * glm::conjugate(from.pose.orientation)) / dt};
}

/// The parameters of the ticks. Without a device nothing clamps the force, so that it can be compared with
/// the exact one; the slew limit on forces that others cause stays on.
haptics::TickParameters parametersOf(const ProbeArguments& arguments, const DeviceClass* device,
                                     const assets::Scene& scene) {
  haptics::TickParameters p;
  p.forceLimit = p.torqueLimit = std::numeric_limits<double>::infinity();
  // Scenes have any size: a motion counts as a jump if it crosses half of the scene in a tick.
  const double diagonal = glm::length(scene.bounds.max - scene.bounds.min);
  p.maxDeviceSpeed = std::max(10.0, std::isfinite(diagonal) ? 0.5 * diagonal / p.dt : 0.0);
  if (device != nullptr) haptics::fitToDevice(device->limits, 0.0, p);
  if (arguments.stiffness > 0.0) {
    p.stiffness = p.graspStiffness = arguments.stiffness;
    p.stiffnessLimit = 0.0;
  }
  if (arguments.damping >= 0.0) {
    p.damping = p.graspDamping = arguments.damping;
    p.dampingLimit = 0.0;
  }
  if (arguments.forceLimit > 0.0) p.forceLimit = arguments.forceLimit;
  if (arguments.slewLimit > 0.0) p.deviceSlewLimit = arguments.slewLimit;
  return p;
}

/// The readings of a device that follows a path, row by row. After the last row it stands still.
class Readings {
 public:
  Readings(const std::vector<PathRow>& path, double dt) : path_(path), dt_(dt) {}

  /// The reading of a tick. Its velocity is taken from the last valid row, however long ago.
  haptics::DeviceSample at(std::size_t tick) {
    ASSERT(!path_.empty() && (before_ == nullptr || tick > beforeIndex_));
    const PathRow& row = path_[std::min(tick, path_.size() - 1)];
    haptics::DeviceSample sample;
    sample.worldFromDevice = row.pose;
    // A time stamp that stands still would count as a lost device.
    sample.time =
        tick < path_.size() ? row.time : row.time + dt_ * static_cast<double>(tick + 1 - path_.size());
    sample.valid = true;  // an invalid row is passed on: the tick has to detect it
    if (!row.valid) return sample;
    if (before_ != nullptr)
      sample.twist = twistBetween(*before_, row, static_cast<double>(tick - beforeIndex_) * dt_);
    before_ = &row;
    beforeIndex_ = tick;
    return sample;
  }

 private:
  const std::vector<PathRow>& path_;
  double dt_;
  const PathRow* before_ = nullptr;  // the last valid row
  std::size_t beforeIndex_ = 0;
};

class Probe {
 public:
  /// With --ticks it also measures the penetration of the held part, which takes far longer than the ticks.
  Probe(const assets::Scene& scene, const haptics::ContactScene& contact,
        const haptics::TickParameters& parameters, Tool tool, const haptics::Sections& sections,
        const ProbeArguments& arguments)
      : scene_(scene),
        contact_(contact),
        state_(contact),
        parameters_(parameters),
        tool_(tool),
        sections_(sections),
        log_(scene, parameters.dt, !arguments.contacts.empty()) {
    if (!arguments.ticks.empty() && tool.part != kNoPart)
      depth_ = std::make_unique<haptics::HeldPartDepthMeter>(contact, tool.part);
    ASSERT(arguments.swept.empty() || tool.part != kNoPart);
    if (!arguments.swept.empty())
      swept_ = std::make_unique<SweptPath>(contact, tool.part, arguments.sweptStep);
    parameters_.toolRadius = tool.radius;
    parameters_.gravity = scene.gravity;
  }

  /// Runs a tick for each row. `second`: the path of a second hand, which holds the part too; empty: none.
  void run(const std::vector<PathRow>& path, const std::vector<PathRow>& second,
           const std::vector<MovedPart>& moves) {
    ASSERT(rows_.empty() && (second.empty() || tool_.part != kNoPart));
    std::vector<haptics::PartMotion> moved(moves.size());
    rows_.reserve(path.size());
    Readings first(path, parameters_.dt), other(second, parameters_.dt);
    for (std::size_t i = 0; i < path.size(); ++i) {
      for (std::size_t m = 0; m < moves.size(); ++m) {
        const std::vector<PathRow>& rows = moves[m].path;
        const PathRow& row = rows[std::min(i, rows.size() - 1)];
        const bool moving = i > 0 && i < rows.size();
        moved[m] = {moves[m].part, row.pose,
                    moving ? twistBetween(rows[i - 1], row, parameters_.dt) : Twist{}};
      }
      haptics::TickInput input;
      input.hands[0].device = first.at(i);
      if (!second.empty()) {
        input.hands[1].device = other.at(i);
        input.handCount = 2;
      }
      input.moved = moved;
      input.sections = {sections_.data(), sections_.size()};
      input.sessionTime = path[i].time;
      const haptics::PartCommand take[3] = {
          {haptics::PartCommand::Kind::own, tool_.part,
           tool_.part == kNoPart ? Pose{} : scene_.parts[tool_.part].worldFromPart},
          {haptics::PartCommand::Kind::grasp, tool_.part, {}},
          {haptics::PartCommand::Kind::grasp, tool_.part, {}, 1}};
      if (i == 0 && tool_.part != kNoPart) input.commands = {take, second.empty() ? 2u : 3u};
      Commands touched;
      if (i > 0) input.commands = {touched.data(), ownTouched(moves, touched)};
      step(input, path[i]);
    }
  }

  const std::vector<Row>& rows() const { return rows_; }
  std::uint64_t allocations() const { return allocations_; }
  const ContactLog& log() const { return log_; }
  /// Null without --swept.
  const SweptPath* swept() const { return swept_.get(); }

 private:
  using Commands = std::array<haptics::PartCommand, haptics::kMaxPartCommands>;

  /// Fills in commands that make this hand own the controls that it touches and the parts that it pushes, and
  /// release those at rest. In a session the server grants them; here no other site can have them.
  std::size_t ownTouched(const std::vector<MovedPart>& moves, Commands& commands) const {
    ASSERT(!rows_.empty());
    using Kind = haptics::PartCommand::Kind;
    std::size_t count = 0;
    const haptics::TickOutput& last = rows_.back().tick;
    const auto touches = [&](PartId part) {
      return std::any_of(last.contacts.begin(), last.contacts.begin() + last.contactCount,
                         [&](const haptics::Contact& c) { return c.part == part && c.force > 0.0; });
    };
    const auto own = [&](PartId part) {
      const bool moved =
          std::any_of(moves.begin(), moves.end(), [&](const MovedPart& m) { return m.part == part; });
      if (!moved && last.simulated(part) == nullptr && part != tool_.part && count < commands.size())
        commands[count++] = {Kind::own, part, state_.worldFromPart(part)};
    };
    for (const assets::Control& control : scene_.controls)
      if (touches(control.part)) own(control.part);
    for (int i = 0; i < last.pushedCount; ++i) own(last.pushed[static_cast<std::size_t>(i)]);
    for (int i = 0; i < last.ownedCount; ++i) {
      const haptics::OwnedPart& owned = last.owned[static_cast<std::size_t>(i)];
      if (owned.atRest && owned.part != tool_.part && !touches(owned.part) && count < commands.size())
        commands[count++] = {Kind::disown, owned.part, {}};
    }
    return count;
  }

  void step(const haptics::TickInput& input, const PathRow& row) {
    const std::uint64_t before = allocationsOfThisThread();
    const Clock::time_point start = Clock::now();
    const haptics::TickOutput output = haptics::tick(input, contact_, parameters_, state_);
    const Clock::time_point end = Clock::now();
    allocations_ += allocationsOfThisThread() - before;
    Row result;
    result.time = row.time;
    result.hand = row.pose;
    result.proxy = output.worldFromProxy;
    if (tool_.part != kNoPart && output.ownedCount > 0) result.proxy = output.owned[0].worldFromPart;
    result.tick = output;
    for (const assets::Control& control : scene_.controls)
      result.controls.push_back(assets::controlValue(control, state_.worldFromPart(control.part)));
    if (depth_ != nullptr) result.depth = depth_->measure(state_).depth;
    result.compute_ns = std::chrono::duration<double, std::nano>(end - start).count();
    log_.note(row.time, row.pose, row.valid, output);
    if (swept_ != nullptr) swept_->note(row.time, state_);
    rows_.push_back(result);
  }

  const assets::Scene& scene_;
  const haptics::ContactScene& contact_;
  haptics::TickState state_;
  haptics::TickParameters parameters_;
  Tool tool_;
  const haptics::Sections sections_;
  ContactLog log_;
  std::unique_ptr<haptics::HeldPartDepthMeter> depth_;
  std::unique_ptr<SweptPath> swept_;
  std::vector<Row> rows_;
  std::uint64_t allocations_ = 0;
};

Status writeTicks(const std::string& path, const std::vector<Row>& rows, const assets::Scene& scene,
                  bool part, bool second) {
  std::string text = "t,hx,hy,hz,px,py,pz,fx,fy,fz,tx,ty,tz,contacts,part,flags,compute_ns";
  if (part) text += ",pqw,pqx,pqy,pqz,depth";
  if (second) text += ",f2x,f2y,f2z,t2x,t2y,t2z";
  for (const assets::Control& control : scene.controls) text += ',' + csvCell("control:" + control.name);
  text += '\n';
  char line[640];
  for (const Row& row : rows) {
    const glm::dvec3 &h = row.hand.position, &p = row.proxy.position;
    const Wrench& w = row.tick.hands[0].toHand;
    const PartId touched = row.tick.contactCount > 0 ? row.tick.contacts[0].part : kNoPart;
    int length = std::snprintf(
        line, sizeof line, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d,%s,%u,%.0f",
        row.time, h.x, h.y, h.z, p.x, p.y, p.z, w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y,
        w.torque.z, row.tick.contactCount,
        touched == kNoPart ? "" : csvCell(scene.parts[touched].name.substr(0, 200)).c_str(), row.tick.flags,
        row.compute_ns);
    text.append(line, std::min(static_cast<std::size_t>(length), sizeof line - 1));
    ASSERT(length > 0 && row.controls.size() == scene.controls.size());
    if (part) {
      const glm::dquat& q = row.proxy.orientation;
      length = std::snprintf(line, sizeof line, ",%.9g,%.9g,%.9g,%.9g,%.6g", q.w, q.x, q.y, q.z, row.depth);
      text.append(line, static_cast<std::size_t>(length));
    }
    if (second) {
      const Wrench& o = row.tick.hands[1].toHand;
      length = std::snprintf(line, sizeof line, ",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", o.force.x, o.force.y,
                             o.force.z, o.torque.x, o.torque.y, o.torque.z);
      text.append(line, static_cast<std::size_t>(length));
    }
    for (const double value : row.controls) {
      length = std::snprintf(line, sizeof line, ",%.9g", value);
      text.append(line, static_cast<std::size_t>(length));
    }
    text += '\n';
  }
  return writeFile(path, text);
}

/// Ticks by flag, of the first hand or of the second.
Json flagCounts(const std::vector<Row>& rows, bool second = false) {
  Json counts = Json::object();
  for (const auto& [bit, name] : tickFlagNames()) {
    std::uint64_t count = 0;
    for (const Row& row : rows)
      count += ((second ? row.tick.hands[1].flags : row.tick.flags) & bit) != 0 ? 1 : 0;
    if (count > 0) counts[name] = count;
  }
  return counts;
}

/// The last, least and greatest value of each control, m or rad.
Json controlValues(const std::vector<Row>& rows, const assets::Scene& scene) {
  ASSERT(!rows.empty());
  Json values = Json::object();
  for (std::size_t i = 0; i < scene.controls.size(); ++i) {
    double least = rows.front().controls[i], largest = least;
    for (const Row& row : rows) {
      least = std::min(least, row.controls[i]);
      largest = std::max(largest, row.controls[i]);
    }
    values[scene.controls[i].name] = {{"unit", assets::turns(scene.controls[i]) ? "rad" : "m"},
                                      {"last", rows.back().controls[i]},
                                      {"least", least},
                                      {"most", largest}};
  }
  return values;
}

/// Prints the largest forces of the first hand, its limits and its flags.
void printForces(const std::vector<Row>& rows, const haptics::TickParameters& parameters,
                 const DeviceClass* device) {
  double largest = 0.0, torque = 0.0;
  int contacts = 0;
  std::size_t touching = 0;
  for (const Row& row : rows) {
    largest = std::max(largest, glm::length(row.tick.hands[0].toHand.force));
    torque = std::max(torque, glm::length(row.tick.hands[0].toHand.torque));
    contacts = std::max(contacts, row.tick.contactCount);
    touching += row.tick.contactCount > 0 ? 1 : 0;
  }
  std::printf("largest force %.4g N, torque %.4g N*m; %zu ticks in contact, at most %d contacts\n", largest,
              torque, touching, contacts);
  if (device != nullptr)
    std::printf("device %s: stiffness %.0f N/m where the material states none, force limit %.4g N\n",
                device->name, parameters.stiffness, parameters.forceLimit);
  const Json flags = flagCounts(rows);
  for (const auto& [name, count] : flags.members())
    std::printf("  %s in %llu ticks\n", name.c_str(), static_cast<unsigned long long>(count.integer()));
}

/// Prints the largest forces of the second hand and its flags.
void printSecond(const std::vector<Row>& rows) {
  double largest = 0.0, torque = 0.0;
  for (const Row& row : rows) {
    largest = std::max(largest, glm::length(row.tick.hands[1].toHand.force));
    torque = std::max(torque, glm::length(row.tick.hands[1].toHand.torque));
  }
  std::printf("second hand: largest force %.4g N, torque %.4g N*m\n", largest, torque);
  const Json flags = flagCounts(rows, true);
  for (const auto& [name, count] : flags.members())
    std::printf("  %s in %llu ticks\n", name.c_str(), static_cast<unsigned long long>(count.integer()));
}

/// The contacts of the held part summed up, and the work of the hand.
Json contactSums(const ContactLog& log, const assets::Scene& scene) {
  Json parts = Json::array();
  for (const ContactLog::Touched& t : log.touched())
    parts.push({{"part", scene.parts[t.part].name},
                {"ticks", t.ticks},
                {"largest_force_n", t.largestForce},
                {"impulse_ns", t.impulse}});
  return {{"parts", parts},
          {"work_j", log.work()},
          {"work_in_contact_j", log.contactWork()},
          {"ticks_with_most_contacts", log.fullTicks()}};
}

Json sweptSums(const SweptPath& swept, const assets::Scene& scene) {
  Json sums = {{"poses", swept.stops().size()}};
  const SweptPath::Clearance least = swept.least();
  if (least.part == kNoPart) return sums;
  sums["least_clearance_m"] = least.distance;
  sums["least_clearance_to"] = scene.parts[least.part].name;
  return sums;
}

Status writeReview(const Probe& probe, const ProbeArguments& arguments) {
  if (!arguments.contacts.empty())
    if (Status written = writeFile(arguments.contacts, probe.log().csv()); !written) return written;
  if (probe.swept() == nullptr) return {};
  return writeFile(arguments.swept, probe.swept()->csv());
}

void printReview(const Probe& probe, const assets::Scene& scene) {
  const ContactLog& log = probe.log();
  for (const ContactLog::Touched& t : log.touched())
    std::printf("  touched %s in %llu ticks: at most %.4g N, %.4g N*s\n", scene.parts[t.part].name.c_str(),
                static_cast<unsigned long long>(t.ticks), t.largestForce, t.impulse);
  std::printf("work of the hand %.4g J, while in contact %.4g J\n", log.work(), log.contactWork());
  if (probe.swept() == nullptr || probe.swept()->least().part == kNoPart) return;
  const SweptPath::Clearance least = probe.swept()->least();
  std::printf("%zu poses swept, least clearance %.4g mm, to %s\n", probe.swept()->stops().size(),
              1e3 * least.distance, scene.parts[least.part].name.c_str());
}

Status checkOptions(const ProbeArguments& arguments, SectionSet& cut) {
  for (const std::string& out : {arguments.ticks, arguments.json, arguments.contacts, arguments.swept})
    if (Status free = writable(out); !free) return free;
  return cut.addAll(arguments.sections);
}

double milliseconds(Clock::time_point from) {
  return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

int runProbe(const ProbeArguments& arguments) {
  SectionSet cut;
  if (Status good = checkOptions(arguments, cut); !good) return badInput(good.error());
  const DeviceClass* device = findDeviceClass(arguments.device);
  if (device == nullptr && arguments.device != kNoDevice)
    return badInput(Error{"--device " + arguments.device + ": must be none, " + deviceClassNames()});
  Result<std::vector<PathRow>> path = loadDevicePath(arguments.path);
  if (!path) return badInput(path.error());
  const Clock::time_point loadStart = Clock::now();
  Result<assets::Scene> scene = loadScene(arguments.scene);
  if (!scene) return badInput(scene.error());
  const double load_ms = milliseconds(loadStart);
  Result<Tool> tool = parseTool(arguments.tool, *scene);
  if (!tool) return badInput(tool.error());
  std::vector<PathRow> second;
  if (!arguments.secondPath.empty()) {
    if (tool->part == kNoPart) return badInput(Error{"--second-path needs --tool part:NAME"});
    Result<std::vector<PathRow>> loaded = loadDevicePath(arguments.secondPath);
    if (!loaded) return badInput(loaded.error());
    second = std::move(*loaded);
    if (!second.front().valid)
      return badInput(Error{arguments.secondPath +
                            ": the first row says where the hand takes the part: it has no numbers"});
  }
  if (tool->part == kNoPart && !(arguments.contacts.empty() && arguments.swept.empty()))
    return badInput(Error{"--contacts and --swept need --tool part:NAME"});
  Result<std::vector<MovedPart>> moves = loadMoves(arguments.moves, *scene);
  if (!moves) return badInput(moves.error());
  const Clock::time_point bakeStart = Clock::now();
  haptics::ContactScene contact(*scene);
  if (tool->part != kNoPart) modelParts(contact, arguments.scene.noCache);
  const double bake_ms = milliseconds(bakeStart);

  const haptics::TickParameters parameters = parametersOf(arguments, device, *scene);
  Probe probe(*scene, contact, parameters, *tool, feltSections(cut.planes()), arguments);
  probe.run(*path, second, *moves);

  if (!arguments.ticks.empty())
    if (Status written =
            writeTicks(arguments.ticks, probe.rows(), *scene, tool->part != kNoPart, !second.empty());
        !written)
      return badInput(written.error());
  if (Status written = writeReview(probe, arguments); !written) return badInput(written.error());
  std::vector<double> times;
  for (const Row& row : probe.rows()) times.push_back(row.compute_ns);
  const Percentiles p = percentiles(times);
  Json json = {{"ticks", probe.rows().size()},
               {"triangles", assets::triangleCount(*scene)},
               {"parts", scene->parts.size()},
               {"load_ms", load_ms},
               {"bake_ms", bake_ms},
               {"compute_ns", {{"p50", p.p50}, {"p99", p.p99}, {"p999", p.p999}, {"max", p.max}}},
               {"allocations", probe.allocations()},
               {"flags", flagCounts(probe.rows())}};
  if (!second.empty()) json["second_flags"] = flagCounts(probe.rows(), true);
  if (tool->part != kNoPart) json["contact"] = contactSums(probe.log(), *scene);
  if (const SweptPath* swept = probe.swept()) json["swept"] = sweptSums(*swept, *scene);
  if (!scene->controls.empty()) json["controls"] = controlValues(probe.rows(), *scene);
  if (!arguments.json.empty())
    if (Status written = writeFile(arguments.json, json.dump(2) + "\n"); !written)
      return badInput(written.error());
  std::printf("%zu ticks on %zu triangles in %zu parts; load %.0f ms, bake %.0f ms\n", probe.rows().size(),
              assets::triangleCount(*scene), scene->parts.size(), load_ms, bake_ms);
  std::printf("tick %.2f us p50, %.2f p99, %.2f p99.9, %.2f max; %llu allocations\n", p.p50 / 1e3,
              p.p99 / 1e3, p.p999 / 1e3, p.max / 1e3, static_cast<unsigned long long>(probe.allocations()));
  printForces(probe.rows(), parameters, device);
  if (!second.empty()) printSecond(probe.rows());
  if (tool->part != kNoPart) printReview(probe, *scene);
  return probe.allocations() == 0 ? kExitDone : kExitFailed;
}

}  // namespace

void addProbe(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<ProbeArguments>();
  assets::CommandLine command =
      program.command("probe", "Run the haptic tick over a scripted device path, without a network");
  addSceneOptions(command, arguments->scene);
  command
      .option("--path", arguments->path,
              "CSV with t,x,y,z[,qw,qx,qy,qz], one row a millisecond, world frame, m")
      .required();
  command.option(
      "--second-path", arguments->secondPath,
      "With part:NAME: the same for a second hand, which takes the part too where its first row is, "
      "on a device like the first one's [none]");
  command.option("--tool", arguments->tool, "point, ball:RADIUS_M or part:NAME").showDefault();
  const haptics::TickParameters defaults;
  const auto stated = [](double value, const char* unit) { return "[" + inShort(value) + " " + unit + "]"; };
  command
      .option("--stiffness", arguments->stiffness,
              "N/m, where the material states none " + stated(defaults.stiffness, "N/m") +
                  "; a device's limit on stiffness is then off")
      .numberFrom(1e-3, 1e6);
  command
      .option("--damping", arguments->damping,
              "N*s/m of surfaces " + stated(defaults.damping, "N*s/m") +
                  "; a device's limit on damping is then off")
      .numberFrom(0.0, 1e4);
  command
      .option("--device", arguments->device,
              "Limits and stiffness as on a device: " + deviceClassNames() +
                  "; none: no limit on force or stiffness, no passivity control")
      .showDefault();
  command.option("--force-limit", arguments->forceLimit, "N [the device's; without one: none]")
      .numberFrom(1e-3, 1e4);
  command
      .option("--slew-limit", arguments->slewLimit,
              "N/s that the device can follow, whatever the cause [none]; what the hand did not do "
              "itself (a part "
              "that jumps onto it, recovery) is always limited to " +
                  inShort(defaults.slewLimit) + " N/s")
      .numberFrom(1e-3, 1e9);
  command.option("--move", arguments->moves, "NAME=PATH.csv: move a part along a path; repeatable [none]");
  command.option("--section", arguments->sections,
                 "Cut away what lies beyond x=M (before: -x=M; y, z; m; along a direction: NX,NY,NZ,M); "
                 "repeatable [none]");
  command.option("--ticks", arguments->ticks, "Write every tick to this CSV file; columns: client/README.md");
  command.option("--contacts", arguments->contacts,
                 "With part:NAME: write every contact of every tick to this CSV file");
  const assets::CommandLineOption swept =
      command.option("--swept", arguments->swept,
                     "With part:NAME: write the poses that the part went through, and "
                     "its clearances there, to this CSV file");
  command
      .option("--swept-step", arguments->sweptStep,
              "m that the part's furthest point goes from pose to pose [a fiftieth of the part]")
      .numberFrom(1e-9, 1e6)
      .needs(swept);
  command.option("--json", arguments->json,
                 "Write load time, tick times, allocations and flags to this file");
  command.footer(
      "Exit code 1: a tick used the heap.\nExample: tandem probe assets/scenes/pump.glb --path stroke.csv "
      "--ticks ticks.csv --json probe.json");
  command.onRun([arguments, &exitCode] { exitCode = runProbe(*arguments); });
}

}  // namespace tandem::client
