#pragma once

// One haptic tick: from the pose of a hand to the wrench on it. A pure function of its arguments, 1 kHz.
//
// 1. Fixed, bounded work: no allocation, lock, system call, log or throw. Capacities are fixed; what does not
//    fit sets a flag.
// 2. The force sent is finite and within the limit; what the hand did not cause grows at a limited rate.
// 3. A reading that is not valid gives zero force in that tick; the next good one recovers.
// 4. A broken invariant ends the stages of its tick, and is latched: the force ramps to zero and stays there.
// 5. Contact never depends on anything that comes over a network but the poses of parts that others move.
//
// Roles of parts. A part is simulated here (owned), or moved by others (TickInput::moved), or still. One that
// other sites simulate too is linked to their replicas (replica_links.h).

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "haptics/base/fault.h"
#include "haptics/base/tick_types.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::haptics {

class TickHelpers;
struct LinkId;
struct LinkTerms;
struct AddressedPacket;

/// Everything that a tick remembers from one to the next. Allocated once, for one scene.
class TickState {
 public:
  /// Takes the parts' rest poses from the scene, which must outlive this object. Allocates.
  explicit TickState(const ContactScene& scene);
  ~TickState();
  TickState(TickState&&) noexcept;
  TickState& operator=(TickState&&) noexcept;

  /// Pose of a part as of the last tick, world.
  const Pose& worldFromPart(PartId part) const;

  /// The latched fault, if any.
  const FaultLatch& fault() const;

  /// After ContactScene::refitMesh(mesh), before the next tick: the proxy stays outside the parts as they are
  /// now, on the side on which it touched them, and the change of force grows at the limited rate. By the
  /// thread that ticks. Free of allocation; 3 ns a part of the scene, and 70 ns (moving: 160) a part that
  /// uses the mesh. Limit: which side it touches is taken from the facets as they now are, so that the proxy
  /// comes out on the other side of one that has rotated by over 90 degrees meanwhile; adopt() knows the
  /// facets before.
  void meshesChanged(std::uint32_t mesh);

  /// The same for a ContactScene made by withMesh(): the next tick must be given `next`, and the one before,
  /// unchanged until here, may end. A part that had no triangles when this state was made stays untouchable.
  void adopt(const ContactScene& next);

  /// The same for a ContactScene whose models alone differ, made by withModel(): a hand feels nothing of it.
  /// At no cost, so it may be called before every tick.
  void refine(const ContactScene& next);

  /// Lets these threads run parts of the ticks in which parts touch in many places; null: the calling thread
  /// does all. The results are the same bit by bit. The threads must outlive this. Allocates.
  void share(TickHelpers* helpers);

  /// What follows is about coordination links to other sites' replicas of parts that are owned here
  /// (replica_links.h): by the thread that ticks, between ticks, free of allocation.

  /// Begins a link now. An existing one carries on or begins anew, while its force decays. False if the part
  /// is not owned here, is a control, or there is no room.
  bool beginLink(const LinkTerms& terms);
  /// Orders a link, which beginOrderedLinks() begins as soon as its part is owned here. Replaces an order for
  /// the same link.
  void orderLink(const LinkTerms& terms);
  void beginOrderedLinks();
  void cancelLinkOrders(PartId part);
  /// Ends a link or cancels its order: the force decays. The hand keeps what it holds.
  void endLink(LinkId link);
  /// Sets how many sites simulate a linked part, this one included.
  void setSimulators(PartId part, int simulators);
  /// Receives a peer's packet. False if it was dropped; a packet may hold anything.
  bool receive(const AddressedPacket& packet);
  /// Hands out the packets to be sent after the last tick and returns their count; those that do not fit stay
  /// due.
  std::size_t drainPackets(std::span<AddressedPacket> packets);

  /// Hands out the links whose peers have come to be doubted since the last call: their packets are such
  /// as no hand makes. Returns their count; those that do not fit stay due.
  std::size_t drainDoubts(std::span<LinkId> doubts);

  /// The ticks have stood still for so long that the device's own watchdog let go of the hand. If the next
  /// reading that counts shows it elsewhere, it has not gone there in contact: the proxy is put onto it, and
  /// it holds its part where both now are. Concerns the first hand. By the thread that ticks, between ticks.
  void noteStall();

  /// Clears a latched fault.
  void resetFault();

  struct Data;
  Data& data() { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

/// One tick. `state` must have been made for `scene`, or have adopted it.
TickOutput tick(const TickInput& input, const ContactScene& scene, const TickParameters& parameters,
                TickState& state);

}  // namespace tandem::haptics
