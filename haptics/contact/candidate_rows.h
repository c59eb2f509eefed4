#pragma once

// Rows for all samples of one side of a pair that could touch within a step: planes where a field or a
// formula tells a direction, or the last exact query does; balls elsewhere (contact_rows.h).
//
// 1. Reads the samples' memory and writes nothing but rows. Free of allocation.

#include <cstdint>

#include "haptics/contact/contact_rows.h"
#include "haptics/contact/sample_memory.h"
#include "haptics/contact/side_query.h"

namespace tandem::haptics {

class CandidateRows {
 public:
  CandidateRows(const SideQuery& query, const SampleMemory& memory, ContactRows& rows)
      : query_(query), memory_(memory), rows_(rows) {}

  /// Adds the rows. Returns m, an upper bound of how deep any sample is in the target; 0 if all are outside.
  double gather();

 private:
  using Reading = DistanceField::Reading;

  const ContactSample& sampleAt(std::uint32_t i) const { return query_.from->samples.samples()[i]; }
  void deepen(float depth) { deepest_ = depth > deepest_ ? depth : deepest_; }

  // Each adds the row of sample `i`, at `place` (m, relative to the origin of the target's field).

  /// Of any sample before a target of implicit shapes.
  void addShapeRows(std::uint32_t i);
  /// Of a sample that stands for a piece of a round surface.
  void addPatchRow(std::uint32_t i, const glm::vec3& place, const Reading& read);
  /// Of a point or a piece of an edge.
  void addSampleRow(std::uint32_t i, const glm::vec3& place, const Reading& read);
  /// The planes of the last answer, of the sample or of its patch, while they are trusted; else a ball of
  /// `room` m, or of what the answer leaves where that is more.
  void addAnsweredRows(std::uint32_t i, const glm::vec3& place, const ContactPatch* patch, float room);

  /// Whether the answer's planes still hold for a sample that has moved `length` m since.
  bool trusts(const SampleAnswer& answer, std::uint32_t sample, float length) const;
  /// Whether a piece of edge may come nearer to the target between its sample and the next one than at both:
  /// where it crosses a thin blade or rib that both samples have beside them. Where the target is convex, the
  /// distance is a convex function along the edge and lies above its tangents.
  bool crossesBlade(const ContactSample& sample, const glm::vec3& place, const Reading& read) const;
  /// Where the field's error is between smooth and rough, the face of the last answer tells more while the
  /// sample is still before that face: its normal and gap replace the field's.
  void alignToFace(std::uint32_t i, const Reading& read, glm::vec3& normal, float& gap) const;

  const SideQuery& query_;
  const SampleMemory& memory_;
  ContactRows& rows_;
  float allowed_ = 0.0f;  // m, depth that the present sample had at rest
  float deepest_ = 0.0f;  // m
};

}  // namespace tandem::haptics
