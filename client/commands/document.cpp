#include <cstdio>
#include <memory>

#include "assets/document/document_json.h"
#include "assets/document/entry_check.h"
#include "assets/scene/scene_package.h"
#include "client/base/json_input.h"
#include "client/commands/command.h"
#include "client/commands/document_file.h"
#include "client/exchange/bcf_file.h"
#include "client/exchange/topic_changes.h"
#include "client/findings/verdicts.h"
#include "client/join/local_time.h"
#include "client/join/scene_store.h"
#include "client/review/clash_check.h"
#include "client/session/document_visit.h"
#include "haptics/scene/contact_scene.h"
#include "sync/transport/join_link.h"
#include "sync/transport/socket_transport.h"

namespace tandem::client {
namespace {

constexpr sync::Micros kPatience = 20 * sync::kSecond;  // without any progress

struct DocumentArguments {
  std::string link, action, file, name = "document", cache, bcf = "3.0";
  int maxScene = 2048;  // MiB
  bool noPictures = false;
};

/// The session's scene with its parts where they are.
struct VisitedScene {
  assets::Scene scene;
  std::vector<Pose> worldFromPart;
};

class DocumentRun {
 public:
  DocumentRun(const DocumentArguments& arguments, const sync::JoinLink& link, DocumentFormat format,
              BcfVersion version)
      : arguments_(arguments), link_(link), format_(format), version_(version) {}

  /// What can be told before the link, which works once, is used.
  Status readFile();
  int run();

 private:
  template <typename Done>
  Status stepUntil(const char* what, const Done& done);
  double progress() const;
  int failed(const Status& status) const;
  std::string sceneHash() const { return assets::toHex(visit_->welcome().sceneHash); }

  Result<VisitedScene> fetchScene();
  int exportDocument();
  int exportTopics();
  Status takeTopics();
  int importEntries();
  int findClashes();
  int bring(std::vector<document::Entry> entries);
  int report() const;

