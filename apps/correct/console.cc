#include "apps/correct/console.h"

#include <sys/resource.h>

#include <iostream>
#include <string>

#include "apps/correct/headline.h"
#include "apps/correct/mismatch_map.h"
#include "apps/correct/record_tables.h"
#include "apps/correct/tables.h"
#include "apps/report/table.h"

namespace mle::correct {
namespace {

void PrintDetails(const Result& result) {
  PrintMessages("warning", result.warnings);
  std::cout << "\n";
  for (const std::string& sentence : result.verdict) {
    std::cout << sentence << "\n";
  }
  for (const std::string& sentence : Sentences(result.findings)) {
    std::cout << "  " << sentence << "\n";
  }
  std::cout << "\n"
            << IntervalNote(result) << "\n\n"
            << report::RenderText(MismatchTable(result)) << "\n"
            << report::RenderText(ParameterTable(result)) << "\n"
            << report::RenderText(ValidationTable(result)) << "\n"
            << report::RenderText(ResidualTable(result)) << "\nWhat to do\n";
  for (const std::string& item : result.advice) {
    std::cout << "  " << item << "\n";
  }
  if (result.tuning.heading.empty()) return;
  std::cout << "\n" << result.tuning.heading << "\n";
  for (const std::string& reason : result.tuning.reasons) {
    std::cout << "  " << reason << "\n";
  }
}

}  // namespace

void PrintData(const RecordData& data, const std::vector<DataFile>& files,
               const ProcessModel& model) {
  std::cout << report::RenderText(FileTable(data, files, model)) << "\n"
            << report::RenderText(ChannelTable(data, model)) << "\n"
            << report::RenderText(WindowTable(data, model)) << "\n";
  for (const Message& note : data.notes) std::cout << Shown(note) << "\n";
}

void PrintMemory() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  constexpr long kKibibytes = 1024;  // of a MiB
  std::cerr << "at most " << (usage.ru_maxrss + kKibibytes - 1) / kKibibytes
            << " MiB of memory were used\n";
}

void PrintMessages(const char* kind, const std::vector<Message>& messages) {
  for (const Message& message : messages) {
    std::cerr << kind << ": " << Shown(message) << "\n";
  }
}

void PrintResult(const Result& result) {
  for (const std::string& line : ShortVerdict(result)) {
    std::cout << line << "\n";
  }
  if (result.request.verbose) PrintDetails(result);
}

}  // namespace mle::correct
