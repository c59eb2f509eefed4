#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>

#include <glm/geometric.hpp>
#include "assets/base/assert.h"
#include "assets/base/json.h"
#include "client/base/readable.h"
#include "client/commands/command.h"
#include "client/join/scene_store.h"
#include "client/viewer/viewer.h"
#include "sync/replica/lease_rules.h"
#include "sync/replica/ownership_view.h"
#include "sync/wire/control_message.h"
#include "sync/wire/recording.h"
#include "sync/wire/site_colours.h"
#include "sync/wire/state_message.h"
#include "sync/wire/time.h"

namespace tandem::client {

namespace {

struct ReplayArguments {
  std::string recording, scenePath, units = "m", screenshot, json, forces, cache;
  std::vector<std::string> movable;
  bool headless = false;
  double at = -1.0;
};

/// A recording in memory, with times from its beginning.
struct Recording {
  sync::RecordingHeader header;
  std::vector<sync::RecordingEntry> entries;
  std::string damaged;
  sync::Micros start = 0;
  double duration = 0.0;  // s
};

Result<Recording> readRecording(const std::string& path) {
  Result<sync::RecordingReader> reader = sync::RecordingReader::open(path);
  if (!reader) return reader.error();
  Recording recording;
  recording.header = reader->header();
  while (std::optional<sync::RecordingEntry> entry = reader->next()) {
    if (entry->time <= 0) entry->time = recording.entries.empty() ? 0 : recording.entries.back().time;
    if (recording.start == 0) recording.start = entry->time;
    recording.entries.push_back(std::move(*entry));
  }
  recording.damaged = reader->damaged();
  for (const sync::RecordingEntry& entry : recording.entries)
    recording.duration = std::max(recording.duration, sync::toSeconds(entry.time - recording.start));
  return recording;
}

/// The session at one instant of a recording. Seeking backwards replays from the beginning.
class Playback {
 public:
  Playback(const Recording& recording, const assets::Scene& scene) : recording_(recording), scene_(scene) {
    model_.scene = &scene;
    model_.replay = true;
    model_.duration = recording.duration;
    rewind();
  }

  void seek(double time) {
    ASSERT(std::isfinite(time));
    if (time < model_.time) rewind();
    model_.time = std::min(std::max(time, 0.0), model_.duration);
    while (next_ < recording_.entries.size() &&
           sync::toSeconds(recording_.entries[next_].time - recording_.start) <= model_.time)
      apply(recording_.entries[next_++]);
    ASSERT(next_ <= recording_.entries.size() && model_.time <= model_.duration);
  }

  ViewModel& model() { return model_; }

 private:
  void rewind() {
    next_ = 0;
    ownership_.emplace(scene_.parts.size(), sync::LeaseRules{});
    model_.time = 0.0;
    model_.worldFromPart.clear();
    for (const assets::Part& part : scene_.parts) model_.worldFromPart.push_back(part.worldFromPart);
    model_.owner.assign(scene_.parts.size(), kNoSite);
    model_.coHolders.assign(scene_.parts.size(), {});
    model_.sites.clear();
  }

  void apply(const sync::RecordingEntry& entry) {
    if (const auto* control = std::get_if<sync::ControlMessage>(&entry.message)) {
      if (const auto* changed = std::get_if<sync::OwnershipChanged>(control)) applyRecord(changed->part);
      if (const auto* reply = std::get_if<sync::GrabReply>(control)) applyRecord(reply->part);
      if (const auto* changed = std::get_if<sync::MembersChanged>(control))
        applyCoHolders(changed->coHolders);
      if (const auto* site = std::get_if<sync::SiteChanged>(control))
        siteOf(site->site.site).info = site->site;
      return;
    }
    const auto* update = std::get_if<sync::StateUpdate>(&std::get<sync::StateMessage>(entry.message));
    if (!update) return;
    SiteView& site = siteOf(update->site != kNoSite ? update->site : update->presence.site);
    site.presence = update->presence;
    site.seen = true;
    for (const sync::PartState& state : update->parts)
      if (state.part < scene_.parts.size()) model_.worldFromPart[state.part] = state.worldFromPart;
  }

