#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include <glm/geometric.hpp>
#include "assets/base/assert.h"
#include "assets/base/process_memory.h"
#include "client/commands/colour_option.h"
#include "client/commands/command.h"
#include "client/commands/join_arguments.h"
#include "client/commands/join_report.h"
#include "client/commands/script_in_window.h"
#include "client/commands/tool_option.h"
#include "client/commands/way_out.h"
#include "client/hand/script_writer.h"
#include "client/join/headless_view.h"
#include "client/join/joined_site.h"
#include "client/join/live_table.h"
#include "client/picture/camera.h"
#include "client/picture/level_choice.h"
#include "client/review/clash_search.h"
#include "client/review/clearance_watch.h"
#include "client/viewer/ui_state.h"
#include "client/viewer/viewer.h"
#include "haptics/devices/device_list.h"
#include "haptics/operator/steered_hand.h"
#include "haptics/operator/virtual_stylus.h"

namespace tandem::client {

namespace {

volatile std::sig_atomic_t interrupted = 0, faultClears = 0;

std::string defaultName(const sync::JoinLink& link) {
  const char* user = std::getenv("USER");
  return user && *user ? user : sync::toString(link.role);
}

std::string cacheOf(const JoinArguments& arguments) {
  return arguments.cache.empty() ? assets::defaultCacheDirectory() : arguments.cache;
}

/// The device in a hand, and the view of it through which the window or a script steers it.
struct Hand {
  std::unique_ptr<haptics::Device> device;
  haptics::VirtualStylus* stylus = nullptr;
  haptics::SteeredHand* steered = nullptr;
  ScriptedDevice* scripted = nullptr;
  std::optional<ScriptWriter> writer;  // beside `scripted`
};

/// Opens the device `name`, placed by its calibration. `option` names the option in errors.
Result<std::unique_ptr<haptics::Device>> openNamed(const std::string& name, const std::string& calibration,
                                                   const std::optional<Pose>& start,
                                                   const char* option = "--device") {
  std::optional<haptics::Colocation> placed;
  if (!calibration.empty()) {
    Result<haptics::Colocation> loaded = haptics::loadColocation(calibration);
    if (!loaded) return loaded.error();
    placed = *loaded;
  }
  Result<std::unique_ptr<haptics::Device>> device =
      haptics::openDevice(name, start, placed ? &*placed : nullptr);
  if (!device) return Error{std::string(option) + ' ' + name + ": " + device.error().message};
  return device;
}

Result<Hand> scriptedHand(const std::string& path, JoinedSite& site, const Pose& start) {
  Result<HandScript> script = loadHandScript(path, site.scene());
  if (!script) return script.error();
  script->toolRadius = site.toolRadius();
  Hand hand;
  hand.writer.emplace(*script, site.contact());
  auto device = std::make_unique<ScriptedDevice>(site.scene(), std::move(*script), haptics::ArmParameters{},
                                                 haptics::SimulatedDeviceParameters{}, start,
                                                 [&site](PartId part) { return site.worldFromPart(part); });
  hand.scripted = device.get();
  hand.device = std::move(device);
  return hand;
}

bool hasSecondHand(const JoinArguments& arguments) {
  return (!arguments.secondDevice.empty() && arguments.secondDevice != "none") ||
         !arguments.secondHand.empty();
}

/// Makes the second hand of the same person; without a device if there is none.
Result<Hand> makeSecondHand(const JoinArguments& arguments, JoinedSite& site) {
  if (!hasSecondHand(arguments)) return Hand{};
  // The hand begins on the other side of the scene, where no other site's hand begins.
  Pose start = defaultHandStart(site.scene(), site.id() + 1u);
  start.position.y += 0.1 * glm::length(site.scene().bounds.max - site.scene().bounds.min);
  if (!arguments.secondHand.empty()) return scriptedHand(arguments.secondHand, site, start);
  Result<std::unique_ptr<haptics::Device>> device =
      openNamed(arguments.secondDevice, arguments.secondCalibration, start, "--second-device");
  if (!device) return device.error();
  Hand hand;
  hand.device = std::move(*device);
  return hand;
}

/// Checks the second hand's options as far as that is possible before there is a session.
Status checkSecondHand(const JoinArguments& arguments) {
  if (!arguments.secondHand.empty()) return checkHandScript(arguments.secondHand);
  const std::string& name = arguments.secondDevice;
  if (name.empty()) return {};
  const Error refused{"--second-device " + name + ": "};
  if (name == "stylus") return Error{refused.message + "the mouse is for the first hand"};
  if (name == arguments.device && name != "none")
    return Error{refused.message + "the first hand has it; two of one kind are not told apart"};
  auto device = openNamed(name, arguments.secondCalibration, std::nullopt, "--second-device");
  if (!device) return device.error();
  (*device)->close();
  return {};
}

Result<Hand> makeHand(const JoinArguments& arguments, JoinedSite& site, bool window) {
  Hand hand;
  const Pose start = defaultHandStart(site.scene(), site.id());
  if (!arguments.hand.empty()) return scriptedHand(arguments.hand, site, start);
  const std::string name = !arguments.device.empty() ? arguments.device : window ? "stylus" : "none";
  if (name == "stylus") {
    auto device = std::make_unique<haptics::VirtualStylus>(start);
    hand.stylus = device.get();
    hand.device = std::move(device);
  } else {
    Result<std::unique_ptr<haptics::Device>> device = openNamed(name, arguments.calibration, start);
    if (!device) return device.error();
    hand.device = std::move(*device);
    hand.steered = dynamic_cast<haptics::SteeredHand*>(hand.device.get());
  }
  return hand;
}

class JoinRun {
 public:
  JoinRun(const JoinArguments& arguments, JoinedSite& site) : arguments_(arguments), site_(site) {}

