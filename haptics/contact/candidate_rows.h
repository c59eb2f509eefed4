#pragma once

// Makes the candidate rows of one side of a pair: one for each sample that could touch within the step. A
// sample becomes a plane where a field, a formula or its last exact query gives a direction, and a ball
// elsewhere (contact_rows.h).
//
// 1. Reads the samples' memory and writes nothing but rows. Free of allocation.

#include <cstdint>

#include "haptics/base/fixed_vector.h"
#include "haptics/contact/due_samples.h"
#include "haptics/contact/side_clocks.h"
#include "haptics/contact/side_query.h"
#include "haptics/fit/counted_work.h"
#include "haptics/solver/contact_rows.h"
#include "haptics/touch/sample_memory.h"

namespace tandem::haptics {

/// Which samples of a side are due, and how deep they may be.
struct SideTimes {
  /// Advances the clock of the side.
  SideTimes(const SideQuery& query, SideClocks& clocks);

  /// The samples are gathered in so many parts, in any order or at the same time, and then closed.
  std::size_t parts() const { return roots.empty() ? 1 : roots.size(); }
  /// After all parts have been gathered.
  void close(const ContactSamples& samples) const;

  static constexpr std::size_t kMaxParts = 4;

  AllowedDepth allowed;
  DueTimes due;                                  // empty: all samples within reach must be read
  FixedVector<std::uint32_t, kMaxParts> roots;   // the balls of the parts
  FixedVector<std::uint32_t, kMaxParts> opened;  // balls that hold those, parents first

 private:
  void divide(const ContactSamples& samples);
};

class CandidateRows {
 public:
  CandidateRows(const SideQuery& query, const SideTimes& times, const SampleMemory& memory, ContactRows& rows)
      : query_(query),
        times_(times),
        memory_(memory),
        rows_(rows),
        turn_(query.toFromSamples.orientation),
        rotation_(glm::mat3_cast(query.toFromSamples.orientation)) {}

  /// Adds the rows of one part of the samples. Returns m, an upper bound of how deep any of its samples is in
  /// the target; 0 if all are outside.
  double gather(std::size_t part);

  /// Reads the samples that have never been read, and calls ask(source) for those of which a field leaves
  /// open whether they touch within the reach; the rows are of no use. False if the work ran out.
  template <typename Ask>
  bool readAhead(const Ask& ask, CountedWork& work);

 private:
  using Reading = DistanceField::Reading;

  const ContactSample& sampleAt(std::uint32_t i) const { return query_.from->samples.samples()[i]; }
  /// m, frame of the target: from the sample to the end of the piece of edge that it stands for.
  glm::vec3 alongOf(const ContactSample& sample) const {
    return sample.along * (rotation_ * query_.from->samples.axis(sample));
  }
  /// Whether neither an overlap nor a fit says where the present sample may be.
  bool asItLies() const { return !(allowed_ > 0.0f) && shift_ == glm::dvec3(0.0); }
  void deepen(float depth) { deepest_ = depth > deepest_ ? depth : deepest_; }

  /// Whether no sample is so near to a target which its part passes through that a surface may pierce the
  /// other between samples.
  bool leaves(const FloatMotion& motion) const;

  // `i` is a sample and `place` where it is, m, relative to the origin of the target's field.

  /// Adds the rows of one sample and sets `clear_`; with a fit of the pair or without.
  void addAnyRows(std::uint32_t i, const glm::vec3& place, const Reading& read) {
    query_.fit != nullptr ? addFittedRows(i, place, read) : addRows(i, place, read);
  }
  /// Whether the rows leave open whether their sample touches: the solver would ask for it at once.
  bool leavesOpen() const { return rows_.balls() > 0 || lowest_ < 0.0f; }
  /// The same without a fit.
  void addRows(std::uint32_t i, const glm::vec3& place, const Reading& read);
  /// The same of a pair with an interference fit.
  void addFittedRows(std::uint32_t i, const glm::vec3& place, const Reading& read);
  /// Adds a plane, unless sections cut its place away.
  void addPlane(const glm::vec3& normal, const glm::vec3& arm, float gap, RowSource source,
                float beside = 0.0f);
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

  /// m that the last answer leaves to the sample, with all that it stands for, as that was seen.
  float roomLeft(std::uint32_t i, const glm::vec3& place, const SampleAnswer& answer,
                 const ContactPatch* patch) const;
  /// The last answer of a sample while its planes are trusted, else null.
  const SampleAnswer* trustedAnswer(std::uint32_t sample, const glm::vec3& place) const;
  bool isTrusted(std::uint32_t sample, const glm::vec3& place, const SampleAnswer& answer) const;
  /// Adds the planes of an answer for the sample at `place`.
  void addPlanes(std::uint32_t i, const glm::vec3& place, const SampleAnswer& answer,
                 const ContactPatch* patch);

  /// Raises clear_ to what the field knows of a piece of edge that is out of reach.
  void clearAlong(const ContactSample& sample, const glm::vec3& place, const Reading& read);

  /// How much nearer (m) to the target than its sample the part may be between it and the next ones.
  struct Dip {
    float depth = 0.0f;
    bool ofBlade = false;  // the target is a thin blade or rib there, so that its field has no direction
  };
  /// Of a piece of edge. Where the target is convex, the distance along the edge is a convex function and
  /// lies above its tangents. Dips that are not deeper than `above` m do not matter.
  Dip edgeDip(const ContactSample& sample, const glm::vec3& place, const Reading& read, float above) const;
  /// The same on the way to the next sample, down in the direction and length of `along`.
  Dip dipTowards(const glm::vec3& along, const glm::vec3& place, const Reading& read) const;
  /// Replaces the normal and gap of a field whose error is between smooth and rough by those of the face of
  /// the last answer, while the sample is still before that face. Whether it has.
  bool alignToFace(std::uint32_t i, const Reading& read, glm::vec3& normal, float& gap) const;

  const SideQuery& query_;
  const SideTimes& times_;
  const SampleMemory& memory_;
  ContactRows& rows_;
  const glm::quat turn_;             // target from samples
  const glm::mat3 rotation_;         // the same
  glm::dvec3 shift_{0.0, 0.0, 0.0};  // m, of the present sample by an interference fit, frame of the target
  InterferenceFit::Hint hint_;       // of the sample before
  float allowed_ = 0.0f;             // m, depth that the present sample had at rest
  float clear_ = 0.0f;               // m, by which the present sample with its piece may move at least
  float deepest_ = 0.0f;             // m
  float lowest_ = 0.0f;              // m, at most the least gap of the present sample's planes
};

template <typename Ask>
bool CandidateRows::readAhead(const Ask& ask, CountedWork& work) {
  const PartModel &from = *query_.from, &to = *query_.to;
  const FloatMotion motion(query_.toFromSamples, to.field.origin());
  if (times_.due.nodes.empty()) return true;
  const auto visit = [&](std::uint32_t i, const glm::vec3& place, const Reading& read) {
    rows_.clear();
    lowest_ = 0.0f;
    addAnyRows(i, place, read);
    if (!leavesOpen()) return clear_;
    work.spend(CountedWork::kTouch);
    ask(query_.source(i));
    rows_.clear();
    addAnyRows(i, place, read);
    return clear_;
  };
  return DueSamples(from.samples, to.field, motion, times_.allowed, query_.limit, times_.due, visit)
      .readAhead(work);
}

}  // namespace tandem::haptics
