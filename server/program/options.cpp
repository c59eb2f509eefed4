#include "server/program/options.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <vector>

#include "assets/base/command_line.h"
#include "sync/wire/limits.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/voice_url.h"

namespace tandem::server {
namespace {

constexpr const char* kExamples = R"(Examples:
  tandem-server assets/scenes/pump.glb
      A session on port 7480 (TCP and UDP); prints one join link a role.
  tandem-server engine.glb --units mm --movable all --invite participant=3
      A plain CAD file in millimetres; every part can be picked up; three open links for participants.
  tandem-server --data /tmp/trial --kick Ben --ban
      Parts from a site of the server that runs there; --help names the other orders.
  tandem-server pump.glb --listen 127.0.0.1:0 --data /tmp/trial --duration 60
      On this machine only, on any free port, for a minute.

Each line on standard output is a role and a link; a link works once, and then a new one is printed.
The session lives in the data directory: start the server again with the same --data and port, and everybody
comes back.
Send a link over a channel that you trust: it carries the right to enter and the pin of the server's key.
Open both TCP and UDP of the port in the firewall; where UDP does not pass, state travels over TCP.)";

constexpr double kMaxGravity = 1000.0;  // m/s^2, the sizes of its components together

Result<glm::dvec3> parseVector(const std::string& text) {
  glm::dvec3 v{0.0};
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &v.x, &v.y, &v.z, &rest) != 3 ||
      !(std::abs(v.x) + std::abs(v.y) + std::abs(v.z) <= kMaxGravity))
    return Error{"--gravity " + text + ": must be X,Y,Z in m/s^2, at most 1000"};
  return v;
}

Status parseInvite(const std::string& text, std::array<int, 3>& invites) {
  const Error wrong{"--invite " + text +
                    ": must be ROLE=N with instructor, participant or observer and N of 0 to " +
                    std::to_string(sync::kMaxSites)};
  const auto equals = text.find('=');
  if (equals == std::string::npos) return wrong;
  int count = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data() + equals + 1, end, count);
  if (error != std::errc() || at != end || count < 0 || count > static_cast<int>(sync::kMaxSites))
    return wrong;
  for (std::size_t role = 0; role < invites.size(); ++role) {
    if (text.substr(0, equals) != sync::toString(static_cast<sync::Role>(role))) continue;
    invites[role] = count;
    return {};
  }
  return wrong;
}

/// As many observers as a session can list beside those who may hold parts.
constexpr std::int64_t kRest = -1;

/// Options as text, before they are understood.
struct Raw {
  std::string listen = ":7480", gravity, metrics;
  std::vector<std::string> movable, invites;
  std::int64_t maxParticipants = Places::kDefaultParticipants;
  std::int64_t maxObservers = kRest;
  double lease_ms = 2000.0;
  std::int64_t maxJson = std::int64_t(assets::LoadOptions{}.maxJsonBytes >> 20);  // MiB
  bool noCache = false;
};

Status parsePlaces(const Raw& raw, Places& places) {
  places.participants = static_cast<std::size_t>(raw.maxParticipants);
  const std::size_t rest = sync::kMaxSites - Places::kForInstructor - places.participants;
  places.observers = raw.maxObservers == kRest ? rest : static_cast<std::size_t>(raw.maxObservers);
  if (places.fit()) return {};
  return Error{"--max-observers " + std::to_string(raw.maxObservers) + ": at most " + std::to_string(rest) +
               " beside " + std::to_string(places.participants) + " participants and an instructor"};
}

Status understand(const Raw& raw, Options& options) {
  if (Status status = check(options.command); !status) return status;
  if (options.command.asked()) return {};
  if (options.scene.empty()) return Error{"SCENE is required (see --help)"};
  if (options.log != "plain" && options.log != "json")
    return Error{"--log " + options.log + ": must be plain or json"};
  const auto units = assets::parseUnits(options.units);
  if (!units) return Error{"--units: " + units.error().message};
  options.load.unitScale = *units;
  options.load.maxJsonBytes = static_cast<std::size_t>(raw.maxJson) << 20;
  for (const std::string& name : raw.movable) {
    if (name == "all")
      options.load.allMovable = true;
    else
      options.load.movable.push_back(name);
  }
  if (!raw.gravity.empty()) {
    const auto gravity = parseVector(raw.gravity);
    if (!gravity) return gravity.error();
    options.load.gravity = *gravity;
  }
  const auto address = parseAddress(raw.listen);
  if (!address) return Error{"--listen " + raw.listen + ": " + address.error().message};
  if (!raw.metrics.empty()) {
    const auto metrics = parseAddress(raw.metrics);
    if (!metrics) return Error{"--metrics " + raw.metrics + ": " + metrics.error().message};
    options.metricsHost = metrics->first.empty() ? "127.0.0.1" : metrics->first;
    if (options.metricsHost.find_first_not_of("0123456789abcdefABCDEF.:") != std::string::npos)
      return Error{"--metrics " + raw.metrics + ": the host must be an address in digits"};
    options.metricsPort = metrics->second;
  }
  options.listenHost = address->first;
  options.listenPort = address->second;
  const auto ofHost = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::strchr(".:-_%", c) != nullptr;
  };
  if (options.linkHost.size() > 253 || !std::all_of(options.linkHost.begin(), options.linkHost.end(), ofHost))
    return Error{"--link-host " + options.linkHost.substr(0, 60) + ": not the name or address of a host"};
  if (!options.voiceUrl.empty() && !sync::isVoiceUrl(options.voiceUrl))
    return Error{"--voice-url " + options.voiceUrl.substr(0, 60) + ": must be a URL of " +
                 sync::kVoiceSchemes + ", of at most " + std::to_string(sync::kMaxVoiceUrl) +
                 " plain characters"};
  for (const std::string& invite : raw.invites)
    if (Status status = parseInvite(invite, options.invites); !status) return status;
  if (Status status = parsePlaces(raw, options.places); !status) return status;
  options.lease = static_cast<sync::Micros>(raw.lease_ms * 1000.0);
  options.cache = !raw.noCache;
  return {};
}

