#pragma once

// Writes one StateUpdate as a datagram, whole or as differences to a given baseline (state_stream.h): the
// common part of StateSender and SharedStateSender, which choose the baseline and what goes along.
//
// No allocation once its buffers have grown.

#include <cstdint>
#include <optional>
#include <vector>

#include "sync/wire/state_stream.h"
#include "sync/wire/wire.h"

namespace tandem::sync {

class StateWriter {
 public:
  /// What goes into an update beside the parts.
  struct With {
    bool presence = false, camera = false, second = false;
    friend bool operator==(const With&, const With&) = default;
  };
  // Where two fields of a streamed update begin, in bits, for whoever replaces them.
  static constexpr int kSequenceBit = 32, kDistanceBit = 69;

  /// Takes the codes of the update's parts; those that cannot be encoded are left out.
  void load(const StateUpdate& update, const WireFrame& frame);
  bool empty() const { return codes_.empty(); }
  /// By how much the sequences of the parts have grown since the baseline; a site's parts all grow by the
  /// same. Nothing: none of them is in it.
  std::optional<std::uint32_t> stepFrom(const KeptUpdate& baseline) const;
  /// Writes the update that was loaded. `baseline` may be null; else stepFrom(*baseline) must give a step.
  void write(const StateUpdate& update, const KeptUpdate* baseline, bool keep, With with,
             const WireFrame& frame, std::vector<std::byte>& bytes, EncodeLosses& losses);
  /// What the update that was written last is as a baseline: `parts` is replaced.
  void baselineOf(Micros elapsed, std::vector<PartBaseline>& parts) const;
  /// The same for an update that was loaded and is written whole.
  void wholeBaseline(std::vector<PartBaseline>& parts) const;

 private:
  /// How one part of the baseline is encoded.
  struct Plan {
    const PartBaseline* baseline = nullptr;
    int code = -1;  // in codes_; -1: it is not in this datagram
    bool same = false;
    DeltaOrders orders{};
  };

  void plan(const KeptUpdate* baseline, Micros elapsed, std::uint32_t step, const WireFrame& frame, int room);
  void writeHead(BitWriter& writer, const StateUpdate& update, const KeptUpdate* baseline, std::uint32_t step,
                 bool keep, With with) const;
  void writeParts(BitWriter& writer, Micros elapsed, const WireFrame& frame);

  std::vector<PartCode> codes_;
  std::vector<Plan> plans_;         // of the baseline's parts
  std::vector<std::size_t> whole_;  // in codes_
  int clamped_ = 0;
};

}  // namespace tandem::sync
