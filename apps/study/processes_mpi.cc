#include "apps/study/processes_mpi.h"

#include <mpi.h>

#include <cstdint>
#include <cstring>
#include <list>
#include <string>
#include <utility>
#include <vector>

namespace mle::study {
namespace {

enum Tag : int { kAssignment = 1, kNoMore = 2, kStop = 3, kReport = 4 };

// Messages are flat: 64-bit numbers, texts after their length.
class Packer {
 public:
  void Add(std::int64_t number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof(number));
  }
  void Add(const std::string& text) {
    Add(static_cast<std::int64_t>(text.size()));
    bytes_ += text;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Unpacker {
 public:
  explicit Unpacker(std::string bytes) : bytes_(std::move(bytes)) {}
  std::int64_t Number() {
    std::int64_t number = 0;
    std::memcpy(&number, bytes_.data() + at_, sizeof(number));
    at_ += sizeof(number);
    return number;
  }
  std::string Text() {
    const auto size = static_cast<std::size_t>(Number());
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

class MpiProcesses : public Processes {
 public:
  MpiProcesses() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    MPI_Comm here = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_,
                        MPI_INFO_NULL, &here);
    MPI_Comm_size(here, &on_this_machine_);
    MPI_Comm_free(&here);
  }
  ~MpiProcesses() override {
    for (Posted& posted : posted_) {
      MPI_Wait(&posted.request, MPI_STATUS_IGNORE);
    }
    MPI_Finalize();
  }

  int rank() const override { return rank_; }
  int count() const override { return count_; }
  int on_this_machine() const override { return on_this_machine_; }

  std::optional<std::string> Broadcast(
      const std::optional<std::string>& text) override {
    std::int64_t size =
        text.has_value() ? static_cast<std::int64_t>(text->size()) : -1;
    MPI_Bcast(&size, 1, MPI_INT64_T, 0, MPI_COMM_WORLD);
    if (size < 0) return std::nullopt;
    std::string received = rank_ == 0 ? *text : std::string(size, '\0');
    MPI_Bcast(received.data(), static_cast<int>(size), MPI_CHAR, 0,
              MPI_COMM_WORLD);
    return received;
  }

  void Assign(int rank, const Assignment& assignment) override {
    Post(rank, kAssignment, assignment.runs);
  }

  void Dismiss(int rank, bool at_once) override {
    Post(rank, at_once ? kStop : kNoMore, {});
  }

  std::vector<Report> Receive() override {
    Forget();
    std::vector<Report> reports;
    MPI_Status status;
    while (Probe(MPI_ANY_SOURCE, kReport, status)) {
      int size = 0;
      MPI_Get_count(&status, MPI_CHAR, &size);
      std::string bytes(static_cast<std::size_t>(size), '\0');
      MPI_Recv(bytes.data(), size, MPI_CHAR, status.MPI_SOURCE, kReport,
               MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      Unpacker unpacker(std::move(bytes));
      Report report;
      report.rank = status.MPI_SOURCE;
      report.wanted = static_cast<int>(unpacker.Number());
      report.harvest.ended = static_cast<int>(unpacker.Number());
      report.harvest.lines.resize(unpacker.Number());
      for (Harvest::Line& line : report.harvest.lines) {
        line.run = unpacker.Number();
        line.text = unpacker.Text();
      }
      reports.push_back(std::move(report));
    }
    return reports;
  }

  void Send(const Report& report) override {
    Packer packer;
    packer.Add(report.wanted);
    packer.Add(report.harvest.ended);
    packer.Add(static_cast<std::int64_t>(report.harvest.lines.size()));
    for (const Harvest::Line& line : report.harvest.lines) {
      packer.Add(line.run);
      packer.Add(line.text);
    }
    const std::string& bytes = packer.bytes();
    MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_CHAR, 0, kReport,
             MPI_COMM_WORLD);
  }

  Order TakeOrder() override {
    Order order;
    MPI_Status status;
    if (!Probe(0, MPI_ANY_TAG, status)) return order;
    int size = 0;
    MPI_Get_count(&status, MPI_INT64_T, &size);
    order.assignment.runs.resize(static_cast<std::size_t>(size));
    MPI_Recv(order.assignment.runs.data(), size, MPI_INT64_T, 0, status.MPI_TAG,
             MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    order.kind = status.MPI_TAG == kAssignment ? Order::Kind::kWork
                 : status.MPI_TAG == kNoMore   ? Order::Kind::kNoMore
                                               : Order::Kind::kStop;
    return order;
  }

 private:
  struct Posted {
    std::vector<std::int64_t> numbers;
    MPI_Request request = MPI_REQUEST_NULL;
  };

  // Sends without waiting: the receiver may itself be sending just then.
  void Post(int rank, Tag tag, std::vector<std::int64_t> numbers) {
    Posted& posted = posted_.emplace_back();
    posted.numbers = std::move(numbers);
    MPI_Isend(posted.numbers.data(), static_cast<int>(posted.numbers.size()),
              MPI_INT64_T, rank, tag, MPI_COMM_WORLD, &posted.request);
  }

  // What has been sent.
  void Forget() {
    posted_.remove_if([](Posted& posted) {
      int sent = 0;
      MPI_Test(&posted.request, &sent, MPI_STATUS_IGNORE);
      return sent != 0;
    });
  }

  static bool Probe(int source, int tag, MPI_Status& status) {
    int there = 0;
    MPI_Iprobe(source, tag, MPI_COMM_WORLD, &there, &status);
    return there != 0;
  }

  int rank_ = 0;
  int count_ = 1;
  int on_this_machine_ = 1;
  std::list<Posted> posted_;  // on their way
};

}  // namespace

absl::StatusOr<std::unique_ptr<Processes>> StartMpi(int* argc, char*** argv) {
  int provided = 0;
  if (MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided) !=
          MPI_SUCCESS ||
      provided < MPI_THREAD_FUNNELED) {
    return absl::InternalError("MPI could not be started with threads");
  }
  return std::make_unique<MpiProcesses>();
}

}  // namespace mle::study
