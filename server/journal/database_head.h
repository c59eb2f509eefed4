#pragma once

// The head of a commit, and its bytes in the last row that the commit wrote.

#include <cstdint>
#include <string>

#include "server/journal/journal.h"
#include "server/journal/record_digest.h"

namespace tandem::server {

struct DatabaseHead {
  Digest session{};
  std::string scene;           // hash, hexadecimal; empty: that of the next start
  std::uint64_t sequence = 0;  // of the last commit
  Digest chain{};              // the hash of this head
  Digest previousChain{};      // of the one before
  DigestSum sum;               // of all rows
  sync::Micros sessionTime = 0;
  Epoch epochFloor = 0;
  SiteId lastSite = 0;
};

/// The hash of a head: a link in the chain.
Digest chainOf(const DatabaseHead& head);
/// A sum that has this value.
DigestSum sumOf(const Digest& value);
/// What of a head changes with every commit, as it stands in the last row of one.
std::string inRow(const DatabaseHead& head);
/// False if these are not the bytes of a head.
bool takeFromRow(const std::string& bytes, DatabaseHead& head);

}  // namespace tandem::server
