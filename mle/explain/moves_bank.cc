#include "mle/explain/moves_bank.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A sample's functions side by side.
using Functions =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The Laguerre functions of a signal (samples × functions), or their sums from
// the first sample on.
template <int kFunctions>
void RunLaguerre(const VectorXd& signal, double pole, bool summed,
                 Functions& result) {
  const double gain = std::sqrt(1.0 - pole * pole);
  double first = 0.0;
  std::array<double, kFunctions> input{};
  std::array<double, kFunctions> state{};
  std::array<double, kFunctions> sum{};
  double* to = result.data();
  for (Index k = 0; k < signal.size(); ++k, to += kFunctions) {
    double value = first;
    first = pole * first + gain * signal[k];
    for (int f = 0; f < kFunctions; ++f) {
      if (f > 0) {  // (q⁻¹ − pole) / (1 − pole q⁻¹)
        state[f] = pole * (state[f] - value) + input[f];
        input[f] = value;
        value = state[f];
      }
      sum[f] = summed ? sum[f] + value : value;
      to[f] = sum[f];
    }
  }
}

// The same, their number being that of the columns of `result`.
template <int kFunctions = MovesBank::kFewestFunctions>
void RunAsMany(const VectorXd& signal, double pole, bool summed,
               Functions& result) {
  if constexpr (kFunctions < MovesBank::kMostFunctions) {
    if (result.cols() > kFunctions) {
      return RunAsMany<kFunctions + 1>(signal, pole, summed, result);
    }
  }
  RunLaguerre<kFunctions>(signal, pole, summed, result);
}

Functions LaguerreOf(const VectorXd& signal, double pole, int functions,
                     bool summed) {
  Functions result(signal.size(), functions);
  RunAsMany(signal, pole, summed, result);
  return result;
}

int ShiftOf(double share, int samples) {
  return static_cast<int>(share * static_cast<double>(samples));
}

// Where a move is later by `shift`; 0 where it is the join of the ends.
int Later(int at, int shift, int samples) {
  return at + shift < samples ? at + shift : at + shift - samples;
}

}  // namespace

double RangeOf(const RecordSignal& signal) {
  double range = 0.0;
  for (const VectorXd& values : signal) {
    range = std::max(range, values.maxCoeff() - values.minCoeff());
  }
  return range;
}

MovesBank::MovesBank(const ExplainedOutput& output,
                     const std::vector<RecordSignal>& signals, int functions,
                     double time)
    : functions_(std::clamp(functions, kFewestFunctions, kMostFunctions)),
      pole_(std::exp(-output.sample_time() / time)),
      rows_(output.rows()) {
  for (const Record& record : output.records()) {
    samples_.push_back(record.samples());
  }
  for (const RecordSignal& signal : signals) {
    const double range = std::max(RangeOf(signal), 1e-300);
    Moves moves;
    for (const VectorXd& values : signal) {
      std::vector<Move>& of_record = moves.emplace_back();
      for (Index k = 1; k < values.size(); ++k) {
        if (values[k] == values[k - 1]) continue;
        of_record.push_back(
            {static_cast<int>(k), (values[k] - values[k - 1]) / range});
      }
    }
    signals_.push_back(std::move(moves));
  }
}

MatrixXd MovesBank::Columns(double share, int every) const {
  const auto rows = static_cast<Index>(rows_.size());
  MatrixXd columns((rows + every - 1) / every, this->columns());
  for (std::size_t s = 0; s < signals_.size(); ++s) {
    const Index at = functions_ * static_cast<Index>(s);
    Functions functions;
    int record = -1;
    for (Index i = 0; i < rows; i += every) {
      const ResidualRow& row = rows_[static_cast<std::size_t>(i)];
      if (row.record != record) {
        record = row.record;
        const int n = samples_[record];
        const int shift = ShiftOf(share, n);
        VectorXd moved = VectorXd::Zero(n);
        for (const Move& move : signals_[s][record]) {
          const int later = Later(move.at, shift, n);
          if (later > 0) moved[later] = move.size;
        }
        for (int k = 1; k < n; ++k) moved[k] += moved[k - 1];
        functions = LaguerreOf(moved, pole_, functions_, false);
      }
      for (int f = 0; f < functions_; ++f) {
        double sum = 0.0;
        for (int k = row.first; k < row.first + row.samples; ++k) {
          sum += functions(k, f);
        }
        columns(i / every, at + f) = sum / row.samples;
      }
    }
  }
  return columns;
}

MatrixXd MovesBank::Project(const VectorXd& x,
                            const std::vector<double>& shares) const {
  MatrixXd products =
      MatrixXd::Zero(columns(), static_cast<Index>(shares.size()));
  std::size_t i = 0;
  for (int r = 0; r < static_cast<int>(samples_.size()); ++r) {
    const int n = samples_[r];
    const Index last = n - 1;
    VectorXd backward = VectorXd::Zero(n);
    for (; i < rows_.size() && rows_[i].record == r; ++i) {
      const ResidualRow& row = rows_[i];
      const double each = x[static_cast<Index>(i)] / row.samples;
      for (int k = row.first; k < row.first + row.samples; ++k) {
        backward[last - k] = each;
      }
    }
    // Sums over all samples from one on.
    const Functions sums = LaguerreOf(backward, pole_, functions_, true);
    for (std::size_t c = 0; c < shares.size(); ++c) {
      const int shift = ShiftOf(shares[c], n);
      for (std::size_t s = 0; s < signals_.size(); ++s) {
        std::array<double, kMostFunctions> sum{};
        for (const Move& move : signals_[s][r]) {
          const int later = Later(move.at, shift, n);
          if (later == 0) continue;
          const double* row = &sums(last - later, 0);
          for (int f = 0; f < functions_; ++f) sum[f] += move.size * row[f];
        }
        for (int f = 0; f < functions_; ++f) {
          products(functions_ * static_cast<Index>(s) + f,
                   static_cast<Index>(c)) += sum[f];
        }
      }
    }
  }
  return products;
}

}  // namespace mle
