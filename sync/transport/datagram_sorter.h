#pragma once

// Sorts the datagrams of a server's port in the kernel, so that a flood of strangers costs the server nothing
// and waits in no known site's way. Internal to the transport.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem::sync {

/// More connections than this are not told apart: those beyond are treated as strangers.
inline constexpr std::size_t kMaxSorted = 1300;

/// Of two sockets that are bound to one port with SO_REUSEPORT, makes the kernel give the datagrams of the
/// connections with these wire ids to the one that was bound second, and all others to the one bound first.
/// Only the first half of an id is compared. False: the system cannot.
bool sortDatagrams(int socket, std::vector<std::uint64_t> wireIds);

}  // namespace tandem::sync
