// Says what became of a record that is in memory, as from a database, and what
// is wrong with its channels: inspect_record MODEL.json < RECORD.csv

#include <iostream>
#include <iterator>
#include <string>

#include "mle/data/channel_health.h"
#include "mle/mle.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const auto model = mle::ReadProcessModel(argv[1]);
  if (!model.ok()) return 2;
  const std::string text(std::istreambuf_iterator<char>(std::cin), {});
  const auto import = mle::ImportHistorianSources(
      {mle::TextSource("standard input", text)}, *model, {});
  if (!import.ok()) {
    std::cerr << import.status() << "\n";
    return 2;
  }
  std::cout << import->report.FullReport(model->time_unit());
  const mle::HealthReport health =
      mle::CheckHealth(import->records, *model, {});
  std::cout << health.Report(import->records);
  return 0;
}
