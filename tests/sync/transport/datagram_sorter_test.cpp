// Which of two sockets on one port gets a datagram: plain sockets on loopback, IPv4, IPv6 and both.

#include "sync/transport/datagram_sorter.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <random>
#include <set>

namespace tandem::sync {
namespace {

enum class Net { v4, v6, both };

struct Socket {
  Socket(int family, bool shared) : fd(socket(family, SOCK_DGRAM, 0)) {
    const int on = 1;
    if (shared) setsockopt(fd, SOL_SOCKET, SO_REUSEPORT, &on, sizeof on);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() { ::close(fd); }
  std::size_t drain() const {
    std::array<char, 64> bytes{};
    std::size_t count = 0;
    while (recv(fd, bytes.data(), bytes.size(), MSG_DONTWAIT) >= 0) ++count;
    return count;
  }
  int fd;
};

sockaddr_storage place(bool v6, bool anywhere, std::uint16_t port) {
  sockaddr_storage storage{};
  if (v6) {
    auto& address = reinterpret_cast<sockaddr_in6&>(storage);
    address.sin6_family = AF_INET6;
    address.sin6_addr = anywhere ? in6addr_any : in6addr_loopback;
    address.sin6_port = htons(port);
  } else {
    auto& address = reinterpret_cast<sockaddr_in&>(storage);
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
  }
  return storage;
}

class Port {
 public:
  explicit Port(Net net)
      : v6_(net != Net::v4), others_(v6_ ? AF_INET6 : AF_INET, true), known_(v6_ ? AF_INET6 : AF_INET, true) {
    const int off = 0;
    for (const Socket* end : {&others_, &known_}) {
      if (net == Net::both) setsockopt(end->fd, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
      sockaddr_storage here = place(v6_, net == Net::both, port_);
      socklen_t size = sizeof here;
      EXPECT_EQ(bind(end->fd, reinterpret_cast<sockaddr*>(&here), size), 0);
      getsockname(end->fd, reinterpret_cast<sockaddr*>(&here), &size);
      port_ = ntohs(v6_ ? reinterpret_cast<sockaddr_in6&>(here).sin6_port
                        : reinterpret_cast<sockaddr_in&>(here).sin_port);
    }
  }
  bool sort(const std::vector<std::uint64_t>& ids) const { return sortDatagrams(others_.fd, ids); }
  /// Whether the datagram comes to the socket for known ones; exactly one of the two gets it.
  bool known(bool overV6, std::uint64_t id, std::size_t size = 32) const {
    std::array<std::byte, 64> bytes{};
    for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::byte>(id >> (56 - 8 * i));
    const Socket from(overV6 ? AF_INET6 : AF_INET, false);
    const sockaddr_storage to = place(overV6, false, port_);
    EXPECT_EQ(sendto(from.fd, bytes.data(), size, 0, reinterpret_cast<const sockaddr*>(&to),
                     overV6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in)),
              static_cast<ssize_t>(size));
    const std::size_t known = known_.drain(), others = others_.drain();
    EXPECT_EQ(known + others, 1u);
    return known == 1;
  }

 private:
  bool v6_;
  std::uint16_t port_ = 0;
  Socket others_, known_;
};

TEST(DatagramSorter, GivesKnownConnectionsASocketOfTheirOwn) {
  std::mt19937_64 random(5);
  for (const Net net : {Net::v4, Net::v6, Net::both}) {
    const Port port(net);
    for (const std::size_t count : {0u, 1u, 8u, 9u, 17u, 64u, 564u, 1300u}) {
      std::vector<std::uint64_t> ids(count);
      std::set<std::uint64_t> heads;
      for (std::uint64_t& id : ids) heads.insert((id = random()) >> 32);
      if (count > 2) ids[1] = 0, ids[2] = ~std::uint64_t{0}, heads.insert({0, 0xffffffffu});
      ASSERT_TRUE(port.sort(ids));
      for (std::size_t i = 0; i < count; i += 1 + count / 20)
        EXPECT_TRUE(port.known(net == Net::v6, ids[i])) << count;
      for (int i = 0; i < 20; ++i) {
        std::uint64_t stranger =
            i % 2 == 0 || count < 3 ? random() : ids[1 + i % 2] ^ std::uint64_t{1} << (32 + i);
        if (heads.contains(stranger >> 32)) continue;
        EXPECT_FALSE(port.known(net == Net::v6, stranger)) << count;
      }
      for (const std::size_t size : {0u, 1u, 3u}) EXPECT_FALSE(port.known(net == Net::v6, 0, size));
    }
  }
}

}  // namespace
}  // namespace tandem::sync
