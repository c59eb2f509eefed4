#include <cstdio>
#include <memory>

#include "assets/document/document_json.h"
#include "assets/scene/scene_package.h"
#include "client/base/json_input.h"
#include "client/commands/command.h"
#include "client/join/local_time.h"
#include "client/session/document_visit.h"
#include "sync/transport/join_link.h"
#include "sync/transport/socket_transport.h"

namespace tandem::client {
namespace {

constexpr sync::Micros kPatience = 20 * sync::kSecond;  // without any progress

struct DocumentArguments {
  std::string link, action, file, name = "document";
};

/// Steps the visit until `done()` holds; an error if it ends before, or nothing goes on.
template <typename Done>
Status stepUntil(sync::SocketTransport& transport, DocumentVisit& visit, ProgressLine& line, const char* what,
                 const Done& done) {
  double progress = -1.0;
  sync::Micros moved = localTime();
  while (!done()) {
    if (visit.stage() == DocumentVisit::Stage::ended) return Error{visit.reason()};
    transport.wait(20 * sync::kMillisecond);
    visit.step(localTime());
    const double now = visit.bringing() != nullptr ? visit.bringing()->progress()
                                                   : static_cast<double>(visit.content().entries().size());
    if (now != progress) moved = localTime();
    progress = now;
    if (localTime() - moved > kPatience) return Error{"no answer"};
    line.show(visit.bringing() != nullptr ? progress : 0.0, what);
  }
  return {};
}

int report(const DocumentImport& import) {
  std::printf("%zu entries made, %zu there already, %zu refused\n", import.made(), import.known(),
              import.refused());
  if (import.refused() == 0) return kExitDone;
  std::fprintf(stderr, "tandem: entries were refused: %s\n", import.reason().c_str());
  return kExitFailed;
}

int exportTo(const std::string& path, const DocumentVisit& visit) {
  const std::string text = toJson(visit.content(), assets::toHex(visit.welcome().sceneHash));
  if (Status written = writeFile(path, text); !written) return badInput(written.error());
  std::printf("%zu entries written to %s\n", visit.content().size(), path.c_str());
  return kExitDone;
}

int run(const DocumentArguments& arguments) {
  const bool imports = arguments.action == "import";
  if (!imports && arguments.action != "export")
    return badInput(Error{"document: " + arguments.action + " is neither export nor import"});
  const Result<sync::JoinLink> link = sync::parseJoinLink(arguments.link);
  if (!link) return badInput(Error{link.error().message + " (quote the link: it holds a & sign)"});
  // A link works once, so everything on this side is checked before it is used.
  if (arguments.name.empty() || arguments.name.size() > sync::kMaxNameLength)
    return badInput(Error{"--name: 1 to " + std::to_string(sync::kMaxNameLength) + " bytes"});
  document::DocumentFile file;
  if (imports) {
    if (link->role == sync::Role::observer)
      return badInput(Error{"document import: an observer's link changes nothing; take another"});
    const Result<std::string> text = readTextFile(arguments.file);
    if (!text) return badInput(text.error());
    Result<document::DocumentFile> read = document::fromJson(*text, arguments.file);
    if (!read) return badInput(read.error());
    file = std::move(*read);
  } else if (Status free = writable(arguments.file); !free) {
    return badInput(free.error());
  }

  sync::ConnectOptions options;
  options.udp = false;  // it sends and needs no state
  options.credential = link->token;
  const auto transport = sync::connectTo(link->host, link->port, link->pin, options);
  if (!transport) return badInput(transport.error());
  DocumentVisit visit(**transport,
                      sync::Hello{sync::kProtocolVersion, false, link->token, arguments.name, {}});
  const auto failed = [&](const Status& status) {
    return badInput(Error{link->host + ":" + std::to_string(link->port) + ": " + status.error().message});
  };
  ProgressLine line;
  const auto there = [&] { return visit.stage() == DocumentVisit::Stage::there; };
  if (Status fetched = stepUntil(**transport, visit, line, "fetching the document", there); !fetched)
    return failed(fetched);
  int exitCode = kExitDone;
  if (!imports) {
    exitCode = exportTo(arguments.file, visit);
  } else if (file.scene != assets::toHex(visit.welcome().sceneHash)) {
    exitCode = badInput(Error{arguments.file + ": is the document of another scene"});
  } else {
    visit.bringIn(std::move(file.entries));
    const auto done = [&] { return visit.bringing()->done(); };
    const Status brought = stepUntil(**transport, visit, line, "bringing entries in", done);
    exitCode = report(*visit.bringing());
    if (!brought) {
      failed(brought);
      exitCode = kExitFailed;
    }
  }
  visit.leave();
  return exitCode;
}

}  // namespace

void addDocument(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<DocumentArguments>();
  assets::CommandLine command =
      program.command("document", "Export what a session has agreed on to a file, or import it");
  command.option("link", arguments->link, "Join link, as tandem-server prints it (tandem://...)").required();
  command.option("action", arguments->action, "export or import").required();
  command.option("file", arguments->file, "JSON file to write or to read").required();
  command.option("--name", arguments->name, "Your name, as the others see it").showDefault();
  command.footer(
      "The document holds notes, views, measures, verdicts on clashes, saved states, groups and names.\n"
      "An import adds the entries that the session has not, as yours; it may be repeated. The file belongs\n"
      "to one scene. Example: tandem document 'tandem://HOST:7480/observer?...' export review.json");
  command.onRun([arguments, &exitCode] { exitCode = run(*arguments); });
}

}  // namespace tandem::client