  const DocumentArguments& arguments_;
  const sync::JoinLink& link_;
  DocumentFormat format_;
  BcfVersion version_;
  document::DocumentFile file_;  // what is brought in, of either kind
  std::vector<Topic> topics_;
  std::size_t kept_ = 0;  // of them, as the session has them
  std::unique_ptr<sync::SocketTransport> transport_;
  std::unique_ptr<DocumentVisit> visit_;
  bool fetchesScene_ = false;
};

Status DocumentRun::readFile() {
  if (format_ == DocumentFormat::bcf) {
    Result<std::vector<Topic>> topics = readBcf(arguments_.file);
    if (!topics) return topics.error();
    topics_ = std::move(*topics);
    return {};
  }
  const Result<std::string> text = readTextFile(arguments_.file);
  if (!text) return text.error();
  Result<document::DocumentFile> read = document::fromJson(*text, arguments_.file);
  if (!read) return read.error();
  file_ = std::move(*read);
  return {};
}

double DocumentRun::progress() const {
  if (visit_->bringing() != nullptr) return visit_->bringing()->progress();
  return fetchesScene_ ? visit_->scene().progress() : static_cast<double>(visit_->content().entries().size());
}

/// Steps the visit until `done()` holds; an error if it ends before, or nothing goes on.
template <typename Done>
Status DocumentRun::stepUntil(const char* what, const Done& done) {
  ProgressLine line;
  double shown = -1.0;
  sync::Micros moved = localTime();
  while (!done()) {
    if (visit_->stage() == DocumentVisit::Stage::ended) return Error{visit_->reason()};
    transport_->wait(20 * sync::kMillisecond);
    visit_->step(localTime());
    const double now = progress();
    if (now != shown) moved = localTime();
    shown = now;
    if (localTime() - moved > kPatience) return Error{"no answer"};
    line.show(visit_->bringing() != nullptr || fetchesScene_ ? shown : 0.0, what);
  }
  return {};
}

int DocumentRun::failed(const Status& status) const {
  return badInput(Error{link_.host + ":" + std::to_string(link_.port) + ": " + status.error().message});
}

Result<VisitedScene> DocumentRun::fetchScene() {
  const sync::Welcome& welcome = visit_->welcome();
  if (welcome.sceneBytes > static_cast<std::uint64_t>(arguments_.maxScene) << 20)
    return Error{"the server's scene is larger than --max-scene"};
  const SceneStore store(arguments_.cache.empty() ? assets::defaultCacheDirectory() : arguments_.cache);
  std::vector<std::byte> package = store.find(welcome.sceneHash);
  if (package.empty()) {
    visit_->fetchScene(store.beginning(welcome.sceneHash));
    fetchesScene_ = true;
    const Status fetched = stepUntil("fetching the scene", [&] { return visit_->scene().complete(); });
    fetchesScene_ = false;
    package = visit_->scene().package();
    if (!fetched) {
      store.keepBeginning(welcome.sceneHash, package);
      return fetched.error();
    }
    if (assets::contentHash(package) != welcome.sceneHash) {
      store.forgetBeginning(welcome.sceneHash);
      return Error{"the scene arrived damaged (its hash is not the announced one)"};
    }
    store.keep(welcome.sceneHash, package);
  }
  Result<assets::Scene> scene = assets::unpackScene(package);
  if (!scene) return Error{"the server's scene cannot be used: " + scene.error().message};
  VisitedScene visited{std::move(*scene), {}};
  for (const assets::Part& part : visited.scene.parts) visited.worldFromPart.push_back(part.worldFromPart);
  for (const sync::PartRecord& record : welcome.parts)
    if (record.part < visited.worldFromPart.size()) visited.worldFromPart[record.part] = record.worldFromPart;
  return visited;
}

int DocumentRun::exportDocument() {
  const std::string text = toJson(visit_->content(), sceneHash());
  if (Status written = writeFile(arguments_.file, text); !written) return badInput(written.error());
  std::printf("%zu entries written to %s\n", visit_->content().size(), arguments_.file.c_str());
  return kExitDone;
}

int DocumentRun::exportTopics() {
  const Result<VisitedScene> visited = fetchScene();
  if (!visited) return failed(visited.error());
  visit_->leave();
  const PartGuids guids(visited->scene);
  const TopicSource source{visit_->content(), visited->scene, guids, visited->worldFromPart, sceneHash()};
  std::vector<Topic> topics = topicsOf(source);
  if (!arguments_.noPictures && format_ != DocumentFormat::csv) {
    ProgressLine line;
    const Status drawn =
        drawTopics(topics, source, [&](double done) { line.show(done, "drawing pictures"); });
    if (!drawn) return badInput(drawn.error());
  }
  const TopicFile file{arguments_.file, format_, version_, visited->scene.name, sceneHash()};
  if (Status written = writeTopics(file, topics); !written) return badInput(written.error());
  std::printf("%zu topics written to %s\n", topics.size(), arguments_.file.c_str());
  return kExitDone;
}

int DocumentRun::report() const {
  const DocumentImport& import = *visit_->bringing();
  std::printf("%zu entries made, %zu changed, %zu there already, %zu refused\n", import.made(),
              import.changed(), import.known(), import.refused());
  if (kept_ > 0) std::printf("%zu are newer in the session and stay as they are\n", kept_);
  if (import.refused() == 0) return kExitDone;
  std::fprintf(stderr, "tandem: entries were refused: %s\n", import.reason().c_str());
  return kExitFailed;
}

/// Makes entries of the topics that were read. Nothing is sent unless all of them are sound.
Status DocumentRun::takeTopics() {
  const Result<VisitedScene> visited = fetchScene();
  if (!visited) return visited.error();
  const PartGuids guids(visited->scene);
  TopicChanges changes =
      changesOf(topics_, {visit_->content(), visited->scene, guids, visited->worldFromPart, sceneHash()},
                arguments_.name);
  std::size_t size = visit_->content().size();
  for (const document::Entry& entry : changes.entries) {
    if (Status sound = document::check(entry.body); !sound) return sound;
    size += entry.revision == 0 ? 1 : 0;
  }
  if (size > document::kMaxEntries) return Error{"the document has no room for all of its topics"};
  kept_ = changes.kept;
  file_ = {sceneHash(), std::move(changes.entries)};
  return {};
}

int DocumentRun::importEntries() {
  if (format_ == DocumentFormat::bcf)
    if (Status taken = takeTopics(); !taken)
      return badInput(Error{arguments_.file + ": " + taken.error().message});
  if (file_.scene != sceneHash())
    return badInput(Error{arguments_.file + ": is the document of another scene"});
  return bring(std::move(file_.entries));
}

/// Searches for clashes of the parts as they stand, and brings the verdicts up to what was found.
int DocumentRun::findClashes() {
  const Result<VisitedScene> visited = fetchScene();
  if (!visited) return failed(visited.error());
  const haptics::ContactScene contact(visited->scene);
  ClashOptions options;
  options.worldFromPart = visited->worldFromPart;
  ProgressLine line;
  options.progress = [&](std::size_t done, std::size_t pairs) {
    line.show(static_cast<double>(done) / static_cast<double>(pairs), "searching for clashes");
  };
  const ClashReport found = client::findClashes(contact, options);
  const std::vector<document::Change> changes =
      mergeClashes(visit_->content(), found.clashes, found.complete, arguments_.name);
  const MergeCounts counts = countChanges(visit_->content(), changes);
  std::printf("%zu clashes are new, %zu are gone, %zu are back, %zu are of another depth\n", counts.added,
              counts.resolved, counts.reopened, counts.deeper);
  std::vector<document::Entry> entries;
  for (const document::Change& change : changes) {
    document::Entry& entry = entries.emplace_back();
    entry.id = change.id != 0 ? change.id : visit_->content().lastId() + entries.size();
    entry.revision = change.base;
    entry.body = change.body;
  }
  return bring(std::move(entries));
}

int DocumentRun::bring(std::vector<document::Entry> entries) {
  visit_->bringIn(std::move(entries));
  const Status brought = stepUntil("bringing entries in", [&] { return visit_->bringing()->done(); });
  const int exitCode = report();
  if (brought) return exitCode;
  failed(brought);
  return kExitFailed;
}

int DocumentRun::run() {
  sync::ConnectOptions options;
  options.udp = false;  // it sends and needs no state
  options.credential = link_.token;
  Result<std::unique_ptr<sync::SocketTransport>> transport =
      sync::connectTo(link_.host, link_.port, link_.pin, options);
  if (!transport) return badInput(transport.error());
  transport_ = std::move(*transport);
  visit_ = std::make_unique<DocumentVisit>(
      *transport_, sync::Hello{sync::kProtocolVersion, false, link_.token, arguments_.name, {}});
  const auto there = [&] { return visit_->stage() == DocumentVisit::Stage::there; };
  if (Status fetched = stepUntil("fetching the document", there); !fetched) return failed(fetched);
  const int exitCode = arguments_.action == "import"     ? importEntries()
                       : arguments_.action == "clashes"  ? findClashes()
                       : format_ == DocumentFormat::json ? exportDocument()
                                                         : exportTopics();
  visit_->leave();
  return exitCode;
}

int runDocument(const DocumentArguments& arguments) {
  const bool imports = arguments.action == "import", finds = arguments.action == "clashes";
  if (!imports && !finds && arguments.action != "export")
    return badInput(Error{"document: " + arguments.action + " is neither export, import nor clashes"});
  if (finds != arguments.file.empty())
    return badInput(Error{finds ? "document clashes: takes no file" : "document: name a file"});
  const Result<sync::JoinLink> link = sync::parseJoinLink(arguments.link);
  if (!link) return badInput(Error{link.error().message + " (quote the link: it holds a & sign)"});
  // A link works once, so everything on this side is checked before it is used.
  if (arguments.name.empty() || arguments.name.size() > sync::kMaxNameLength)
    return badInput(Error{"--name: 1 to " + std::to_string(sync::kMaxNameLength) + " bytes"});
  const Result<DocumentFormat> format =
      finds ? DocumentFormat::json : documentFormat(arguments.file, imports);
  if (!format) return badInput(format.error());
  const Result<BcfVersion> version = parseBcfVersion(arguments.bcf);
  if (!version) return badInput(version.error());
  DocumentRun visit(arguments, *link, *format, *version);
  if ((imports || finds) && link->role == sync::Role::observer)
    return badInput(
        Error{"document " + arguments.action + ": an observer's link changes nothing; take another"});
  if (Status ready = imports ? visit.readFile() : finds ? Status{} : writable(arguments.file); !ready)
    return badInput(ready.error());
  return visit.run();
}

}  // namespace

void addDocument(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<DocumentArguments>();
  assets::CommandLine command =
      program.command("document", "Export what a session has agreed on to a file, or import it");
  command.option("link", arguments->link, "Join link, as tandem-server prints it (tandem://...)").required();
  command.option("action", arguments->action, "export, import or clashes: find them and keep their status")
      .required();
  command.option("file", arguments->file,
                 "File to write (.json, .bcf, .bcfzip, .csv, .html) or to read (.json, .bcf, .bcfzip)");
  command.option("--name", arguments->name, "Your name, as the others see it").showDefault();
  command.option("--bcf", arguments->bcf, "Version of BCF to write: 2.1 or 3.0").showDefault();
  command.flag("--no-pictures", arguments->noPictures, "Leave the pictures of topics out");
  command.option("--cache", arguments->cache, "Folder for scenes [" + assets::defaultCacheDirectory() + "]");
  command.option("--max-scene", arguments->maxScene, "Largest scene to fetch, MiB")
      .integerFrom(1, 1 << 20)
      .showDefault();
  command.footer(
      "The document holds notes, views, measures, verdicts on clashes, saved states, groups and names, and "
      "its\n"
      "JSON file all of them. Its topics (notes, clashes, views, measures) go to review tools (BCF), tables, "
      "pages.\n"
      "'clashes' searches the parts as they stand: what is new is added, what is gone resolved, what is back "
      "active;\n"
      "what is approved stays. Only true clashes are kept, not those that facets explain.\n"
      "An import adds the entries that the session has not, as yours; it may be repeated. A JSON file "
      "belongs\n"
      "to one scene. Example: tandem document 'tandem://HOST:7480/observer?...' export review.html");
  command.onRun([arguments, &exitCode] { exitCode = runDocument(*arguments); });
}

}  // namespace tandem::client
