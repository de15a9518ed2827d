// Matrices of doubles in NumPy's .npy format, version 1.0, column by column.

#ifndef BENCHMARKS_PEERS_NPY_H_
#define BENCHMARKS_PEERS_NPY_H_

#include <string>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle::benchmarks {

absl::Status WriteNpy(const Eigen::MatrixXd& matrix, const std::string& path);

// Reads what WriteNpy writes and what numpy.save makes of a two-dimensional
// array of float64 in Fortran order; InvalidArgument names what else it finds.
absl::StatusOr<Eigen::MatrixXd> ReadNpy(const std::string& path);

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_PEERS_NPY_H_
