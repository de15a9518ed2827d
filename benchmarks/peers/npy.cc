#include "benchmarks/peers/npy.h"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <fstream>

#include "absl/strings/str_format.h"

namespace mle::benchmarks {
namespace {

static_assert(std::endian::native == std::endian::little);

// Magic, version 1.0, and the header's length in two bytes.
constexpr char kMagic[] = "\x93NUMPY\x01";
constexpr std::size_t kPrelude = 10;

}  // namespace

absl::Status WriteNpy(const Eigen::MatrixXd& matrix, const std::string& path) {
  std::string header = absl::StrFormat(
      "{'descr': '<f8', 'fortran_order': True, 'shape': (%d, %d), }",
      matrix.rows(), matrix.cols());
  // The data start at a multiple of 64 bytes.
  header.append(63 - (kPrelude + header.size()) % 64, ' ');
  header += '\n';
  std::ofstream file(path, std::ios::binary);
  file.write(kMagic, 7);
  file.put('\0');
  file.put(static_cast<char>(header.size() % 256));
  file.put(static_cast<char>(header.size() / 256));
  file << header;
  file.write(reinterpret_cast<const char*>(matrix.data()),
             static_cast<std::streamsize>(matrix.size() * sizeof(double)));
  file.close();
  if (!file) {
    return absl::UnavailableError(
        absl::StrFormat("%s could not be written", path));
  }
  return absl::OkStatus();
}

absl::StatusOr<Eigen::MatrixXd> ReadNpy(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string prelude(kPrelude, '\0');
  file.read(prelude.data(), kPrelude);
  if (!file || prelude.compare(0, 7, kMagic) != 0) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s is not an .npy file of version 1.0", path));
  }
  std::string header(static_cast<std::uint8_t>(prelude[8]) +
                         256U * static_cast<std::uint8_t>(prelude[9]),
                     '\0');
  file.read(header.data(), static_cast<std::streamsize>(header.size()));
  long rows = 0;
  long cols = 0;
  const std::size_t shape = header.find("'shape': (");
  if (!file || header.find("'<f8'") == std::string::npos ||
      header.find("'fortran_order': True") == std::string::npos ||
      shape == std::string::npos ||
      std::sscanf(header.c_str() + shape, "'shape': (%ld, %ld)", &rows,
                  &cols) != 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s: the header is %s; wanted are two dimensions of float64 in Fortran "
        "order",
        path, header));
  }
  Eigen::MatrixXd matrix(rows, cols);
  file.read(reinterpret_cast<char*>(matrix.data()),
            static_cast<std::streamsize>(matrix.size() * sizeof(double)));
  if (!file) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s ends before its %d × %d numbers", path, rows, cols));
  }
  return matrix;
}

}  // namespace mle::benchmarks
