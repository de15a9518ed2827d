// The strict reader of records: what it takes is a valid record, and reads back
// as the same.

#include <cmath>
#include <sstream>

#include "mle/data/record_csv.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/tank.h"

namespace mle {
namespace {

bool Same(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const double x = a.data()[i];
    const double y = b.data()[i];
    if (x != y && !(std::isnan(x) && std::isnan(y))) return false;
  }
  return true;
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const mle::ProcessModel& tank = mle::fuzz::Tank();
  std::istringstream in{std::string(bytes.Rest())};
  const auto record =
      mle::ParseRecordCsv(in, "fuzz.csv", tank, {.bad_values = {"-9999"}});
  if (!record.ok()) {
    FUZZ_EXPECT(record.status().message().find("fuzz.csv") == 0,
                record.status().ToString());
    return 0;
  }
  FUZZ_EXPECT(record->Validate().ok(), record->Validate().ToString());
  const auto text = mle::FormatRecordCsv(*record, tank);
  FUZZ_EXPECT(text.ok(), text.status().ToString());
  std::istringstream second(*text);
  const auto again = mle::ParseRecordCsv(second, "again.csv", tank);
  FUZZ_EXPECT(again.ok(), again.status().ToString() + *text);
  FUZZ_EXPECT(mle::Same(again->outputs, record->outputs), *text);
  FUZZ_EXPECT(mle::Same(again->inputs, record->inputs), *text);
  FUZZ_EXPECT(mle::Same(again->set_points, record->set_points), *text);
  return 0;
}
