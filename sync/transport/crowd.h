#pragma once

// Who has to make way when there are too many: the network with the most members loses its oldest one.
// Networks with a handful or fewer count alike, so that a few honest peers behind one address do not make way
// for a thousand addresses with one peer each. Internal to the transport.

#include <cstddef>
#include <cstdint>
#include <set>
#include <tuple>
#include <unordered_map>

namespace tandem::sync {

/// The part of an address that one peer commands by itself: an IPv4 address, or an IPv6 prefix of 64 bits.
using Network = std::uint64_t;
/// Numbers grow: who came later has the higher one.
using VisitorId = std::uint64_t;

class Crowd {
 public:
  static constexpr std::size_t kHandful = 16;
  explicit Crowd(std::size_t handful = kHandful) : handful_(handful) {}

  void add(VisitorId visitor, Network network);
  /// Nothing happens if it is no member.
  void remove(VisitorId visitor);
  std::size_t size() const { return networkOf_.size(); }
  bool contains(VisitorId visitor) const { return networkOf_.contains(visitor); }
  /// The oldest member of the network with the most; of networks with as many, the one that is oldest. Must
  /// not be called on an empty crowd.
  VisitorId first() const;

 private:
  using Rank = std::tuple<std::size_t, VisitorId, Network>;  // less for more members; the oldest
  Rank rankOf(Network network, const std::set<VisitorId>& members) const;

  std::size_t handful_;
  std::unordered_map<VisitorId, Network> networkOf_;
  std::unordered_map<Network, std::set<VisitorId>> members_;
  std::set<Rank> order_;
};

}  // namespace tandem::sync