void addOptions(assets::CommandLine& app, Raw& raw, Options& options) {
  app.option("scene", options.scene, "the scene, .gltf or .glb; or a CAD file: .step, .3mf, .stl, .obj, .ply")
      .typeName("SCENE");
  app.option("--listen", raw.listen, "address and port to listen on, TCP and UDP; port 0: any free one")
      .typeName("HOST:PORT")
      .showDefault();
  app.option("--data", options.data, "directory that keeps the session: keys, who owns what, where parts are")
      .typeName("DIR")
      .showDefault();
  app.option("--units", options.units, "what one unit of the file is: m, cm, mm, inch, foot").showDefault();
  app.option("--max-json", raw.maxJson, "largest JSON of the scene file, MiB; 32 take up to 2 GiB of memory")
      .integerFrom(1, 2048)
      .showDefault();
  app.option("--movable", raw.movable, "a part that can be picked up, or all; may be given again")
      .typeName("NAME|all")
      .oneValue();
  app.option("--gravity", raw.gravity, "m/s^2; none by default").typeName("X,Y,Z");
  app.option("--invite", raw.invites, "how many links to keep open for a role; one each by default")
      .typeName("ROLE=N")
      .oneValue();
  app.option("--max-participants", raw.maxParticipants,
             "places for participants and instructors; one more is kept for an instructor")
      .typeName("N")
      .integerFrom(1, static_cast<int>(sync::kMaxSites - Places::kForInstructor))
      .showDefault();
  app.option("--max-observers", raw.maxObservers,
             "places for observers; by default as many as make a session of " +
                 std::to_string(sync::kMaxSites) + " sites")
      .typeName("N")
      .integerFrom(0, static_cast<int>(sync::kMaxSites - Places::kForInstructor - 1));
  app.option("--link-host", options.linkHost, "host in the links, as the sites reach this machine")
      .typeName("HOST");
  app.option("--voice-url", options.voiceUrl, "where people talk to each other; shown to all who join")
      .typeName("URL");
  app.option("--token-lifetime", options.tokenLifetime_s, "how long a link is good, s")
      .typeName("S")
      .integerFrom(1, 366 * 24 * 3600)
      .showDefault();
  app.option("--lease-ms", raw.lease_ms, "how long a silent site keeps its parts, ms")
      .typeName("MS")
      .numberFrom(200.0, 600000.0)
      .showDefault();
  app.option("--record", options.record,
             "records the session, for tandem replay; a file that is there is kept, and FILE-2 written")
      .typeName("FILE");
  app.option("--duration", options.duration_s, "stops after this time, s; 0: runs until SIGINT or SIGTERM")
      .typeName("S")
      .numberFrom(0.0, 1e9);
  app.flag("--no-cache", raw.noCache, "prepares the scene anew");
  app.flag("--quiet", options.quiet, "logs only what is wrong");
  app.option("--metrics", raw.metrics,
             "serves /metrics (Prometheus) and /healthz; no HOST: this machine only")
      .typeName("HOST:PORT");
  app.option("--log", options.log, "how the log is written: plain, or json (an object a line)")
      .typeName("FORMAT")
      .showDefault();
  addCommandOptions(app, options.command);
}

}  // namespace

Result<std::pair<std::string, std::uint16_t>> parseAddress(const std::string& text) {
  const Error wrong{"must be HOST:PORT, [IPV6]:PORT or :PORT"};
  const auto colon = text.rfind(':');
  if (colon == std::string::npos) return wrong;
  std::string host = text.substr(0, colon);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  else if (host.find(':') != std::string::npos)
    return wrong;
  std::uint16_t port = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data() + colon + 1, end, port);
  if (error != std::errc() || at != end) return wrong;
  return std::pair{host, port};
}

std::variant<Options, int> parseOptions(int argc, char** argv) {
  assets::CommandLine app("One Tandem session: who owns what, and the state between the sites.",
                          TANDEM_VERSION);
  app.footer(kExamples);
  Options options;
  Raw raw;
  addOptions(app, raw, options);
  if (const std::optional<int> exitCode = app.parse("tandem-server", argc, argv)) return *exitCode;
  if (Status status = understand(raw, options); !status) {
    std::string line = status.error().message;
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < 32 || c == 127; }, '_');
    std::fprintf(stderr, "tandem-server: %s\n", line.c_str());
    return 2;
  }
  return options;
}

}  // namespace tandem::server
