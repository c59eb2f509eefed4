#pragma once

// The samples of a side whose time has come (side_clocks.h), by the tree of balls. For the files of this room
// only.

#include "haptics/contact/side_clocks.h"
#include "haptics/fit/counted_work.h"
#include "haptics/touch/near_samples.h"

namespace tandem::haptics {

/// The time at which the first child of a ball is due.
inline float leastOfChildren(const ContactSamples& samples, const DueTimes& due, std::uint32_t n) {
  return std::min(due.nodes[n + 1], due.nodes[samples.nodes()[n].second]);
}
/// Whether the parts of a ball say when they are due, so that it need not be read as a whole.
inline bool isOpen(const ContactSamples& samples, const DueTimes& due, std::uint32_t n) {
  return due.nodes[n] > DueTimes::kNever &&
         (samples.nodes()[n].second == 0 || due.nodes[n] == leastOfChildren(samples, due, n));
}

/// Reads the samples that may be within `reach` m of a field's surface or behind it, less what they may be
/// behind it, and no others. Sets the times until which what it has read need not be read again.
///
/// `Visit` is called as visit(sample, place in the field, reading there) for the samples that may be that
/// near. It returns a lower bound of how far the sample, with the piece that it stands for, is free to move,
/// m.
template <typename Visit>
class DueSamples {
 public:
  DueSamples(const ContactSamples& samples, const DistanceField& field, const FloatMotion& motion,
             const AllowedDepth& allowed, float reach, const DueTimes& due, const Visit& visit)
      : samples_(samples),
        field_(field),
        motion_(motion),
        allowed_(allowed),
        reach_(reach),
        due_(due),
        visit_(visit),
        end_(due.now + reach) {}

  /// Those in the ball `root`.
  void read(std::uint32_t root) {
    push(root);
    while (top_ > 0) readBalls(kAtOnce);
    readSamples();
    close();
  }

  /// Reads those alone that have never been read, whose visits may cost work. False if the work ran out: the
  /// rest stays as if never read.
  bool readAhead(CountedWork& work) {
    constexpr int kMost =
        static_cast<int>(ContactSamples::kMaxInLeaf) * (CountedWork::kReading + CountedWork::kTouch);
    end_ = DueTimes::kNever;
    push(0);
    while (top_ > 0 && !work.pauses(kMost)) {
      work.spend(static_cast<int>(ContactSamples::kMaxInLeaf) * CountedWork::kReading);
      readBalls(1);
      readSamples();
    }
    const bool done = top_ == 0;
    close();
    return done;
  }

 private:
  using Node = ContactSamples::Node;
  static constexpr std::uint32_t kAtOnce = DistanceField::kMaxAtOnce;

  const Node& node(std::uint32_t n) const { return samples_.nodes()[n]; }
  static glm::vec3 centreOf(const Node& node) { return {node.centre[0], node.centre[1], node.centre[2]}; }
  void push(std::uint32_t n) {
    if (due_.nodes[n] <= end_) stack_[top_++] = n;
  }

  /// Notes when the balls are due whose parts have been read.
  void close() {
    // Children are read after their parent.
    while (visited_ > 0) {
      const std::uint32_t n = due_.visited[--visited_];
      due_.nodes[n] = leastOfChildren(samples_, due_, n);
    }
  }

