// A tank with one input and one output, and exports of it as texts, for tests
// of the import.

#ifndef TESTS_MLE_DATA_HISTORIAN_TEXTS_H_
#define TESTS_MLE_DATA_HISTORIAN_TEXTS_H_

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "mle/model/process_model.h"

namespace mle {

inline ProcessModel Tank() {
  return ProcessModel("tank", "min", {{"steam", ""}}, {{"level", ""}});
}

inline absl::StatusOr<HistorianImport> Import(
    const std::string& text, const HistorianOptions& options = {},
    const ProcessModel& model = Tank()) {
  return ImportHistorianSources({TextSource("a.csv", text)}, model, options);
}

inline HistorianImport ImportOk(const std::string& text,
                                const HistorianOptions& options = {}) {
  absl::StatusOr<HistorianImport> import = Import(text, options);
  EXPECT_TRUE(import.ok()) << import.status();
  return import.ok() ? *std::move(import) : HistorianImport();
}

inline std::string Error(const std::string& text,
                         const HistorianOptions& options = {}) {
  const absl::Status status = Import(text, options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  return std::string(status.message());
}

inline std::vector<double> RowOf(const Eigen::MatrixXd& matrix, int row = 0) {
  const Eigen::RowVectorXd values = matrix.row(row);
  return {values.data(), values.data() + values.size()};
}

MATCHER(IsNan, "") { return std::isnan(arg); }

}  // namespace mle

#endif  // TESTS_MLE_DATA_HISTORIAN_TEXTS_H_
