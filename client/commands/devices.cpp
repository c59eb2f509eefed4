#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include <glm/geometric.hpp>
#include "assets/base/json.h"
#include "client/commands/command.h"
#include "haptics/devices/colocation.h"
#include "haptics/devices/device_list.h"
#include "haptics/devices/hid_record.h"
#include "haptics/devices/udev_rule.h"

namespace tandem::client {

namespace {

struct DevicesArguments {
  std::string test, calibrate, out, hidRecord;
  bool rigid = false;
  double seconds = 5.0;
  bool json = false;
  bool udevRule = false;
};

int list(const DevicesArguments& arguments) {
  const std::vector<haptics::DeviceReport> reports = haptics::listDevices();
  if (arguments.json) {
    Json json = Json::array();
    for (const haptics::DeviceReport& report : reports)
      json.push({{"name", report.name},
                 {"vendor", report.vendor},
                 {"product", report.product},
                 {"node", report.node},
                 {"driver", report.driver},
                 {"usable", report.usable},
                 {"reason", report.reason},
                 {"remedy", report.remedy}});
    std::printf("%s\n", json.dump(2).c_str());
    return kExitDone;
  }
  for (const haptics::DeviceReport& report : reports) {
    char id[16] = "-";
    if (report.vendor != 0) std::snprintf(id, sizeof id, "%04x:%04x", report.vendor, report.product);
    std::printf("%-12s %-9s  %-14s %-8s %s\n", report.driver.c_str(), id,
                report.node.empty() ? "built in" : report.node.c_str(), report.usable ? "usable" : "CLOSED",
                report.name.c_str());
    if (!report.reason.empty()) std::printf("             %s\n", report.reason.c_str());
    for (const std::string& command : report.remedy) std::printf("               %s\n", command.c_str());
  }
  std::printf("\ntry one:  tandem devices --test NAME      use one:  tandem join LINK --device NAME\n");
  return kExitDone;
}

int printUdevRule() {
  const std::string_view rule = haptics::udevRule();
  const bool written = std::fwrite(rule.data(), 1, rule.size(), stdout) == rule.size();
  return written && std::fflush(stdout) == 0 ? kExitDone : kExitFailed;
}

/// A hint for the person: how to move the device, or why it does not move here.
std::string whatToDo(const std::string& name) {
  if (name == "stylus")
    return "This is the pen that mouse and keyboard move in the window of 'tandem join'. There is no window "
           "here, "
           "so nobody moves it: it stays where it is. Readings show that it runs.";
  if (name == "simulated")
    return "A modelled hand that programs and scripts move: here it stays where it is.";
  if (name == "simulated-arm") return "A model: it stays where it is, but for what its encoders round.";
  if (name == "none") return "There is nothing to read.";
  return "Move it and press its buttons.";
}

int test(const DevicesArguments& arguments) {
  std::unique_ptr<haptics::RecordingHidBus> recorder;
  if (!arguments.hidRecord.empty()) {
    auto made = haptics::RecordingHidBus::create(haptics::systemHidBus(), arguments.hidRecord);
    if (!made) return badInput(Error{"--hid-record " + made.error().message});
    recorder = std::move(*made);
  }
  Result<std::unique_ptr<haptics::Device>> device = haptics::openDevice(
      arguments.test, std::nullopt, nullptr, recorder ? *recorder : haptics::systemHidBus());
  if (!device) return badInput(device.error());
  const haptics::DeviceLimits limits = (*device)->limits();
  std::printf(
      "%s: senses %d axes, drives %d; at most %.1f N; reads to %.3f mm; read for %g s under zero force\n%s\n",
      (*device)->name().c_str(), limits.sensedAxes, limits.actuatedAxes, limits.maxForce,
      limits.quantum * 1e3, arguments.seconds, whatToDo(arguments.test).c_str());
  const bool terminal = isatty(STDOUT_FILENO) != 0;
  const haptics::DeviceTestState state =
      haptics::testDevice(**device, arguments.seconds, [&](const haptics::DeviceTestState& now) {
        const glm::dvec3& p = now.sample.worldFromDevice.position;
        if (terminal) {
          std::printf("\r\033[K%5.1f s  %8.4f %8.4f %8.4f m  buttons %02x  %s", now.elapsed, p.x, p.y, p.z,
                      now.sample.buttons, now.sample.valid ? "" : "no reading");
          std::fflush(stdout);
        }
        return true;
      });
  (*device)->close();
  std::printf("%s%llu readings, %llu valid, %llu changed, %.0f a second\n", terminal ? "\r\033[K" : "",
              static_cast<unsigned long long>(state.ticks), static_cast<unsigned long long>(state.valid),
              static_cast<unsigned long long>(state.changes), state.tickRate);
  if (recorder) {
    const Result<std::uint64_t> recorded = recorder->finish();
    if (!recorded) return badInput(Error{arguments.hidRecord + ": " + recorded.error().message});
    std::printf("%llu input reports in %s\n", static_cast<unsigned long long>(*recorded),
                arguments.hidRecord.c_str());
  }
  return state.valid > 0 || arguments.test == "none" ? kExitDone : kExitFailed;
}

/// Fits a calibration to pairs of points. Prints it, or writes it to a file and prints the residual.
int calibrate(const DevicesArguments& arguments) {
  const Result<std::vector<haptics::PointPair>> pairs = haptics::loadPairs(arguments.calibrate);
  if (!pairs) return badInput(pairs.error());
  const Result<haptics::Colocation> found = haptics::colocate(*pairs, !arguments.rigid);
  if (!found) return badInput(Error{arguments.calibrate + ": " + found.error().message});
  const std::string json = haptics::toJson(*found);
  if (arguments.out.empty()) {
    std::printf("%s", json.c_str());
    return kExitDone;
  }
  if (Status written = writeFile(arguments.out, json); !written) return badInput(written.error());
  std::printf(
      "%zu pairs, scale %.4f, residual %.3f mm rms, %.3f mm at worst; use it:\n"
      "  tandem join LINK --device NAME --calibration %s\n",
      found->pairs, found->scale, 1e3 * found->rms, 1e3 * found->worst, arguments.out.c_str());
  return kExitDone;
}

int runDevices(const DevicesArguments& arguments) {
  if (!arguments.calibrate.empty()) return calibrate(arguments);
  if (arguments.udevRule) return printUdevRule();
  return arguments.test.empty() ? list(arguments) : test(arguments);
}

}  // namespace

void addDevices(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<DevicesArguments>();
  assets::CommandLine command =
      program.command("devices", "List the devices that are connected, say why one cannot be opened");
  command.option("--test", arguments->test,
                 "Read this device (its name in the list) for a while under zero force; stylus and simulated "
                 "move in a session only");
  command
      .option("--hid-record", arguments->hidRecord,
              "Write what a HID device sends meanwhile to this file (text; without its serial number)")
      .needs("--test");
  command.option("--seconds", arguments->seconds, "Length of the test, s")
      .numberFrom(0.1, 3600.0)
      .showDefault();
  command.option(
      "--calibrate", arguments->calibrate,
      "Find where a device's workspace lies in the view from this CSV of touched points "
      "(header dx,dy,dz,vx,vy,vz: in the device's axes, as --test shows them, and in the scene; m)");
  command.option("--out", arguments->out, "File for the calibration (JSON) [standard output]");
  command.flag("--rigid", arguments->rigid, "Keep the scale at 1");
  command.flag("--json", arguments->json, "Print JSON instead of a table");
  command.flag(
      "--udev-rule", arguments->udevRule,
      "Print the udev rule that lets you open these devices, for " + std::string(haptics::kUdevRulePath));
  command.footer(
      "Examples:\n"
      "  tandem devices --test spacemouse --seconds 5\n"
      "  tandem devices --calibrate touched.csv --out desk.json\n"
      "  tandem devices --udev-rule | sudo tee " +
      std::string(haptics::kUdevRulePath));
  command.onRun([arguments, &exitCode] { exitCode = runDevices(*arguments); });
}

}  // namespace tandem::client
