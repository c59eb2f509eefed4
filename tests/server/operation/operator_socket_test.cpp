#include "server/operation/operator_socket.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <random>
#include <thread>

namespace tandem::server {
namespace {

using Kind = OperatorRequest::Kind;

TEST(OperatorRequest, SurvivesItsLineAndNoOtherLineIsOne) {
  for (int kind = 0; kind < 6; ++kind) {
    const OperatorRequest request{static_cast<Kind>(kind), "Ada \"x\" \n", sync::Role::instructor};
    const std::string line = encodeRequest(request);
    EXPECT_EQ(line.find('\n'), std::string::npos);
    const auto read = decodeRequest(line);
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(read->kind, request.kind);
    EXPECT_EQ(read->who, request.who);
    EXPECT_EQ(read->role, request.role);
  }
  std::mt19937 random(3);
  const std::string good = encodeRequest({Kind::ban, "Ada", sync::Role::observer});
  for (int i = 0; i < 5000; ++i) {
    std::string line = good;
    line[random() % line.size()] = static_cast<char>(random() % 256);
    static_cast<void>(decodeRequest(line));
  }
  for (const char* wrong :
       {"", "7", "[]", "{}", R"({"do":"kick"})", R"({"do":7,"role":"observer"})", "{\"do\""})
    EXPECT_FALSE(decodeRequest(wrong).ok()) << wrong;
}

/// A socket in a directory whose path is longer than a socket's address, served by a thread of the test.
struct Served {
  std::filesystem::path root, folder;
  std::unique_ptr<OperatorSocket> socket;
  std::atomic<bool> stop{false};
  std::atomic<int> obeyed{0};
  std::thread thread;

  Served() {
    std::string name = (std::filesystem::temp_directory_path() / "tandem-socket-XXXXXX").string();
    root = ::mkdtemp(name.data());
    folder = root / std::string(120, 'd');
    std::filesystem::create_directory(folder);
    auto opened = OperatorSocket::open(folder.string(), [] {});
    EXPECT_TRUE(opened.ok());
    socket = std::move(*opened);
    thread = std::thread([this] {
      for (; !stop; std::this_thread::sleep_for(std::chrono::milliseconds(1)))
        socket->serve([this](const OperatorRequest& request) -> Result<std::string> {
          ++obeyed;
          if (request.who == "nobody") return Error{"there is no such site"};
          return "done with " + request.who;
        });
    });
  }
  ~Served() {
    stop = true;
    thread.join();
    socket.reset();
    EXPECT_FALSE(std::filesystem::exists(folder / "control.sock"));
    std::filesystem::remove_all(root);
  }
  int connect() const {
    const int link = ::open(folder.c_str(), O_PATH);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = "/proc/self/fd/" + std::to_string(link) + "/control.sock";
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    const int client = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(link);
    return client;
  }
};

TEST(OperatorSocket, CarriesCommandsAndAnswersAndIsPrivate) {
  Served served;
  struct stat file {};
  ASSERT_EQ(::stat((served.folder / "control.sock").c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777u, 0600u);
  OperatorAnswer answer = askServer(served.folder.string(), {Kind::kick, "Ada", {}});
  EXPECT_EQ(answer.outcome, OperatorAnswer::Outcome::done);
  EXPECT_EQ(answer.text, "done with Ada");
  answer = askServer(served.folder.string(), {Kind::ban, "nobody", {}});
  EXPECT_EQ(answer.outcome, OperatorAnswer::Outcome::refused);
  EXPECT_EQ(answer.text, "there is no such site");
}

TEST(OperatorSocket, NoiseAndEndlessLinesAreNoCommandAndDoNotLast) {
  Served served;
  const std::string half = "{\"do\":\"kick\"", endless(100000, 'x'), noise = "noise\n";
  for (const std::string& bytes : {half, endless, noise}) {
    const int client = served.connect();
    static_cast<void>(::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
    ::close(client);
  }
  EXPECT_EQ(askServer(served.folder.string(), {Kind::kick, "Ada", {}}).outcome,
            OperatorAnswer::Outcome::done);
  EXPECT_EQ(served.obeyed, 1);
}

TEST(OperatorSocket, WithoutAServerTheAnswerNamesThePlace) {
  const OperatorAnswer answer = askServer("/nowhere", {Kind::kick, "Ada", {}});
  EXPECT_EQ(answer.outcome, OperatorAnswer::Outcome::unreachable);
  EXPECT_NE(answer.text.find("/nowhere"), std::string::npos);
}

}  // namespace
}  // namespace tandem::server