  void applyRecord(const sync::PartRecord& record) {
    if (record.part >= scene_.parts.size() || !ownership_->apply(record)) return;
    model_.owner[record.part] = record.owner;
    model_.worldFromPart[record.part] = record.worldFromPart;
  }

  void applyCoHolders(const sync::CoHolderRecord& record) {
    if (record.part < scene_.parts.size() && ownership_->apply(record))
      model_.coHolders[record.part] = record.sites;
  }

  SiteView& siteOf(SiteId id) {
    for (SiteView& site : model_.sites)
      if (site.info.site == id) return site;
    SiteView site;
    site.info.site = id;
    site.info.name = "site " + std::to_string(id);
    site.info.colour = sync::siteColour(id - std::size_t{1});
    model_.sites.push_back(site);
    return model_.sites.back();
  }

  const Recording& recording_;
  const assets::Scene& scene_;
  std::optional<sync::OwnershipView> ownership_;
  ViewModel model_;
  std::size_t next_ = 0;
};

/// The sums of one site over a recording.
struct SiteSum {
  std::string name;
  std::uint64_t updates = 0;
  double largestForce = 0.0;  // N
  int grants = 0;
};

/// The sums of a recording, for the summary and --json.
struct Summary {
  std::map<SiteId, SiteSum> sites;
  int grants = 0, denials = 0;
  Json ownership = Json::array();
  Json shared = Json::array();  // the co-holders of a part, at each change
};

/// The co-holders of a part if the message carries them: a reply to the site that asked, a message to the
/// others.
const sync::CoHolderRecord* coHoldersIn(const sync::ControlMessage& message) {
  if (const auto* changed = std::get_if<sync::MembersChanged>(&message)) return &changed->coHolders;
  if (const auto* reply = std::get_if<sync::EngageReply>(&message)) return &reply->coHolders;
  return nullptr;
}

/// Recognises grants: records with a newer epoch and an owner. Records at the beginning are of grants before
/// it.
class GrantCount {
 public:
  bool isGrant(const sync::PartRecord& record, double time) {
    std::uint32_t& last = epochs_[record.part];
    const bool newer = record.epoch > last;
    last = std::max(last, record.epoch);
    return newer && record.owner != kNoSite && time > 0.0;
  }

