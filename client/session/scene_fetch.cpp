#include "client/session/scene_fetch.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr std::uint64_t kMaxReserved = 64 << 20;  // bytes before any has come, whatever the server announces

}  // namespace

void SceneFetch::expect(std::uint64_t total) {
  running_ = false;
  total_ = total;
}

SceneRequest SceneFetch::start(std::vector<std::byte> have) {
  ASSERT(!running_);
  package_ = std::move(have);
  if (package_.size() > total_) package_.clear();
  package_.reserve(std::min(total_, kMaxReserved));
  running_ = !complete();
  return {package_.size()};
}

bool SceneFetch::handle(const SceneChunk& message) {
  if (!running_ || message.offset != package_.size() || message.bytes.size() > total_ - package_.size())
    return false;
  const auto* begin = reinterpret_cast<const std::byte*>(message.bytes.data());
  package_.insert(package_.end(), begin, begin + message.bytes.size());
  ASSERT(package_.size() <= total_);
  running_ = !complete();
  return true;
}

double SceneFetch::progress() const {
  return total_ == 0 ? 0.0 : static_cast<double>(package_.size()) / static_cast<double>(total_);
}

}  // namespace tandem::client