  /// Takes several balls from the stack, so that their memory latencies overlap.
  void readBalls(std::size_t most) {
    std::array<std::uint32_t, kAtOnce> closed, leaves;
    std::array<glm::vec3, kAtOnce> at;
    std::uint32_t closedCount = 0, leafCount = 0;
    const auto open = [&](std::uint32_t n) {
      if (node(n).second == 0) {
        __builtin_prefetch(&due_.samples[node(n).begin]);
        __builtin_prefetch(&samples_.points()[node(n).begin]);
        leaves[leafCount++] = n;
        return;
      }
      due_.visited[visited_++] = n;
      push(node(n).second);
      push(n + 1);
    };
    const std::size_t batch = std::min(top_, most), first = top_ - batch;
    std::array<std::uint32_t, kAtOnce> taken;
    std::copy_n(stack_.begin() + static_cast<std::ptrdiff_t>(first), batch, taken.begin());
    top_ = first;
    for (std::size_t k = 0; k < batch; ++k) {
      if (isOpen(samples_, due_, taken[k])) {
        open(taken[k]);
      } else {
        at[closedCount] = motion_(centreOf(node(taken[k])));
        closed[closedCount++] = taken[k];
      }
    }
    field_.read(at.data(), closedCount, readings_.data());
    for (std::uint32_t k = 0; k < closedCount; ++k) {
      const Node& ball = node(closed[k]);
      const float clear = readings_[k].distance - readings_[k].error - ball.radius +
                          allowed_.least(centreOf(ball), at[k], ball.radius);
      if (clear > reach_)
        due_.nodes[closed[k]] = due_.until(clear);
      else
        open(closed[k]);
    }
    for (std::uint32_t l = 0; l < leafCount; ++l) collect(leaves[l]);
  }

  /// Takes the samples of a leaf that are due. Those of several leaves are read at a time.
  void collect(std::uint32_t n) {
    const Node& leaf = node(n);
    const float allowed = allowed_.least(centreOf(leaf), motion_(centreOf(leaf)), leaf.radius);
    due_.nodes[n] = 1e30f;
    for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
      if (due_.samples[i] > end_) {
        due_.nodes[n] = std::min(due_.nodes[n], due_.samples[i]);
        continue;
      }
      Batch& batch = batches_[filling_];
      const glm::vec4& point = samples_.points()[i];
      batch.at[batch.count] = motion_(glm::vec3(point));
      batch.samples[batch.count++] = {i, n, ContactSamples::touchAbout(point), allowed};
      if (batch.count == kAtOnce) nextBatch();
    }
  }

  /// Reads the samples that have been collected: of both batches.
  void readSamples() {
    for (int k = 0; k < 2; ++k) nextBatch();
  }
  /// Visits the samples of the batch before the one that has been filled, while memory answers for this one.
  void nextBatch() {
    Batch& filled = batches_[filling_];
    field_.seek(filled.at.data(), filled.count, filled.places);
    for (std::uint32_t k = 0; k < filled.count; ++k)
      __builtin_prefetch(&samples_.samples()[filled.samples[k].index]);
    filling_ ^= 1u;
    readBatch(batches_[filling_]);
    field_.fetch(filled.count, filled.places);
  }

  struct Collected {
    std::uint32_t index, leaf;
    float radius, allowed;  // m, about it where its part may touch; that it may be deep
  };
  struct Batch {
    std::array<Collected, kAtOnce> samples;
    std::array<glm::vec3, kAtOnce> at;
    DistanceField::Places places;
    std::uint32_t count = 0;
  };

  void readBatch(Batch& batch) {
    field_.read(batch.at.data(), batch.count, batch.places, readings_.data());
    for (std::uint32_t k = 0; k < batch.count; ++k) {
      const Collected& sample = batch.samples[k];
      float clear = readings_[k].distance - readings_[k].error - sample.radius + sample.allowed;
      if (clear <= reach_) clear = visit_(sample.index, batch.at[k], readings_[k]);
      const float until = due_.until(clear);
      due_.samples[sample.index] = until;
      due_.nodes[sample.leaf] = std::min(due_.nodes[sample.leaf], until);
    }
    batch.count = 0;
  }

  const ContactSamples& samples_;
  const DistanceField& field_;
  const FloatMotion& motion_;
  const AllowedDepth& allowed_;
  const float reach_;  // m
  const DueTimes& due_;
  const Visit& visit_;
  float end_;  // time until which samples are due
  std::array<DistanceField::Reading, kAtOnce> readings_;
  std::array<Batch, 2> batches_;  // one is filled while the other waits for memory
  std::uint32_t filling_ = 0;
  // A tree of 2^32 samples is 28 levels deep, and each level leaves at most kAtOnce balls behind.
  std::array<std::uint32_t, 40 * kAtOnce> stack_;
  std::size_t top_ = 0, visited_ = 0;
};

}  // namespace tandem::haptics
