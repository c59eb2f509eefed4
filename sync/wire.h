#pragma once

// Messages to bytes and back. The bytes of a peer are hostile until decode returns ok.

#include <cstddef>
#include <span>
#include <vector>

#include "assets/result.h"
#include "assets/scene.h"
#include "sync/messages.h"

namespace tandem::sync {

/// The range in which positions are quantised on the wire; the same at every site because it comes from the scene.
/// Positions outside are clamped, and counted by the encoder.
struct WireFrame {
  glm::dvec3 centre{0.0, 0.0, 0.0};   // m
  double halfExtent = 2.0;            // m, of a cube around the centre
};

/// A cube several times the scene's bounds, so that parts can be laid aside. Position quantum: 2 halfExtent / 2^24.
WireFrame wireFrame(const assets::Bounds& sceneBounds);

std::vector<std::byte> encodeControl(const ControlMessage& message);
/// Control messages are exact: doubles on the wire.
Result<ControlMessage> decodeControl(std::span<const std::byte> bytes);

/// Appends nothing that does not fit: parts from the back of StateUpdate::parts are left out to stay within
/// kMaxStateBytes, and `*leftOut` (if given) says how many. Does not allocate once `bytes` has its capacity.
void encodeState(const StateMessage& message, const WireFrame& frame, std::vector<std::byte>& bytes,
                 int* leftOut = nullptr);
/// Reuses the storage of `message` (a StateUpdate keeps its vector's capacity).
Status decodeState(std::span<const std::byte> bytes, const WireFrame& frame, StateMessage& message);

/// The pose and twist as they will be at the receiver after quantisation.
PartState quantised(const PartState& state, const WireFrame& frame);

}  // namespace tandem::sync
