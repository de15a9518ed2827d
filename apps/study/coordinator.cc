#include "apps/study/coordinator.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "mle/base/status.h"

namespace mle::study {
namespace {

using experiment::Grid;

// How long a thread sleeps between two looks at messages and signals.
constexpr absl::Duration kPause = absl::Milliseconds(2);
constexpr absl::Duration kPauseAlone = absl::Milliseconds(100);

// The runs that are left, unit by unit.
class Remaining {
 public:
  Remaining(const Grid& grid, const Journal& journal)
      : grid_(grid), journal_(journal) {}

  // Empty if there are none.
  Assignment Next() {
    Assignment assignment;
    while (assignment.runs.empty() && next_unit_ < grid_.num_units()) {
      for (const std::int64_t run : grid_.RunsOf(next_unit_)) {
        if (!journal_.IsDone(run)) assignment.runs.push_back(run);
      }
      ++next_unit_;
    }
    return assignment;
  }

 private:
  const Grid& grid_;
  const Journal& journal_;
  std::int64_t next_unit_ = 0;
};

class Coordinator {
 public:
  Coordinator(const Grid& grid, Processes& processes, WorkerPool& pool,
              Journal& journal, const ProgressFunction& told)
      : processes_(processes),
        pool_(pool),
        journal_(journal),
        remaining_(grid, journal),
        num_runs_(grid.num_runs()),
        told_(told),
        others_(static_cast<std::size_t>(processes.count())) {
    next_ = remaining_.Next();
  }

  absl::Status Run(const std::function<bool()>& stopped) {
    const absl::Duration pause = processes_.count() > 1 ? kPause : kPauseAlone;
    absl::Status status;
    told_(journal_.num_done(), num_runs_);
    while (true) {
      if (!stopping_ && (stopped() || !status.ok())) {
        stopping_ = true;
        pool_.Stop();
      }
      Deal();
      if (IsOver()) break;
      status.Update(Keep(pool_.Collect(pause)));
      for (Processes::Report& report : processes_.Receive()) {
        Other& other = others_[report.rank];
        other.wanted += report.wanted;
        other.outstanding -= report.harvest.ended;
        other.known = true;
        status.Update(Keep(report.harvest));
      }
      told_(journal_.num_done(), num_runs_);
    }
    // What came out between the last look and the end.
    const std::int64_t told = journal_.num_done();
    status.Update(Keep(pool_.Collect(absl::ZeroDuration())));
    if (journal_.num_done() > told) told_(journal_.num_done(), num_runs_);
    status.Update(journal_.Sync());
    return status;
  }

 private:
  struct Other {
    bool known = false;  // has reported once
    bool dismissed = false;
    bool told_to_stop = false;
    int wanted = 0;
    int outstanding = 0;
  };

  bool NothingToDeal() const { return stopping_ || next_.runs.empty(); }

  Assignment Take() { return std::exchange(next_, remaining_.Next()); }

  void Deal() {
    while (!NothingToDeal() && pool_.outstanding() < pool_.threads()) {
      pool_.Submit(Take());
    }
    for (int rank = 1; rank < processes_.count(); ++rank) {
      Other& other = others_[rank];
      while (!NothingToDeal() && other.wanted > 0) {
        processes_.Assign(rank, Take());
        --other.wanted;
        ++other.outstanding;
      }
      if (NothingToDeal() && other.known && !other.dismissed) {
        processes_.Dismiss(rank, stopping_);
        other.dismissed = true;
        other.told_to_stop = stopping_;
      }
      if (stopping_ && other.dismissed && !other.told_to_stop) {
        processes_.Dismiss(rank, true);
        other.told_to_stop = true;
      }
    }
  }

  bool IsOver() const {
    if (!NothingToDeal() || pool_.outstanding() > 0) return false;
    for (int rank = 1; rank < processes_.count(); ++rank) {
      if (!others_[rank].dismissed || others_[rank].outstanding > 0) {
        return false;
      }
    }
    return true;
  }

  absl::Status Keep(const Harvest& harvest) {
    for (const Harvest::Line& line : harvest.lines) {
      MLE_RETURN_IF_ERROR(journal_.Append(line.run, line.text));
    }
    return absl::OkStatus();
  }

  Processes& processes_;
  WorkerPool& pool_;
  Journal& journal_;
  Remaining remaining_;
  Assignment next_;
  const std::int64_t num_runs_;
  const ProgressFunction& told_;
  std::vector<Other> others_;
  bool stopping_ = false;
};

}  // namespace

absl::Status Coordinate(const Grid& grid, Processes& processes,
                        WorkerPool& pool, Journal& journal,
                        const std::function<bool()>& stopped,
                        const ProgressFunction& told) {
  return Coordinator(grid, processes, pool, journal, told).Run(stopped);
}

void Serve(Processes& processes, WorkerPool& pool,
           const std::function<bool()>& stopped) {
  processes.Send(
      {.rank = processes.rank(), .wanted = pool.threads(), .harvest = {}});
  bool more = true;
  bool stopping = false;
  while (true) {
    if (!stopping && stopped()) {
      stopping = true;
      pool.Stop();
    }
    Harvest harvest = pool.Collect(kPause);
    const int ended = harvest.ended;
    if (ended > 0 || !harvest.lines.empty()) {
      processes.Send({.rank = processes.rank(),
                      .wanted = ended,
                      .harvest = std::move(harvest)});
    } else if (!more && pool.outstanding() == 0) {
      return;
    }
    while (true) {
      Processes::Order order = processes.TakeOrder();
      if (order.kind == Processes::Order::Kind::kNone) break;
      if (order.kind == Processes::Order::Kind::kWork) {
        pool.Submit(std::move(order.assignment));
        continue;
      }
      more = false;
      if (order.kind == Processes::Order::Kind::kStop) pool.Stop();
    }
  }
}

}  // namespace mle::study
