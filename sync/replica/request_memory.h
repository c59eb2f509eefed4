#pragma once

// The requests of each site that the server has answered lately, so that one that is repeated gets the same
// answer again (S7).

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>

#include "sync/wire/ownership_messages.h"

namespace tandem::sync {

class RequestMemory {
 public:
  enum class Kind : std::uint8_t { grab, reclaim, release };
  /// A request is the same only if all of these are: a site that began to count anew may use a number again.
  struct Request {
    Kind kind = Kind::grab;
    RequestId request = 0;
    PartId part = kNoPart;
    Epoch epoch = 0;  // 0 for a grab
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Answer {
    Denial denial = Denial::none;
    PartRecord record;
  };

  /// The answer that this request of the site got, or null. Valid until the next call of remember() or
  /// forget().
  const Answer* find(SiteId site, const Request& request) const;
  /// Keeps an answer; the oldest one of the site gives way to it where there are kPerSite.
  void remember(SiteId site, const Request& request, const Answer& answer);
  /// The site left for good.
  void forget(SiteId site) { sites_.erase(site); }
  /// Forgets what the site was answered about one part.
  void forget(SiteId site, PartId part) {
    if (const auto found = sites_.find(site); found != sites_.end())
      std::erase_if(found->second, [&](const Entry& entry) { return entry.request.part == part; });
  }

  static constexpr std::size_t kPerSite = 64;

 private:
  struct Entry {
    Request request;
    Answer answer;
  };
  std::map<SiteId, std::deque<Entry>> sites_;  // oldest first
};

}  // namespace tandem::sync
