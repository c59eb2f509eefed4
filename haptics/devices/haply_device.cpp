#include <utility>  // before Asio of Boost 1.74, which forgets it

#include "haptics/devices/haply_device.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <charconv>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "assets/base/assert.h"
#include "haptics/base/triple_buffer.h"
#include "haptics/devices/haply_codec.h"
#include "haptics/devices/hid_worker.h"
#include "haptics/operator/simulated_hand.h"

namespace tandem::haptics {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using boost::system::error_code;
using Socket = websocket::stream<beast::tcp_stream>;

constexpr double kHaplySilence = 0.05, kStale = 0.05;  // s
constexpr auto kPatience = std::chrono::seconds(2);
constexpr auto kHaplyRetry = std::chrono::milliseconds(200);
constexpr auto kClosingTimeout = std::chrono::milliseconds(100);

struct WantedOfHaply {
  glm::dvec3 force{0.0, 0.0, 0.0};  // N, device axes
  double renewedAt = -1e9;          // s, driverClock
};

}  // namespace

struct HaplyDevice::Driver {
  explicit Driver(const HaplySettings& s) : settings(s), resolver(io), deadline(io) {}

  void run();
  void connect();
  void shake();
  void listen();
  void onMessage(const error_code& error);
  void answer();
  void sendZeroAndClose();
  template <typename Next>
  void send(const glm::dvec3& force, Next next);
  void fail(const std::string& why);
  void publish() { published.write(reading); }
  void reportOutcome(const std::string& why);

  HaplySettings settings;
  asio::io_context io;
  asio::ip::tcp::resolver resolver;
  asio::steady_timer deadline;  // of the last message when closing
  std::optional<Socket> socket;
  beast::flat_buffer buffer;
  std::string reply;
  HaplyState state;
  HaplyReading reading;
  bool leaving = false;  // the thread's copy of `stopping`
  bool writing = false;

  TripleBuffer<HaplyReading> published;
  TripleBuffer<WantedOfHaply> wanted;

  std::thread thread;
  std::mutex mutex;
  std::condition_variable wake;
  bool stopping = false, settled = false;  // under mutex; settled: the first attempt has ended
  std::string problem;                     // under mutex; empty: connected
};

void HaplyDevice::Driver::run() {
  for (;;) {
    io.restart();
    writing = false;
    connect();
    io.run();
    socket.reset();
    buffer.clear();
    reading.connected = reading.present = false;
    publish();
    std::unique_lock lock(mutex);
    wake.wait_for(lock, kHaplyRetry, [this] { return stopping; });
    if (stopping) return;
  }
}

/// Reports the first outcome of an attempt, which open() waits for.
void HaplyDevice::Driver::reportOutcome(const std::string& why) {
  {
    const std::lock_guard lock(mutex);
    settled = true;
    problem = why;
  }
  wake.notify_all();
}

void HaplyDevice::Driver::fail(const std::string& why) {
  reportOutcome(why);
  deadline.cancel();
  resolver.cancel();
  if (!socket) return;
  beast::get_lowest_layer(*socket).close();
  // A pending timer would keep the thread alive. The stream must not be destroyed within one of its own
  // handlers.
  asio::post(io, [this] { socket.reset(); });
}

void HaplyDevice::Driver::connect() {
  socket.emplace(io);
  resolver.async_resolve(settings.host, std::to_string(settings.port),
                         [this](const error_code& error, const asio::ip::tcp::resolver::results_type& found) {
                           if (error || leaving) return fail("its host is not known: " + error.message());
                           beast::tcp_stream& stream = beast::get_lowest_layer(*socket);
                           stream.expires_after(kPatience);
                           stream.async_connect(
                               found, [this](const error_code& failed, const asio::ip::tcp::endpoint&) {
                                 if (failed || leaving) return fail(failed.message());
                                 shake();
                               });
                         });
}

void HaplyDevice::Driver::shake() {
  beast::tcp_stream& stream = beast::get_lowest_layer(*socket);
  error_code ignored;
  stream.socket().set_option(asio::ip::tcp::no_delay(true), ignored);
  stream.expires_never();
  socket->set_option(websocket::stream_base::timeout{kPatience, kPatience, false});
  socket->read_message_max(kMaxHaplyMessage);
  socket->async_handshake(settings.host + ":" + std::to_string(settings.port), "/",
                          [this](const error_code& error) {
                            if (error || leaving)
                              return fail("it does not speak WebSocket: " + error.message());
                            reading.connected = true;
                            ++reading.connections;
                            publish();
                            reportOutcome("");
                            listen();
                          });
}

void HaplyDevice::Driver::listen() {
  ASSERT(socket);
  socket->async_read(buffer, [this](const error_code& error, std::size_t) { onMessage(error); });
}

void HaplyDevice::Driver::onMessage(const error_code& error) {
  if (error == websocket::error::message_too_big || error == websocket::error::buffer_overflow)
    ++reading.oversized;
  if (error) return fail(error.message());
  const auto bytes = buffer.data();
  switch (decodeHaply({static_cast<const char*>(bytes.data()), bytes.size()}, state)) {
    case HaplyMessage::kState:
      ++reading.states;
      reading.present = true;
      reading.position = fromHaplyAxes(state.position);
      reading.velocity = fromHaplyAxes(state.velocity);
      reading.orientation = fromHaplyAxes(state.orientation);
      reading.buttons = state.buttons;
      reading.at = driverClock();
      break;
    case HaplyMessage::kNoDevice:
      reading.present = false;
      break;
    case HaplyMessage::kMalformed:
      ++reading.malformed;
      break;
  }
  buffer.clear();
  publish();
  answer();
}

