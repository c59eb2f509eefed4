#pragma once

// Gathers the candidate rows of all pairs of an island in parallel, on idle cores: a subtree of the samples
// of one side of a pair is one task. The rows are those that one thread would have gathered, in the same
// order, so that the solution is the same bit by bit; where more are found than fit, others may be dropped.
//
// 1. Called by the thread that ticks. 2. Only the constructor allocates.

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/base/tick_helpers.h"
#include "haptics/contact/candidate_rows.h"
#include "haptics/contact/side_clocks.h"
#include "haptics/contact/side_query.h"
#include "haptics/solver/contact_rows.h"
#include "haptics/touch/sample_memory.h"

namespace tandem::haptics {

class SharedGather {
 public:
  /// What the gathering of one step reads and writes.
  struct Step {
    const ContactIsland& island;
    Overlaps& overlaps;
    const SampleMemory& memory;
    SideClocks& clocks;
    ContactRows& rows;
    double reach = 0.0;  // m
  };

  /// The helpers must outlive this.
  SharedGather(TickHelpers& helpers, const SideClocks& clocks);

  TickHelpers& helpers() { return helpers_; }

  // In a step: findSides(), then appendPair() for each pair, in order.

  /// Finds the rows of all sides.
  void findSides(const Step& step);
  /// Adds the rows of a pair, and notes its depth.
  void appendPair(int pair, const Step& step);

 private:
  struct Side {
    SideQuery query;
    SideTimes times;
  };
  /// A part of a side.
  struct Task {
    std::size_t side = 0, part = 0;
    int worker = 0;
    ContactRows::Range rows;  // of the worker
    double depth = 0.0;       // m
  };
  /// Of one thread.
  struct Worker {
    ContactRows rows;
    std::vector<std::uint32_t> visited;  // DueTimes::visited
  };

  /// Gathers the sides that have not been yet.
  void gatherSides(const Step& step);

  TickHelpers& helpers_;
  std::vector<Worker> workers_;
  // Of the present step.
  std::vector<Side> sides_;
  std::vector<Task> tasks_;
  std::size_t closed_ = 0, gathered_ = 0, appended_ = 0;  // of the sides; of the tasks
};

}  // namespace tandem::haptics
