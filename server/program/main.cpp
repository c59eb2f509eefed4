// tandem-server: loads a scene, opens its session's data directory, prints join links, and serves until a
// signal stops it. Standard output carries the links and nothing else; the log goes to standard error. Exit
// codes: 0 done, 1 the run failed, 2 bad arguments or input (one line on standard error).

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>

#include <spdlog/spdlog.h>

#include "assets/base/process_memory.h"
#include "assets/base/utc_time.h"
#include "assets/gltf/cad_file.h"
#include "assets/scene/scene_package.h"
#include "assets/scene/scene_size.h"
#include "server/admission.h"
#include "server/data_directory.h"
#include "server/journal/sqlite_journal.h"
#include "server/program/invitations.h"
#include "server/program/operation.h"
#include "server/program/options.h"
#include "server/session.h"
#include "sync/transport/socket_transport.h"

namespace tandem::server {
namespace {

constexpr sync::Micros kLongestWait = 100 * sync::kMillisecond;  // so that a signal is handled soon
constexpr sync::Micros kClosingTime = 300 * sync::kMillisecond;

volatile std::sig_atomic_t stopAsked = 0;

extern "C" void onStopSignal(int) { stopAsked = 1; }

void watchSignals() {
  struct sigaction action {};
  action.sa_handler = onStopSignal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
  sigaction(SIGXFSZ, &action, nullptr);  // a file at its limit is a failed write, like a full disk
}

/// Monotonic, from the start of the program.
sync::Micros localNow() {
  using Clock = std::chrono::steady_clock;
  static const Clock::time_point start = Clock::now();
  return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start).count();
}

int badInput(const Error& error) {
  // Messages quote files and arguments, which may hold line breaks and codes that a terminal executes.
  std::string line = error.message;
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 32 || c == 127; }, '_');
  std::fprintf(stderr, "tandem-server: %s\n", line.c_str());
  return kExitBadInput;
}

Result<assets::Scene> load(Options& options) {
  const bool bar = ::isatty(STDERR_FILENO) == 1 && !options.quiet;
  if (bar)
    options.load.progress = [](double share, const char* what) {
      std::fprintf(stderr, "\r\033[Kloading %3.0f %% %s", 100.0 * share, what);
    };
  const assets::SceneFile file{options.scene, options.units,
                               options.cache ? assets::defaultCacheDirectory() : ""};
  auto scene = assets::loadSceneFile(file, options.load, [] { return stopAsked != 0; });
  if (bar) std::fputs("\r\033[K", stderr);
  if (scene && scene->parts.empty()) return Error{options.scene + ": no parts in it"};
  return scene;
}

/// Everything that a running session needs, in the order in which it is made.
struct Server {
  assets::Scene scene;        // without its geometry, which the package has
  std::size_t triangles = 0;  // that it had
  std::vector<std::byte> package;
  DataDirectory directory;
  std::unique_ptr<sync::SocketTransport> transport;
  std::unique_ptr<SqliteJournal> journal;  // after the transport: its thread wakes it
  std::optional<sync::RecordingWriter> recording;
  std::shared_ptr<const Session*> session;  // by which the transport knows knocks, once there is one
};

/// Serves until a signal stops it. Returns whether the journal was sound to the end.
bool serve(const Options& options, Server& server, Session& session, Operation& operation,
           Invitations& invitations) {
  const sync::Micros end = options.duration_s > 0.0
                               ? localNow() + static_cast<sync::Micros>(options.duration_s * 1e6)
                               : std::numeric_limits<sync::Micros>::max();
  while (stopAsked == 0 && localNow() < end) {
    const sync::Micros wait = std::clamp<sync::Micros>(session.nextDeadline() - localNow(), 0, kLongestWait);
    server.transport->wait(wait);
    const sync::Micros began = localNow();
    session.step(began, systemUnixTime());
    operation.step(session, invitations, localNow(), systemUnixTime());
    invitations.renew(session, session.drainUsedTokens(), systemUnixTime());
    operation.took(localNow() - began);
  }
  operation.stopping();
  session.shutDown();
  const sync::Micros closed = localNow() + kClosingTime;
  for (sync::TransportEvent event; localNow() < closed && session.sites().size() > 0;) {
    server.transport->wait(10 * sync::kMillisecond);
    while (server.transport->poll(event)) {
    }
  }
  return server.journal->failure().empty();
}

/// Adds to the error of a port in use how to listen on a free one.
Error listenError(const Error& error, const std::string& host) {
  const std::string inUse = std::make_error_code(std::errc::address_in_use).message();
  if (error.message.find(inUse) == std::string::npos) return error;
  const bool ipv6 = host.find(':') != std::string::npos;
  return Error{error.message + " (--listen " + (ipv6 ? '[' + host + ']' : host) + ":0 takes any free port)"};
}

Result<Server> prepare(Options& options, int& exitCode) {
  exitCode = kExitBadInput;
  Result<assets::Scene> scene = load(options);
  if (!scene) return scene.error();
  std::vector<std::byte> package = assets::packScene(*scene);
  const std::size_t triangles = assets::triangleCount(*scene);
  assets::dropGeometry(*scene);
  returnFreedPieces();  // what loading took
  Result<DataDirectory> directory = DataDirectory::open(options.data);
  if (!directory) return directory.error();
  const auto hash = assets::contentHash(package);
  const SqliteJournalOptions kept{
      assets::toHex(hash), 0, directory->fingerprint(), directory->used(), {directory->lockPath()}};
  auto journal = SqliteJournal::open(directory->journalPath(), kept);
  if (!journal) return journal.error();
  if (Status key = directory->keepSigningKey(); !key) return key.error();
  std::optional<sync::RecordingWriter> recording;
  if (!options.record.empty()) {
    auto writer = sync::RecordingWriter::create(options.record, {hash, sync::wireFrame(scene->bounds)});
    if (!writer) return writer.error();
    recording = std::move(*writer);
    if (recording->path() != options.record)
      spdlog::info("{} is there: this recording is {}", options.record, recording->path());
  }
  exitCode = kExitFailed;
  sync::ListenOptions listen;
  const auto session = std::make_shared<const Session*>(nullptr);
  listen.knows = [session](const sync::Knock& knock) {
    return *session != nullptr && (*session)->knows(knock);
  };
  auto transport = sync::listenOn(options.listenHost, options.listenPort, directory->identity(), listen);
  if (!transport) return listenError(transport.error(), options.listenHost);
  return Server{std::move(*scene),     triangles,           std::move(package),   std::move(*directory),
                std::move(*transport), std::move(*journal), std::move(recording), session};
}