  int run() {
    const bool window = !arguments_.headless && displayPresent();
    if (!arguments_.headless && !window && !arguments_.quiet) noteHeadless();
    if (window) {
      Result<std::unique_ptr<Viewer>> viewer = Viewer::open(site_.scene(), windowOptions());
      if (!viewer) return badInput(viewer.error());
      viewer_ = std::move(*viewer);
    }
    if (Status ready = modelParts(); !ready) return badInput(ready.error());
    if (window || !arguments_.screenshot.empty())
      clearance_ = std::make_unique<ClearanceWatch>(site_.contact());
    Result<Hand> hand = makeHand(arguments_, site_, window);
    if (!hand) return badInput(hand.error());
    Result<Hand> second = makeSecondHand(arguments_, site_);
    if (!second) return badInput(second.error());
    if (!arguments_.trace.empty()) {
      trace_ = std::make_unique<PoseTrace>(arguments_.trace);
      if (!trace_->good()) return badInput(Error{arguments_.trace + ": cannot be written"});
      site_.onShown = [this](const ShownPose& shown) { trace_->add(shown, site_.scene()); };
    }
    haptics::VirtualStylus* stylus = hand->stylus;
    haptics::SteeredHand* steered = hand->steered;
    const auto prepare = [first = hand->scripted, other = second->scripted](HandLoop& loop) {
      if (first) {
        loop.setWish(first->wish());
        loop.setControl(first->control());
      }
      if (other) {
        loop.setWish(other->wish(), 1);
        loop.setControl(other->control(), 1);
      }
    };
    scripts_ = {&*hand, &*second};
    site_.start(std::move(hand->device), prepare, std::move(second->device));
    loop(stylus, steered);
    return finish();
  }

 private:
  using Clock = std::chrono::steady_clock;

  ViewerOptions windowOptions() const {
    ViewerOptions options;
    options.title = "Tandem - " + arguments_.name;
    options.width = arguments_.width;
    options.height = arguments_.height;
    options.stylusFromMouse = arguments_.device.empty() || arguments_.device == "stylus";
    options.sections = arguments_.cut;
    options.style = arguments_.style;
    options.follows = !arguments_.alone;
    options.cacheDirectory = cacheOf(arguments_);
    return options;
  }