 private:
  std::map<PartId, std::uint32_t> epochs_;
};

Summary summarise(const Recording& recording, const assets::Scene& scene) {
  Summary summary;
  GrantCount count;
  for (const sync::RecordingEntry& entry : recording.entries) {
    const double time = sync::toSeconds(entry.time - recording.start);
    if (const auto* control = std::get_if<sync::ControlMessage>(&entry.message)) {
      if (const auto* site = std::get_if<sync::SiteChanged>(control))
        summary.sites[site->site.site].name = site->site.name;
      const auto* reply = std::get_if<sync::GrabReply>(control);
      if (reply && reply->denial != sync::Denial::none) ++summary.denials;
      const sync::CoHolderRecord* coHolders = coHoldersIn(*control);
      if (coHolders && coHolders->part < scene.parts.size())
        summary.shared.push(
            {{"t", time}, {"part", scene.parts[coHolders->part].name}, {"sites", coHolders->sites}});
      const auto* changed = std::get_if<sync::OwnershipChanged>(control);
      if (!changed || changed->part.part >= scene.parts.size()) continue;
      if (count.isGrant(changed->part, time)) {
        ++summary.grants;
        ++summary.sites[changed->part.owner].grants;
      }
      summary.ownership.push({{"t", time},
                              {"part", scene.parts[changed->part.part].name},
                              {"owner", changed->part.owner},
                              {"epoch", changed->part.epoch}});
      continue;
    }
    if (const auto* update = std::get_if<sync::StateUpdate>(&std::get<sync::StateMessage>(entry.message))) {
      SiteSum& site = summary.sites[update->site != kNoSite ? update->site : update->presence.site];
      ++site.updates;
      site.largestForce = std::max(site.largestForce, glm::length(update->presence.force));
    }
  }
  return summary;
}

Json recordingJson(const Recording& recording, const Summary& summary) {
  Json json;
  json["duration_s"] = recording.duration;
  json["entries"] = recording.entries.size();
  json["damaged"] = recording.damaged;
  json["sites"] = Json::array();
  for (const auto& [id, site] : summary.sites)
    json["sites"].push({{"site", id},
                        {"name", site.name},
                        {"updates", site.updates},
                        {"grants", site.grants},
                        {"largest_force_n", site.largestForce}});
  json["grants"] = summary.grants;
  json["denials"] = summary.denials;
  json["ownership"] = summary.ownership;
  json["shared"] = summary.shared;
  return json.rounded();
}

/// The force on each hand in N, world axes, a row for each update of its site.
std::string forcesCsv(const Recording& recording) {
  std::string csv = "t,site,x,y,z\n";
  for (const sync::RecordingEntry& entry : recording.entries) {
    const auto* state = std::get_if<sync::StateMessage>(&entry.message);
    const auto* update = state ? std::get_if<sync::StateUpdate>(state) : nullptr;
    if (!update) continue;
    const SiteId site = update->site != kNoSite ? update->site : update->presence.site;
    const glm::dvec3& force = update->presence.force;
    char line[128];
    std::snprintf(line, sizeof line, "%.6f,%u,%.4f,%.4f,%.4f\n",
                  sync::toSeconds(entry.time - recording.start), static_cast<unsigned>(site), force.x,
                  force.y, force.z);
    csv += line;
  }
  return csv;
}

void printRecording(const Recording& recording, const Summary& summary) {
  std::printf("%.1f s, %zu people, %d grants, %d denials sent to whoever recorded\n", recording.duration,
              summary.sites.size(), summary.grants, summary.denials);
  for (const auto& [id, site] : summary.sites)
    std::printf("  %-16s %d grant%s, largest force %s N\n",
                site.name.empty() ? ("site " + std::to_string(id)).c_str() : site.name.c_str(), site.grants,
                site.grants == 1 ? "" : "s", threeDigits(site.largestForce).c_str());
}

Result<assets::Scene> sceneOf(const ReplayArguments& arguments, const Recording& recording) {
  if (!arguments.scenePath.empty()) {
    SceneArguments scene;
    scene.path = arguments.scenePath;
    scene.units = arguments.units;
    scene.movable = arguments.movable;
    return loadScene(scene);
  }
  const SceneStore store(arguments.cache.empty() ? assets::defaultCacheDirectory() : arguments.cache);
  const std::vector<std::byte> package = store.find(recording.header.sceneHash);
  if (package.empty())
    return Error{arguments.recording +
                 ": its scene is not in the cache of this user; give it with --scene FILE"};
  return assets::unpackScene(package);
}

int playInWindow(Playback& playback) {
  Result<std::unique_ptr<Viewer>> viewer =
      Viewer::open(*playback.model().scene, {"Tandem - replay", 1440, 900, true, false});
  if (!viewer) return badInput(viewer.error());
  auto last = std::chrono::steady_clock::now();
  playback.model().playing = true;
  for (;;) {
    const auto now = std::chrono::steady_clock::now();
    const double elapsed = std::chrono::duration<double>(now - last).count();
    last = now;
    if (playback.model().playing) playback.seek(playback.model().time + elapsed * playback.model().speed);
    const ViewActions actions = (*viewer)->frame(playback.model());
    if (actions.seek) playback.seek(actions.seekTo);
    if (actions.setSpeed > 0.0) playback.model().speed = actions.setSpeed;
    if (actions.togglePlay) playback.model().playing = !playback.model().playing;
    if (actions.quit) return kExitDone;
  }
}

int runReplay(const ReplayArguments& arguments) {
  for (const std::string& path : {arguments.json, arguments.forces, arguments.screenshot})
    if (Status free = writable(path); !free) return badInput(free.error());
  Result<Recording> recording = readRecording(arguments.recording);
  if (!recording) return badInput(recording.error());
  if (arguments.at > recording->duration) {
    char text[64];
    std::snprintf(text, sizeof text, "--at %g: the recording ends at %.3f s", arguments.at,
                  recording->duration);
    return badInput(Error{text});
  }
  Result<assets::Scene> scene = sceneOf(arguments, *recording);
  if (!scene) return badInput(scene.error());
  const Summary summary = summarise(*recording, *scene);
  if (!arguments.json.empty())
    if (Status written = writeFile(arguments.json, recordingJson(*recording, summary).dump(2) + "\n");
        !written)
      return badInput(written.error());
  if (!arguments.forces.empty())
    if (Status written = writeFile(arguments.forces, forcesCsv(*recording)); !written)
      return badInput(written.error());
  if (!recording->damaged.empty())
    std::fprintf(stderr, "tandem: %s: %s; the rest is shown\n", arguments.recording.c_str(),
                 recording->damaged.c_str());
  Playback playback(*recording, *scene);
  if (!arguments.screenshot.empty()) {
    playback.seek(arguments.at >= 0.0 ? arguments.at : recording->duration);
    ViewerOptions options;
    options.levels = false;  // for one picture they are not worth their making
    Result<std::unique_ptr<Viewer>> viewer = Viewer::openOffscreen(*scene, options);
    if (!viewer) return badInput(viewer.error());
    for (int i = 0; i < 3; ++i) static_cast<void>((*viewer)->frame(playback.model()));
    (*viewer)->fitAll();
    static_cast<void>((*viewer)->frame(playback.model()));
    if (Status saved = (*viewer)->screenshot(arguments.screenshot); !saved) return badInput(saved.error());
    std::printf("picture of %.1f s: %s\n", playback.model().time, arguments.screenshot.c_str());
  }
  if (arguments.headless || !displayPresent()) {
    printRecording(*recording, summary);
    return kExitDone;
  }
  return playInWindow(playback);
}

}  // namespace

void addReplay(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<ReplayArguments>();
  assets::CommandLine command = program.command("replay", "Show a recorded session again, with its forces");
  command
      .option("recording", arguments->recording, "File of 'tandem join --record' or 'tandem-server --record'")
      .required();
  command.option("--scene", arguments->scenePath,
                 "Scene file, if this user never joined that session [from --cache]");
  command.option("--units", arguments->units, "Unit of the scene file").showDefault();
  command.option("--movable", arguments->movable, "As given to the server, with --scene [none]");
  command.flag("--headless", arguments->headless, "No window: print a summary");
  command.option("--screenshot", arguments->screenshot, "Write a picture (PNG) of the instant --at");
  command.option("--at", arguments->at, "Seconds from the beginning [the end]").numberFrom(0.0, 1e9);
  command.option("--json", arguments->json, "Write a summary to this file");
  command.option("--forces", arguments->forces,
                 "Write the force on every hand in N, world axes, to this CSV file");
  command.option("--cache", arguments->cache,
                 "Folder of fetched scenes [" + assets::defaultCacheDirectory() + "]");
  command.footer(
      "With a window P plays and pauses; Follow beside a name shows what that person saw.\n"
      "Example: tandem replay review.rec --at 12.5 --screenshot review.png --headless");
  command.onRun([arguments, &exitCode] { exitCode = runReplay(*arguments); });
}

}  // namespace tandem::client
