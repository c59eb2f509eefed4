#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>

#include <CLI/CLI.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "assets/allocation_counter.h"
#include "assets/percentiles.h"
#include "client/commands/command.h"
#include "client/device_class.h"
#include "client/device_path.h"
#include "client/tick_flags.h"
#include "haptics/device_defaults.h"
#include "haptics/tick.h"

namespace tandem::client {

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kNoDevice = "none";

struct Arguments {
  SceneArguments scene;
  std::string path, tool = "point", ticks, json, device = kNoDevice;
  std::vector<std::string> moves;
  double stiffness = 0.0, damping = -1.0, forceLimit = 0.0, slewLimit = 0.0;
};

constexpr double kLargestRadius = 1e4;  // m

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
  std::vector<double> controls;  // m or rad, of the scene's controls in their order, after the tick
  double compute_ns = 0.0;
};

Result<Tool> parseTool(const std::string& text, const assets::Scene& scene) {
  Tool tool;
  if (text == "point") return tool;
  if (text.rfind("ball:", 0) == 0) {
    char* end = nullptr;
    tool.radius = std::strtod(text.c_str() + 5, &end);
    if (*end != '\0' || !(tool.radius >= 1e-9 && tool.radius <= kLargestRadius))
      return Error{"--tool " + text + ": the radius must be a number of metres from 1e-9 to 1e4"};
    return tool;
  }
  if (text.rfind("part:", 0) == 0) {
    tool.part = assets::findPart(scene, text.substr(5));
    if (tool.part == kNoPart) return Error{"--tool " + text + ": no part has this name"};
    if (!scene.parts[tool.part].movable)
      return Error{"--tool " + text + ": the part is not movable (see --movable)"};
    return tool;
  }
  return Error{"--tool " + text + ": must be point, ball:RADIUS_M or part:NAME"};
}