  void noteHeadless() const {
    const bool hand =
        !arguments_.hand.empty() || !arguments_.device.empty() || site_.role() == sync::Role::observer;
    std::fprintf(stderr, "tandem: no display: running headless%s\n",
                 hand ? "" : ", without a hand: --hand FILE scripts one, --device NAME takes a device");
  }

  /// Makes the contact models. No part can be held before they exist; meanwhile the window, or a line of
  /// text, shows the progress.
  Status modelParts() {
    const Clock::time_point start = Clock::now();
    ProgressLine line(!arguments_.quiet);
    Status made = site_.modelParts([&](double done, const char* what) {
      if (viewer_)
        showWaiting(done, what);
      else
        line.show(done, what);
      return interrupted == 0 && !waiting_.quit;
    });
    report_.modelSeconds = std::chrono::duration<double>(Clock::now() - start).count();
    return made;
  }

  void showWaiting(double done, const char* what) {
    site_.update(model_);
    char text[80];
    std::snprintf(text, sizeof text, "%s: %.0f %%", what, 100.0 * done);
    model_.connection.status = text;
    model_.notices = {{Notice::Level::info, 0.0, text}};
    ViewActions actions = viewer_->frame(model_);
    actions.stylusMoved = actions.stylusMoved || waiting_.stylusMoved;
    actions.settingsChanged = actions.settingsChanged || waiting_.settingsChanged;
    model_.settings = actions.settings;
    actions.grasp = false;
    site_.act(actions);
    waiting_ = actions;
  }

