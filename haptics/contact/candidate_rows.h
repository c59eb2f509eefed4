#pragma once

// Makes the candidate rows of one side of a pair: one for each sample that could touch within the step. A
// sample becomes a plane where a field, a formula or its last exact query gives a direction, and a ball
// elsewhere (contact_rows.h).
//
// 1. Reads the samples' memory and writes nothing but rows. Free of allocation.

#include <cstdint>

#include "haptics/contact/contact_rows.h"
#include "haptics/contact/sample_memory.h"
#include "haptics/contact/side_clocks.h"
#include "haptics/contact/side_query.h"

namespace tandem::haptics {

class CandidateRows {
 public:
  CandidateRows(const SideQuery& query, const SampleMemory& memory, SideClocks& clocks, ContactRows& rows)
      : query_(query), memory_(memory), clocks_(clocks), rows_(rows) {}

  /// Adds the rows. Returns m, an upper bound of how deep any sample is in the target; 0 if all are outside.
  double gather();

 private:
  using Reading = DistanceField::Reading;

  const ContactSample& sampleAt(std::uint32_t i) const { return query_.from->samples.samples()[i]; }
  void deepen(float depth) { deepest_ = depth > deepest_ ? depth : deepest_; }

  // `i` is a sample and `place` where it is, m, relative to the origin of the target's field.

  /// Adds the rows of one sample and sets `clear_`.
  void addRows(std::uint32_t i, const glm::vec3& place, const Reading& read);
  /// Adds a plane, unless sections cut its place away.
  void addPlane(const glm::vec3& normal, const glm::vec3& arm, float gap, RowSource source);
  /// Adds a plane for each implicit shape of the target.
  void addShapeRows(std::uint32_t i);
  /// Adds the row of a sample that stands for a piece of a round surface.
  void addPatchRow(std::uint32_t i, const glm::vec3& place, const Reading& read);
  /// Adds the row of a point or of a piece of an edge.
  void addSampleRow(std::uint32_t i, const glm::vec3& place, const Reading& read);
  /// Whether the last answer of a point or of a piece of an edge says more than the field.
  bool isAnswered(std::uint32_t i, const glm::vec3& place) const;
  /// Adds the planes of the last answer while they are trusted. Otherwise adds a ball of `room` m, or of
  /// the room that the answer leaves where that is more. `patch` is null for a sample that is a point.
  void addAnsweredRows(std::uint32_t i, const glm::vec3& place, const ContactPatch* patch, float room);

  /// Whether the planes of an answer are trusted for a sample that has moved `length` m since.
  bool trusts(const SampleAnswer& answer, std::uint32_t sample, float length) const;
  /// Whether a piece of edge may come nearer to the target between its sample and the next one than at
  /// both, because it crosses a thin blade or rib there. Where the target is convex, the distance is a
  /// convex function along the edge and lies above its tangents.
  bool crossesBlade(const ContactSample& sample, const glm::vec3& place, const Reading& read) const;
  /// Replaces the normal and gap of a field whose error is between smooth and rough by those of the face of
  /// the last answer, while the sample is still before that face.
  void alignToFace(std::uint32_t i, const Reading& read, glm::vec3& normal, float& gap) const;

  const SideQuery& query_;
  const SampleMemory& memory_;
  SideClocks& clocks_;
  ContactRows& rows_;
  float allowed_ = 0.0f;  // m, depth that the present sample had at rest
  float clear_ = 0.0f;    // m, by which the present sample with its piece may move at least
  float deepest_ = 0.0f;  // m
};

}  // namespace tandem::haptics
