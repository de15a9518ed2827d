// Corrects a process model from records: correct_from_csv MODEL.json OUT.json
// RECORD.csv… prints the decision and writes the corrected model.

#include <cstdio>
#include <string>
#include <vector>

#include "mle/mle.h"

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: %s MODEL.json OUT.json RECORD.csv…\n",
                 argv[0]);
    return 2;
  }
  const std::vector<std::string> records(argv + 3, argv + argc);
  const auto result = mle::CorrectFromRecords(
      argv[1], records, mle::HistorianOptions(), mle::CorrectOptions());
  if (!result.ok()) {
    std::fprintf(stderr, "%s\n",
                 std::string(result.status().message()).c_str());
    return 2;
  }
  std::printf("%s\n", std::string(mle::NameOf(result->decision)).c_str());
  for (const mle::Message& reason : result->reasons) {
    std::printf("  %s\n", reason.text.c_str());
  }
  for (const mle::Message& warning : result->warnings) {
    std::printf("  warning, %s: %s\n", warning.place.c_str(),
                warning.text.c_str());
  }
  if (!result->accepted() || !result->usable()) return 1;
  const absl::Status written =
      mle::WriteProcessModel(result->fopdt_model, argv[2]);
  if (!written.ok()) {
    std::fprintf(stderr, "%s\n", std::string(written.message()).c_str());
  }
  return written.ok() ? 0 : 2;
}
