#include <utility>  // before Asio of Boost 1.74, which forgets it

#include "tests/support/fake_haply.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <nlohmann/json.hpp>

namespace tandem::haptics::testing {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

}  // namespace

struct FakeHaply::State {
  asio::io_context io;
  tcp::acceptor acceptor{io, tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
  std::optional<boost::beast::websocket::stream<tcp::socket>> client;
};

FakeHaply::FakeHaply() : state_(std::make_unique<State>()) {}
FakeHaply::~FakeHaply() = default;

std::uint16_t FakeHaply::port() const { return state_->acceptor.local_endpoint().port(); }

bool FakeHaply::accept() {
  error_code error;
  tcp::socket socket(state_->io);
  state_->acceptor.accept(socket, error);
  if (error) return false;
  socket.set_option(tcp::no_delay(true), error);
  state_->client.emplace(std::move(socket));
  state_->client->accept(error);
  return !error;
}

std::optional<std::string> FakeHaply::exchange(const std::string& message) {
  if (!state_->client) return std::nullopt;
  error_code error;
  state_->client->text(true);
  state_->client->write(asio::buffer(message), error);
  if (error) return std::nullopt;
  boost::beast::flat_buffer buffer;
  state_->client->read(buffer, error);
  if (error) return std::nullopt;
  return boost::beast::buffers_to_string(buffer.data());
}

void FakeHaply::drop() { state_->client.reset(); }

std::string FakeHaply::state(const glm::dvec3& p, const glm::dvec3& v, bool grasp) {
  nlohmann::json message;
  message["inverse3"] = {{{"device_id", "049D"},
                          {"state",
                           {{"cursor_position", {{"x", p.x}, {"y", p.y}, {"z", p.z}}},
                            {"cursor_velocity", {{"x", v.x}, {"y", v.y}, {"z", v.z}}}}}}};
  message["wireless_verse_grip"] = {{{"device_id", "61548"},
                                     {"state",
                                      {{"orientation", {{"x", 0}, {"y", 0}, {"z", 0}, {"w", 1}}},
                                       {"buttons", {{"a", grasp}, {"b", false}, {"c", false}}}}}}};
  return message.dump();
}

std::optional<glm::dvec3> FakeHaply::forceIn(const std::string& answer) {
  const auto json = nlohmann::json::parse(answer, nullptr, false);
  if (!json.is_object() || !json.contains("inverse3") || json["inverse3"].empty()) return std::nullopt;
  const auto& values = json["inverse3"][0]["commands"]["set_cursor_force"]["values"];
  return glm::dvec3(values["x"].get<double>(), values["y"].get<double>(), values["z"].get<double>());
}

}  // namespace tandem::haptics::testing
