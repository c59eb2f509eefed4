#include "sync/transport/datagram_sorter.h"

#include <linux/filter.h>
#include <sys/socket.h>

#include <algorithm>
#include <span>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr std::uint32_t kFirstBound = 0, kSecondBound = 1;

/// A program for the kernel's packet filter that looks up the first 32 bits of a datagram by bisection.
class Program {
 public:
  explicit Program(std::span<const std::uint32_t> sorted) {
    add(BPF_LD | BPF_W | BPF_ABS, 0);  // of a shorter datagram: ends with the result 0
    lookUp(sorted);
    ASSERT(steps_.size() <= BPF_MAXINSNS);
  }
  sock_fprog forKernel() { return {static_cast<unsigned short>(steps_.size()), steps_.data()}; }

 private:
  static constexpr std::size_t kLeaf = 8;

  void lookUp(std::span<const std::uint32_t> sorted) {
    if (sorted.size() <= kLeaf) {
      for (const std::uint32_t id : sorted) {
        add(BPF_JMP | BPF_JEQ | BPF_K, id, 0, 1);
        add(BPF_RET | BPF_K, kSecondBound);
      }
      return add(BPF_RET | BPF_K, kFirstBound);
    }
    const std::size_t half = sorted.size() / 2;
    add(BPF_JMP | BPF_JGE | BPF_K, sorted[half], 0, 1);
    const std::size_t jump = steps_.size();
    add(BPF_JMP | BPF_JA, 0);
    lookUp(sorted.first(half));
    steps_[jump].k = static_cast<std::uint32_t>(steps_.size() - jump - 1);
    lookUp(sorted.subspan(half));
  }
  void add(int code, std::uint32_t k, std::uint8_t ifTrue = 0, std::uint8_t ifFalse = 0) {
    steps_.push_back({static_cast<std::uint16_t>(code), ifTrue, ifFalse, k});
  }

  std::vector<sock_filter> steps_;
};

}  // namespace

bool sortDatagrams(int socket, std::vector<std::uint64_t> wireIds) {
  wireIds.resize(std::min(wireIds.size(), kMaxSorted));
  std::vector<std::uint32_t> heads;
  heads.reserve(wireIds.size());
  for (const std::uint64_t id : wireIds) heads.push_back(static_cast<std::uint32_t>(id >> 32));
  std::sort(heads.begin(), heads.end());
  Program program(heads);
  const sock_fprog filter = program.forKernel();
  return setsockopt(socket, SOL_SOCKET, SO_ATTACH_REUSEPORT_CBPF, &filter, sizeof filter) == 0;
}

}  // namespace tandem::sync