void HaplyDevice::Driver::answer() {
  if (leaving) return sendZeroAndClose();
  const WantedOfHaply& now = wanted.latest();
  const bool silent = driverClock() - now.renewedAt > kHaplySilence;
  send(silent ? glm::dvec3(0.0) : now.force, [this] { leaving ? sendZeroAndClose() : listen(); });
}

/// Sends zero force and closes.
void HaplyDevice::Driver::sendZeroAndClose() {
  if (!writing) send(glm::dvec3(0.0), [this] { fail("closed"); });
}

template <typename Next>
void HaplyDevice::Driver::send(const glm::dvec3& force, Next next) {
  ASSERT(socket && !writing);
  reply = encodeHaply(state.id, force);
  writing = true;
  socket->text(true);
  socket->async_write(asio::buffer(reply), [this, next](const error_code& error, std::size_t) {
    writing = false;
    if (error) return fail(error.message());
    next();
  });
}

HaplyDevice::HaplyDevice(const HaplySettings& settings)
    : settings_(settings), driver_(std::make_unique<Driver>(settings)) {}

HaplyDevice::~HaplyDevice() { close(); }

DeviceLimits HaplyDevice::limits() const {
  DeviceLimits limits;
  limits.sensedAxes = 6;
  limits.actuatedAxes = 3;
  limits.maxForce = settings_.maxForce;
  limits.quantum = 0.01e-3;
  limits.workspaceRadius = 0.1;
  return limits;
}

Status HaplyDevice::open() {
  Driver& d = *driver_;
  if (d.thread.joinable()) return {};
  d.stopping = d.settled = d.leaving = false;
  d.problem.clear();
  d.thread = std::thread([driver = driver_.get()] { driver->run(); });
  std::string problem;
  {
    std::unique_lock lock(d.mutex);
    if (!d.wake.wait_for(lock, kPatience, [&d] { return d.settled; }))
      problem = "no answer within two seconds";
    else
      problem = d.problem;
  }
  if (problem.empty()) return {};
  close();
  return Error{"haply: no device service at " + settings_.host + ":" + std::to_string(settings_.port) + ": " +
               problem};
}

void HaplyDevice::close() {
  Driver& d = *driver_;
  if (!d.thread.joinable()) return;
  {
    const std::lock_guard lock(d.mutex);
    d.stopping = true;
  }
  d.wake.notify_all();
  // The next answer is zero force and the last one; it is not sent if no further message arrives.
  asio::post(d.io, [driver = &d] {
    {
      // Clears the flag of an earlier closing that found the thread between two attempts.
      const std::lock_guard lock(driver->mutex);
      if (!driver->stopping) return;
    }
    driver->leaving = true;
    if (!driver->reading.connected) return driver->fail("closed");
    driver->deadline.expires_after(kClosingTimeout);
    driver->deadline.async_wait([driver](const error_code& error) {
      if (!error && driver->socket) driver->sendZeroAndClose();
    });
  });
  d.thread.join();
  d.thread = std::thread();
}

DeviceSample HaplyDevice::poll(double now) {
  reading_ = driver_->published.latest();
  DeviceSample sample;
  sample.worldFromDevice = {reading_.position, glm::normalize(reading_.orientation)};
  sample.twist.linear = reading_.velocity;
  sample.buttons = reading_.buttons;
  sample.time = now;
  sample.valid = reading_.connected && reading_.present && driverClock() - reading_.at <= kStale;
  return sample;
}

void HaplyDevice::apply(const Wrench& toHand) {
  driver_->wanted.write({toHaplyAxes(limited(toHand.force, settings_.maxForce)), driverClock()});
}

Result<HaplySettings> parseHaplyName(const std::string& name) {
  HaplySettings settings;
  if (name == "haply") return settings;
  const Error wrong{"device '" + name + "': must be haply, haply:HOST or haply:HOST:PORT"};
  if (!name.starts_with("haply:")) return wrong;
  const std::string place = name.substr(6);
  const std::size_t colon = place.rfind(':');
  settings.host = place.substr(0, colon);
  if (settings.host.empty() || settings.host.size() > 253) return wrong;
  if (colon == std::string::npos) return settings;
  const char* const end = place.data() + place.size();
  const auto [stop, error] = std::from_chars(place.data() + colon + 1, end, settings.port);
  if (error != std::errc{} || stop != end || settings.port == 0) return wrong;
  return settings;
}

Status probeHaply(const HaplySettings& settings) {
  asio::io_context io;
  error_code error;
  asio::ip::tcp::resolver resolver(io);
  const auto found = resolver.resolve(settings.host, std::to_string(settings.port), error);
  asio::ip::tcp::socket probe(io);
  if (!error) asio::connect(probe, found, error);
  if (!error) return {};
  return Error{"no Haply device service at " + settings.host + ":" + std::to_string(settings.port) +
               ": start Haply's Inverse Service"};
}

}  // namespace tandem::haptics