  void loop(haptics::VirtualStylus* stylus, haptics::SteeredHand* steered) {
    ASSERT(end_.empty());
    const Clock::time_point start = Clock::now();
    headless_.emplace(fitView(site_.scene().bounds, 1.6), arguments_.cut.planes(), !arguments_.alone,
                      arguments_.style);
    if (!viewer_) site_.act(headless_->act(model_));
    if (viewer_ && stylus) followMouse(*stylus, waiting_, 0.0);
    if (viewer_ && arguments_.notes) viewer_->openNotes();
    if (viewer_ && arguments_.measures) viewer_->openMeasures();
    if (viewer_ && arguments_.clashes >= 0.0) viewer_->openClashes({arguments_.clashes, false});
    if (viewer_ && !arguments_.wayOut.empty()) {
      site_.update(model_);
      wayOut_.act(wayOutOf(), model_.worldFromPart);
    }
    LiveTable table(arguments_.quiet || viewer_ != nullptr);
    while (!interrupted && end_.empty()) {
      site_.update(model_);
      showClearance();
      showClashes();
      model_.wayOut = wayOut_.view();
      report_.collect(site_);
      clearFaults();
      const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
      writeByScript(elapsed);
      if (viewer_) {
        ViewActions actions = viewer_->frame(model_);
        for (sync::Say& said : std::exchange(says_, {})) actions.says.push_back(std::move(said));
        if (stylus) followMouse(*stylus, actions, elapsed);
        // A SpaceMouse or gamepad moves the stylus in screen axes. Full deflection crosses the scene in four
        // seconds.
        if (steered) steered->setView({actions.worldFromCamera.orientation, 0.25 * sceneSize()});
        site_.act(actions);
        model_.measure = measures_.update(actions.marks, model_.worldFromPart);
        searchClashes(actions);
        wayOut_.act(actions, model_.worldFromPart);
        if (actions.quit) end_ = "window closed";
      } else {
        site_.act(headless_->act(model_));
        table.show(model_, elapsed);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
      if (arguments_.duration > 0.0 && elapsed >= arguments_.duration) end_ = "done";
      if (std::string reason; site_.ended(reason)) {
        end_ = reason;
        failed_ = true;
      }
    }
    if (end_.empty()) end_ = "interrupted";
  }

  /// Puts the held part's nearest neighbour into the model of the window and the picture.
  void showClearance() {
    model_.hand.nearest = {};
    if (!clearance_) return;
    const std::optional<Clash> found = clearance_->update(model_.hand.held, model_.worldFromPart);
    if (found) model_.hand.nearest = {found->b, found->distance - found->depth, found->onA, found->onB};
  }

  /// Starts and stops the search of clashes as the list of clashes requests it.
  void searchClashes(const ViewActions& actions) {
    if (actions.findClashes) {
      if (!clashes_) clashes_ = std::make_unique<ClashSearch>(site_.contact());
      clashes_->start(*actions.findClashes, model_.worldFromPart);
    }
    if (actions.stopClashes && clashes_) clashes_->stop();
  }

  void showClashes() {
    if (clashes_) model_.clashes = clashes_->view();
    model_.clashes.possible = true;
  }

  Status offscreenPicture() {
    ViewerOptions options;
    options.width = arguments_.width;
    options.sections = SectionSet(headless_->sections(model_));
    options.style = headless_->style(model_);
    options.hidden = headless_->hidden();
    options.height = arguments_.height;
    options.follows = headless_->following().followsSections();
    options.shares = headless_->shares();
    options.cacheDirectory = cacheOf(arguments_);
    Result<std::unique_ptr<Viewer>> opened = Viewer::openOffscreen(*model_.scene, options);
    if (!opened) return opened.error();
    Viewer& viewer = **opened;
    showClashes();
    for (int i = 0; i < 3; ++i)
      static_cast<void>(viewer.frame(model_));  // panels take their sizes in the first frames
    // Parts and hands may be far from their initial poses.
    if (!headless_->following().followsView()) viewer.fitAll();
    static_cast<void>(viewer.frame(model_));
    if (arguments_.clashes >= 0.0) frameClashes(viewer);
    if (!arguments_.wayOut.empty()) frameWayOut(viewer);
    inspectIn(viewer);
    if (arguments_.measures) viewer.openMeasures();
    if (arguments_.notes) viewer.openNotes();
    if (arguments_.notes || arguments_.measures) {
      for (int i = 0; i < 3; ++i) static_cast<void>(viewer.frame(model_));
    }
    // What stands in for large parts at first is several pixels off.
    for (const Clock::time_point start = Clock::now();
         viewer.pixelsOff() > kMostPixels && !interrupted && Clock::now() - start < kLevelsPatience;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      static_cast<void>(viewer.frame(model_));
    }
    return viewer.screenshot(arguments_.screenshot);
  }

  /// Draws frames until what this person or the one who presents measures has its figures.
  void inspectIn(Viewer& viewer) {
    const sync::Inspection& own = headless_->inspection();
    viewer.ui().shared.lookAtClash(own);
    if (own.measuring) {
      viewer.ui().measures.open = true;
      viewer.ui().measures.marks = own.marks;
    }
    for (int i = 0; i < kFramesOfMeasure && !interrupted; ++i) {
      model_.measure = measures_.update(viewer.frame(model_).marks, model_.worldFromPart);
      if (!viewer.ui().measures.open) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  /// The part whose way out was asked for is searched for at once.
  ViewActions wayOutOf() const {
    ViewActions actions;
    actions.findWayOut = assets::findPart(site_.scene(), arguments_.wayOut);
    return actions;
  }

  /// Draws frames until the way out is found.
  void frameWayOut(Viewer& viewer) {
    wayOut_.act(wayOutOf(), model_.worldFromPart);
    do {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      model_.wayOut = wayOut_.view();
    } while (model_.wayOut.running && !interrupted);
    for (int i = 0; i < 3; ++i) static_cast<void>(viewer.frame(model_));
    viewer.fitAll();
    static_cast<void>(viewer.frame(model_));
  }

  /// Draws frames until the search has ended and the camera shows the first clash.
  void frameClashes(Viewer& viewer) {
    ASSERT(arguments_.clashes >= 0.0);
    viewer.openClashes({arguments_.clashes, false});
    for (int after = 0; after < 40 && !interrupted; after += model_.clashes.findings ? 1 : 0) {
      searchClashes(viewer.frame(model_));
      showClashes();
      if (!model_.clashes.findings) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  /// Clears the fault once for each SIGUSR1, since there may be no window with a button for it.
  void clearFaults() {
    const int requests = faultClears;
    if (requests == report_.faultClears) return;
    report_.faultClears = requests;
    site_.clearFault();
  }

  /// Moves the tip with the mouse. A mouse can jump to the far side of a part, where a hand could not go. A
  /// tip that stays caught far from the mouse is put back to it.
  void followMouse(haptics::VirtualStylus& stylus, const ViewActions& actions, double elapsed) {
    if (actions.stylusMoved)
      stylus.setTarget(actions.worldFromStylus.position, actions.worldFromStylus.orientation);
    const double away = glm::length(model_.hand.worldFromProxy.position - actions.worldFromStylus.position);
    if (model_.hand.held != kNoPart || away < kCaughtShare * sceneSize()) {
      caughtSince_ = elapsed;
    } else if (elapsed - caughtSince_ > kCaughtFor) {
      caughtSince_ = elapsed;
      site_.reseat();
    }
  }

  /// Writes in the document, and shows and says, what the scripts of the hands have come to.
  void writeByScript(double elapsed) {
    for (Hand* hand : scripts_) {
      if (!hand->writer) continue;
      const Camera camera = viewer_ ? viewer_->camera() : headless_->camera();
      const ScriptWriter::Written written =
          hand->writer->write(elapsed, hand->scripted->written(), model_, camera);
      for (DocumentWish wish : written.wishes) {
        if (auto* view = std::get_if<document::NamedView>(&wish.change.body)) keepIn(*view);
        site_.want(wish);
      }
      for (const ScriptStep& step : written.shown) {
        if (viewer_)
          showInWindow(step, model_, *viewer_, says_);
        else
          headless_->perform(step, model_);
      }
      for (const std::string& problem : written.problems)
        std::fprintf(stderr, "tandem: script: %s\n", problem.c_str());
    }
  }

  /// Puts what the person sees into a view that a script keeps: all but the camera, which is in it already.
  void keepIn(document::NamedView& view) const {
    if (viewer_)
      view = viewAs(view.name, viewer_->camera(), viewer_->ui().sections, viewer_->ui().parts);
    else
      headless_->keepIn(view, model_);
  }

  double sceneSize() const { return glm::length(site_.scene().bounds.max - site_.scene().bounds.min); }

  int finish() {
    site_.update(model_);
    report_.collect(site_);
    if (!arguments_.screenshot.empty()) {
      Status picture = viewer_ ? viewer_->screenshot(arguments_.screenshot) : offscreenPicture();
      if (!picture) {
        std::fprintf(stderr, "tandem: %s\n", picture.error().message.c_str());
        failed_ = true;
      }
    }
    if (!arguments_.json.empty())
      if (Status written =
              writeFile(arguments_.json,
                        reportJson(site_, model_, report_, viewer_ ? nullptr : &*headless_, end_) + "\n");
          !written)
        return badInput(written.error());
    if (!arguments_.quiet) LiveTable::summary(model_, end_, report_.grabs.size(), site_.sharedParts());
    return failed_ ? kExitFailed : kExitDone;
  }

  const JoinArguments& arguments_;
  JoinedSite& site_;
  std::unique_ptr<Viewer> viewer_;
  std::unique_ptr<ClearanceWatch> clearance_;  // null without a window and a picture
  std::unique_ptr<ClashSearch> clashes_;       // null before the first search
  MeasureWatch measures_{site_.contact()};
  WayOut wayOut_{site_.scene(), cacheOf(arguments_)};
  std::unique_ptr<PoseTrace> trace_;
  std::array<Hand*, 2> scripts_{};        // while run() runs
  std::optional<HeadlessView> headless_;  // from loop() on
  ViewModel model_;
  std::vector<sync::Say> says_;  // by the scripts, in a window
  ViewActions waiting_;          // input from before the hand exists
  JoinReport report_;
  static constexpr std::chrono::minutes kLevelsPatience{10};
  static constexpr int kFramesOfMeasure =
      20;  // of a picture, 20 ms apart: by then edges and clearance are known
  static constexpr double kCaughtShare = 0.05;  // of the scene's size
  static constexpr double kCaughtFor = 0.5;     // s
  double caughtSince_ = 0.0;                    // s since the start
  std::string end_;
  bool failed_ = false;
};

int runJoin(JoinArguments& arguments) {
  Result<sync::JoinLink> link = sync::parseJoinLink(arguments.link);
  if (!link) return badInput(Error{link.error().message + " (quote the link: it holds a & sign)"});
  // A link works once, so everything on this side is checked before it is used.
  for (const std::string& path : {arguments.json, arguments.trace, arguments.record, arguments.screenshot})
    if (Status free = writable(path); !free) return badInput(free.error());
  if (Status cut = arguments.cut.addAll(arguments.sections); !cut) return badInput(cut.error());
  if (Status colouring = setColouring(arguments); !colouring) return badInput(colouring.error());
  if (arguments.clashes >= 0.0 && arguments.headless && arguments.screenshot.empty())
    return badInput(Error{"--clashes: nobody sees the list without a window or --screenshot"});
  if (!arguments.hand.empty())
    if (Status script = checkHandScript(arguments.hand); !script) return badInput(script.error());
  if (!arguments.device.empty()) {
    auto device = openNamed(arguments.device, arguments.calibration, std::nullopt);
    if (!device) return badInput(device.error());
    (*device)->close();
  }
  if (Status second = checkSecondHand(arguments); !second) return badInput(second.error());
  JoinOptions options;
  options.link = *link;
  const Result<std::optional<double>> tip = parseTip(arguments.tool);
  if (!tip) return badInput(tip.error());
  options.toolRadius = *tip;
  if (arguments.name.empty()) arguments.name = defaultName(*link);
  if (arguments.name.size() > sync::kMaxNameLength)
    return badInput(Error{"--name: at most " + std::to_string(sync::kMaxNameLength) + " bytes"});
  options.name = arguments.name;
  if (!arguments.colour.empty()) {
    Result<sync::SiteColour> colour = parseColour(arguments.colour);
    if (!colour) return badInput(colour.error());
    options.colour = *colour;
  }
  options.udp = !arguments.tcp;
  options.cacheDirectory = cacheOf(arguments);
  options.recordPath = arguments.record;
  options.deadband = arguments.deadband;
  const bool watches =
      arguments.hand.empty() && !hasSecondHand(arguments) &&
      (arguments.device.empty() ? arguments.headless || !displayPresent() : arguments.device == "none");
  options.partContact = !arguments.noPartContact && !watches;
  options.facets = arguments.facets;
  options.maxSceneBytes = static_cast<std::uint64_t>(arguments.maxScene) << 20;
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGUSR1, [](int) { faultClears = faultClears + 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  returnFreedArrays();
  auto line = std::make_unique<ProgressLine>();
  Result<std::unique_ptr<JoinedSite>> site = JoinedSite::enter(options, [&](double done, const char* what) {
    line->show(done, what);
    return interrupted == 0;
  });
  line.reset();
  if (!site) return badInput(site.error());
  return JoinRun(arguments, **site).run();
}

}  // namespace

void addJoin(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<JoinArguments>();
  assets::CommandLine command = program.command("join", "Enter a session: see, touch and move its parts");
  addJoinOptions(command, *arguments);
  command.footer(
      "In the window F1 shows all keys. Space stops all force.\n"
      "A fault turns force off until C, its button or the signal USR1 clears it.\n"
      "Example: tandem join 'tandem://review.example:7480/participant?token=...&pin=...' --name Ada");
  command.onRun([arguments, &exitCode] { exitCode = runJoin(*arguments); });
}

}  // namespace tandem::client
