// Uses files and the kernels alone: exits with 0 if what has been written is
// read, and a triangular system is solved.

#include <cmath>
#include <cstdio>
#include <string>

#include "mle/base/file.h"
#include "mle/regression/kernels/kernels.h"

int main() {
  const absl::Status written =
      mle::WriteFileAtomically("right_side.txt", "4 6");
  const absl::StatusOr<std::string> text = mle::ReadFile("right_side.txt");
  double x[2] = {};
  if (!written.ok() || !text.ok() ||
      std::sscanf(text->c_str(), "%lf %lf", &x[0], &x[1]) != 2) {
    std::fprintf(stderr, "the file was not written or not read\n");
    return 1;
  }
  // U = [2 1; 0 3] by columns.
  const double u[4] = {2.0, 0.0, 1.0, 3.0};
  mle::VectorKernels().solve(u, 2, 2, x);
  std::printf("x = %.17g %.17g\n", x[0], x[1]);
  return std::abs(x[0] - 1.0) + std::abs(x[1] - 2.0) < 1e-12 ? 0 : 1;
}
