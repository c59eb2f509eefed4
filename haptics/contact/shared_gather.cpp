#include "haptics/contact/shared_gather.h"

namespace tandem::haptics {

SharedGather::SharedGather(TickHelpers& helpers, const SideClocks& clocks) : helpers_(helpers) {
  workers_.resize(static_cast<std::size_t>(helpers.count()) + 1);
  for (Worker& worker : workers_) worker.visited.resize(clocks.mostNodes());
  sides_.reserve(2 * kMaxPairs);
  tasks_.reserve(2 * kMaxPairs * SideTimes::kMaxParts);
}

void SharedGather::findSides(const Step& step) {
  sides_.clear();
  tasks_.clear();
  closed_ = gathered_ = appended_ = 0;
  for (Worker& worker : workers_) worker.rows.clear();
  for (int i = 0; i < step.island.pairCount(); ++i) {
    const ContactPair& pair = step.island.pair(i);
    if (!pair.mayTouch()) continue;
    for (const std::uint16_t side : {std::uint16_t{0}, std::uint16_t{1}}) {
      const SideQuery query(step.island, step.overlaps, static_cast<std::uint16_t>(i), side,
                            pair.closing(step.reach));
      if (step.clocks.forgetsFor(query.sampled, query.target, query)) gatherSides(step);
      sides_.push_back({query, SideTimes(query, step.clocks)});
      for (std::size_t part = 0; part < sides_.back().times.parts(); ++part) {
        Task& task = tasks_.emplace_back();
        task.side = sides_.size() - 1;
        task.part = part;
      }
    }
  }
  gatherSides(step);
  for (const Worker& worker : workers_) step.rows.noteDropped(worker.rows);
}

void SharedGather::gatherSides(const Step& step) {
  const std::size_t first = gathered_;
  gathered_ = tasks_.size();
  helpers_.run(static_cast<int>(gathered_ - first), [&](int index, int number) {
    Task& task = tasks_[first + static_cast<std::size_t>(index)];
    const Side& side = sides_[task.side];
    Worker& worker = workers_[static_cast<std::size_t>(number)];
    SideTimes times = side.times;
    times.due.visited = worker.visited;
    task.worker = number;
    task.rows = worker.rows.begin();
    task.depth = CandidateRows(side.query, times, step.memory, worker.rows).gather(task.part);
    worker.rows.end(task.rows);
  });
  for (; closed_ < sides_.size(); ++closed_) sides_[closed_].times.close(sides_[closed_].query.from->samples);
}

void SharedGather::appendPair(int pair, const Step& step) {
  for (; appended_ < tasks_.size() && sides_[tasks_[appended_].side].query.pair == pair; ++appended_) {
    const Task& task = tasks_[appended_];
    step.rows.append(workers_[static_cast<std::size_t>(task.worker)].rows, task.rows);
    step.overlaps.noteDepth(pair, task.depth);
  }
}

}  // namespace tandem::haptics
