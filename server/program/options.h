#pragma once

// The command line of tandem-server.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "assets/base/result.h"
#include "assets/gltf/load_gltf.h"
#include "server/places.h"
#include "server/program/commands.h"
#include "sync/wire/time.h"

namespace tandem::server {

struct Options {
  std::string scene;
  std::string units = "m";  // what one unit of the file is
  assets::LoadOptions load;
  bool cache = true;
  std::string listenHost;           // empty: every address
  std::uint16_t listenPort = 7480;  // 0: any free one
  std::string linkHost;             // the host by which sites reach this machine; empty: determined
  std::string data = "tandem-data";
  std::string record;  // empty: no recording
  Places places;
  std::string voiceUrl;                 // where people talk; empty: nowhere that all are told of
  std::array<int, 3> invites{1, 1, 1};  // open links a role, by sync::Role
  std::int64_t tokenLifetime_s = 24 * 3600;
  sync::Micros lease = 2 * sync::kSecond;
  double duration_s = 0.0;  // 0: until a signal stops it
  bool quiet = false;
  std::string metricsHost;  // with metricsPort; nothing is served without
  std::optional<std::uint16_t> metricsPort;
  std::string log = "plain";  // or json
  CommandOptions command;     // what is done instead of serving
};

/// The options; or the exit code where the command line asks for help (0) or is wrong (2, with the error on
/// stderr).
std::variant<Options, int> parseOptions(int argc, char** argv);

/// "HOST:PORT", "[IPV6]:PORT" or ":PORT" into its two halves.
Result<std::pair<std::string, std::uint16_t>> parseAddress(const std::string& text);

}  // namespace tandem::server