/// Says what reading the scene found that may be wrong: of the whole scene in words, of single meshes how
/// many.
void logFindings(const assets::Scene& scene, const std::string& file) {
  std::set<std::string> flawed;
  for (const assets::Finding& finding : scene.findings) {
    if (finding.severity == assets::Finding::Severity::note) continue;
    if (finding.where.empty())
      spdlog::warn("{}: {} ({})", file, finding.message, finding.count);
    else
      flawed.insert(finding.where);
  }
  if (flawed.size() == 1)
    spdlog::warn("{}: the mesh of {} has flaws, which `tandem check` lists", file, *flawed.begin());
  if (flawed.size() > 1)
    spdlog::warn("{}: {} meshes, that of {} among them, have flaws, which `tandem check` lists", file,
                 flawed.size(), *flawed.begin());
}

/// A session of many sites needs more descriptors than most systems give a process at first.
void raiseFileLimit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

int run(Options& options) {
  watchSignals();
  raiseFileLimit();
  returnFreedArrays();
  ::umask(077);  // files of the server are readable by its user only
  startLog(options.quiet, options.log == "json");
  localNow();
  int exitCode = kExitDone;
  Result<Server> prepared = prepare(options, exitCode);
  if (!prepared) {
    badInput(prepared.error());
    return exitCode;
  }
  Server& server = *prepared;
  const Result<std::string> pin = sync::pinOf(server.directory.identity());
  if (!pin) return badInput(pin.error());
  nameSessionInLog(pin->substr(0, 12));
  auto operation =
      Operation::open(server.directory, [transport = server.transport.get()] { transport->wake(); });
  if (!operation) return badInput(operation.error());
  if (options.metricsPort) {
    const Status served = (*operation)->serveMetrics(options.metricsHost, *options.metricsPort);
    if (!served) {
      badInput(served.error());
      return kExitFailed;
    }
  }
  server.journal->onProgress([transport = server.transport.get()] { transport->wake(); });

  SessionConfig config;
  config.key = server.directory.signingKey();
  config.linkKey = server.directory.linkKey();
  config.places = options.places;
  config.voiceUrl = options.voiceUrl;
  config.lease.lease = options.lease;
  config.lease.margin = std::min(config.lease.margin, options.lease / 8);
  Session session(server.scene, server.package, config, *server.transport, *server.journal,
                  server.recording ? &*server.recording : nullptr, localNow(), systemUnixTime());
  *server.session = &session;
  const std::string host = options.linkHost.empty() ? defaultLinkHost(options.listenHost) : options.linkHost;
  const auto movable = std::count_if(server.scene.parts.begin(), server.scene.parts.end(),
                                     [](const assets::Part& part) { return part.movable; });
  spdlog::info("{}: {}, {} parts ({} movable), {} triangles, {} KiB to each new site; port {}; data in {}",
               options.scene, assets::sizeInWords(server.scene), server.scene.parts.size(), movable,
               server.triangles, server.package.size() / 1024, server.transport->port(), options.data);
  if (movable == 0)
    spdlog::warn("{}: nothing in it can be taken; --movable all or NAME lets it", options.scene);
  if (const std::string doubt = assets::unitDoubt(server.scene, options.units); !doubt.empty())
    spdlog::warn("{}: {}", options.scene, doubt);
  logFindings(server.scene, options.scene);
  Invitations invitations(options, host, server.transport->port(), *pin);
  invitations.open(session, systemUnixTime());
  (*operation)->ready(session);
  const bool sound = serve(options, server, session, **operation, invitations);

  const SessionCounters& c = session.counters();
  spdlog::info(
      "stopped: {} grants, {} denials, {} releases, {} updates relayed, {} states and {} datagrams dropped",
      c.grants, c.denials, c.releases, c.relayedUpdates + c.relayedLinks, c.droppedStates,
      c.droppedMalformed + c.droppedFlood + c.droppedLinks + c.droppedBaselines);
  for (const auto& cause : sync::kTrafficCauses) {
    const sync::Flow &in = c.received.*cause.flow, &out = c.sent.*cause.flow;
    if (in.packets + out.packets > 0)
      spdlog::info("{}: {} in, {} KiB; {} out, {} KiB", cause.name, in.packets, in.bytes / 1024, out.packets,
                   out.bytes / 1024);
  }
  return sound ? kExitDone : kExitFailed;
}

}  // namespace
}  // namespace tandem::server

int main(int argc, char** argv) {
  auto parsed = tandem::server::parseOptions(argc, argv);
  if (const int* exitCode = std::get_if<int>(&parsed)) return *exitCode;
  auto& options = std::get<tandem::server::Options>(parsed);
  try {
    if (options.command.asked()) return tandem::server::runCommand(options.command, options.data);
    return tandem::server::run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem-server: %s\n", error.what());
    return tandem::server::kExitFailed;
  }
}
