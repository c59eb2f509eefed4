#include "client/join/joined_site.h"

#include <algorithm>
#include <chrono>
#include <future>

#include "assets/base/assert.h"
#include "assets/scene/smooth_normals.h"
#include "client/base/felt_sections.h"
#include "client/join/local_time.h"
#include "haptics/safety/device_defaults.h"
#include "haptics/tool/tip_radius.h"
#include "sync/transport/socket_transport.h"

namespace tandem::client {

using namespace sync;

namespace {
constexpr Micros kNetworkPeriod = kMillisecond;
constexpr double kNoticeLife = 8.0;        // s
constexpr std::size_t kPlotLength = 1000;  // ticks of force
}  // namespace

JoinedSite::JoinedSite(const JoinOptions& options) : options_(options), store_(options.cacheDirectory) {}

JoinedSite::~JoinedSite() {
  if (servo_) servo_->stop();
  stop_ = true;
  if (network_.joinable()) network_.join();
}

Result<std::unique_ptr<JoinedSite>> JoinedSite::enter(const JoinOptions& options, const Progress& progress) {
  std::unique_ptr<JoinedSite> site(new JoinedSite(options));
  if (Status status = site->enterSession(progress); !status) return status.error();
  return site;
}

Status JoinedSite::enterSession(const Progress& progress) {
  ConnectionOptions connectionOptions;
  connectionOptions.name = options_.name;
  connectionOptions.colour = options_.colour;
  connectionOptions.token = options_.link.token;
  connectionOptions.rates.deadband = options_.deadband;
  connectionOptions.maxSceneBytes = options_.maxSceneBytes;
  connection_ =
      std::make_unique<ServerConnection>(connectionOptions, [this]() -> Result<std::unique_ptr<Transport>> {
        ConnectOptions connect;
        connect.udp = options_.udp;
        connect.credential = connection_->credential();
        Result<std::unique_ptr<SocketTransport>> made =
            connectTo(options_.link.host, options_.link.port, options_.link.pin, connect);
        if (!made) return made.error();
        return std::unique_ptr<Transport>(std::move(*made));
      });
  connection_->setObserver(&notes_);
  const Micros deadline = localTime() + static_cast<Micros>(options_.enterTimeout_s * 1e6);
  while (connection_->stage() == ServerConnection::Stage::connecting ||
         connection_->stage() == ServerConnection::Stage::entering) {
    // A person waits while the site enters, so the first failure is reported instead of retried.
    if (!connection_->reason().empty() || localTime() > deadline)
      return Error{options_.link.host + ":" + std::to_string(options_.link.port) + ": " +
                   (connection_->reason().empty() ? "no answer" : connection_->reason())};
    if (!progress(0.0, "entering the session")) return Error{"interrupted"};
    waitForNetwork();
    connection_->step(localTime());
  }
  if (connection_->stage() == ServerConnection::Stage::ended)
    return Error{"the session refused this site: " + connection_->reason()};
  return prepareScene(progress);
}

Status JoinedSite::prepareScene(const Progress& progress) {
  std::vector<std::byte> package = store_.find(connection_->welcome().sceneHash);
  if (package.empty()) {
    const auto step = [this](Micros now) {
      waitForNetwork();
      connection_->step(now);
    };
    if (Status fetched = downloadScene(*connection_, store_, progress, step); !fetched) return fetched;
    package = connection_->takeScenePackage();
  } else {
    connection_->skipTransfer();
  }
  if (!progress(1.0, "preparing the scene")) return Error{"interrupted"};
  Result<assets::Scene> scene = assets::unpackScene(package);
  if (!scene) return Error{"the server's scene cannot be used: " + scene.error().message};
  scene_ = std::move(*scene);
  assets::dropShells(scene_);
  if (options_.facets) assets::dropNormals(scene_);
  contact_ = std::make_unique<haptics::ContactScene>(scene_);
  exchange_ = std::make_unique<Exchange>();
  if (!options_.recordPath.empty()) {
    Result<RecordingWriter> writer = RecordingWriter::create(
        options_.recordPath, {connection_->welcome().sceneHash, wireFrame(scene_.bounds)});
    if (!writer) return writer.error();
    recording_ = std::make_unique<RecordingWriter>(std::move(*writer));
    if (recording_->path() != options_.recordPath)
      std::fprintf(stderr, "tandem: %s is there: this recording is %s\n", options_.recordPath.c_str(),
                   recording_->path().c_str());
    connection_->setRecording(recording_.get());
    store_.keep(connection_->welcome().sceneHash, package);  // a replay finds the scene by its hash
  }
  settings_.parameters[0].gravity = scene_.gravity;
  return {};
}

Status JoinedSite::modelParts(const Progress& progress) {
  ASSERT(contact_ != nullptr && servo_ == nullptr);
  if (!options_.partContact || role() == Role::observer) return {};
  std::atomic<double> done{0.0};
  std::atomic<bool> stop{false};
  haptics::ModelOptions models;
  models.coarse = true;
  models.progress = [&](double share, const char*) {
    done = share;
    return !stop;
  };
  felt_.emplace(*contact_);
  // In a thread of its own: a large mesh takes seconds, and the server drops a site that sends nothing.
  std::future<bool> made = std::async(std::launch::async, [&] { return felt_->modelParts(models); });
  bool ended = false;
  Micros nextShare = 0;
  while (made.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    waitForNetwork();
    connection_->step(localTime());
    if (connection_->stage() == ServerConnection::Stage::needScene)
      connection_->skipTransfer();  // reconnected after an outage
    ended = connection_->stage() == ServerConnection::Stage::ended;
    if (const Micros now = localTime(); now >= nextShare) {
      nextShare = now + SharedSession::kPeriod;
      shared_.exchange(*connection_, scene_.parts.size());  // the participants are displayed meanwhile
    }
    if (!stop && (ended || !progress(done, "making parts ready to collide"))) stop = true;
  }
  if (made.get()) return {};
  return ended ? Error{"the session ended: " + connection_->reason()} : Error{"interrupted"};
}

double JoinedSite::toolRadius() const {
  ASSERT(contact_ != nullptr);
  return options_.toolRadius ? *options_.toolRadius : haptics::tipRadius(*contact_);
}

void JoinedSite::start(std::unique_ptr<haptics::Device> device, std::function<void(HandLoop&)> prepare,
                       std::unique_ptr<haptics::Device> second) {
  ASSERT(device != nullptr && contact_ != nullptr && exchange_ != nullptr && servo_ == nullptr);
  haptics::ModelOptions fine;
  fine.cacheDirectory = options_.cacheDirectory;
  refiner_ = std::make_unique<haptics::ModelRefiner>(
      felt_ ? *std::move(felt_) : *contact_, fine,
      [this] { return glm::dvec3(tip_[0].load(), tip_[1].load(), tip_[2].load()); });
  felt_.reset();
  hand_ = std::make_unique<HandLoop>(refiner_->newest(), *exchange_);
  // One core is the loop's, and one is left to the window and the network.
  if (const int idle = static_cast<int>(std::thread::hardware_concurrency()) - 2; idle > 0) {
    helpers_ = std::make_unique<haptics::TickHelpers>(idle, [] { haptics::ServoLoop::becomeRealtime(); });
    hand_->share(helpers_.get());
  }
  device_ = std::move(device);
  secondDevice_ = std::move(second);
  settings_.parameters[0].toolRadius = toolRadius();
  settings_.parameters[1] = settings_.parameters[0];
  stiffest_ = haptics::fitToDevice(device_->limits(), 0.0, settings_.parameters[0]);
  if (secondDevice_) {
    hand_->addSecondHand();
    haptics::fitToDevice(secondDevice_->limits(), 0.0, settings_.parameters[1]);
  }
  exchange_->settings.write(settings_);
  connection_->setLoopTotals([this] { return loopTotals(); });
  connection_->sceneReady(scene_, *exchange_);
  const auto tick = [this, prepare = std::move(prepare)](const haptics::DeviceSample& sample,
                                                         const haptics::DeviceSample* other, double now) {
    const double began = haptics::ServoLoop::now();
    if (prepare) prepare(*hand_);
    hand_->refine(refiner_->newest());
    for (int axis = 0; axis < 3; ++axis)
      tip_[static_cast<std::size_t>(axis)].store(sample.worldFromDevice.position[axis],
                                                 std::memory_order_relaxed);
    const Wrench wrench = hand_->tick(sample, static_cast<Micros>(now * 1e6), other);
    if ((hand_->output().tick.flags & haptics::kFlagForceLimited) != 0)
      forceLimited_.fetch_add(1, std::memory_order_relaxed);
    hand_->took(haptics::ServoLoop::kUsualRate * (haptics::ServoLoop::now() - began));
    return wrench;
  };
  if (secondDevice_) {
    servo_ = std::make_unique<haptics::ServoLoop>(
        *device_, *secondDevice_,
        [this, tick](const std::array<haptics::DeviceSample, 2>& samples, double now) {
          const Wrench first = tick(samples[0], &samples[1], now);
          return std::array<Wrench, 2>{first, hand_->output().tick.hands[1].toHand};
        });
  } else {
    servo_ = std::make_unique<haptics::ServoLoop>(
        *device_,
        [tick](const haptics::DeviceSample& sample, double now) { return tick(sample, nullptr, now); });
  }
  servo_->start();
  network_ = std::thread([this] { runNetwork(); });
}

// ---- network thread ----

void JoinedSite::waitForNetwork() {
  if (auto* sockets = dynamic_cast<SocketTransport*>(connection_->transport()))
    sockets->wait(kNetworkPeriod);
  else
    std::this_thread::sleep_for(std::chrono::microseconds(kNetworkPeriod));
}

LoopTotals JoinedSite::loopTotals() const {
  const haptics::ServoStatistics servo = servoStatistics();
  return {servo.ticks, servo.late + servo.skipped, forceLimited_.load(std::memory_order_relaxed),
          servo_ ? servo_->computeTimes() : haptics::DurationCounts{}};
}

void JoinedSite::runNetwork() {
  Micros nextShare = 0;
  while (!stop_) {
    waitForNetwork();
    const Micros now = localTime();
    connection_->step(now);
    if (now < nextShare) continue;
    nextShare = now + SharedSession::kPeriod;
    shared_.exchange(*connection_, scene_.parts.size());
  }
  // The Goodbye must leave before the socket is closed.
  if (connection_->stage() != ServerConnection::Stage::ended) connection_->leave();
  for (int i = 0; i < 20 && connection_->transport(); ++i) {
    connection_->step(localTime());
    waitForNetwork();
  }
  if (recording_)
    if (Status flushed = recording_->flush(); !flushed)
      shared_.notice({Notice::Level::error, 0.0, flushed.error().message});
}

// ---- main thread ----

haptics::ServoStatistics JoinedSite::servoStatistics() const {
  return servo_ ? servo_->statistics() : haptics::ServoStatistics{};
}

void JoinedSite::update(ViewModel& model) {
  const double now = haptics::ServoLoop::now();
  const double elapsed = lastUpdate_ > 0.0 ? now - lastUpdate_ : 0.0;
  lastUpdate_ = now;
  if (model.worldFromPart.size() != scene_.parts.size()) {
    model.scene = &scene_;
    model.worldFromPart.clear();
    for (const assets::Part& part : scene_.parts) model.worldFromPart.push_back(part.worldFromPart);
  }
  ShownPose shown;
  while (exchange_->shown.pop(shown)) {
    ASSERT(shown.part < model.worldFromPart.size());
    model.worldFromPart[shown.part] = shown.worldFromDrawn;
    if (onShown) onShown(shown);
  }
  updateHand(model);
  std::vector<Notice> fresh = shared_.read(model, scene_.parts.size());
  for (Notice& notice : notices_) notice.age += elapsed;
  std::erase_if(notices_, [](const Notice& notice) { return notice.age > kNoticeLife; });
  for (Notice& notice : fresh) {
    notice.number = ++noticeCount_;
    notices_.push_back(std::move(notice));
  }
  model.notices = notices_;
}

void JoinedSite::updateTool(const HandOutput& output, std::size_t hand, ToolView& tool) const {
  const haptics::DeviceSample& device = output.hands[hand].device;
  tool.valid = device.valid;
  tool.worldFromDevice = device.worldFromDevice;
  tool.toolRadius = settings_.parameters[hand].toolRadius;
  tool.force = output.tick.hands[hand].toHand.force;
}

void JoinedSite::updateSecondHand(const HandOutput& output, SecondHandView& hand) const {
  const HandRecord& record = output.hands[1];
  updateTool(output, 1, hand);
  hand.deviceName = secondDevice_->name();
  hand.held = output.tick.hands[1].held;
  hand.mostForce = record.maxForce;
  hand.flagsSeen = record.flagsSeen;
  hand.worldFromProxy = record.worldFromProxy;
  hand.contacts = record.contacts;
  hand.contactCount = record.contactCount;
}

void JoinedSite::updateHand(ViewModel& model) {
  const HandOutput& output = exchange_->view.latest();
  HandView& hand = model.hand;
  hand.deviceName = device_ ? device_->name() : "none";
  hand.present = device_ && hand.deviceName != "none";
  updateTool(output, 0, hand);
  hand.worldFromProxy = output.tick.worldFromProxy;
  hand.contacts = output.tick.contacts;
  hand.contactCount = output.tick.contactCount;
  hand.touched = output.tick.touched;
  hand.held = output.tick.hands[0].held;
  const haptics::OwnedPart* held = output.tick.simulated(hand.held);
  hand.links = held != nullptr ? held->links : haptics::LinkReport{};
  hand.grabPending = output.grabPending;
  hand.flags = output.tick.flags;
  if (output.poppedThrough) hand.flags |= haptics::kFlagPopThrough;
  hand.flagsSeen = output.hands[0].flagsSeen;
  hand.stalls = output.stalls;
  if (secondDevice_) updateSecondHand(output, hand.second);
  hand.fault = output.fault != nullptr ? output.fault : "";
  hand.stiffest = stiffest_;
  const haptics::ServoStatistics servo = servoStatistics();
  if (!servo.fault.empty()) {
    hand.fault = servo.fault;
    hand.force = glm::dvec3(0.0);
  }
  model.loop.compute_us_p50 = servo.compute_us_p50;
  model.loop.compute_us_p99 = servo.compute_us_p99;
  model.loop.compute_us_max = servo.compute_us_max;
  model.loop.ticks = servo.ticks;
  model.loop.late = servo.late;
  model.loop.realtime = servo.realtime;
  model.loop.refined = refined();
  if (servo_) {
    const std::array<float, 256> recent = servo_->recentComputeTimes();
    model.loop.recentCompute_us.assign(recent.begin(), recent.end());
  }
  float force = 0.0f;
  while (exchange_->forces.pop(force)) recentForces_.push_back(force);
  if (recentForces_.size() > kPlotLength)
    recentForces_.erase(recentForces_.begin(),
                        recentForces_.end() - static_cast<std::ptrdiff_t>(kPlotLength));
  model.loop.recentForce_n = recentForces_;
  model.settings = {settings_.parameters[0].forceLimit, settings_.parameters[0].gain,
                    settings_.parameters[0].zeroForce, settings_.parameters[0].stiffness};
}

void JoinedSite::reseat() {
  ++settings_.reseats;
  exchange_->settings.write(settings_);
}

void JoinedSite::clearFault() {
  ++settings_.faultResets;
  exchange_->settings.write(settings_);
}

void JoinedSite::act(const ViewActions& actions) {
  if (actions.settingsChanged) {
    settings_.parameters[0].forceLimit = actions.settings.forceLimit;
    settings_.parameters[0].gain = actions.settings.gain;
    settings_.parameters[0].zeroForce = actions.settings.zeroForce;
    settings_.parameters[0].stiffness = actions.settings.stiffness;
    settings_.parameters[1].gain = actions.settings.gain;
    settings_.parameters[1].zeroForce = actions.settings.zeroForce;
    // A person who sets a larger stiffness than the limit of the device raises the limit.
    double& limit = settings_.parameters[0].stiffnessLimit;
    if (limit > 0.0) limit = std::max(limit, actions.settings.stiffness);
  }
  if (actions.setControl != kNoPart)
    settings_.control = {actions.setControl, actions.controlValue, settings_.control.count + 1};
  if (actions.resetFault) ++settings_.faultResets;
  settings_.graspButton = actions.grasp;
  settings_.wish = actions.graspedAt;
  settings_.lifted = actions.lifted;
  const haptics::Sections sections = feltSections(actions.sections);
  settings_.sectionCount = sections.size();
  std::copy(sections.begin(), sections.end(), settings_.sections.begin());
  exchange_->settings.write(settings_);
  shared_.act(actions);
}

}  // namespace tandem::client