Result<std::vector<MovedPart>> loadMoves(const std::vector<std::string>& moves, const assets::Scene& scene) {
  std::vector<MovedPart> moved;
  for (const std::string& move : moves) {
    const std::size_t equals = move.rfind('=');
    if (equals == std::string::npos) return Error{"--move " + move + ": must be NAME=PATH.csv"};
    MovedPart entry;
    entry.part = assets::findPart(scene, move.substr(0, equals));
    if (entry.part == kNoPart)
      return Error{"--move " + move + ": no part is named " + move.substr(0, equals)};
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

/// Without a device nothing clamps the force, so that it can be compared with the exact one. What others do
/// to the hand is limited all the same.
haptics::TickParameters parametersOf(const Arguments& arguments, const DeviceClass* device,
                                     const assets::Scene& scene) {
  haptics::TickParameters p;
  p.forceLimit = p.torqueLimit = std::numeric_limits<double>::infinity();
  // A script may move a hand of any size: a jump is what crosses half of the scene in a tick.
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

class Probe {
 public:
  Probe(const assets::Scene& scene, const haptics::ContactScene& contact,
        const haptics::TickParameters& parameters, Tool tool)
      : scene_(scene), contact_(contact), state_(contact), parameters_(parameters), tool_(tool) {
    parameters_.toolRadius = tool.radius;
    parameters_.gravity = scene.gravity;
  }

  void run(const std::vector<PathRow>& path, const std::vector<MovedPart>& moves) {
    std::vector<haptics::PartMotion> moved(moves.size());
    rows_.reserve(path.size());
    PathRow before = path.front();
    std::size_t beforeIndex = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      for (std::size_t m = 0; m < moves.size(); ++m) {
        const std::vector<PathRow>& rows = moves[m].path;
        const PathRow& row = rows[std::min(i, rows.size() - 1)];
        const bool moving = i > 0 && i < rows.size();
        moved[m] = {moves[m].part, row.pose,
                    moving ? twistBetween(rows[i - 1], row, parameters_.dt) : Twist{}};
      }
      haptics::TickInput input;
      input.device = sample(path[i], i, before, beforeIndex);
      input.moved = moved;
      input.sessionTime = path[i].time;
      const haptics::PartCommand take[2] = {
          {haptics::PartCommand::Kind::own, tool_.part,
           tool_.part == kNoPart ? Pose{} : scene_.parts[tool_.part].worldFromPart},
          {haptics::PartCommand::Kind::grasp, tool_.part, {}}};
      if (i == 0 && tool_.part != kNoPart) input.commands = take;
      std::array<haptics::PartCommand, haptics::kMaxPartCommands> controls;
      if (i > 0) input.commands = {controls.data(), takeControls(moves, controls)};
      step(input, path[i]);
      if (path[i].valid) {
        before = path[i];
        beforeIndex = i;
      }
    }
  }

  const std::vector<Row>& rows() const { return rows_; }
  std::uint64_t allocations() const { return allocations_; }

 private:
  /// Commands that give the hand the controls that it touches, and take from it those that rest: without a
  /// session nobody else could have them.
  std::size_t takeControls(const std::vector<MovedPart>& moves,
                           std::array<haptics::PartCommand, haptics::kMaxPartCommands>& commands) const {
    using Kind = haptics::PartCommand::Kind;
    std::size_t count = 0;
    const haptics::TickOutput& last = rows_.back().tick;
    const auto touches = [&](PartId part) {
      return std::any_of(last.contacts.begin(), last.contacts.begin() + last.contactCount,
                         [&](const haptics::Contact& c) { return c.part == part && c.force > 0.0; });
    };
    for (const assets::Control& control : scene_.controls) {
      const PartId part = control.part;
      const auto* ownedEnd = last.owned.data() + last.ownedCount;
      const auto* owned = std::find_if(last.owned.data(), ownedEnd,
                                       [&](const haptics::OwnedPart& o) { return o.part == part; });
      const bool moved =
          std::any_of(moves.begin(), moves.end(), [&](const MovedPart& m) { return m.part == part; });
      if (moved || part == tool_.part || count == commands.size()) continue;
      if (owned == ownedEnd && touches(part))
        commands[count++] = {Kind::own, part, state_.worldFromPart(part)};
      else if (owned != ownedEnd && owned->atRest && !touches(part))
        commands[count++] = {Kind::disown, part, {}};
    }
    return count;
  }

  /// The velocity is that since the last reading that was one, however long ago.
  haptics::DeviceSample sample(const PathRow& row, std::size_t index, const PathRow& before,
                               std::size_t beforeIndex) const {
    haptics::DeviceSample sample;
    sample.worldFromDevice = row.pose;
    sample.time = row.time;
    sample.valid = true;  // an invalid row goes in as it is: the tick must find out
    if (row.valid && before.valid && index > beforeIndex)
      sample.twist = twistBetween(before, row, static_cast<double>(index - beforeIndex) * parameters_.dt);
    return sample;
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
    result.compute_ns = std::chrono::duration<double, std::nano>(end - start).count();
    rows_.push_back(result);
  }

  const assets::Scene& scene_;
  const haptics::ContactScene& contact_;
  haptics::TickState state_;
  haptics::TickParameters parameters_;
  Tool tool_;
  std::vector<Row> rows_;
  std::uint64_t allocations_ = 0;
};

/// A part's name as one cell: file formats allow commas, quotes and more in it.
std::string csvCell(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string cell = "\"";
  for (const char c : name) cell.append(c == '"' ? 2 : 1, c);
  return cell + '"';
}

Status writeTicks(const std::string& path, const std::vector<Row>& rows, const assets::Scene& scene,
                  bool part) {
  std::string text = "t,hx,hy,hz,px,py,pz,fx,fy,fz,tx,ty,tz,contacts,part,flags,compute_ns";
  if (part) text += ",pqw,pqx,pqy,pqz,depth";
  for (const assets::Control& control : scene.controls) text += ',' + csvCell("control:" + control.name);
  text += '\n';
  char line[640];
  for (const Row& row : rows) {
    const glm::dvec3 &h = row.hand.position, &p = row.proxy.position;
    const Wrench& w = row.tick.toHand;
    const PartId touched = row.tick.contactCount > 0 ? row.tick.contacts[0].part : kNoPart;
    int length = std::snprintf(
        line, sizeof line, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d,%s,%u,%.0f",
        row.time, h.x, h.y, h.z, p.x, p.y, p.z, w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y,
        w.torque.z, row.tick.contactCount,
        touched == kNoPart ? "" : csvCell(scene.parts[touched].name.substr(0, 200)).c_str(), row.tick.flags,
        row.compute_ns);
    text.append(line, std::min(static_cast<std::size_t>(length), sizeof line - 1));
    if (part) {
      // A held part does not touch others in this version: there is no penetration depth to tell.
      const glm::dquat& q = row.proxy.orientation;
      length = std::snprintf(line, sizeof line, ",%.9g,%.9g,%.9g,%.9g,nan", q.w, q.x, q.y, q.z);
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

nlohmann::ordered_json flagCounts(const std::vector<Row>& rows) {
  nlohmann::ordered_json counts = nlohmann::ordered_json::object();
  for (const auto& [bit, name] : tickFlagNames()) {
    std::uint64_t count = 0;
    for (const Row& row : rows) count += (row.tick.flags & bit) != 0 ? 1 : 0;
    if (count > 0) counts[name] = count;
  }
  return counts;
}

/// Where each control ended and between which values it was, m or rad.
nlohmann::ordered_json controlValues(const std::vector<Row>& rows, const assets::Scene& scene) {
  nlohmann::ordered_json values = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < scene.controls.size(); ++i) {
    double least = rows.front().controls[i], most = least;
    for (const Row& row : rows) {
      least = std::min(least, row.controls[i]);
      most = std::max(most, row.controls[i]);
    }
    values[scene.controls[i].name] = {{"unit", assets::turns(scene.controls[i]) ? "rad" : "m"},
                                      {"last", rows.back().controls[i]},
                                      {"least", least},
                                      {"most", most}};
  }
  return values;
}

/// What was felt, under which limits.
void printForces(const std::vector<Row>& rows, const haptics::TickParameters& parameters,
                 const DeviceClass* device) {
  double most = 0.0, torque = 0.0;
  int contacts = 0;
  std::size_t touching = 0;
  for (const Row& row : rows) {
    most = std::max(most, glm::length(row.tick.toHand.force));
    torque = std::max(torque, glm::length(row.tick.toHand.torque));
    contacts = std::max(contacts, row.tick.contactCount);
    touching += row.tick.contactCount > 0 ? 1 : 0;
  }
  std::printf("largest force %.4g N, torque %.4g N*m; %zu ticks in contact, at most %d contacts\n", most,
              torque, touching, contacts);
  if (device != nullptr)
    std::printf("device %s: stiffness %.0f N/m where the material states none, force limit %.4g N\n",
                device->name, parameters.stiffness, parameters.forceLimit);
  const nlohmann::ordered_json flags = flagCounts(rows);
  for (const auto& [name, count] : flags.items())
    std::printf("  %s in %llu ticks\n", name.c_str(),
                static_cast<unsigned long long>(count.get<std::uint64_t>()));
}

double milliseconds(Clock::time_point from) {
  return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

int run(const Arguments& arguments) {
  for (const std::string& out : {arguments.ticks, arguments.json})
    if (Status free = writable(out); !free) return badInput(free.error());
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
  Result<std::vector<MovedPart>> moves = loadMoves(arguments.moves, *scene);
  if (!moves) return badInput(moves.error());
  const Clock::time_point bakeStart = Clock::now();
  const haptics::ContactScene contact(*scene);
  const double bake_ms = milliseconds(bakeStart);
  if (tool->part != kNoPart)
    std::fprintf(
        stderr,
        "tandem: note: a held part follows the hand but does not collide with others in this version\n");

  const haptics::TickParameters parameters = parametersOf(arguments, device, *scene);
  Probe probe(*scene, contact, parameters, *tool);
  probe.run(*path, *moves);

  if (!arguments.ticks.empty())
    if (Status written = writeTicks(arguments.ticks, probe.rows(), *scene, tool->part != kNoPart); !written)
      return badInput(written.error());
  std::vector<double> times;
  for (const Row& row : probe.rows()) times.push_back(row.compute_ns);
  const Percentiles p = percentiles(times);
  nlohmann::ordered_json json = {
      {"ticks", probe.rows().size()},
      {"triangles", assets::triangleCount(*scene)},
      {"parts", scene->parts.size()},
      {"load_ms", load_ms},
      {"bake_ms", bake_ms},
      {"compute_ns", {{"p50", p.p50}, {"p99", p.p99}, {"p999", p.p999}, {"max", p.max}}},
      {"allocations", probe.allocations()},
      {"flags", flagCounts(probe.rows())}};
  if (!scene->controls.empty()) json["controls"] = controlValues(probe.rows(), *scene);
  if (!arguments.json.empty())
    if (Status written = writeFile(arguments.json, json.dump(2) + "\n"); !written)
      return badInput(written.error());
  std::printf("%zu ticks on %zu triangles in %zu parts; load %.0f ms, bake %.0f ms\n", probe.rows().size(),
              assets::triangleCount(*scene), scene->parts.size(), load_ms, bake_ms);
  std::printf("tick %.2f us p50, %.2f p99, %.2f p99.9, %.2f max; %llu allocations\n", p.p50 / 1e3,
              p.p99 / 1e3, p.p999 / 1e3, p.max / 1e3, static_cast<unsigned long long>(probe.allocations()));
  printForces(probe.rows(), parameters, device);
  return probe.allocations() == 0 ? kExitDone : kExitFailed;
}

}  // namespace

void addProbe(CLI::App& app, int& exitCode) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("probe", "Run the haptic tick over a scripted device path, without a network");
  addSceneOptions(*command, arguments->scene);
  command
      ->add_option("--path", arguments->path,
                   "CSV with t,x,y,z[,qw,qx,qy,qz], one row a millisecond, world frame, m")
      ->required();
  command->add_option("--tool", arguments->tool, "point, ball:RADIUS_M or part:NAME")->capture_default_str();
  const haptics::TickParameters defaults;
  const auto stated = [](double value, const char* unit) { return "[" + inShort(value) + " " + unit + "]"; };
  command
      ->add_option("--stiffness", arguments->stiffness,
                   "N/m, where the material states none " + stated(defaults.stiffness, "N/m") +
                       "; a device's limit on stiffness is then off")
      ->check(numberFrom(1e-3, 1e6));
  command
      ->add_option("--damping", arguments->damping,
                   "N*s/m of surfaces " + stated(defaults.damping, "N*s/m") +
                       "; a device's limit on damping is then off")
      ->check(numberFrom(0.0, 1e4));
  command
      ->add_option("--device", arguments->device,
                   "Limits and stiffness as on a device: " + deviceClassNames() +
                       "; none: no limit on force or stiffness, no passivity control")
      ->capture_default_str();
  command->add_option("--force-limit", arguments->forceLimit, "N [the device's; without one: none]")
      ->check(numberFrom(1e-3, 1e4));
  command
      ->add_option("--slew-limit", arguments->slewLimit,
                   "N/s that the device can follow, whatever the cause [none]; what the hand did not do "
                   "itself (a part "
                   "that jumps onto it, recovery) is always limited to " +
                       inShort(defaults.slewLimit) + " N/s")
      ->check(numberFrom(1e-3, 1e9));
  command->add_option("--move", arguments->moves,
                      "NAME=PATH.csv: move a part along a path; repeatable [none]");
  command->add_option("--ticks", arguments->ticks,
                      "Write every tick to this CSV file; columns: client/README.md");
  command->add_option("--json", arguments->json,
                      "Write load time, tick times, allocations and flags to this file");
  command->footer(
      "Exit code 1: a tick used the heap.\nExample: tandem probe assets/scenes/pump.glb --path stroke.csv "
      "--ticks ticks.csv --json probe.json");
  command->callback([arguments, &exitCode] { exitCode = run(*arguments); });
}

}  // namespace tandem::client
